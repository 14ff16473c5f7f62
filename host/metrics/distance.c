/* Exact Euclidean distances in two passes (Meijster, Roerdink and Hesselink 2000). */
#include "base/host.h"
#include "base/parallel.h"
#include "metrics/metrics.h"
#include <stdlib.h>

typedef struct distances {
  const uint8_t *marked;
  uint32_t width, height;
  int32_t *vertical; /* to the nearest marked point of the column; `none` or more: there is none */
  int32_t none;
  int64_t *squares;
} distances;

static void scan_columns(const distances *d) {
  for (uint32_t x = 0; x < d->width; x++)
    d->vertical[x] = d->marked[x] ? 0 : d->none;
  for (uint32_t y = 1; y < d->height; y++)
    for (uint32_t x = 0; x < d->width; x++) {
      const size_t at = (size_t)y * d->width + x;
      d->vertical[at] = d->marked[at] ? 0 : d->vertical[at - d->width] + (d->vertical[at - d->width] < d->none);
    }
  for (uint32_t y = d->height - 1; y-- > 0;)
    for (uint32_t x = 0; x < d->width; x++) {
      const size_t at = (size_t)y * d->width + x;
      const int32_t below = d->vertical[at + d->width] + 1;
      d->vertical[at] = below < d->vertical[at] ? below : d->vertical[at];
    }
}

static int64_t square(int64_t value) {
  return value * value;
}

/* From which column on the parabola of column b lies below that of a < b. */
static int64_t crossing(const int32_t *vertical, int64_t a, int64_t b) {
  const int64_t above = square(b) - square(a) + square(vertical[b]) - square(vertical[a]);
  const int64_t below = 2 * (b - a);
  return above >= 0 ? above / below + 1 : -((-above + below - 1) / below) + 1;
}

static void scan_row(void *context, uint32_t row) {
  const distances *d = context;
  const int32_t *vertical = d->vertical + (size_t)row * d->width;
  int64_t *squares = d->squares + (size_t)row * d->width;
  int64_t *apexes = host_allocate(2 * (size_t)d->width, sizeof *apexes), *starts = apexes + d->width;
  int64_t count = 0;
  for (int64_t x = 0; x < d->width; x++) {
    if (vertical[x] >= d->none)
      continue;
    while (count > 0 && crossing(vertical, apexes[count - 1], x) <= starts[count - 1])
      count--;
    starts[count] = count ? crossing(vertical, apexes[count - 1], x) : INT32_MIN;
    apexes[count++] = x;
  }
  for (int64_t x = d->width - 1; x >= 0; x--) {
    while (count > 0 && starts[count - 1] > x)
      count--;
    squares[x] = count ? square(x - apexes[count - 1]) + square(vertical[apexes[count - 1]]) : INT64_MAX;
  }
  free(apexes);
}

void metrics_distances(const uint8_t *marked, uint32_t width, uint32_t height, int64_t *squares) {
  distances d = {.marked = marked,
                 .width = width,
                 .height = height,
                 .vertical = host_allocate((size_t)width * height, sizeof *d.vertical),
                 .none = (int32_t)height,
                 .squares = squares};
  scan_columns(&d);
  parallel_rows(height, scan_row, &d, NULL);
  free(d.vertical);
}
