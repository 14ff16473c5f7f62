#include "passes.h"
#include "shader_code.h"

mask_kind mask_kind_of(const csm_config *config, bool normals) {
  return (mask_kind){.filter = config->filter,
                     .early = config->filter_early_out,
                     .plane = config->bias_mode == CSM_BIAS_RECEIVER_PLANE,
                     .normals = normals};
}

uint32_t mask_kind_index(const mask_kind *kind) {
  return kind->view ? MASK_KINDS - 1 : kind->filter * 8 + kind->early * 4u + kind->plane * 2u + kind->normals;
}

/* By bias, then by where normals come from. */
#define MASK_CODES(name)                                                                                               \
  {                                                                                                                    \
    {&shader_mask_##name##_ps, &shader_mask_##name##_normals_ps}, {                                                    \
      &shader_mask_##name##_plane_ps, &shader_mask_##name##_plane_normals_ps                                           \
    }                                                                                                                  \
  }

/* These leave the bias to the constants: vkd3d draws some of them wrong where it is fixed. */
#define MASK_EARLY(name)                                                                                               \
  {                                                                                                                    \
    {&shader_mask_##name##_early_ps, &shader_mask_##name##_early_normals_ps}, {                                        \
      &shader_mask_##name##_early_ps, &shader_mask_##name##_early_normals_ps                                           \
    }                                                                                                                  \
  }

csm_result mask_program(pass_gpu gpu, const mask_kind *kind, gpu_program **out) {
  /* By early out, which large boxes alone have; linear_depth has no texels to place on a plane. */
  const gpu_code *const codes[MASK_FILTERS][2][2][2] = {
      [CSM_FILTER_PCF_2X2] = {MASK_CODES(pcf_2x2)},
      [CSM_FILTER_PCF_3X3] = {MASK_CODES(pcf_3x3)},
      [CSM_FILTER_NEAREST] = {MASK_CODES(nearest)},
      [CSM_FILTER_LINEAR_DEPTH] = {{{&shader_mask_linear_depth_ps, &shader_mask_linear_depth_normals_ps}}},
      [CSM_FILTER_PCF_5X5] = {MASK_CODES(pcf_5x5), MASK_EARLY(pcf_5x5)},
      [CSM_FILTER_PCF_7X7] = {MASK_CODES(pcf_7x7), MASK_EARLY(pcf_7x7)},
      [CSM_FILTER_PCF_N] = {MASK_CODES(pcf_n), MASK_EARLY(pcf_n)},
      [CSM_FILTER_POISSON] = {MASK_CODES(poisson)},
      [CSM_FILTER_VOGEL] = {MASK_CODES(vogel)},
      [CSM_FILTER_GRID_17] = {MASK_CODES(grid_17)},
  };
  const gpu_program_info info = {
      .name = kind->view ? "mask view" : "mask",
      .vertex = shader_screen_vs,
      .pixel = kind->view ? shader_mask_view_ps : *codes[kind->filter][kind->early][kind->plane][kind->normals],
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
  gpu.api->pass_begin(gpu.device, &(gpu_pass_info){.target = pass->target, .color_load = GPU_LOAD_DISCARD});
  gpu.api->pass_program(gpu.device, pass->program);
  gpu.api->pass_bind(gpu.device, pass->bindings, offsets);
  gpu.api->pass_draw(gpu.device, &(gpu_draw){.count = 3, .instance_count = 1});
  gpu.api->pass_end(gpu.device);
  gpu.api->marker_end(gpu.device);
}
