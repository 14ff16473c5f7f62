/* measure/error_picture.h: pictures of the truth, of what was drawn, and of where they differ. */
#ifndef HOST_MEASURE_PICTURE_H
#define HOST_MEASURE_PICTURE_H

#include "base/image.h"
#include "metrics/metrics.h"

/* The surfaces that the truth sees, lit by `visibility`. */
void measure_picture_lit(image *out, const truth_view *view, const scene_light *light, const float *visibility);

/*
 * What each pixel is: right ones in grey, lit or shadowed by the truth; lit ones that should be in shadow in orange, or
 * red far from every edge (leak); shadowed ones that should be lit in light blue, or blue far from every edge (acne);
 * what the light grazes in brown, what is left out in a bluish grey.
 */
void measure_picture_errors(image *out, const metrics_frame *frame, const uint8_t *kinds);

#endif
