/* measure/error_picture.h: pictures of the truth, of what was drawn, and of where they differ. */
#ifndef HOST_MEASURE_PICTURE_H
#define HOST_MEASURE_PICTURE_H

#include "base/image.h"
#include "metrics/metrics.h"

/* The surfaces that the truth sees, lit by `visibility`. */
void measure_picture_lit(image *out, const truth_view *view, const scene_light *light, const float *visibility);

/* The same visibility as grey; what is not measured is bluish: the sky lighter than surfaces. */
void measure_picture_visibility(image *out, const metrics_frame *frame, const uint8_t *kinds, const float *visibility);

/*
 * Where drawn and true visibility differ: too bright towards orange, too dark towards blue, in full from a quarter on;
 * what differs by less than 1/64 is grey, by the truth; what is not measured as below. What a soft sun is judged by.
 */
void measure_picture_difference(image *out, const metrics_frame *frame, const uint8_t *kinds);

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
