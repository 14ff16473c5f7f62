/* write.c: the floats that shaders read. Everything is computed in doubles and rounded once. */
#include "plan/internal.h"

#include "csm_constants.h"
#include <math.h>

/*
 * A frame without shadows (frame->unshadowed) needs nothing of its own here. plan_fit_nothing has given its cascades
 * intervals that end far below every view depth, and matrices that put every point at texture coordinates and a depth
 * of 2. So a shader that runs through a fixed number of cascades finds none that holds a point.
 */

static void put(float *out, uint32_t index, double x, double y, double z, double w) {
  out[index * 4] = plan_float(x);
  out[index * 4 + 1] = plan_float(y);
  out[index * 4 + 2] = plan_float(z);
  out[index * 4 + 3] = plan_float(w);
}

/* The place of a map's lower left texel on the world's grid, which repeats after so many texels. */
static double grid_place(const plan_cascade *cascade) {
  const double period = 2048.0;
  double place[2];
  for (int i = 0; i < 2; ++i) {
    const double texel = floor(cascade->origin_texels[i]);
    place[i] = texel - floor(texel / period) * period;
  }
  return place[0] + 4096.0 * place[1];
}

static void put_cascade(float *out, uint32_t index, const plan_frame *frame, const plan_cascade *cascade,
                        double reach_texels) {
  const csm_cascade_info *info = &cascade->info;
  const double *m = info->world_to_shadow, *origin = frame->origin;
  put(out, CSM_C_TEXELS + index, info->texel_size, 1.0 / info->depth_range, reach_texels * info->texel_size,
      cascade->texel[0] / cascade->texel[1]);
  for (uint32_t row = 0; row < 3; ++row)
    put(out, CSM_C_MATRICES + index * 3 + row, m[row], m[4 + row], m[8 + row],
        m[row] * origin[0] + m[4 + row] * origin[1] + m[8 + row] * origin[2] + m[12 + row]);
  out[CSM_C_GRID * 4 + index] = plan_float(grid_place(cascade));
}

static void put_filter(float *out, const csm_config *config) {
  double weights[PLAN_MAX_WEIGHTS];
  const double sum = plan_filter_weights(weights, config);
  put(out, CSM_C_KERNEL, config->filter, plan_filter_taps(config), config->filter_radius_texels, 1.0 / (sum * sum));
  for (uint32_t i = 0; i < PLAN_MAX_WEIGHTS; ++i)
    out[CSM_C_WEIGHTS * 4 + i] = (float)weights[i];
  put(out, CSM_C_OPTIONS, config->filter_early_out, 0.0, 0.0, 0.0);
}

static void put_bias(float *out, const csm_config *config) {
  /* A depth in 16 bits is off by up to half a unit; what a float is off by lies within the bias in texels. */
  const double rounding = config->map_format == CSM_MAP_D16 ? 0.5 / 65535.0 : 0.0;
  put(out, CSM_C_BIAS, config->bias_constant_texels, config->bias_slope_texels, config->bias_slope_max,
      config->bias_normal_texels);
  put(out, CSM_C_UNITS, config->bias_constant_range + rounding, config->bias_constant_m, config->bias_slope_range,
      config->bias_limit_range > 0.0 ? config->bias_limit_range : 1e30);
}

static void put_maps(float *out, const csm_config *config) {
  plan_layout layout;
  plan_layout_make(&layout, config);
  for (uint32_t i = 0; i < CSM_CONSTANTS_CASCADES; ++i) {
    const plan_rect *rect = &layout.rects[i < config->cascade_count ? i : config->cascade_count - 1];
    put(out, CSM_C_RECTS + i, rect->x, rect->y, rect->side, rect->layer);
  }
  put(out, CSM_C_PARAMS, config->cascade_count, layout.width, 1.0 / layout.width, 0.0);
  put(out, CSM_C_IMAGE, 1.0 / layout.width, 1.0 / layout.height, config->map_reversed ? -1.0 : 1.0,
      config->normal_offset_mode);
}

uint32_t plan_write_constants(float *out, const plan_frame *frame, const csm_config *config) {
  const uint32_t count = frame->cascade_count;
  const double *view = frame->camera.view, side = plan_view_side(&frame->camera);
  /* A plane under the filter needs no more than what it cannot know: half a texel. */
  const double reach_texels = config->bias_mode == CSM_BIAS_SLOPE ? plan_filter_reach_texels(config) : 0.5;
  put_maps(out, config);
  put(out, CSM_C_DEPTH, side * view[2], side * view[6], side * view[10], 0.0);
  for (uint32_t i = 0; i < 3; ++i)
    put(out, CSM_C_BASIS + i, frame->basis[i * 3], frame->basis[i * 3 + 1], frame->basis[i * 3 + 2], 0.0);
  for (uint32_t i = 0; i < CSM_CONSTANTS_CASCADES; ++i) {
    const plan_cascade *cascade = &frame->cascades[i < count ? i : count - 1];
    out[CSM_C_SPLITS * 4 + i] = plan_float(cascade->info.far_depth);
    put_cascade(out, i, frame, cascade, reach_texels);
  }
  const double end = frame->cascades[count - 1].info.far_depth;
  out[CSM_C_PARAMS * 4 + 3] = plan_float(end);
  out[CSM_C_BIAS_MODE * 4 + 3] = config->bias_mode == CSM_BIAS_RECEIVER_PLANE;
  out[CSM_C_FILTER * 4 + 3] = config->filter == CSM_FILTER_PCF_3X3 ? 3.0f : 1.0f;
  put_bias(out, config);
  put_filter(out, config);
  put(out, CSM_C_MODES, config->selection, plan_filter_radius_texels(config), config->out_of_range, config->blend_mode);
  const double fade = config->fade_share * end;
  put(out, CSM_C_BAND, config->blend_share, end - fade, fade > 1e-30 ? 1.0 / fade : 0.0,
      frame->cascades[0].info.near_depth);
  return CSM_C_COUNT * 4 * sizeof(float);
}

/* 1 if image right, image up and back to the viewer are a right-handed basis of the world, else -1. */
static double image_handedness(const plan_camera *camera) {
  const double *v = camera->view, *p = camera->projection;
  double cross[3];
  plan_cross(cross, &v[0], &v[4]);
  const double view = plan_dot(cross, &v[8]);
  const double image = p[0] * p[5] - p[4] * p[1];
  return copysign(1.0, view) * copysign(1.0, image) * -plan_view_side(camera);
}

uint32_t plan_write_mask_constants(float *out, const plan_frame *frame, const plan_camera *camera, uint32_t width,
                                   uint32_t height, bool unorm_normals, uint32_t view) {
  double unproject[16], rotation[9];
  (void)plan_invert(unproject, camera->projection); /* plan_camera_make saw to it that it can be */
  plan_view_rotation_inverse(rotation, camera->view);
  for (int row = 0; row < 3; ++row) {
    const double apart = camera->position[row] - frame->origin[row];
    double values[4];
    for (int k = 0; k < 4; ++k)
      values[k] = rotation[row] * unproject[k * 4] + rotation[3 + row] * unproject[k * 4 + 1] +
                  rotation[6 + row] * unproject[k * 4 + 2] + apart * unproject[k * 4 + 3];
    put(out, CSM_M_INVERSE + (uint32_t)row, values[0], values[1], values[2], values[3]);
  }
  put(out, CSM_M_INVERSE + 3, unproject[3], unproject[7], unproject[11], unproject[15]);
  put(out, CSM_M_SIZE, width, height, 1.0 / width, 1.0 / height);
  put(out, CSM_M_CLEAR, camera->reversed ? 0.0 : 1.0, image_handedness(camera), unorm_normals ? 2.0 : 1.0,
      unorm_normals ? -1.0 : 0.0);
  put(out, CSM_M_VIEW, view, 0.0, 0.0, 0.0);
  return CSM_M_COUNT * 4 * sizeof(float);
}
