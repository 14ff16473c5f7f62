/* measure/error_picture.h: pictures of the truth, of what was drawn, and of where they differ. */
#ifndef HOST_MEASURE_PICTURE_H
#define HOST_MEASURE_PICTURE_H

#include "base/image.h"
#include "metrics/metrics.h"

/* The surfaces that the truth sees, lit by `visibility`. */
void measure_picture_lit(image *out, const truth_view *view, const scene_light *light, const float *visibility);

/*
 * What each pixel is:
 *   grey         right, lit or shadowed by the truth
 *   orange, red  lit, and should be in shadow; red is far from every edge (leak)
 *   light blue, blue  shadowed, and should be lit; blue is far from every edge (acne)
 *   brown        grazed by the light
 *   bluish grey  left out
 */
void measure_picture_errors(image *out, const metrics_frame *frame, const uint8_t *kinds);

#endif
