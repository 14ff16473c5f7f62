/* In place of engine.c in a build without Vulkan. */
#include "base/host.h"
#include "hard/engine.h"

bool hard_engine_there(const host_options *options) {
  (void)options;
  return false;
}

int hard_engine_open(hard_engine **out, const host_setup *setup, const host_options *options, bool engine_buffers) {
  (void)setup;
  (void)options;
  (void)engine_buffers;
  *out = NULL;
  return host_fail(HOST_NO_DEVICE, "this csm-host was built without Vulkan");
}

void hard_engine_close(hard_engine *engine) {
  (void)engine;
}

stage *hard_engine_stage(hard_engine *engine) {
  (void)engine;
  return NULL;
}

int hard_engine_map(hard_engine *engine, uint32_t index, csm_cascade_info *cascade, float **out) {
  (void)engine;
  (void)index;
  (void)cascade;
  (void)out;
  return HOST_NO_DEVICE;
}

int hard_engine_draw(hard_engine *engine, const hard_inputs *inputs, const camera *from, const scene_light *light,
                     float *mask) {
  (void)engine;
  (void)inputs;
  (void)from;
  (void)light;
  (void)mask;
  return HOST_NO_DEVICE;
}
