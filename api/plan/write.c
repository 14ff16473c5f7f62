/* write.c: the floats that shaders read. Everything is computed in doubles and rounded once. */
#include "plan/internal.h"

#include "csm_constants.h"
#include <math.h>
#include <string.h>

/*
 * A frame without shadows (frame->unshadowed) needs nothing of its own here. plan_fit_nothing has given its cascades
 * intervals that end far below every view depth, and scales that put every point at texture coordinates and a depth of
 * 2. So a shader that runs through a fixed number of cascades finds none that holds a point.
 */

static void put(float *out, uint32_t index, double x, double y, double z, double w) {
  out[index * 4] = plan_float(x);
  out[index * 4 + 1] = plan_float(y);
  out[index * 4 + 2] = plan_float(z);
  out[index * 4 + 3] = plan_float(w);
}

/* The place of a map's lower left texel on its grid, which repeats after so many texels. */
static double grid_place(const plan_cascade *cascade) {
  const double period = 2048.0;
  double place[2];
  for (int i = 0; i < 2; ++i) {
    const double texel = cascade->place_texels[i];
    place[i] = texel - floor(texel / period) * period;
  }
  return place[0] + 4096.0 * place[1];
}

/* Where a cascade's map lies in light space that begins at the frame's origin. */
static void put_cascade(float *out, uint32_t index, const plan_frame *frame, const plan_cascade *cascade) {
  double scale[3], offset[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    scale[axis] = cascade->to_clip[axis * 5];
    offset[axis] = scale[axis] * plan_dot(&frame->basis[axis * 3], frame->origin) + cascade->to_clip[axis * 4 + 3];
  }
  offset[2] -= scale[2] * cascade->shift;
  put(out, CSM_C_SCALES + index, scale[0], scale[1], scale[2], cascade->jitter_texels[0]);
  put(out, CSM_C_OFFSETS + index, offset[0], offset[1], offset[2], cascade->jitter_texels[1]);
  out[CSM_C_GRID * 4 + index] = plan_float(grid_place(cascade));
}

/* One that holds nothing: all of light space lies beyond its border. */
static void put_no_cascade(float *out, uint32_t index) {
  put(out, CSM_C_SCALES + index, 0.0, 0.0, 0.0, 0.0);
  put(out, CSM_C_OFFSETS + index, 2.0, 2.0, 2.0, 0.0);
  out[CSM_C_GRID * 4 + index] = 0.0f;
}

static void put_maps(float *out, const plan_frame *frame, const csm_config *config) {
  plan_layout layout;
  plan_layout_make(&layout, config);
  const double border = plan_filter_radius_texels(config);
  for (uint32_t i = 0; i < CSM_CONSTANTS_CASCADES; ++i) {
    const uint32_t index = i < frame->cascade_count ? i : frame->cascade_count - 1;
    const plan_cascade *cascade = &frame->cascades[index];
    const plan_rect *rect = &layout.rects[index];
    const double side = cascade->resolution; /* the rectangle's, unless a budget uses its top left part */
    put(out, CSM_C_RECTS + i, rect->x + cascade->begin_texels[0], rect->y + cascade->begin_texels[1], side,
        rect->layer);
    put(out, CSM_C_TEXELS + i, cascade->info.texel_size, 1.0 / cascade->info.depth_range, 1.0 - 2.0 * border / side,
        cascade->texel[0] * cascade->texel[1]);
    out[CSM_C_SPLITS * 4 + i] = plan_float(cascade->info.far_depth);
    if (i == index)
      put_cascade(out, i, frame, cascade);
    else
      put_no_cascade(out, i);
  }
  const double end = frame->cascades[frame->cascade_count - 1].info.far_depth;
  put(out, CSM_C_PARAMS, frame->cascade_count, end, 1.0 / layout.width, 1.0 / layout.height);
}

static void put_filter(float *out, const csm_config *config) {
  double weights[PLAN_MAX_WEIGHTS];
  const double sum = plan_filter_weights(weights, config);
  put(out, CSM_S_KERNEL, config->filter, plan_filter_taps(config), config->filter_radius_texels, 1.0 / (sum * sum));
  for (uint32_t i = 0; i < PLAN_MAX_WEIGHTS; ++i)
    out[CSM_S_WEIGHTS * 4 + i] = (float)weights[i];
}

static void put_bias(float *out, const csm_config *config) {
  /* A plane under the filter needs no more than what it cannot know: half a texel. A mean of depths is on it. */
  const bool plane = config->bias_mode == CSM_BIAS_RECEIVER_PLANE || plan_has_moments(config);
  const double reach_texels = plane ? 0.5 : plan_filter_reach_texels(config);
  plan_moment_errors errors;
  plan_moment_errors_make(&errors, config);
  /* A depth in 16 bits is off by up to half a unit; what a float is off by lies within the bias in texels. Moments are off
     by as much as they say, of a range from -1 to 1. */
  const double rounding = (config->map_format == CSM_MAP_D16 ? 0.5 / 65535.0 : 0.0) + errors.mean / 2.0;
  put(out, CSM_S_BIAS, config->bias_constant_texels, config->bias_slope_texels * reach_texels, config->bias_slope_max,
      config->bias_normal_texels);
  put(out, CSM_S_UNITS, config->bias_constant_range + rounding, config->bias_constant_m, config->bias_slope_range,
      config->bias_limit_range > 0.0 ? config->bias_limit_range : 1e30);
  put(out, CSM_S_OWN, fmax(config->bias_plane_max, config->bias_slope_max), plan_filter_reach_texels(config),
      plan_filter_least_share(config), errors.variance);
}

static void put_moments(float *out, const csm_config *config) {
  const double deviation = 2.0 * config->moment_deviation_range;
  const bool samples = config->moment_sampling != CSM_SAMPLING_BILINEAR || config->filter == CSM_FILTER_VSSM;
  const bool packed = config->filter == CSM_FILTER_MSM4 && config->moment_format == CSM_MOMENTS_FLOAT16;
  plan_moments moments = {.levels = 1, .side = 1, .depth_layers = 1};
  if (plan_has_moments(config))
    plan_moments_make(&moments, config);
  plan_moment_errors errors;
  plan_moment_errors_make(&errors, config);
  put(out, CSM_S_MOMENTS, config->filter == CSM_FILTER_MSM4 ? packed : errors.exponent, errors.negative,
      fmax(config->moment_bias, errors.bias), moments.depth_layers);
  put(out, CSM_S_VARIANCE, deviation * deviation + errors.mean * errors.mean, config->moment_deviation_m,
      config->moment_deviation_slope, 1.0 / (moments.side << config->moment_halved));
  put(out, CSM_S_BLEEDING, config->bleeding_reduction, 1.0 / (1.0 - config->bleeding_reduction), config->bleeding_power,
      config->bleeding_curve);
  put(out, CSM_S_LEVELS, samples ? moments.levels - 1.0 : 0.0, plan_moment_spread(config),
      config->moment_sampling == CSM_SAMPLING_ANISOTROPIC ? config->moment_anisotropy : 1.0,
      config->moment_halved ? 0.5 : 1.0);
}

static void put_soft(float *out, const plan_frame *frame, const csm_config *config) {
  put(out, CSM_S_SOFT, tan(0.5 * frame->light_diameter), config->soft_search_taps, config->soft_taps,
      config->soft_radius_max_texels);
  put(out, CSM_S_SOFT_MORE, config->soft_penumbra, config->soft_light_range, config->soft_radius_least_texels, 0.0);
}

/* CSM_R_*, but for what the instances' tree tells. Depths and positions are a few last places of floats off (measured: a
   surface meets itself below 2^-20 of the view depth, or of how far the origin is; docs/exact.md). */
static void put_rays(float *out, const plan_frame *frame, const csm_config *config) {
  float high[3];
  double low[3];
  for (int i = 0; i < 3; ++i) {
    high[i] = (float)frame->origin[i];
    low[i] = frame->origin[i] - high[i];
  }
  put(out, CSM_R_HIGH, high[0], high[1], high[2], config->ray_taps);
  put(out, CSM_R_LOW, low[0], low[1], low[2], 0.0);
  put(out, CSM_R_OFFSET, 0.0, 0.0, 0.0, 3e-6);
  put(out, CSM_R_UNSURE, config->ray_unsure_cosine * config->ray_unsure_cosine,
      config->ray_grazing_cosine * config->ray_grazing_cosine, 0.0, 0.0);
}

static void put_settings(float *out, const plan_frame *frame, const csm_config *config) {
  const double end = frame->shadow_end, fade = config->fade_share * end;
  put_bias(out, config);
  put_filter(out, config);
  put(out, CSM_S_MODES, config->selection, config->out_of_range, config->blend_mode, config->normal_offset_mode);
  put(out, CSM_S_BAND, config->blend_share, end - fade, fade > 1e-30 ? 1.0 / fade : 0.0,
      frame->cascades[0].info.near_depth);
  put(out, CSM_S_OPTIONS, config->bias_mode, config->filter_early_out, config->map_reversed ? -1.0 : 1.0,
      config->map_reversed ? 0.0 : 1.0);
  put_moments(out, config);
  put_soft(out, frame, config);
  put_rays(out, frame, config);
}

/*
 * A picture of one column or row tells no plane of what it shows, if its normals come from the depth: its receivers are
 * taken to face the light, with the bias of one depth for the whole filter at the steepest slope that bias grows with.
 */
static bool knows_no_plane(const plan_picture *picture) {
  return !picture->normals && (picture->width == 1 || picture->height == 1);
}

/* CSM_M_BIAS: x, y and z of CSM_S_BIAS, and x of CSM_S_UNITS. */
static void put_picture_bias(float *out, const plan_picture *picture, const csm_config *config) {
  float settings[CSM_C_COUNT * 4];
  put_bias(settings, config);
  const float *bias = &settings[CSM_S_BIAS * 4], *units = &settings[CSM_S_UNITS * 4];
  double texels = bias[0], range = units[0];
  if (knows_no_plane(picture)) {
    texels += config->bias_slope_max * config->bias_slope_texels * plan_filter_reach_texels(config);
    range += fmin(config->bias_slope_max * config->bias_slope_range, units[3]);
  }
  put(out, CSM_M_BIAS, texels, bias[1], bias[2], range);
}

/* The way the camera looks, as its view has it, and the view depth of the frame's origin. */
static double look(double forward[3], const plan_frame *frame) {
  const double *view = frame->camera.view, side = plan_view_side(&frame->camera);
  double depth = 0.0;
  for (int i = 0; i < 3; ++i) {
    forward[i] = side * view[i * 4 + 2];
    depth += forward[i] * (frame->origin[i] - frame->camera.position[i]);
  }
  return depth;
}

uint32_t plan_write_constants(float *out, const plan_frame *frame, const csm_config *config) {
  double forward[3];
  const double depth = look(forward, frame);
  memset(out, 0, CSM_C_COUNT * 4 * sizeof(float));
  put(out, CSM_C_DEPTH, forward[0], forward[1], forward[2], depth);
  for (uint32_t i = 0; i < 3; ++i)
    put(out, CSM_C_BASIS + i, frame->basis[i * 3], frame->basis[i * 3 + 1], frame->basis[i * 3 + 2], 0.0);
  put_maps(out, frame, config);
  put_settings(out, frame, config);
  return CSM_C_COUNT * 4 * sizeof(float);
}

/* How a camera's pixels and light space belong together: CSM_M_LIGHT, CSM_M_PLANES and CSM_M_NORMALS. */
static void put_pixels(float *out, const plan_frame *frame, const plan_picture *picture) {
  const plan_camera *camera = picture->camera;
  double to_pixels[16], to_relative[16];
  plan_relative_to_pixels(to_pixels, frame, camera, picture->width, picture->height);
  plan_pixels_to_relative(to_relative, frame, camera, picture->width, picture->height);
  /* A plane's value grows towards what has less depth, which is the viewer's side unless depth is reversed */
  const double viewer = camera->reversed ? -1.0 : 1.0;
  const double decode = picture->unorm_normals ? 2.0 : 1.0, middle = picture->unorm_normals ? -1.0 : 0.0;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const double *a = &frame->basis[axis * 3];
    double light[4], plane[4];
    for (int k = 0; k < 4; ++k) {
      light[k] = plan_dot(a, &to_relative[k * 4]);
      plane[k] = viewer * plan_dot(a, (const double[3]){to_pixels[k], to_pixels[4 + k], to_pixels[8 + k]});
    }
    put(out, CSM_M_LIGHT + axis, light[0], light[1], light[2], light[3]);
    if (knows_no_plane(picture))
      put(out, CSM_M_PLANES + axis, 0.0, 0.0, axis == 2 ? 1.0 : 0.0, 0.0);
    else
      put(out, CSM_M_PLANES + axis, plane[0], plane[1], plane[2], plane[3]);
    put(out, CSM_M_NORMALS + axis, decode * a[0], decode * a[1], decode * a[2], middle * (a[0] + a[1] + a[2]));
  }
  put(out, CSM_M_LIGHT + 3, to_relative[3], to_relative[7], to_relative[11], to_relative[15]);
}

/*
 * What CSM_M_CLEAR says of rounding. A normal's components are each off by it, and their sum along the light by all of
 * them. A depth's step is the difference of two depths, each of which the format rounds, and interpolation, a chain of
 * three sums and products, by up to three times a float's half last place.
 */
static plan_grain normal_rounding(const plan_frame *frame, const plan_picture *picture) {
  const double *along = &frame->basis[6];
  const plan_grain r = picture->rounding;
  const double decode = picture->unorm_normals ? 2.0 : 1.0, sum = fabs(along[0]) + fabs(along[1]) + fabs(along[2]);
  return picture->normals ? (plan_grain){r.share, decode * sum * r.step}
                          : (plan_grain){2.0 * r.share + 6.0 * 0x1p-24, 2.0 * r.step};
}

uint32_t plan_write_mask_constants(float *out, const plan_frame *frame, const plan_picture *picture,
                                   const csm_config *config) {
  const double width = picture->width, height = picture->height;
  const plan_grain rounding = normal_rounding(frame, picture);
  double forward[3];
  const double depth = look(forward, frame);
  put_pixels(out, frame, picture);
  put(out, CSM_M_SIZE, width, height, 1.0 / width, 1.0 / height);
  put_picture_bias(out, picture, config);
  put(out, CSM_M_CLEAR, plan_clear_depth(picture->camera), picture->show, rounding.share, rounding.step);
  put(out, CSM_M_DEPTH_OFF, picture->depth_rounding.share, picture->depth_rounding.step, 0.0, 0.0);
  put(out, CSM_M_DEPTH, plan_dot(forward, &frame->basis[0]), plan_dot(forward, &frame->basis[3]),
      plan_dot(forward, &frame->basis[6]), depth);
  return CSM_M_COUNT * 4 * sizeof(float);
}
