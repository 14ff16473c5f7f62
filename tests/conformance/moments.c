/* moments.c: the moments that a device makes of its maps' depths, against the same in doubles. */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 200, SLICES_MOST = 4, RADIUS_MOST = 32 };

/* One configuration, and how far its moments may be off: by a share of themselves, and so much more. */
typedef struct trial {
  const char *name;
  uint32_t filter, format, blur, radius, halved, layers;
  uint32_t reversed, map_format, layout;
  bool sizes;
  double exponent, negative, share, more;
} trial;

static const double float_share = 1e-5, float_more = 2e-6, half_share = 3e-3, half_more = 3e-4;

/* ---- in doubles ---- */

typedef struct moments {
  double m[4];
} moments;

static uint32_t channels_of(const csm_config *config) {
  return config->filter == CSM_FILTER_ESM                                          ? 1
         : config->filter == CSM_FILTER_EVSM4 || config->filter == CSM_FILTER_MSM4 ? 4
                                                                                   : 2;
}

/* z of a depth in a slice: layers reach beyond their share, by half towards the light and by a quarter away from it. */
static double slice_depth(const csm_config *config, double depth, uint32_t slice) {
  const double length = 1.0 / config->moment_layers;
  const double begin = fmax((slice - 0.5) * length, 0.0), end = fmin((slice + 1.25) * length, 1.0);
  return fmin(fmax(2.0 * (depth - begin) / (end - begin) - 1.0, -1.0), 1.0);
}

static moments moments_of(const csm_config *config, double map, uint32_t slice) {
  const double z = slice_depth(config, config->map_reversed ? 1.0 - map : map, slice);
  const double grown = exp(config->moment_exponent * z), fallen = exp(-config->moment_exponent_negative * z);
  switch (config->filter) {
  case CSM_FILTER_ESM:
    return (moments){{grown}};
  case CSM_FILTER_EVSM2:
    return (moments){{grown, grown * grown}};
  case CSM_FILTER_EVSM4:
    return (moments){{grown, grown * grown, -fallen, fallen * fallen}};
  case CSM_FILTER_MSM4:
    return (moments){{z, z * z, z * z * z, z * z * z * z}};
  default:
    return (moments){{z, z * z}};
  }
}

/* Peters and Klein's axes for moments of 16 bits, from -0.5 to 0.5 each. */
static moments packed(const csm_config *config, moments of) {
  const double *m = of.m, root = sqrt(3.0);
  if (config->filter != CSM_FILTER_MSM4 || config->moment_format != CSM_MOMENTS_FLOAT16)
    return of;
  return (moments){{1.5 * m[0] - 2.0 * m[2], 4.0 * m[1] - 4.0 * m[3] - 0.5, root / 2.0 * m[0] - 2.0 * root / 9.0 * m[2],
                    0.5 * m[1] + 0.5 * m[3] - 0.5}};
}

static double weight(const csm_config *config, int away) {
  const double radius = config->moment_blur_texels, share = away / (radius / 2.0);
  return config->moment_blur == CSM_BLUR_GAUSSIAN && away ? exp(-0.5 * share * share) : 1.0;
}

static int clamped(int at, int side) {
  return at < 0 ? 0 : at >= side ? side - 1 : at;
}

/* One pass of a blur, along x or along y. */
static moments *blurred(const csm_config *config, const moments *from, int side, bool along_y) {
  const int radius = (int)config->moment_blur_texels;
  moments *out = calloc((size_t)side * side, sizeof *out);
  double sum = 0.0;
  for (int i = -radius; i <= radius; ++i)
    sum += weight(config, i);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      for (int i = -radius; i <= radius; ++i) {
        const int column = along_y ? x : clamped(x + i, side), row = along_y ? clamped(y + i, side) : y;
        for (int k = 0; k < 4; ++k)
          out[y * side + x].m[k] += weight(config, i) / sum * from[row * side + column].m[k];
      }
  return out;
}

/* A cascade's slice. */
static moments *reference(const csm_config *config, const float *map, int map_side, uint32_t slice) {
  const int texels = config->moment_halved ? 2 : 1, side = map_side / texels;
  moments *made = calloc((size_t)side * side, sizeof *made);
  for (int y = 0; y < side * texels; ++y)
    for (int x = 0; x < side * texels; ++x) {
      const moments of = moments_of(config, map[y * map_side + x], slice);
      for (int k = 0; k < 4; ++k)
        made[y / texels * side + x / texels].m[k] += of.m[k] / (texels * texels);
    }
  moments *rows = blurred(config, made, side, false), *out = blurred(config, rows, side, true);
  free(made);
  free(rows);
  for (int i = 0; i < side * side; ++i)
    out[i] = packed(config, out[i]);
  return out;
}

/* ---- a device's ---- */

typedef struct drawn {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  support_scene scene;
} drawn;

static void open_drawn(drawn *d) {
  memset(d, 0, sizeof *d);
  d->context = support_open(&d->record);
  support_scene_make(&d->scene, d->context);
}

static void begin(drawn *d, const csm_config *config) {
  assert_int_equal(csm_cascades_create(d->context, config, &d->cascades), CSM_SUCCESS);
}

static void draw(drawn *d) {
  assert_int_equal(csm_render_cascades(d->cascades, shot_frame(&d->scene.shot)), CSM_SUCCESS);
}

static void end(drawn *d) {
  assert_int_equal(csm_cascades_destroy(d->cascades), CSM_SUCCESS);
}

static void close_drawn(drawn *d) {
  support_close(d->context, &d->record);
}

static float *read_level(const drawn *d, uint32_t cascade, uint32_t level, size_t count) {
  float *data = malloc(count * sizeof *data);
  const csm_read_info info = {.struct_size = sizeof info,
                              .source = CSM_READ_MOMENTS,
                              .cascades = d->cascades,
                              .cascade = cascade,
                              .data = data,
                              .size = count * sizeof *data,
                              .level = level};
  assert_int_equal(csm_read(d->context, &info), CSM_SUCCESS);
  return data;
}

static float *read_moments(const drawn *d, uint32_t cascade, size_t count) {
  return read_level(d, cascade, 0, count);
}

static uint32_t side_of(const csm_config *config, uint32_t cascade) {
  return config->resolutions[cascade] ? config->resolutions[cascade] : config->resolution;
}

/* ---- the trials ---- */

static csm_config config_of(const trial *t) {
  csm_config config = support_config();
  config.resolution = SIDE;
  config.filter = t->filter;
  config.moment_format = t->format;
  config.moment_blur = t->blur;
  config.moment_blur_texels = t->radius;
  config.moment_halved = t->halved;
  config.moment_layers = t->layers ? t->layers : 1;
  config.moment_levels = t->filter == CSM_FILTER_VSSM ? 3 : 1; /* it needs some */
  if (t->exponent > 0)
    config.moment_exponent = t->exponent;
  if (t->negative > 0)
    config.moment_exponent_negative = t->negative;
  config.map_reversed = t->reversed;
  config.map_format = t->map_format;
  config.map_layout = t->layout;
  if (t->sizes)
    config.resolutions[1] = 139;
  return config;
}

static void check_cascade(const drawn *d, const csm_config *config, const trial *t, uint32_t cascade) {
  const uint32_t map_side = side_of(config, cascade), side = map_side >> config->moment_halved;
  const uint32_t channels = channels_of(config);
  const size_t texels = (size_t)side * side;
  float *map = support_map(d->context, d->cascades, cascade, map_side);
  float *got = read_moments(d, cascade, texels * channels * config->moment_layers);
  for (uint32_t slice = 0; slice < config->moment_layers; ++slice) {
    moments *expected = reference(config, map, (int)map_side, slice);
    const float *of = got + slice * texels * channels;
    for (size_t i = 0; i < texels * channels; ++i) {
      const double value = expected[i / channels].m[i % channels];
      if (!(fabs(of[i] - value) <= t->share * fabs(value) + t->more))
        fail_msg("%s: cascade %u, slice %u, texel %zu, moment %zu: %.9g, not %.9g", t->name, cascade, slice,
                 i / channels, i % channels, of[i], value);
    }
    free(expected);
  }
  free(map);
  free(got);
}

static void moments_are_those_of_the_depths(void **state) {
  (void)state;
  const trial trials[] = {
      {.name = "vsm", .filter = CSM_FILTER_VSM, .share = float_share, .more = float_more},
      {.name = "vsm, radius 1", .filter = CSM_FILTER_VSM, .radius = 1, .share = float_share, .more = float_more},
      {.name = "vssm, radius 2, gaussian, atlas",
       .filter = CSM_FILTER_VSSM,
       .radius = 2,
       .blur = CSM_BLUR_GAUSSIAN,
       .layout = CSM_LAYOUT_ATLAS,
       .sizes = true,
       .share = float_share,
       .more = float_more},
      {.name = "vsm, 4 layers, radius 3, reversed",
       .filter = CSM_FILTER_VSM,
       .radius = 3,
       .layers = 4,
       .reversed = 1,
       .share = float_share,
       .more = 2e-5},
      {.name = "vsm, 3 layers, radius 9, d16",
       .filter = CSM_FILTER_VSM,
       .radius = 9,
       .layers = 3,
       .map_format = CSM_MAP_D16,
       .share = float_share,
       .more = 2e-5},
      {.name = "vsm, half, radius 3",
       .filter = CSM_FILTER_VSM,
       .format = CSM_MOMENTS_FLOAT16,
       .radius = 3,
       .share = half_share,
       .more = half_more},
      {.name = "esm, radius 32, gaussian",
       .filter = CSM_FILTER_ESM,
       .radius = 32,
       .blur = CSM_BLUR_GAUSSIAN,
       .exponent = 30,
       .share = 5e-5,
       .more = 1e-12},
      {.name = "esm, half",
       .filter = CSM_FILTER_ESM,
       .format = CSM_MOMENTS_FLOAT16,
       .exponent = 8,
       .halved = 1,
       .share = half_share,
       .more = half_more},
      {.name = "evsm2, radius 3",
       .filter = CSM_FILTER_EVSM2,
       .radius = 3,
       .exponent = 20,
       .share = 5e-5,
       .more = 1e-12},
      {.name = "evsm2, halved, radius 5",
       .filter = CSM_FILTER_EVSM2,
       .radius = 5,
       .exponent = 20,
       .halved = 1,
       .sizes = true,
       .share = 5e-5,
       .more = 1e-12},
      {.name = "evsm4, radius 3",
       .filter = CSM_FILTER_EVSM4,
       .radius = 3,
       .exponent = 40,
       .negative = 5,
       .sizes = true,
       .share = 1e-4,
       .more = 1e-30},
      {.name = "evsm4, half, radius 7",
       .filter = CSM_FILTER_EVSM4,
       .format = CSM_MOMENTS_FLOAT16,
       .radius = 7,
       .exponent = 4,
       .negative = 3,
       .share = half_share,
       .more = half_more},
      {.name = "evsm4, halved, radius 2",
       .filter = CSM_FILTER_EVSM4,
       .radius = 2,
       .halved = 1,
       .exponent = 40,
       .negative = 5,
       .share = 1e-4,
       .more = 1e-30},
      {.name = "msm4, radius 3", .filter = CSM_FILTER_MSM4, .radius = 3, .share = float_share, .more = float_more},
      {.name = "msm4, half, radius 3",
       .filter = CSM_FILTER_MSM4,
       .format = CSM_MOMENTS_FLOAT16,
       .radius = 3,
       .share = half_share,
       .more = half_more},
      {.name = "msm4, half",
       .filter = CSM_FILTER_MSM4,
       .format = CSM_MOMENTS_FLOAT16,
       .share = half_share,
       .more = half_more},
  };
  drawn d;
  open_drawn(&d);
  for (size_t i = 0; i < sizeof trials / sizeof *trials; ++i) {
    const csm_config config = config_of(&trials[i]);
    begin(&d, &config);
    draw(&d);
    for (uint32_t cascade = 0; cascade < config.cascade_count; ++cascade)
      check_cascade(&d, &config, &trials[i], cascade);
    end(&d);
  }
  close_drawn(&d);
}

/* At the largest exponents that are taken, whatever the depth: what is not a number, or is infinite, fails. */
static void moments_are_numbers(void **state) {
  (void)state;
  drawn d;
  open_drawn(&d);
  for (uint32_t filter = CSM_FILTER_VSM; filter <= CSM_FILTER_MSM4; ++filter)
    for (uint32_t format = CSM_MOMENTS_FLOAT32; format <= CSM_MOMENTS_FLOAT16; ++format) {
      const trial t = {.filter = filter, .format = format, .radius = 4, .exponent = 100, .negative = 100};
      csm_config config = config_of(&t);
      const size_t count = (size_t)SIDE * SIDE * channels_of(&config);
      begin(&d, &config);
      draw(&d);
      float *got = read_moments(&d, config.cascade_count - 1, count);
      for (size_t i = 0; i < count; ++i)
        assert_true(isfinite(got[i]));
      free(got);
      end(&d);
    }
  close_drawn(&d);
}

/* ---- levels ---- */

/* The mean of a square of `wide` texels of level 0, and of their sizes. */
static double box_mean(const float *first, size_t side, uint32_t channels, size_t x, size_t y, size_t wide,
                       double *sizes) {
  double sum = 0.0, all = 0.0;
  for (size_t row = y * wide; row < (y + 1) * wide; ++row)
    for (size_t column = x * wide; column < (x + 1) * wide; ++column) {
      const double value = first[(row * side + column) * channels];
      sum += value;
      all += fabs(value);
    }
  *sizes = all / (double)(wide * wide);
  return sum / (double)(wide * wide);
}

/* A level is made of the one before with three sums of floats, and stored: in 16 bits to the nearest, of which the least
   are 2^-24 apart. */
static void check_level(const drawn *d, const csm_config *config, uint32_t cascade, uint32_t level) {
  const uint32_t channels = channels_of(config);
  const size_t side = side_of(config, cascade) >> config->moment_halved, small = side >> level;
  const bool half = config->moment_format == CSM_MOMENTS_FLOAT16;
  const double share = level * (3 * 0x1p-24 + (half ? 0x1p-11 : 0.0)), more = half ? level * 0x1p-25 : 0.0;
  float *first = read_moments(d, cascade, side * side * channels * config->moment_layers);
  float *got = read_level(d, cascade, level, small * small * channels * config->moment_layers);
  size_t varied = 0;
  for (size_t slice = 0; slice < config->moment_layers; ++slice)
    for (size_t i = 0; i < small * small * channels; ++i) {
      const size_t texel = i / channels, channel = i % channels;
      const float *layer = first + slice * side * side * channels + channel;
      double sizes;
      const double mean = box_mean(layer, side, channels, texel % small, texel / small, (size_t)1 << level, &sizes);
      const double value = got[slice * small * small * channels + i];
      if (!(fabs(value - mean) <= share * sizes + more))
        fail_msg("filter %u, cascade %u, slice %zu, level %u, texel %zu, moment %zu: %.9g, not %.9g", config->filter,
                 cascade, slice, level, texel, channel, value, mean);
      varied += fabs(mean - layer[((texel / small * side + texel % small) << level) * channels]) > 0.01 * sizes;
    }
  assert_true(varied > small);
  free(first);
  free(got);
}

static void levels_are_means_of_level_0(void **state) {
  (void)state;
  static const trial trials[] = {
      {.filter = CSM_FILTER_VSM, .layers = 4},
      {.filter = CSM_FILTER_VSSM, .radius = 3, .layout = CSM_LAYOUT_ATLAS},
      {.filter = CSM_FILTER_ESM, .radius = 1, .exponent = 30},
      {.filter = CSM_FILTER_EVSM2, .format = CSM_MOMENTS_FLOAT16, .exponent = 4},
      {.filter = CSM_FILTER_EVSM4, .radius = 5, .exponent = 40, .negative = 5},
      {.filter = CSM_FILTER_MSM4, .format = CSM_MOMENTS_FLOAT16, .radius = 3},
  };
  enum { LEVELS = 4 }; /* 200 and 136 halve so often */
  drawn d;
  open_drawn(&d);
  for (size_t i = 0; i < sizeof trials / sizeof *trials; ++i) {
    csm_config config = config_of(&trials[i]);
    config.moment_levels = 12;
    config.moment_sampling = CSM_SAMPLING_TRILINEAR;
    config.resolutions[1] = 136;
    begin(&d, &config);
    draw(&d);
    for (uint32_t cascade = 0; cascade < 2; ++cascade)
      for (uint32_t level = 1; level < LEVELS; ++level)
        check_level(&d, &config, cascade, level);
    float number;
    const csm_read_info beyond = {.struct_size = sizeof beyond,
                                  .source = CSM_READ_MOMENTS,
                                  .cascades = d.cascades,
                                  .data = &number,
                                  .size = sizeof number,
                                  .level = LEVELS};
    d.record.quiet = true;
    assert_int_equal(csm_read(d.context, &beyond), CSM_ERROR_INVALID_INDEX);
    d.record.quiet = false;
    d.record.errors = 0;
    end(&d);
  }
  close_drawn(&d);
}

/* ---- what is left out ---- */

static float *mask_of(drawn *d, csm_view *view) {
  assert_int_equal(shot_resolve(&d->scene.shot, view, d->cascades, 160, 120), CSM_SUCCESS);
  return support_image(d->context, view, CSM_READ_MASK, 160, 120);
}

/* With caster_set view, what the camera cannot see is not made, and the mask is none other. */
static void what_is_not_seen_is_left_out(void **state) {
  (void)state;
  const uint32_t filters[] = {CSM_FILTER_VSM, CSM_FILTER_EVSM4, CSM_FILTER_MSM4};
  const uint32_t radii[] = {0, 3, 12};
  drawn d;
  open_drawn(&d);
  for (int i = 0; i < 3; ++i) {
    const trial t = {.filter = filters[i], .radius = radii[i]};
    csm_config config = config_of(&t);
    config.resolution = 512;
    config.depth_mode = CSM_DEPTH_SLICE; /* the same depths, whichever casters are drawn */
    const size_t count = (size_t)config.resolution * config.resolution * channels_of(&config);
    begin(&d, &config);
    support_perspective(d.scene.shot.camera.projection, 20, 4.0 / 3.0, 0.5, 0);
    draw(&d);
    csm_view *view = support_view(d.context);
    float *all = mask_of(&d, view);
    config.caster_set = CSM_CASTER_SET_VIEW;
    assert_int_equal(csm_cascades_configure(d.cascades, &config), CSM_SUCCESS);
    draw(&d);
    float *seen = mask_of(&d, view), *got = read_moments(&d, 0, count);
    assert_memory_equal(all, seen, 160 * 120 * sizeof *all);
    size_t zeros = 0;
    for (size_t k = 0; k < count; k += channels_of(&config))
      zeros += got[k] == 0.0f;
    assert_true(zeros > count / channels_of(&config) / 8);
    free(all);
    free(seen);
    free(got);
    end(&d);
  }
  close_drawn(&d);
}

/* Frame by frame, moments that may be kept are those that cascades without a past make. */
static void what_is_kept_is_what_is_made_anew(void **state) {
  (void)state;
  const trial t = {.filter = CSM_FILTER_EVSM2, .radius = 3, .exponent = 20};
  csm_config config = config_of(&t);
  config.caster_set = CSM_CASTER_SET_VIEW;
  const size_t count = (size_t)SIDE * SIDE * channels_of(&config);
  drawn d;
  open_drawn(&d);
  begin(&d, &config);
  csm_scene *scene;
  csm_instance_id ids[SUPPORT_INSTANCES];
  assert_int_equal(csm_scene_create(d.context, &scene), CSM_SUCCESS);
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = SUPPORT_INSTANCES, .ids = ids, .instances = d.scene.instances};
  assert_int_equal(csm_scene_add(scene, &batch), CSM_SUCCESS);
  for (int step = 0; step < 6; ++step) {
    const double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.3 * step, 2, 0, 1};
    if (step == 2 || step == 3)
      assert_int_equal(csm_scene_move(scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                                .count = 1,
                                                                .ids = &ids[1 + step % 2],
                                                                .matrices = matrix}),
                       CSM_SUCCESS);
    if (step == 4)
      support_look_at(d.scene.shot.camera.view, (const double[3]){4, 3, 6}, (const double[3]){0, 0, 0});
    csm_frame frame = *shot_frame(&d.scene.shot);
    frame.scene = scene;
    frame.instances = NULL;
    frame.instance_count = 0;
    drawn fresh = d;
    assert_int_equal(csm_cascades_create(d.context, &config, &fresh.cascades), CSM_SUCCESS);
    assert_int_equal(csm_render_cascades(d.cascades, &frame), CSM_SUCCESS);
    assert_int_equal(csm_render_cascades(fresh.cascades, &frame), CSM_SUCCESS);
    for (uint32_t cascade = 0; cascade < config.cascade_count; ++cascade) {
      float *kept = read_moments(&d, cascade, count), *made = read_moments(&fresh, cascade, count);
      for (size_t i = 0; i < count; ++i)
        if (made[i] != 0.0f && made[i] != kept[i]) /* 0: it was not seen */
          fail_msg("step %d, cascade %u: %.9g, not %.9g", step, cascade, kept[i], made[i]);
      free(kept);
      free(made);
    }
    assert_int_equal(csm_cascades_destroy(fresh.cascades), CSM_SUCCESS);
  }
  assert_int_equal(csm_scene_destroy(scene), CSM_SUCCESS);
  end(&d);
  close_drawn(&d);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(moments_are_those_of_the_depths),   cmocka_unit_test(moments_are_numbers),
      cmocka_unit_test(levels_are_means_of_level_0),       cmocka_unit_test(what_is_not_seen_is_left_out),
      cmocka_unit_test(what_is_kept_is_what_is_made_anew),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof *tests);
}
