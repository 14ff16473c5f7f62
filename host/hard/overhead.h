/*
 * hard/overhead.h: a square of ground seen straight from above by an orthographic camera, with one map for all of it.
 * Light comes straight down unless it is turned, so that a texel knows one height, and closed forms hold.
 */
#ifndef HOST_HARD_OVERHEAD_H
#define HOST_HARD_OVERHEAD_H

#include "hard/hard.h"

/*
 * Begins a setup whose picture has `pixels` a side and shows `side` metres around the world's y axis; the camera stands
 * at height `eye` and sees down to `floor`. One cascade, whose map is as wide as the picture.
 */
typedef struct overhead {
  double side, eye, floor;
  uint32_t pixels;
} overhead;

void overhead_begin(host_setup *out, const overhead *how);

/* Level, facing up: from (x0, z0) to (x1, z1) at a height. */
void overhead_tile(mesh_builder *b, const double corners[4], double height);

/*
 * The map's range goes from `top` to `bottom`, whatever else there is below and above: two small tiles beside the
 * picture mark them. Call it last: it sets how deep maps reach.
 */
void overhead_range(host_setup *setup, double top, double bottom);

/* World x and z of a pixel's centre. */
void overhead_place(const host_setup *setup, uint32_t column, uint32_t row, double place[2]);

#endif
