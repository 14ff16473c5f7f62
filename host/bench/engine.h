/* bench/engine.h: what csm_render_cascades costs an engine's CPU, by how its instances are handed over. */
#ifndef HOST_BENCH_ENGINE_H
#define HOST_BENCH_ENGINE_H

#include "bench/scene_plan.h"
#include <jansson.h>
#include <stdio.h>

typedef enum engine_way {
  ENGINE_LIST,  /* all of them in each frame */
  ENGINE_STILL, /* in a scene, of which none moves */
  ENGINE_MOVED, /* in a scene, of which some move in each frame */
  ENGINE_WAYS
} engine_way;

typedef struct bench_engine {
  uint32_t rounds; /* 0: not measured */
  uint32_t instances, moved;
  estimate call_ms[ENGINE_WAYS]; /* of csm_render_cascades */
  estimate to_list[ENGINE_WAYS]; /* ratio to the list, in the same round */
  estimate move_ms;              /* of csm_scene_move, which comes before */
  uint32_t allocations;          /* that csm asked of the engine's allocator, in all measured frames together */
} bench_engine;

/*
 * Records `many`'s instances in each way in turn, on a Vulkan device of the host's own. Nothing is submitted: a CPU
 * that draws would share its caches with what is timed. 0, HOST_NO_DEVICE or HOST_BAD_INPUT after a message.
 */
int bench_engine_run(bench_engine *out, const host_setup *setup, const bench_plan *many, const char *device,
                     uint32_t rounds);

void bench_engine_print(FILE *to, const bench_engine *engine);
json_t *bench_engine_to_json(const bench_engine *engine);

#endif
