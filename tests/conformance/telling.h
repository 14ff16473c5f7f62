/*
 * telling.h: a small scene in which every option of the configuration shows: a ground, boxes, one of them mirrored and
 * one sheared, a wedge and its mirror image, a two-sided alpha-tested leaf, a sheet that is not closed, a tall thin
 * mast that reaches before near planes, and a tower beyond the last cascade.
 */
#ifndef TELLING_H
#define TELLING_H

#include "support.h"

enum { TELLING_INSTANCES = 16, TELLING_CAMERAS = 3, TELLING_STEPS = 2 };

typedef struct telling {
  csm_mesh square, box, wedge, leaf;
  csm_alpha_mask alpha_mask;
  csm_instance instances[TELLING_INSTANCES];
} telling;

void telling_make(telling *scene, csm_context *context);
/* One of the cameras, at a step of its way: it goes on a little, turns, and the sun moves. */
shot telling_shot(const telling *scene, uint32_t camera, uint32_t step, double aspect);

#endif
