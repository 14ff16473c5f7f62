#include "passes.h"
#include "shader_code.h"

uint32_t mask_kind_index(const mask_kind *kind) {
  return kind->view ? MASK_KINDS - 1 : kind->filter * 2 + kind->normals;
}

csm_result mask_program(pass_gpu gpu, const mask_kind *kind, gpu_program **out) {
  const gpu_code *const codes[MASK_FILTERS][2] = {
      [CSM_FILTER_PCF_2X2] = {&shader_mask_pcf_2x2_ps, &shader_mask_pcf_2x2_normals_ps},
      [CSM_FILTER_PCF_3X3] = {&shader_mask_pcf_3x3_ps, &shader_mask_pcf_3x3_normals_ps},
      [CSM_FILTER_NEAREST] = {&shader_mask_nearest_ps, &shader_mask_nearest_normals_ps},
      [CSM_FILTER_LINEAR_DEPTH] = {&shader_mask_linear_depth_ps, &shader_mask_linear_depth_normals_ps},
      [CSM_FILTER_PCF_5X5] = {&shader_mask_pcf_5x5_ps, &shader_mask_pcf_5x5_normals_ps},
      [CSM_FILTER_PCF_7X7] = {&shader_mask_pcf_7x7_ps, &shader_mask_pcf_7x7_normals_ps},
      [CSM_FILTER_PCF_N] = {&shader_mask_pcf_n_ps, &shader_mask_pcf_n_normals_ps},
      [CSM_FILTER_POISSON] = {&shader_mask_poisson_ps, &shader_mask_poisson_normals_ps},
      [CSM_FILTER_VOGEL] = {&shader_mask_vogel_ps, &shader_mask_vogel_normals_ps},
      [CSM_FILTER_GRID_17] = {&shader_mask_grid_17_ps, &shader_mask_grid_17_normals_ps},
  };
  const gpu_program_info info = {
      .name = kind->view ? "mask view" : "mask",
      .vertex = shader_screen_vs,
      .pixel = kind->view ? shader_mask_view_ps : *codes[kind->filter][kind->normals],
      .constants_count = 2,
      .constants_sizes = {MASK_CASCADES_BLOCK, MASK_CAMERA_BLOCK},
      .texture_count = kind->normals && !kind->view ? 3 : 2,
      .sampler_count = 1,
      .samplers = {GPU_SAMPLER_POINT_CLAMP},
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
