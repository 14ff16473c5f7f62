/* bench/moving.h: a plan's many instances as csm takes them, and those of them that move in each frame. */
#ifndef HOST_BENCH_MOVING_H
#define HOST_BENCH_MOVING_H

#include "bench/scene_plan.h"
#include "stage/assets.h"

typedef struct bench_moving {
  csm_instance *instances;
  uint32_t count, moved; /* how many there are, and how many of them move */
  csm_instance_id *ids;  /* in the scene that they were added to last */
  csm_instance_id *moved_ids;
  double (*places)[16]; /* where these go */
} bench_moving;

/* Instances of meshes that were uploaded. */
void bench_moving_make(bench_moving *out, const bench_plan *many, const assets *assets);
void bench_moving_free(bench_moving *m);

/* A scene of all of them. */
csm_result bench_moving_scene(bench_moving *m, csm_context *context, csm_scene **out);

/* For csm_scene_move: some of them, spread over all, go up a metre in every second frame, and down again in the others. It
 * holds until the next call. */
csm_scene_batch bench_moving_next(bench_moving *m, uint64_t frame);

#endif
