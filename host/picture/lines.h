/* picture/lines.h: straight lines in a picture, dimmed where surfaces hide them. */
#ifndef HOST_PICTURE_LINES_H
#define HOST_PICTURE_LINES_H

#include "base/image.h"

typedef struct line_style {
  const float *color;   /* three, linear */
  uint32_t width;       /* in pixels */
  const float *nearest; /* depth of the surface at each pixel, top row first; NULL: nothing hides a line */
  float hidden;         /* how much of a line is seen behind a surface, 0 to 1 */
} line_style;

/*
 * A line between two points, each in pixels to the right, pixels down, and a depth that grows away from the viewer; (0,
 * 0) is the middle of the first pixel. A line covers one place in each column, or in each row where it is steeper,
 * `width` pixels wide. What lies outside the picture is left out. Precondition: all numbers are finite.
 */
void picture_line(image *out, const line_style *style, const double from[3], const double to[3]);

#endif
