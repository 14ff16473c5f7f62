/* vulkan.c: smoke tests on a Vulkan engine's device: "bare", with render passes, or "modern", with dynamic rendering
   and the engine's own memory. */
#include "smoke.h"

#include "../engine/vulkan_engine.h"

#include <string.h>

static vulkan_engine engine;

void smoke_open(smoke *s, gpu_open_info *info) {
  (void)s;
  const bool modern = info->device_name && !strcmp(info->device_name, "modern");
  vulkan_engine_open(&engine, modern ? VULKAN_ENGINE_MODERN : VULKAN_ENGINE_BARE);
  info->device_name = NULL;
  info->native = &engine.native;
}

void *smoke_begin(smoke *s) {
  (void)s;
  return vulkan_engine_begin(&engine);
}

void smoke_end(smoke *s) {
  (void)s;
  vulkan_engine_end(&engine);
}

csm_result smoke_wait(smoke *s, uint32_t slot) {
  (void)s, (void)slot;
  vulkan_engine_run(&engine, engine.frame);
  return CSM_SUCCESS;
}

void smoke_close(smoke *s) {
  CHECK(s, engine.pieces == 0, "%u pieces of the engine's memory are left", engine.pieces);
  s->messages += engine.messages;
  vulkan_engine_close(&engine);
}
