#include "techniques/mask/mask_programs.h"

#include "shader_code.h"

mask_kind mask_kind_of(const csm_config *config, bool normals, bool shows) {
  if (shows)
    return (mask_kind){.shows = true};
  return (mask_kind){.filter = config->filter,
                     .early = config->filter_early_out,
                     .plane = config->bias_mode == CSM_BIAS_RECEIVER_PLANE,
                     .normals = normals};
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

static csm_result make(gpu gpu, const void *about, gpu_program **out) {
  const mask_kind *kind = about;
  /* By early out, which large boxes alone have; linear_depth has no texels to place on a plane. */
  const gpu_code *const codes[][2][2][2] = {
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
      .name = kind->shows ? "mask view" : "mask",
      .vertex = shader_screen_vs,
      .pixel = kind->shows ? shader_mask_view_ps : *codes[kind->filter][kind->early][kind->plane][kind->normals],
      .constants_count = 2,
      .constants_sizes = {MASK_CASCADES_BLOCK, MASK_CAMERA_BLOCK},
      .texture_count = kind->normals ? 3 : 2,
      .sampler_count = 1,
      .samplers = {GPU_SAMPLER_POINT_CLAMP},
      .color_format = GPU_FORMAT_R8_UNORM,
      .cull = GPU_CULL_NONE,
  };
  return gpu_program_create(gpu, &info, out);
}

csm_result mask_program(device *device, const mask_kind *kind, gpu_program **out) {
  const program_key key = {.make = make, .name = "a mask program", .about = kind, .size = sizeof *kind};
  return programs_find(device, &key, out);
}
