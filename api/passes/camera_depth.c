#include "draw_list.h"
#include "shader_code.h"

csm_result camera_depth_program(pass_gpu gpu, bool reversed, pass_vertices vertices, gpu_program **out) {
  const draw_list_kind kind = {.name = reversed ? "camera depth, reversed" : "camera depth",
                               .vertex = shader_camera_depth_vs,
                               .cut_out_vertex = shader_camera_depth_opacity_vs,
                               .rows = PASS_CAMERA_ROWS,
                               .format = GPU_FORMAT_D32_FLOAT,
                               .compare = reversed ? GPU_COMPARE_GREATER : GPU_COMPARE_LESS,
                               .clip = true};
  return draw_list_program(gpu, &kind, vertices, out);
}

void camera_depth_record(pass_gpu gpu, const camera_depth_pass *pass) {
  gpu.api->marker_begin(gpu.device, "camera depth");
  gpu.api->clear_depth(gpu.device, pass->depth, pass->reversed ? 0.0f : 1.0f);
  if (pass->list->draw_count) {
    gpu.api->pass_begin(gpu.device, &(gpu_pass_info){.target = pass->target});
    draw_list(gpu, &(draw_list_info){.programs = (gpu_program *const *const[]){pass->programs},
                                     .cull = GPU_CULL_NONE,
                                     .list = pass->list,
                                     .meshes = pass->meshes,
                                     .matrices = pass->matrices,
                                     .offset = pass->matrices_offset,
                                     .rows = PASS_CAMERA_ROWS});
    gpu.api->pass_end(gpu.device);
  }
  gpu.api->make_readable(gpu.device, pass->depth, NULL);
  gpu.api->marker_end(gpu.device);
}
