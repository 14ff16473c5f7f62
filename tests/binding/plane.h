/* plane.h: a plane that a camera sees, so that a forward shader can tell each pixel's position without a depth. */
#ifndef TEST_PLANE_H
#define TEST_PLANE_H

#include <string.h>

/*
 * A level plane `rise` above the eye, as the float4 of plane_block of forward.ps.hlsl: along the ray d of a pixel it is at
 * d * rise / (n . d), n being up, and d is affine in the pixel's coordinates. Positions are relative to the eye.
 */
static inline void plane_rows(float out[16], const double view[16], const double projection[16], double rise, int width,
                              int height) {
  const double at[3][3] = {{-1 / projection[0], 1 / projection[5], -1},
                           {2.0 / width / projection[0], 0, 0},
                           {0, -2.0 / height / projection[5], 0}};
  for (int i = 0; i < 3; ++i) {
    double d[3];
    for (int axis = 0; axis < 3; ++axis)
      d[axis] = view[axis * 4] * at[i][0] + view[axis * 4 + 1] * at[i][1] + view[axis * 4 + 2] * at[i][2];
    for (int axis = 0; axis < 3; ++axis)
      out[i * 4 + axis] = (float)(d[axis] * rise);
    out[i * 4 + 3] = (float)d[1];
  }
  memcpy(&out[12], (const float[]){0, 1, 0, 0}, 16);
}

#endif
