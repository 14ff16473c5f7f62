#include "picture/lines.h"
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

/* Narrows a line's share [low, high] to where start + share * change is between 0 and `end`. False: nowhere. */
static bool clip(double share[2], double start, double change, double end) {
  if (change == 0.0)
    return start >= 0.0 && start <= end;
  const double first = (change > 0.0 ? -start : end - start) / change;
  const double last = (change > 0.0 ? end - start : -start) / change;
  share[0] = fmax(share[0], first);
  share[1] = fmin(share[1], last);
  return share[0] <= share[1];
}

static void dot(image *out, const line_style *style, int64_t x, int64_t y, double depth) {
  if (x < 0 || y < 0 || x >= out->width || y >= out->height)
    return;
  const bool hidden = style->nearest && depth > style->nearest[(size_t)y * out->width + (size_t)x];
  image_mix(out, (uint32_t)x, (uint32_t)y, style->color, hidden ? style->hidden : 1.0f);
}

void picture_line(image *out, const line_style *style, const double from[3], const double to[3]) {
  const double change[3] = {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
  const int along = fabs(change[0]) >= fabs(change[1]) ? 0 : 1, across = 1 - along;
  const double margin = style->width; /* a wide line may begin beside the picture */
  const double size[2] = {out->width - 1.0, out->height - 1.0};
  double share[2] = {0.0, 1.0};
  for (int i = 0; i < 2; i++)
    if (!clip(share, from[i] + margin, change[i], size[i] + 2.0 * margin))
      return;
  const double ends[2] = {from[along] + share[0] * change[along], from[along] + share[1] * change[along]};
  const int64_t first = llround(fmin(ends[0], ends[1])), last = llround(fmax(ends[0], ends[1]));
  for (int64_t at = first; at <= last; at++) {
    const double part = change[along] == 0.0 ? 0.0 : fmin(fmax(((double)at - from[along]) / change[along], 0.0), 1.0);
    const double middle = from[across] + part * change[across];
    const int64_t begin = llround(middle - 0.5 * (style->width - 1.0));
    for (int64_t side = begin; side < begin + style->width; side++)
      dot(out, style, along == 0 ? at : side, along == 0 ? side : at, from[2] + part * change[2]);
  }
}
