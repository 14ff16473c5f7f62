/* moment_scene.c: moments as csm made them, and as they should be. */
#include "hard/moment_scene.h"
#include "base/host.h"
#include "base/linear.h"
#include "csm_constants.h"
#include <math.h>
#include <stdlib.h>

void moment_scene_free(moment_scene *scene) {
  free(scene->map);
  free(scene->moments);
  *scene = (moment_scene){0};
}

/* The constants that csm tells its shaders, which the model takes over; all that is done with them is its own. */
static moment_model model_of(const csm_config *config, const csm_binding *binding) {
  const csm_settings_block *block = binding->setting_constants;
  const double range = binding->cascades[0].depth_range;
  const double meters = 2.0 * config->moment_deviation_m / range;
  return (moment_model){.filter = config->filter,
                        .exponents = {block->moments[0], block->moments[1]},
                        .deviation = sqrt(block->variance[0] + meters * meters),
                        .noise = block->own[3],
                        .bias = block->moments[2],
                        .reduction = config->bleeding_reduction,
                        .power = config->bleeding_power,
                        .smoothstep = config->bleeding_curve == CSM_BLEEDING_SMOOTHSTEP};
}

static bool is_warped(const csm_config *config) {
  return config->filter >= CSM_FILTER_ESM && config->filter <= CSM_FILTER_EVSM4;
}

/*
 * How often a moment is stored: when it is made, by each way of a blur, and by each level. Stores of 16 bits may round
 * towards zero, so that all errors are to one side and add up; of 32 bits a level's are half of those before, and no more
 * than two count.
 */
static double stores(const csm_config *config) {
  const double blurs = config->moment_blur_texels > 0 ? 2.0 : 0.0, levels = config->moment_levels - 1.0;
  return 1.0 + (config->moment_format == CSM_MOMENTS_FLOAT16 ? blurs + levels : fmax(blurs, fmin(levels, 2.0)));
}

/* How often a float is rounded that sums levels and samples up, is mixed with another, and compared. */
static double sums(const csm_config *config) {
  return 4.0 + (config->moment_levels > 1 ? 3.0 : 0.0) +
         (config->moment_sampling == CSM_SAMPLING_ANISOTROPIC ? config->moment_anisotropy : 0.0);
}

static bool is_packed(const csm_config *config) {
  return config->filter == CSM_FILTER_MSM4 && config->moment_format == CSM_MOMENTS_FLOAT16;
}

/*
 * What a moment is off by being stored, as a share of itself, or, where it is 1 at most, at all: the last of 11 bits, or half
 * of the last of 24, each time. What is stored as sums of half its size is told from them as unpack does: an odd moment
 * 1/3 + sqrt(3) times as well, an even one 1.125 times.
 */
static double store_error(const csm_config *config, uint32_t moment) {
  const double share = config->moment_format == CSM_MOMENTS_FLOAT16 ? 0x1p-10 : 0x1p-24;
  const double packed = moment % 2 ? 1.125 / 2.0 : (1.0 / 3.0 + sqrt(3.0)) / 2.0;
  return stores(config) * share * (is_packed(config) ? packed : 1.0) * (is_warped(config) ? 1.0 : 0.5);
}

/* And by half of the last of 24 bits for each step of the arithmetic. */
static double moment_error(const csm_config *config, uint32_t moment) {
  return store_error(config, moment) + sums(config) * 0x1p-24 * (is_warped(config) ? 1.0 : 0.5);
}

/* A share of exp(c z) is that share over c of z; exp itself may be off by 3 + 2 |c z| of its last places, twice. */
static double mean_error(const csm_config *config, const moment_model *model) {
  const double share = moment_error(config, 0);
  double largest = share;
  for (int i = 0; is_warped(config) && i < (config->filter == CSM_FILTER_EVSM4 ? 2 : 1); i++) {
    const double c = model->exponents[i], error = (share + (3.0 + 2.0 * c) * 0x1p-22) / c;
    largest = i ? fmax(largest, error) : error;
  }
  return largest;
}

/*
 * A mean and a receiver, which is moved by as much; the float arithmetic to a depth, off by 2^-22 of the range; and half
 * a step of 16 bits, 2^-17 of it, by which a depth is off and its receiver is moved.
 */
static double doubt_of(const csm_config *config, double error) {
  return 2.0 * error + 0x1p-21 + (config->map_format == CSM_MAP_D16 ? 2.0 * 0x1p-16 : 0.0);
}

static int read_moments(moment_scene *scene, const hard_run *run) {
  const csm_config *config = &scene->config;
  scene->channels = moment_model_channels(&scene->model);
  scene->layers = config->filter == CSM_FILTER_VSM ? config->moment_layers : 1;
  scene->moment_side = config->moment_halved ? scene->side / 2 : scene->side;
  const size_t count = (size_t)scene->moment_side * scene->moment_side * scene->channels * scene->layers;
  scene->moments = host_allocate(count, sizeof *scene->moments);
  const csm_read_info info = {.struct_size = sizeof info,
                              .source = CSM_READ_MOMENTS,
                              .cascades = run->stages[0].cascades,
                              .data = scene->moments,
                              .size = count * sizeof *scene->moments};
  return csm_read(run->stages[0].context, &info) == CSM_SUCCESS ? 0 : HOST_NO_DEVICE;
}

/*
 * Four moments in 16 bits are stored as sums (Peters 2017): 1.5 a - 2 c, 4 b - 4 d, sqrt(3) / 2 a - sqrt(12) / 9 c and
 * (b + d) / 2 of a to d, the second and the fourth less a half.
 */
static void unpack(moment_scene *scene) {
  for (size_t i = 0; i < (size_t)scene->moment_side * scene->moment_side; i++) {
    float *m = &scene->moments[i * MOMENT_CHANNELS];
    const double odd[2] = {m[0], m[2]}, even[2] = {m[1] + 0.5, m[3] + 0.5};
    m[0] = (float)(-odd[0] / 3.0 + sqrt(3.0) * odd[1]);
    m[1] = (float)(even[0] / 8.0 + even[1]);
    m[2] = (float)(-0.75 * odd[0] + 0.75 * sqrt(3.0) * odd[1]);
    m[3] = (float)(even[1] - even[0] / 8.0);
  }
}

int moment_scene_read(moment_scene *out, hard_run *run, const csm_config *config) {
  moment_scene_free(out);
  out->config = *config;
  int code = hard_bind(run, &out->binding);
  if (code == 0)
    code = hard_map(run, 0, &out->map, &out->side);
  if (code)
    return code;
  out->model = model_of(config, &out->binding);
  out->error = mean_error(config, &out->model);
  out->doubt = doubt_of(config, out->error);
  const int read = read_moments(out, run);
  if (read == 0 && is_packed(config))
    unpack(out);
  return read;
}

/* ---- what they should be ---- */

double moment_scene_depth(const moment_scene *scene, const double place[3]) {
  double at[4];
  mat_transform(at, scene->binding.cascades[0].world_to_shadow, place, 1.0);
  return scene->config.map_reversed ? 1.0 - 2.0 * at[2] : 2.0 * at[2] - 1.0;
}

void moment_scene_texel(const moment_scene *scene, const double place[3], double texel[2]) {
  double at[4];
  mat_transform(at, scene->binding.cascades[0].world_to_shadow, place, 1.0);
  texel[0] = at[0] * scene->side;
  texel[1] = at[1] * scene->side;
}

static double stored_depth(const moment_scene *scene, int x, int y) {
  const int last = (int)scene->side - 1;
  const int column = x < 0 ? 0 : x > last ? last : x, row = y < 0 ? 0 : y > last ? last : y;
  const double depth = scene->map[(size_t)row * scene->side + (size_t)column];
  return scene->config.map_reversed ? 1.0 - 2.0 * depth : 2.0 * depth - 1.0;
}

/*
 * Weights of the texels from -radius to radius + 1 around a place, along one axis: the blur's, at a place between two
 * texels. A box weighs its 2 r + 1 texels alike.
 */
static void axis_weights(const moment_scene *scene, double place, double *weights, int *first) {
  const int radius = (int)scene->config.moment_blur_texels, count = 2 * radius + 1;
  const double from = floor(place - 0.5), share = place - 0.5 - from;
  *first = (int)from - radius;
  for (int i = 0; i <= count; i++)
    weights[i] = ((i < count ? 1.0 - share : 0.0) + (i > 0 ? share : 0.0)) / count;
}

enum { MOST_WEIGHTS = 2 * 32 + 2 };

/*
 * A layer of VSM holds the depths from half of its length before its own share of the range to a quarter behind it, as
 * they were a range of their own; others are taken to its ends. Lauritzen and McCool 2008.
 */
typedef struct layer {
  double begin, scale; /* in z: of the layer's -1, and of a depth from there */
} layer;

static layer layer_of(const moment_scene *scene, double z) {
  const double count = scene->layers, length = 2.0 / count;
  const double index = fmin(fmax(floor((z + 1.0) / length), 0.0), count - 1.0);
  const double begin = fmax(-1.0 + (index - 0.5) * length, -1.0), end = fmin(-1.0 + (index + 1.25) * length, 1.0);
  return (layer){.begin = begin, .scale = 2.0 / (end - begin)};
}

static double in_layer(const layer *l, double z) {
  return (z - l->begin) * l->scale - 1.0;
}

/*
 * The moments that a place in the map should have, in doubles, from the depths in the map: those of each texel, blurred
 * and read bilinearly.
 */
static void find_moments(const moment_scene *scene, const double texel[2], const layer *l,
                         double moments[MOMENT_CHANNELS]) {
  double weights[2][MOST_WEIGHTS];
  int first[2];
  const int count = 2 * (int)scene->config.moment_blur_texels + 2;
  for (int axis = 0; axis < 2; axis++)
    axis_weights(scene, texel[axis], weights[axis], &first[axis]);
  for (int i = 0; i < MOMENT_CHANNELS; i++)
    moments[i] = 0.0;
  for (int y = 0; y < count; y++)
    for (int x = 0; x < count; x++) {
      const double z = in_layer(l, stored_depth(scene, first[0] + x, first[1] + y));
      double one[MOMENT_CHANNELS];
      moment_model_warp(&scene->model, fmin(fmax(z, -1.0), 1.0), one);
      for (int i = 0; i < MOMENT_CHANNELS; i++)
        moments[i] += weights[0][x] * weights[1][y] * one[i];
    }
}

/* ---- between which two ---- */

/* Every moment is off by its rounding, up or down. */
static void widen(const moment_scene *scene, const moment_model *model, const double moments[MOMENT_CHANNELS], double z,
                  double bounds[2]) {
  for (uint32_t signs = 0; signs < 1u << scene->channels; signs++) {
    double rounded[MOMENT_CHANNELS];
    for (uint32_t i = 0; i < MOMENT_CHANNELS; i++)
      rounded[i] = moments[i] + (signs >> i & 1 ? 1.0 : -1.0) * moment_error(&scene->config, i) *
                                    (is_warped(&scene->config) ? moments[i] : 1.0);
    const double lit = moment_model_visibility(model, rounded, z);
    bounds[0] = fmin(bounds[0], lit);
    bounds[1] = fmax(bounds[1], lit);
  }
}

/* A receiver is moved towards the light by the error of a mean, or by none, and rounded. `z` lies in a layer. */
static void widen_receiver(const moment_scene *scene, const layer *l, const double moments[MOMENT_CHANNELS], double z,
                           double bounds[2]) {
  moment_model model = scene->model;
  model.deviation *= l->scale;
  widen(scene, &model, moments, z - (scene->error + 0x1p-21) * l->scale, bounds);
  widen(scene, &model, moments, z + 0x1p-21 * l->scale, bounds);
}

void moment_scene_bounds(const moment_scene *scene, const double place[3], double bounds[2]) {
  static const double steps[5][2] = {{0.0, 0.0}, {-1.0, -1.0}, {-1.0, 1.0}, {1.0, -1.0}, {1.0, 1.0}};
  const double z = moment_scene_depth(scene, place), step = 1.0 / 256.0;
  const layer l = layer_of(scene, z);
  double texel[2];
  moment_scene_texel(scene, place, texel);
  bounds[0] = 1.0;
  bounds[1] = 0.0;
  for (int i = 0; i < 5; i++) {
    const double beside[2] = {texel[0] + step * steps[i][0], texel[1] + step * steps[i][1]};
    double moments[MOMENT_CHANNELS];
    find_moments(scene, beside, &l, moments);
    widen_receiver(scene, &l, moments, in_layer(&l, z), bounds);
  }
}

void moment_scene_bounds_of_one(const moment_scene *scene, double caster, double z, double bounds[2]) {
  const layer whole = {.begin = -1.0, .scale = 1.0};
  double moments[MOMENT_CHANNELS];
  moment_model_warp(&scene->model, caster, moments);
  bounds[0] = 1.0;
  bounds[1] = 0.0;
  widen_receiver(scene, &whole, moments, z, bounds);
}

/* ---- figures ---- */

void moment_scene_name(const csm_config *config, char *out, size_t size) {
  static const char *const names[] = {"vsm", "esm", "evsm2", "evsm4", "msm4"};
  const char *name = config->filter == CSM_FILTER_VSSM ? "vssm" : names[config->filter - CSM_FILTER_VSM];
  const int bits = config->moment_format == CSM_MOMENTS_FLOAT16 ? 16 : 32;
  if (config->filter == CSM_FILTER_VSM && config->moment_layers > 1)
    snprintf(out, size, "%s of %u layers, float%d", name, config->moment_layers, bits);
  else
    snprintf(out, size, "%s, float%d", name, bits);
}

/* What shaders take off a variance. */
static double noise(const moment_scene *scene, double square) {
  return scene->model.noise * (is_warped(&scene->config) ? square : 1.0);
}

/* The least variance that shaders take for a pair of moments: a deviation of z by the warp's slope. */
static double least_variance(const moment_scene *scene, uint32_t pair, double mean) {
  const bool warped = is_warped(&scene->config);
  const double deviation = scene->model.deviation * (warped ? scene->model.exponents[pair] * fabs(mean) : 1.0);
  return deviation * deviation;
}

/* An exponential may be off by 3 + 2 |c z| of its last places, and its square by twice that. */
static double exponential_error(const moment_scene *scene, uint32_t moment) {
  const double c = scene->model.exponents[moment / 2];
  return (3.0 + 2.0 * c) * 0x1p-23 * (moment % 2 ? 2.0 : 1.0);
}

/* What a warped moment is off when it is made and stored. */
static double warped_error(const moment_scene *scene, uint32_t moment) {
  return moment_error(&scene->config, moment) + exponential_error(scene, moment);
}

/*
 * A depth of 16 bits is rounded to a float, and doubled with it, and so is z, by half of the last of 24 bits each; the n-th
 * power of z is off by n times as much, and by as much for each product.
 */
static double power_error(const moment_scene *scene, uint32_t moment) {
  const double power = moment + 1.0, z = scene->config.map_format == CSM_MAP_D16 ? 3.0 : 1.0;
  return (power * z + power - 1.0) * 0x1p-25;
}

/* A blur adds each of its texels, along a row and along a column, to what is 1 at most, and is rounded each time. A float of
   32 bits is stored as it is. */
static double plain_error(const moment_scene *scene, uint32_t moment) {
  const csm_config *config = &scene->config;
  const double radius = config->moment_blur_texels, blur = radius > 0.0 ? 2.0 * (2.0 * radius + 1.0) * 0x1p-25 : 0.0;
  const double stored = config->moment_format == CSM_MOMENTS_FLOAT16 ? store_error(config, moment) : 0.0;
  return stored + power_error(scene, moment) + blur;
}

/* The most that a moment is off what it should be, of what rounding may do to it: of one layer, here and there. */
static double worst_moment(const moment_scene *scene) {
  const layer whole = {.begin = -1.0, .scale = 1.0};
  double worst = 0.0;
  for (uint32_t y = 3; y < scene->side; y += 13)
    for (uint32_t x = 3; x < scene->side; x += 11) {
      const float *at = &scene->moments[((size_t)y * scene->side + x) * scene->channels];
      double moments[MOMENT_CHANNELS];
      find_moments(scene, (const double[2]){x + 0.5, y + 0.5}, &whole, moments);
      for (uint32_t k = 0; k < scene->channels; k++) {
        const double most =
            is_warped(&scene->config) ? warped_error(scene, k) * fabs(moments[k]) : plain_error(scene, k);
        worst = fmax(worst, fabs(at[k] - moments[k]) / most);
      }
    }
  return worst;
}

void moment_scene_add_numbers(hard_run *run, const moment_scene *scene, const char *name) {
  const size_t texels = (size_t)scene->moment_side * scene->moment_side * scene->layers;
  const uint32_t pairs = scene->config.filter == CSM_FILTER_EVSM4 ? 2 : scene->channels > 1 ? 1 : 0;
  uint64_t odd = 0;
  double lowest = 0.0;
  for (size_t i = 0; i < texels; i++) {
    const float *at = &scene->moments[i * scene->channels];
    for (uint32_t k = 0; k < scene->channels; k++)
      odd += !isfinite(at[k]);
    for (uint32_t k = 0; k < pairs; k++) {
      const double mean = at[2 * k], variance = at[2 * k + 1] - mean * mean;
      lowest = fmin(lowest, variance / (least_variance(scene, k, mean) + noise(scene, at[2 * k + 1])));
    }
  }
  /* A wide blur rounds more often where texels differ, here by all of the range: how much is stated. */
  const double bound = scene->config.moment_blur_texels > 7 ? INFINITY : 1.0;
  hard_figure_add(run, (double)odd, 0.0, "1", "moments that are no number, %s", name);
  if (scene->layers == 1 && scene->moment_side == scene->side)
    hard_figure_add(run, worst_moment(scene), bound, "1", "a moment off, of what rounding may do, %s", name);
  /* The least variance is what rounding may cost, and more. */
  if (pairs)
    hard_figure_add(run, -lowest, bound, "1", "variance below 0, of the least variance, %s", name);
}
