#include "techniques/draw_list.h"
#include "shader_code.h"

#include <stdio.h>

/* The rasteriser biases away from the light, which is towards 0 where depth is reversed. */
pass_casters cascade_depth_casters(const csm_config *config) {
  static const gpu_cull culls[] = {
      [CSM_FACE_CULLING_NONE] = GPU_CULL_NONE, [CSM_FACE_CULLING_FRONT] = GPU_CULL_FRONT, [CSM_FACE_CULLING_BACK] = GPU_CULL_BACK};
  const float away = config->map_reversed ? -1.0f : 1.0f;
  return (pass_casters){.format = config->map_format == CSM_MAP_D16 ? GPU_FORMAT_D16_UNORM : GPU_FORMAT_D32_FLOAT,
                        .reversed = config->map_reversed,
                        .clip = config->pancaking == CSM_PANCAKING_CLIP,
                        .cull = culls[config->face_culling],
                        .bias = {.constant = (int32_t)(away * (float)config->polygon_offset_constant),
                                 .slope = away * (float)config->polygon_offset_slope,
                                 .clamp = away * (float)config->polygon_offset_clamp}};
}

csm_result cascade_depth_program(pass_gpu gpu, const pass_casters *casters, gpu_cull cull, pass_vertices vertices,
                                 gpu_program **out) {
  const draw_list_kind kind = {.name = "cascade depth",
                               .vertex = shader_cascade_depth_vs,
                               .cut_out_vertex = shader_cascade_depth_opacity_vs,
                               .rows = PASS_CASCADE_ROWS,
                               .format = casters->format,
                               .compare = casters->reversed ? GPU_COMPARE_GREATER : GPU_COMPARE_LESS,
                               .clip = casters->clip,
                               .cull = cull,
                               .bias = casters->bias};
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
  const plan_rect *rect = &pass->layout->rects[cascade];
  gpu.api->pass_begin(gpu.device, &(gpu_pass_info){.target = pass->targets[rect->layer]});
  gpu.api->pass_area(gpu.device, &(gpu_rect){.x = rect->x, .y = rect->y, .width = rect->side, .height = rect->side});
  draw_list(gpu, &(draw_list_info){.programs = pass->programs,
                                   .cull = pass->casters->cull,
                                   .skip_hidden = true,
                                   .list = list,
                                   .meshes = pass->meshes,
                                   .matrices = pass->matrices,
                                   .offset = pass->matrices_offsets[cascade],
                                   .rows = PASS_CASCADE_ROWS});
  if (pass->draw)
    pass->draw(pass->draw_user, cascade);
  gpu.api->pass_end(gpu.device);
}

void cascade_depth_record(pass_gpu gpu, const cascade_depth_pass *pass) {
  stamp(gpu, pass, 0);
  gpu.api->clear_depth(gpu.device, pass->maps, pass->casters->reversed ? 0.0f : 1.0f);
  stamp(gpu, pass, 1);
  for (uint32_t cascade = 0; cascade < pass->plan->cascade_count; ++cascade) {
    char name[32];
    snprintf(name, sizeof name, "cascade %u depth", (unsigned)cascade);
    gpu.api->marker_begin(gpu.device, name);
    draw_cascade(gpu, pass, cascade);
    gpu.api->marker_end(gpu.device);
    stamp(gpu, pass, 2 + cascade);
  }
  gpu.api->make_readable(gpu.device, pass->maps, NULL);
}
