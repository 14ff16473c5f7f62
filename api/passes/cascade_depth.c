#include "draw_list.h"
#include "shader_code.h"

#include <stdio.h>

csm_result cascade_depth_program(pass_gpu gpu, pass_vertices vertices, gpu_program **out) {
  const draw_list_kind kind = {.name = "cascade depth",
                               .vertex = shader_cascade_depth_vs,
                               .cut_out_vertex = shader_cascade_depth_opacity_vs,
                               .rows = PASS_CASCADE_ROWS,
                               .compare = GPU_COMPARE_LESS};
  return draw_list_program(gpu, &kind, vertices, out);
}

static void stamp(pass_gpu gpu, const cascade_depth_pass *pass, uint32_t index) {
  if (pass->timestamps)
    gpu.api->timestamp(gpu.device, pass->first_timestamp + index);
}

static void draw_cascade(pass_gpu gpu, const cascade_depth_pass *pass, uint32_t cascade) {
  const plan_list *list = &pass->plan->cascades[cascade].list;
  if (!list->draw_count && !pass->draw)
    return;
  gpu.api->pass_begin(gpu.device, pass->targets[cascade]);
  draw_list(gpu, pass->programs, list, pass->meshes, pass->matrices, pass->matrices_offsets[cascade],
            PASS_CASCADE_ROWS);
  if (pass->draw)
    pass->draw(pass->draw_user, cascade);
  gpu.api->pass_end(gpu.device);
}

void cascade_depth_record(pass_gpu gpu, const cascade_depth_pass *pass) {
  stamp(gpu, pass, 0);
  gpu.api->clear_depth(gpu.device, pass->maps, 1.0f);
  stamp(gpu, pass, 1);
  for (uint32_t cascade = 0; cascade < pass->plan->cascade_count; ++cascade) {
    char name[32];
    snprintf(name, sizeof name, "cascade %u depth", (unsigned)cascade);
    gpu.api->marker_begin(gpu.device, name);
    draw_cascade(gpu, pass, cascade);
    gpu.api->marker_end(gpu.device);
    stamp(gpu, pass, 2 + cascade);
  }
  gpu.api->make_readable(gpu.device, pass->maps);
}
