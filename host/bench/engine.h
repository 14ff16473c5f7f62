/* bench/engine.h: what csm costs an engine's CPU: its device, its command buffers, three frames in flight. */
#ifndef HOST_BENCH_ENGINE_H
#define HOST_BENCH_ENGINE_H

#include "bench/scene_plan.h"

typedef struct bench_engine {
  estimate call_ms;     /* of csm_render_cascades */
  uint32_t allocations; /* that csm asked of the engine's allocator, in all measured frames together */
  uint32_t frames;      /* measured */
} bench_engine;

/*
 * Draws `many`'s instances on a device of the host's own through csm_create_info.vulkan, `frames` times after a
 * warm-up. 0, HOST_NO_DEVICE or HOST_BAD_INPUT after a message.
 */
int bench_engine_run(bench_engine *out, const host_setup *setup, const bench_plan *many, const char *device,
                     uint32_t frames);

#endif
