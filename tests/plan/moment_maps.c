#include "moment_maps.h"

#include "plan/internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const uint32_t filters[] = {CSM_FILTER_VSM, CSM_FILTER_ESM, CSM_FILTER_EVSM2, CSM_FILTER_EVSM4, CSM_FILTER_MSM4};

/* Five filters, two formats, alone and blurred and with levels; then five more for layers. */
const moment_case *moment_case_at(int index) {
  static moment_case cases[moment_case_count];
  moment_case *c = &cases[index];
  *c = (moment_case){.filter = filters[index % 5], .format = (uint32_t)(index / 5 % 2), .levels = 1, .layers = 1};
  if (index >= 20)
    *c = (moment_case){.filter = CSM_FILTER_VSM,
                       .format = index == 20,
                       .blur_texels = index < 22 ? 0 : 2,
                       .levels = index < 23 ? 1 : 4,
                       .layers = index == 24 ? 3 : 4};
  else if (index >= 10) {
    c->blur_texels = 3;
    c->levels = 4;
  }
  return c;
}

const char *moment_case_name(const moment_case *c) {
  static char name[96];
  (void)snprintf(name, sizeof name, "filter %u, format %u, blur %u, levels %u, layers %u", c->filter, c->format,
                 c->blur_texels, c->levels, c->layers);
  return name;
}

csm_config moment_config(const moment_case *c) {
  csm_config config = default_config();
  config.cascade_count = 1;
  config.resolution = moment_side;
  config.filter = c->filter;
  config.moment_format = c->format;
  config.moment_blur_texels = c->blur_texels;
  config.moment_levels = c->levels;
  config.moment_sampling = c->levels > 1 ? CSM_SAMPLING_ANISOTROPIC : CSM_SAMPLING_BILINEAR;
  config.moment_anisotropy = 8;
  config.moment_layers = c->layers;
  config.moment_bias = config.moment_deviation_m = config.moment_deviation_slope = config.moment_deviation_range = 0.0;
  config.moment_exponent = config.moment_exponent_negative = 100.0;
  config.bleeding_reduction = 0.0;
  config.bleeding_power = 1.0;
  return config;
}

/* ---- formats ---- */

/* `directed`: towards zero, as Direct3D stores it. */
static float rounded_to_half(float v, bool directed) {
  if (v == 0.0f || !isfinite(v))
    return v;
  int exponent;
  (void)frexpf(v, &exponent);
  const double unit = ldexp(1.0, (exponent < -13 ? -13 : exponent) - 11);
  const double nearest = (directed ? trunc((double)v / unit) : nearbyint((double)v / unit)) * unit;
  return fabs(nearest) > 65504.0 ? copysignf(INFINITY, v) : (float)nearest;
}

float moment_rounded(uint32_t format, float v) {
  return format == CSM_MOMENTS_FLOAT16 ? rounded_to_half(v, false) : v;
}

static float stored(const moment_map *map, float v) {
  return map->config.moment_format == CSM_MOMENTS_FLOAT16 ? rounded_to_half(v, !map->nearest) : v;
}

/* ---- images ---- */

void moment_map_plan(moment_map *map, const csm_config *config) {
  const test_camera camera = plain_camera();
  const char *error = "";
  map->config = *config;
  if (plan_config_check(config, &error))
    fail_msg("%s", error);
  const plan_frame frame = plan_empty(config, &camera, (double[]){0.3, -1.0, 0.2});
  (void)plan_write_constants((float *)&map->constants, &frame, config);
  plan_moments moments;
  plan_moments_make(&moments, config);
  map->levels = moments.levels;
  static const float empty[16] = {0};
  sampler_bind((const float *)&map->constants, empty, 1, 1, 1);
}

static void bind(const moment_map *map) {
  sampler_bind_moments(map->texels, moment_side, map->config.moment_layers, map->levels);
}

static int inside(int i) {
  return i < 0 ? 0 : i >= moment_side ? moment_side - 1 : i;
}

/* One pass of the blur, as differences from the middle: what is flat stays as it is. */
static void blur(const moment_map *map, float *to, const float *from, int right, int down) {
  const int radius = (int)map->config.moment_blur_texels;
  const float weight = 1.0f / (2.0f * (float)radius + 1.0f);
  for (int y = 0; y < moment_side; ++y)
    for (int x = 0; x < moment_side; ++x)
      for (int k = 0; k < 4; ++k) {
        const float middle = from[(y * moment_side + x) * 4 + k];
        float sum = 0.0f;
        for (int i = -radius; i <= radius; ++i)
          sum += from[(inside(y + i * down) * moment_side + inside(x + i * right)) * 4 + k] - middle;
        to[(y * moment_side + x) * 4 + k] = stored(map, fmaf(weight, sum, middle));
      }
}

static void bring_down(const moment_map *map, float *to, const float *from, int side) {
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      for (int k = 0; k < 4; ++k) {
        const float *four = &from[(2 * y * 2 * side + 2 * x) * 4 + k];
        const float sum = (four[0] + four[4]) + (four[8 * side] + four[8 * side + 4]);
        to[(y * side + x) * 4 + k] = stored(map, 0.25f * sum);
      }
}

/* The levels below the first, which lie behind all its layers. */
static void make_levels(moment_map *map) {
  float *from = map->texels;
  for (uint32_t level = 1; level < map->levels; ++level) {
    const int above = moment_side >> (level - 1), side = above / 2, layers = (int)map->config.moment_layers;
    float *to = from + 4 * above * above * layers;
    for (int layer = 0; layer < layers; ++layer)
      bring_down(map, to + 4 * side * side * layer, from + 4 * above * above * layer, side);
    from = to;
  }
}

void moment_map_make(moment_map *map, const float *depths) {
  static float passes[2][4 * moment_side * moment_side];
  for (uint32_t layer = 0; layer < map->config.moment_layers; ++layer) {
    float *const level = map->texels + (size_t)layer * 4 * moment_side * moment_side;
    for (int i = 0; i < moment_side * moment_side; ++i) {
      sampler_moments_of(&passes[0][i * 4], depths[i], (float)layer);
      for (int k = 0; k < 4; ++k)
        passes[0][i * 4 + k] = stored(map, passes[0][i * 4 + k]);
    }
    if (map->config.moment_blur_texels) {
      blur(map, passes[1], passes[0], 1, 0);
      blur(map, passes[0], passes[1], 0, 1);
    }
    memcpy(level, passes[0], sizeof passes[0]);
  }
  make_levels(map);
  bind(map);
}

void moment_map_flat(moment_map *map, float depth) {
  moment_map_mix(map, depth, depth, 1.0);
}

/* What is the same everywhere is so in every level. */
void moment_map_mix(moment_map *map, float nearer, float farther, double share) {
  float *texel = map->texels;
  for (uint32_t level = 0; level < map->levels; ++level)
    for (uint32_t layer = 0; layer < map->config.moment_layers; ++layer) {
      float a[4], b[4], mixed[4];
      sampler_moments_of(a, nearer, (float)layer);
      sampler_moments_of(b, farther, (float)layer);
      for (int k = 0; k < 4; ++k) {
        const double mean = share * (double)a[k] + (1.0 - share) * (double)b[k];
        mixed[k] = stored(map, (float)mean);
      }
      const int side = moment_side >> level;
      for (int i = 0; i < side * side; ++i, texel += 4)
        memcpy(texel, mixed, sizeof mixed);
    }
  bind(map);
}

float moment_map_visibility(const moment_map *map, double depth) {
  sampler_spot spot = {.place = {moment_side / 2.0f, moment_side / 2.0f}, .room = moment_side / 4.0f};
  spot.depth = (float)(depth - (double)map->constants.settings.units[0]);
  return sampler_filter_spot(&spot);
}
