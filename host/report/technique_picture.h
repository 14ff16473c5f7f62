/* report/technique_picture.h: what a technique makes of a soft sun's shadows, where they are softest. */
#ifndef HOST_REPORT_TECHNIQUE_PICTURE_H
#define HOST_REPORT_TECHNIQUE_PICTURE_H

#include "base/image.h"
#include "metrics/metrics.h"

/* A part of a picture, in pixels. */
typedef struct report_crop {
  uint32_t x, y, width, height;
} report_crop;

/* The part of a picture that sees most half-shadow, by the truth and of what is measured. */
report_crop report_crop_choose(const metrics_frame *frame);
/* Marks it in a picture. */
void report_crop_mark(image *picture, const report_crop *crop);

/* Three panes side by side, of that part alone: true visibility, drawn visibility, their difference. */
void report_technique_picture(image *out, const metrics_frame *frame, const uint8_t *kinds, const report_crop *crop);

#endif
