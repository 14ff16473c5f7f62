#include "report/technique_picture.h"
#include "base/host.h"
#include "measure/error_picture.h"
#include <stdlib.h>
#include <string.h>

enum { crop_width = 192, crop_height = 144, gap = 4, panes = 3 };

/* ---- where ---- */

/* 1 at half-shadow, 0 where the sun is seen whole or not at all, or where nothing is measured. */
static double softness(const metrics_frame *frame, size_t pixel) {
  const truth_surface *surface = &frame->view->surfaces[pixel];
  if (surface->triangle == TRUTH_NOTHING || surface->view_depth > frame->shadow_distance ||
      truth_facing(surface, frame->light) <= METRICS_GRAZING_COSINE)
    return 0.0;
  const double visibility = frame->visibility[pixel];
  return 4.0 * visibility * (1.0 - visibility);
}

/* Of a table with a row and a column of zeros before the pixels: the sum over all that is above and left of each. */
static double *sum_softness(const metrics_frame *frame) {
  const uint32_t width = frame->view->width, height = frame->view->height;
  const size_t stride = (size_t)width + 1;
  double *sums = host_allocate(stride * (height + 1), sizeof *sums);
  for (uint32_t y = 0; y < height; y++) {
    double row = 0.0;
    for (uint32_t x = 0; x < width; x++) {
      row += softness(frame, (size_t)y * width + x);
      sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
    }
  }
  return sums;
}

/* Of a side, but no more than that and at least a pixel. */
static uint32_t quarter_of(uint32_t side, uint32_t most) {
  const uint32_t quarter = side / 4 ? side / 4 : 1;
  return quarter < most ? quarter : most;
}

report_crop report_crop_choose(const metrics_frame *frame) {
  const uint32_t width = frame->view->width, height = frame->view->height;
  report_crop crop = {.width = quarter_of(width, crop_width), .height = quarter_of(height, crop_height)};
  const size_t stride = (size_t)width + 1, down = crop.height * stride;
  double *sums = sum_softness(frame), most = -1.0;
  for (uint32_t y = 0; y + crop.height <= height; y++)
    for (uint32_t x = 0; x + crop.width <= width; x++) {
      const double *at = sums + y * stride + x;
      const double sum = at[down + crop.width] - at[down] - at[crop.width] + at[0];
      if (sum > most) {
        most = sum;
        crop.x = x;
        crop.y = y;
      }
    }
  free(sums);
  return crop;
}

void report_crop_mark(image *picture, const report_crop *crop) {
  static const float red[3] = {1.0f, 0.05f, 0.05f};
  for (uint32_t y = 0; y < crop->height; y++)
    for (uint32_t x = 0; x < crop->width; x++)
      if (x < 4 || y < 4 || x + 4 >= crop->width || y + 4 >= crop->height)
        image_set(picture, crop->x + x, crop->y + y, red);
}

/* ---- what ---- */

/* Takes the picture over. */
static void place(image *out, int pane, image *picture, const report_crop *crop) {
  for (uint32_t y = 0; y < crop->height; y++)
    memcpy(out->pixels + 3 * ((size_t)y * out->width + (size_t)pane * (crop->width + gap)),
           picture->pixels + 3 * ((size_t)(crop->y + y) * picture->width + crop->x), 3 * (size_t)crop->width);
  image_free(picture);
}

void report_technique_picture(image *out, const metrics_frame *frame, const uint8_t *kinds, const report_crop *crop) {
  image picture;
  image_create(out, panes * crop->width + (panes - 1) * gap, crop->height);
  memset(out->pixels, 255, 3 * (size_t)out->width * out->height);
  measure_picture_visibility(&picture, frame, kinds, frame->visibility);
  place(out, 0, &picture, crop);
  measure_picture_visibility(&picture, frame, kinds, frame->mask);
  place(out, 1, &picture, crop);
  measure_picture_difference(&picture, frame, kinds);
  place(out, 2, &picture, crop);
}
