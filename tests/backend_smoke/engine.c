/* engine.c: smoke tests on an engine's device: "bare", with no more than csm requires, or "modern", with all that an
   engine may lend. */
#include "smoke.h"

#include "../engine/rig.h"

#include <string.h>

static rig *engine;

void smoke_open(smoke *s, gpu_open_info *info) {
  (void)s;
  const bool modern = info->device_name && !strcmp(info->device_name, "modern");
  csm_create_info lent = {.struct_size = sizeof lent};
  engine = rig_open(modern ? RIG_MODERN : RIG_BARE);
  rig_give(engine, &lent);
  info->device_name = NULL;
  info->native = lent.vulkan ? (const void *)lent.vulkan : lent.d3d12;
}

void *smoke_begin(smoke *s) {
  (void)s;
  return rig_begin(engine);
}

void smoke_end(smoke *s) {
  (void)s;
  rig_end(engine);
}

csm_result smoke_wait(smoke *s, uint32_t slot) {
  (void)s, (void)slot;
  rig_run(engine, rig_frame(engine));
  return CSM_SUCCESS;
}

void smoke_close(smoke *s) {
  const uint32_t pieces = rig_lent_memory(engine)->pieces;
  CHECK(s, pieces == 0, "%u pieces of the engine's memory are left", pieces);
  s->messages += rig_messages(engine);
  rig_close(engine);
}
