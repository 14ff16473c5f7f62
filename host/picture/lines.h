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
 * A line between two points: pixels to the right and down, (0, 0) being the middle of the first one, and a depth that
 * grows away from the viewer. It covers one place for each column or row, whichever are more, `width` pixels wide
 * there. What lies outside the picture is left out; all numbers must be finite.
 */
void picture_line(image *out, const line_style *style, const double from[3], const double to[3]);

#endif
