#include "passes.h"
#include "shader_code.h"

uint32_t mask_kind_index(const mask_kind *kind) {
  return kind->filter * 4 + kind->bias_mode * 2 + kind->normals;
}

mask_kind mask_kind_at(uint32_t index) {
  return (mask_kind){.filter = index / 4, .bias_mode = index / 2 % 2, .normals = index % 2};
}

csm_result mask_program(pass_gpu gpu, const mask_kind *kind, gpu_program **out) {
  const gpu_code *const codes[2][2][2] = {
      [CSM_FILTER_PCF_2X2] = {[CSM_BIAS_SLOPE] = {&shader_mask_2x2_slope_ps, &shader_mask_2x2_slope_normals_ps},
                              [CSM_BIAS_RECEIVER_PLANE] = {&shader_mask_2x2_ps, &shader_mask_2x2_normals_ps}},
      [CSM_FILTER_PCF_3X3] = {[CSM_BIAS_SLOPE] = {&shader_mask_3x3_slope_ps, &shader_mask_3x3_slope_normals_ps},
                              [CSM_BIAS_RECEIVER_PLANE] = {&shader_mask_3x3_ps, &shader_mask_3x3_normals_ps}},
  };
  const gpu_program_info info = {
      .name = kind->filter == CSM_FILTER_PCF_2X2 ? "mask, PCF 2x2" : "mask, PCF 3x3",
      .vertex = shader_screen_vs,
      .pixel = *codes[kind->filter][kind->bias_mode][kind->normals],
      .constants_count = 2,
      .constants_sizes = {MASK_CASCADES_BLOCK, MASK_CAMERA_BLOCK},
      .texture_count = kind->normals ? 3 : 2,
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
