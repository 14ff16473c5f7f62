#include "techniques/maps/casters.h"

#include "shader_code.h"
#include "techniques/draw_list.h"

/* The rasteriser biases away from the light, which is towards 0 where depth is reversed. */
caster_look caster_look_of(const csm_config *config) {
  static const gpu_cull culls[] = {[CSM_FACE_CULLING_NONE] = GPU_CULL_NONE,
                                   [CSM_FACE_CULLING_FRONT] = GPU_CULL_FRONT,
                                   [CSM_FACE_CULLING_BACK] = GPU_CULL_BACK};
  const float away = config->map_reversed ? -1.0f : 1.0f;
  return (caster_look){.format = config->map_format == CSM_MAP_D16 ? GPU_FORMAT_D16_UNORM : GPU_FORMAT_D32_FLOAT,
                       .reversed = config->map_reversed,
                       .clip = config->pancaking == CSM_PANCAKING_CLIP,
                       .cull = culls[config->face_culling],
                       .bias = {.constant = (int32_t)(away * (float)config->polygon_offset_constant),
                                .slope = away * (float)config->polygon_offset_slope,
                                .clamp = away * (float)config->polygon_offset_clamp}};
}

/* Without padding, as keys want it. */
typedef struct caster_key {
  uint32_t format, reversed, clip, cull;
  gpu_raster_bias bias;
  mesh_vertices vertices;
} caster_key;

static csm_result make(gpu gpu, const void *about, gpu_program **out) {
  const caster_key *key = about;
  const draw_list_kind kind = {.name = "cascade depth",
                               .vertex = shader_cascade_depth_vs,
                               .cut_out_vertex = shader_cascade_depth_alpha_mask_vs,
                               .rows = CASTER_ROWS,
                               .format = (gpu_format)key->format,
                               .compare = key->reversed ? GPU_COMPARE_GREATER : GPU_COMPARE_LESS,
                               .clip = key->clip,
                               .cull = (gpu_cull)key->cull,
                               .bias = key->bias};
  return draw_list_program(gpu, &kind, key->vertices, out);
}

static void give_back_shape(device *device, caster_programs *programs, uint32_t shape) {
  for (gpu_cull cull = GPU_CULL_NONE; cull <= GPU_CULL_FRONT; ++cull) {
    programs_give_back(device, programs->programs[cull][shape]);
    programs->programs[cull][shape] = NULL;
  }
}

static csm_result take_shape(device *device, caster_programs *programs, uint32_t shape) {
  const caster_look *look = &programs->look;
  csm_result result = CSM_SUCCESS;
  for (gpu_cull cull = GPU_CULL_NONE; cull <= GPU_CULL_FRONT && !result; ++cull) {
    const caster_key about = {.format = look->format,
                              .reversed = look->reversed,
                              .clip = look->clip,
                              .cull = cull,
                              .bias = look->bias,
                              .vertices = device->shapes.vertices[shape]};
    const program_key key = {.make = make, .name = "a cascade depth program", .about = &about, .size = sizeof about};
    result = programs_take(device, &key, &programs->programs[cull][shape]);
  }
  if (result)
    give_back_shape(device, programs, shape);
  return result;
}

csm_result caster_programs_extend(device *device, caster_programs *programs) {
  csm_result result = CSM_SUCCESS;
  while (programs->shapes < device->shapes.count && !result) {
    result = take_shape(device, programs, programs->shapes);
    programs->shapes += !result;
  }
  return result;
}

void caster_programs_give_back(device *device, caster_programs *programs) {
  while (programs->shapes)
    give_back_shape(device, programs, --programs->shapes);
}
