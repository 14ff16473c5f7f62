/* hard/engine.h: the scene that is loaded, on a Vulkan device of an engine's. */
#ifndef HOST_HARD_ENGINE_H
#define HOST_HARD_ENGINE_H

#include "hard/hard.h"

typedef struct hard_engine hard_engine;

/* Whether there is one: this csm-host was built with Vulkan, and the options ask for it. */
bool hard_engine_there(const host_options *options);
/* 0, or a code after a message; hard_engine_close is allowed in both cases. */
int hard_engine_open(hard_engine **out, const host_setup *setup, const host_options *options, bool engine_buffers);
void hard_engine_close(hard_engine *engine); /* NULL is allowed */
/* What stands on the engine's device: for settings. */
stage *hard_engine_stage(hard_engine *engine);
/* One frame: maps and mask, width * height pixels. */
int hard_engine_draw(hard_engine *engine, const hard_inputs *inputs, const camera *from, const scene_light *light,
                     float *mask);
/* A cascade of the last frame, and its map, to be freed. */
int hard_engine_map(hard_engine *engine, uint32_t index, csm_cascade_info *cascade, float **out);

#endif
