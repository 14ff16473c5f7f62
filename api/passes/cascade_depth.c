#include "draw_list.h"
#include "shader_code.h"

#include <stdio.h>

csm_result cascade_depth_program(pass_gpu gpu, gpu_program **out) {
  return draw_list_program(gpu, "cascade depth", shader_cascade_depth_vs, PASS_CASCADE_ROWS, GPU_COMPARE_LESS, false,
                           out);
}

static void stamp(pass_gpu gpu, const cascade_depth_pass *pass, uint32_t index) {
  if (pass->timestamps)
    gpu.api->timestamp(gpu.device, index);
}

void cascade_depth_record(pass_gpu gpu, const cascade_depth_pass *pass) {
  stamp(gpu, pass, 0);
  gpu.api->clear_depth(gpu.device, pass->maps, 1.0f);
  stamp(gpu, pass, 1);
  for (uint32_t cascade = 0; cascade < pass->plan->cascade_count; ++cascade) {
    const plan_list *list = &pass->plan->cascades[cascade].list;
    char name[32];
    snprintf(name, sizeof name, "cascade %u depth", (unsigned)cascade);
    gpu.api->marker_begin(gpu.device, name);
    if (list->draw_count) {
      gpu.api->pass_begin(gpu.device, pass->targets[cascade]);
      gpu.api->pass_program(gpu.device, pass->program);
      draw_list(gpu, list, pass->meshes, pass->matrices, pass->matrices_offsets[cascade], PASS_CASCADE_ROWS);
      gpu.api->pass_end(gpu.device);
    }
    gpu.api->marker_end(gpu.device);
    stamp(gpu, pass, 2 + cascade);
  }
  gpu.api->make_readable(gpu.device, pass->maps);
}
