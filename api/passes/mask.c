#include "passes.h"
#include "shader_code.h"

csm_result mask_program(pass_gpu gpu, uint32_t filter, bool normals, gpu_program **out) {
  const gpu_code *const codes[2][2] = {
      [CSM_FILTER_PCF_2X2] = {&shader_mask_2x2_ps, &shader_mask_2x2_normals_ps},
      [CSM_FILTER_PCF_3X3] = {&shader_mask_3x3_ps, &shader_mask_3x3_normals_ps},
  };
  const gpu_program_info info = {
      .name = filter == CSM_FILTER_PCF_2X2 ? "mask, PCF 2x2" : "mask, PCF 3x3",
      .vertex = shader_screen_vs,
      .pixel = *codes[filter][normals],
      .constants_count = 2,
      .constants_sizes = {MASK_CASCADES_BLOCK, MASK_CAMERA_BLOCK},
      .texture_count = normals ? 3 : 2,
      .sampler_count = 1,
      .samplers = {GPU_SAMPLER_COMPARE_LESS_EQUAL},
      .color_format = GPU_FORMAT_R8_UNORM,
      .cull = GPU_CULL_NONE,
  };
  return gpu.api->program_create(gpu.device, &info, out);
}

gpu_bindings_info mask_inputs(const gpu_program *program, gpu_buffer *constants, gpu_image *maps, gpu_image *depth,
                              gpu_image *normals) {
  return (gpu_bindings_info){
      .name = "mask",
      .program = program,
      .constants = {constants, constants},
      .textures = {maps, depth, normals},
  };
}

void mask_record(pass_gpu gpu, const mask_pass *pass) {
  const uint32_t offsets[] = {pass->constants_offset, pass->constants_offset + MASK_CASCADES_BLOCK};
  gpu.api->marker_begin(gpu.device, "mask");
  gpu.api->pass_begin(gpu.device, pass->target);
  gpu.api->pass_program(gpu.device, pass->program);
  gpu.api->pass_bind(gpu.device, pass->bindings, offsets);
  gpu.api->pass_draw(gpu.device, &(gpu_draw){.count = 3, .instance_count = 1});
  gpu.api->pass_end(gpu.device);
  gpu.api->marker_end(gpu.device);
}
