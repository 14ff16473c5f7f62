/*
 * life.h: a context's whole life in steps that may be repeated, in which each call that may fail, and each allocation,
 * fails in turn. The error has its name; what failed succeeds when it is tried again, or the context is lost and can be
 * switched or destroyed; what is drawn in the end is what is drawn without faults; and nothing is left behind.
 */
#ifndef LIFE_H
#define LIFE_H

#include "stage.h"

/* What lives through all lives. */
typedef struct props {
  rig *rig; /* of kind RIG_FAILING; NULL: own devices, whose API fails by itself */
  hill hill;
  rig_buffer vertices, indices; /* of the hill */
  rig_image *depth, *normals;
} props;

typedef struct life {
  record record; /* first: callbacks get it */
  props *props;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  support_scene scene;
  csm_instance instances[3];
  bool recording; /* the engine's command buffer is open */
  picture picture;
} life;

void props_open(props *props, rig *rig);
void props_close(props *props);

/* Every fault of rig_faults at every call of every step. */
void live_with_faults(props *props);

/* A life up to its first picture, and to its end. */
void life_open(life *life, props *props);
void life_end(life *life);
csm_config life_config(uint32_t cascades);
csm_result life_render(life *life);
csm_result life_resolve(life *life);
/* With the engine's images, where there are some. */
csm_result life_resolve_images(life *life);
/* Runs what was recorded, and takes the picture. */
csm_result life_finish(life *life);
/* Moves to the same device again. */
csm_result life_switch(life *life);
/* Asserts that the context answers as a lost one does; what was recorded is run. */
void life_expect_lost(life *life);

#endif
