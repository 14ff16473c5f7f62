#include "techniques/mask/mask_programs.h"

#include "plan/plan.h"
#include "shader_code.h"

/* Values of the axes of mask.ps.hlsl in variants.toml, beside those of csm_config. */
enum { BIAS_AS_CONFIGURED = -1, PLAIN = 0, GENERAL = 1, PAGES = 2, PLAIN_CASCADES = 4 };

/* What a program is made for. */
typedef struct mask_key {
  uint64_t variant; /* of mask.ps.hlsl or mask_penumbra.ps.hlsl; 0: mask_view.ps.hlsl */
  uint64_t normals;
  uint64_t moments; /* how many levels of them are read: none, one, or more */
  uint64_t ranges;  /* they are read */
  uint64_t repeats; /* maps go on at their other side */
  uint64_t format;
} mask_key;

/* Whether the programs do that leave out what few configurations ask for. */
static bool is_plain(const csm_config *config) {
  return config->cascade_count <= PLAIN_CASCADES && config->selection != CSM_SELECT_INTERVAL &&
         config->blend_mode == CSM_BLEND_OFF && config->bias_normal_texels == 0.0 && plan_bias_in_texels(config) &&
         !config->map_reversed && plan_maps_alike(config);
}

static uint64_t variant_of(const csm_config *config, bool normals) {
  const bool early = config->filter_early_out;
  const int32_t bias = plan_has_moments(config) ? CSM_BIAS_RECEIVER_PLANE : (int32_t)config->bias_mode;
  return shader_key_mask((int32_t)config->filter, early ? BIAS_AS_CONFIGURED : bias, early, normals,
                         !is_plain(config)        ? GENERAL
                         : plan_has_pages(config) ? PAGES
                                                  : PLAIN,
                         plan_has_ranges(config));
}

static csm_result make(gpu gpu, const void *about, gpu_program **out) {
  const mask_key *key = about;
  const gpu_program_info info = {
      .name = key->variant ? "mask" : "mask view",
      .vertex = key->normals ? shader_mask_normals_vs : shader_mask_vs,
      .pixel = key->variant ? *shader_find(key->variant) : shader_mask_view_ps,
      .constants_count = 2,
      .constants_sizes = {MASK_CASCADES_BLOCK, MASK_CAMERA_BLOCK},
      .texture_count = 2 + (key->moments > 0) + (key->ranges > 0) + (key->normals > 0),
      .sampler_count = key->moments ? 3 : 2,
      .samplers = {GPU_SAMPLER_POINT_CLAMP, key->repeats ? GPU_SAMPLER_POINT_REPEAT : GPU_SAMPLER_POINT_CLAMP,
                   key->moments > 1 ? GPU_SAMPLER_TRILINEAR_CLAMP : GPU_SAMPLER_LINEAR_CLAMP},
      .color_format = (gpu_format)key->format,
      .cull = GPU_CULL_NONE,
  };
  return gpu_program_create(gpu, &info, out);
}

bool mask_reads_moments(const csm_config *config, uint32_t show) {
  return plan_has_moments(config) && (show == CSM_SHOW_VISIBILITY || show == CSM_SHOW_PENUMBRA);
}

bool mask_reads_ranges(const csm_config *config, uint32_t show) {
  return plan_has_ranges(config) && show == CSM_SHOW_VISIBILITY;
}

gpu_format mask_format(const csm_config *config, uint32_t show) {
  return config->history == CSM_HISTORY_ON && show == CSM_SHOW_VISIBILITY ? GPU_FORMAT_RG16_UNORM : GPU_FORMAT_R8_UNORM;
}

static mask_key key_of(const csm_config *config, bool normals, uint32_t show) {
  const bool moments = mask_reads_moments(config, show);
  const bool seen = show == CSM_SHOW_VISIBILITY, rays = show == CSM_SHOW_RAYS;
  return (mask_key){.variant = seen   ? variant_of(config, normals)
                               : rays ? shader_key_mask_rays((int32_t)config->filter, normals)
                               : show == CSM_SHOW_PENUMBRA
                                   ? shader_key_mask_penumbra(moments ? CSM_FILTER_VSSM : CSM_FILTER_PCSS)
                                   : 0,
                    .normals = normals && (seen || rays),
                    .moments = !moments                    ? 0
                               : config->moment_levels > 1 ? 2
                                                           : 1,
                    .ranges = mask_reads_ranges(config, show),
                    .repeats = plan_has_pages(config),
                    .format = mask_format(config, show)};
}

csm_result mask_program_create(gpu gpu, const csm_config *config, bool normals, uint32_t show, gpu_program **out) {
  const mask_key key = key_of(config, normals, show);
  return make(gpu, &key, out);
}

csm_result mask_program(device *device, const csm_config *config, bool normals, uint32_t show, gpu_program **out) {
  const mask_key about = key_of(config, normals, show);
  const program_key key = {.make = make, .name = "a mask program", .about = &about, .size = sizeof about};
  return programs_find(device, &key, out);
}
