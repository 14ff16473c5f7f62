/* dispatches.h: frames of a scene that stays on the null backend, and how many dispatches each takes, read from its log. */
#ifndef PASSES_DISPATCHES_H
#define PASSES_DISPATCHES_H

#include "../conformance/support.h"

typedef struct commands {
  uint32_t dispatches, breaches;
  bool drawn_after; /* a pass came after the first dispatch */
} commands;

typedef struct fixture {
  commands commands; /* of the last frame */
  csm_context *context;
  csm_cascades *cascades;
  csm_scene *scene;
  csm_config config;
  support_scene instances;
  csm_instance_id ids[SUPPORT_INSTANCES];
} fixture;

/* A test's set-up: `flags` are the context's, CSM_CREATE_*. */
int fixture_begin(void **state, uint32_t flags, const csm_config *config);
int fixture_end(void **state);
/* Draws a frame; returns how many dispatches it took. */
uint32_t fixture_render(fixture *f);
/* Puts an instance at x, 1 m up. */
void fixture_move(fixture *f, uint32_t instance, double x);

#endif
