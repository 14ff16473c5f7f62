/* bench/scene_plan.h: the host's own planning of a scene: what the bare loop draws, and what planning costs. */
#ifndef HOST_BENCH_PLAN_H
#define HOST_BENCH_PLAN_H

#include "base/statistics.h"
#include "plan.h"
#include "setup/options.h"

typedef struct bench_plan {
  plan_scene scene;
  plan_instance *instances;
  plan_box *boxes;
  plan_bounds *bounds;
  plan_memory memory;
  float *matrices; /* room for one cascade's */
  plan_frame frame;
} bench_plan;

/*
 * Plans the setup's frame with `instance_count` instances: the scene's own, then copies of them, strewn over the scene.
 * 0, or HOST_BAD_INPUT after a message; bench_plan_free is always allowed.
 */
int bench_plan_make(bench_plan *out, const host_setup *setup, uint32_t instance_count);
void bench_plan_free(bench_plan *plan);

/* Milliseconds to plan, cull and write every matrix and constant that a frame needs, measured `count` times. */
estimate bench_plan_time(bench_plan *plan, const host_setup *setup, uint32_t count);

#endif
