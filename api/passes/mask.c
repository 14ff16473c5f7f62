#include "passes.h"
#include "shader_code.h"

/* Values of the axes of mask.ps.hlsl in variants.toml, beside those of csm_config. */
enum { MASK_BIAS_AS_CONFIGURED = -1, MASK_PLAIN = 0, MASK_GENERAL = 1, MASK_PLAIN_CASCADES = 4 };

/* Whether the programs do that leave out what few configurations ask for. */
static bool is_plain(const csm_config *config) {
  return config->cascade_count <= MASK_PLAIN_CASCADES && config->selection == CSM_SELECT_MAP &&
         config->blend_mode == CSM_BLEND_OFF && config->bias_normal_texels == 0.0 && plan_bias_in_texels(config) &&
         !config->map_reversed && plan_maps_alike(config);
}

uint64_t mask_key(const csm_config *config, bool normals, uint32_t view) {
  if (view != CSM_VIEW_SHADOW)
    return MASK_VIEW_KEY;
  const bool early = config->filter_early_out;
  return shader_key_mask((int32_t)config->filter, early ? MASK_BIAS_AS_CONFIGURED : (int32_t)config->bias_mode, early,
                         normals, is_plain(config) ? MASK_PLAIN : MASK_GENERAL);
}

csm_result mask_program(pass_gpu gpu, uint64_t key, bool normals, gpu_program **out) {
  const bool view = key == MASK_VIEW_KEY;
  const gpu_program_info info = {
      .name = view ? "mask view" : "mask",
      .vertex = normals ? shader_mask_normals_vs : shader_mask_vs,
      .pixel = view ? shader_mask_view_ps : *shader_find(key),
      .constants_count = 2,
      .constants_sizes = {MASK_CASCADES_BLOCK, MASK_CAMERA_BLOCK},
      .texture_count = normals ? 3 : 2,
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
