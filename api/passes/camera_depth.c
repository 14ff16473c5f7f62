#include "draw_list.h"
#include "shader_code.h"

csm_result camera_depth_program(pass_gpu gpu, bool reversed, gpu_program **out) {
  return draw_list_program(gpu, reversed ? "camera depth, reversed" : "camera depth", shader_camera_depth_vs,
                           PASS_CAMERA_ROWS, reversed ? GPU_COMPARE_GREATER : GPU_COMPARE_LESS, true, out);
}

void camera_depth_record(pass_gpu gpu, const camera_depth_pass *pass) {
  gpu.api->marker_begin(gpu.device, "camera depth");
  gpu.api->clear_depth(gpu.device, pass->depth, pass->reversed ? 0.0f : 1.0f);
  if (pass->list->draw_count) {
    gpu.api->pass_begin(gpu.device, pass->target);
    gpu.api->pass_program(gpu.device, pass->program);
    draw_list(gpu, pass->list, pass->meshes, pass->matrices, pass->matrices_offset, PASS_CAMERA_ROWS);
    gpu.api->pass_end(gpu.device);
  }
  gpu.api->make_readable(gpu.device, pass->depth);
  gpu.api->marker_end(gpu.device);
}
