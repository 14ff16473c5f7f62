/*
 * filters.c: what each filter makes of a map, against the same sums taken on the CPU from the map and the camera's
 * depth that csm_read gives; and that no filter shadows a plane by itself. CSM_LONG=1 in the environment has each filter
 * draw with every shape of a map; else it draws with two that are opposites, so that all pairs of a filter and one thing
 * about a map are met.
 */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { width = 160, height = 96, pixels = width * height, resolution = 256 };

typedef struct fixture {
  record record;
  csm_context *context;
  csm_mesh ground, box;
  csm_instance instances[8];
  shot shot;
  csm_cascades *cascades;
  csm_view *view;
  csm_binding binding;
  float *map, *depth, *mask;
} fixture;

/* ---- drawing ---- */

static void open_fixture(fixture *f) {
  memset(f, 0, sizeof *f);
  f->context = support_open(&f->record);
  f->ground = support_square(f->context);
  f->box = support_box(f->context, 2);
  csm_instance *to = f->instances;
  to[0] = support_instance(f->ground, 0, 0, 0, 60, 1, 60);
  to[1] = support_instance(f->box, 0, 6, 0, 3, 0.3, 2);
  to[2] = support_instance(f->box, -7, 7, -4, 0.2, 0.2, 5);
  to[3] = support_instance(f->box, 5, 6, 2, 1, 1, 1);
  to[4] = support_instance(f->box, 5, 8, -6, 4, 0.1, 0.15);
  f->view = support_view(f->context);
  support_keep_programs(f->context);
  f->shot = shot_make(f->instances, 5);
  memcpy(f->shot.light.direction, (const double[]){0.3, -1, 0.2}, sizeof f->shot.light.direction);
  /* Looks down from below the boxes, and so sees the ground alone. */
  support_look_at(f->shot.camera.view, (const double[]){1, 4, 9}, (const double[]){1, 0, 0});
  support_perspective(f->shot.camera.projection, 50, (double)width / height, 0.1, 100);
}

static void close_fixture(fixture *f) {
  support_close(f->context, &f->record);
}

static csm_config one_map(uint32_t filter) {
  csm_config config = support_config();
  config.cascade_count = 1;
  config.resolution = resolution;
  config.shadow_distance = 30;
  config.filter = filter;
  config.bias_mode = CSM_BIAS_SLOPE;
  return config;
}

static void draw(fixture *f, const csm_config *config) {
  assert_int_equal(csm_cascades_create(f->context, config, &f->cascades), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&f->shot)), CSM_SUCCESS);
  assert_int_equal(shot_resolve(&f->shot, f->view, f->cascades, width, height), CSM_SUCCESS);
  f->binding = (csm_binding){.struct_size = sizeof f->binding};
  assert_int_equal(csm_bind(f->cascades, &f->binding), CSM_SUCCESS);
  f->mask = support_image(f->context, f->view, CSM_READ_MASK, width, height);
  f->depth = support_image(f->context, f->view, CSM_READ_CAMERA_DEPTH, width, height);
  f->map = support_map(f->context, f->cascades, 0, f->binding.resolutions[0]);
}

static void forget(fixture *f) {
  free(f->mask);
  free(f->depth);
  free(f->map);
  assert_int_equal(csm_cascades_destroy(f->cascades), CSM_SUCCESS);
}

/* ---- the same on the CPU ---- */

typedef struct kernel {
  int taps;
  double weights[32]; /* of all taps along an axis */
} kernel;

static kernel make_kernel(const csm_config *config) {
  static const double castano[3][7] = {{1, 2, 1}, {1, 3, 4, 3, 1}, {1, 5, 12, 16, 12, 5, 1}};
  kernel out = {0};
  out.taps = config->filter == CSM_FILTER_PCF_2X2   ? 1
             : config->filter == CSM_FILTER_PCF_3X3 ? 3
             : config->filter == CSM_FILTER_PCF_5X5 ? 5
             : config->filter == CSM_FILTER_PCF_7X7 ? 7
                                                    : (int)config->filter_taps;
  for (int i = 0; i < out.taps; ++i) {
    const double away = (i - out.taps / 2) / (out.taps / 4.0);
    out.weights[i] = config->filter_weights == CSM_WEIGHTS_GAUSSIAN  ? exp(-0.5 * away * away)
                     : config->filter_weights == CSM_WEIGHTS_CASTANO ? castano[out.taps / 2 - 1][i]
                                                                     : 1;
  }
  return out;
}

/* Whether a pixel sees a surface before the end of shadows. */
static bool within(const fixture *f, const csm_config *config, uint32_t pixel) {
  const double *p = f->shot.camera.projection;
  const double depth = p[14] / (p[10] + (double)f->depth[pixel]);
  return f->depth[pixel] > 0 && depth < 0.99 * config->shadow_distance;
}

/* Of n x n bilinear comparisons the weighted mean, by the naive loop; `reference` is the depth that is compared. */
static double naive(const fixture *f, const kernel *k, const double at[3]) {
  const double px = at[0] * resolution - 0.5, py = at[1] * resolution - 0.5;
  double sum = 0, weight = 0;
  for (int j = 0; j < k->taps; ++j)
    for (int i = 0; i < k->taps; ++i) {
      const double x = px + i - k->taps / 2, y = py + j - k->taps / 2;
      double lit = 0;
      for (int corner = 0; corner < 4; ++corner) {
        const int tx = (int)floor(x) + corner % 2, ty = (int)floor(y) + corner / 2;
        const double wx = corner % 2 ? x - floor(x) : 1 - (x - floor(x));
        const double wy = corner / 2 ? y - floor(y) : 1 - (y - floor(y));
        assert_true(tx >= 0 && ty >= 0 && tx < resolution && ty < resolution);
        lit += wx * wy * (at[2] <= (double)f->map[ty * resolution + tx]);
      }
      sum += k->weights[i] * k->weights[j] * lit;
      weight += k->weights[i] * k->weights[j];
    }
  return sum / weight;
}

/*
 * Casters hang metres above a ground that lies metres before the map's end, so no bias decides a comparison. The mask
 * holds eight bits, and the place in the map is a float's, which moves a sum by up to 2e-4: not a step more.
 */
static void compare_with_naive(fixture *f, const csm_config *config) {
  draw(f, config);
  const kernel k = make_kernel(config);
  uint32_t between = 0, rounded = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      double position[3], at[3];
      if (!within(f, config, y * width + x))
        continue;
      support_seen(&f->shot.camera, f->depth[y * width + x], (x + 0.5) / width, (y + 0.5) / height, position);
      support_apply(f->binding.cascades[0].world_to_shadow, position, at);
      at[2] -= 0.5 / f->binding.cascades[0].depth_range;
      const double expected = naive(f, &k, at), drawn = f->mask[y * width + x];
      between += drawn > 0 && drawn < 1;
      if (fabs(expected - drawn) > 0.5 / 255 + 2e-4 && !rounded++)
        print_error("filter %u, %d taps, weights %u: pixel %u, %u: %g, not %g\n", config->filter, k.taps,
                    config->filter_weights, x, y, drawn, expected);
    }
  assert_int_equal(rounded, 0);
  assert_true(between > pixels / 100);
  forget(f);
}

static void filters_are_the_naive_sums(void **state) {
  (void)state;
  static const uint32_t filters[] = {CSM_FILTER_PCF_2X2, CSM_FILTER_PCF_3X3, CSM_FILTER_PCF_5X5, CSM_FILTER_PCF_7X7,
                                     CSM_FILTER_PCF_N};
  fixture f;
  open_fixture(&f);
  for (size_t i = 0; i < sizeof filters / sizeof *filters; ++i)
    for (uint32_t weights = 0; weights <= CSM_WEIGHTS_CASTANO; ++weights) {
      csm_config config = one_map(filters[i]);
      config.filter_weights = weights;
      const bool castano = weights == CSM_WEIGHTS_CASTANO;
      if ((weights && config.filter == CSM_FILTER_PCF_2X2) || (castano && config.filter == CSM_FILTER_PCF_N))
        continue;
      compare_with_naive(&f, &config);
    }
  close_fixture(&f);
}

/* ---- masks against masks ---- */

static float *mask_of(fixture *f, const csm_config *config) {
  draw(f, config);
  float *mask = f->mask;
  f->mask = NULL;
  forget(f);
  return mask;
}

static void pcf_n_is_the_fixed_filter(void **state) {
  (void)state;
  static const uint32_t fixed[][2] = {{CSM_FILTER_PCF_3X3, 3}, {CSM_FILTER_PCF_5X5, 5}, {CSM_FILTER_PCF_7X7, 7}};
  fixture f;
  open_fixture(&f);
  for (int i = 0; i < 3; ++i)
    for (uint32_t bias = 0; bias < 2; ++bias) {
      csm_config config = one_map(fixed[i][0]);
      config.bias_mode = bias;
      float *a = mask_of(&f, &config);
      config.filter = CSM_FILTER_PCF_N;
      config.filter_taps = fixed[i][1];
      float *b = mask_of(&f, &config);
      assert_memory_equal(a, b, pixels * sizeof *a);
      free(a);
      free(b);
    }
  close_fixture(&f);
}

/* Looking at 20 texels first gives the whole filter's value, or 0 or 1 where a thin thing hides between them. */
static void early_out_misses_thin_things_alone(void **state) {
  (void)state;
  static const uint32_t filters[] = {CSM_FILTER_PCF_5X5, CSM_FILTER_PCF_7X7, CSM_FILTER_PCF_N};
  fixture f;
  open_fixture(&f);
  for (int i = 0; i < 3; ++i) {
    csm_config config = one_map(filters[i]);
    config.filter_taps = 15;
    float *full = mask_of(&f, &config);
    config.filter_early_out = 1;
    float *early = mask_of(&f, &config);
    uint32_t missed = 0, between = 0;
    for (uint32_t k = 0; k < pixels; ++k) {
      const bool same = full[k] == early[k], rounded = early[k] == 0 || early[k] == 1;
      assert_true(same || (rounded && fabsf(full[k] - early[k]) < 0.5f));
      missed += !same;
      between += early[k] > 0 && early[k] < 1;
    }
    printf("filter %u: %u pixels between light and shadow, %u missed by the early out\n", filters[i], between, missed);
    assert_true(between > pixels / 100 && missed * 5 < between);
    free(full);
    free(early);
  }
  close_fixture(&f);
}

/* ---- planes ---- */

static void expect_all(fixture *f, const csm_config *config, float expected, const char *what) {
  draw(f, config);
  uint32_t wrong = 0, seen = 0;
  for (uint32_t i = 0; i < pixels; ++i) {
    seen += within(f, config, i);
    wrong += within(f, config, i) && f->mask[i] != expected;
  }
  assert_true(seen > pixels / 2);
  if (wrong)
    fail_msg("%s: filter %u, format %u, reversed %u, layout %u, resolution %u, light %g, %g, %g: %u pixels are not %g",
             what, config->filter, config->map_format, config->map_reversed, config->map_layout, config->resolution,
             f->shot.light.direction[0], f->shot.light.direction[1], f->shot.light.direction[2], wrong,
             (double)expected);
  forget(f);
}

static csm_config variant(uint32_t filter, uint32_t shape) {
  csm_config config = support_config();
  config.cascade_count = 1 + shape;
  config.selection = (shape + filter) % 3;
  config.filter = filter;
  config.map_format = shape & 1;
  config.map_reversed = shape >> 1 & 1;
  config.map_layout = shape >> 2 & 1;
  config.resolution = (const uint32_t[]){256, 100, 333}[shape % 3];
  config.bias_mode = filter == CSM_FILTER_LINEAR_DEPTH ? CSM_BIAS_SLOPE : CSM_BIAS_RECEIVER_PLANE;
  return config;
}

static bool draws_shape(uint32_t filter, uint32_t shape) {
  return getenv("CSM_LONG") || shape % 4 == (shape & 4 ? 3 - filter % 4 : filter % 4);
}

/* No filter, format, layout, size or light makes a plane shadow itself; what covers it all leaves no light. */
static void a_plane_is_lit_and_a_covered_one_is_not(void **state) {
  (void)state;
  static const double suns[][3] = {{0, -1, 0}, {0.5, -1, 0.2}, {-1, -1, 1}, {3, -1, -0.4}, {0.1, -0.3, -1}};
  fixture f;
  open_fixture(&f);
  f.instances[1] = support_instance(f.box, 0, 30, 0, 400, 1, 400);
  for (uint32_t filter = 0; filter <= CSM_FILTER_GRID_17; ++filter)
    for (uint32_t shape = 0; shape < 8; ++shape) {
      if (!draws_shape(filter, shape))
        continue;
      const csm_config config = variant(filter, shape);
      memcpy(f.shot.light.direction, suns[(shape + filter) % 5], sizeof suns[0]);
      f.shot.frame.instance_count = 1;
      expect_all(&f, &config, 1, "an uncovered plane");
      f.shot.frame.instance_count = 2;
      expect_all(&f, &config, 0, "a covered plane");
    }
  close_fixture(&f);
}

/* A map of 16 bits, and one whose depth runs the other way, tell the same tale where casters are metres away. */
static void formats_tell_the_same(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  for (uint32_t filter = 0; filter <= CSM_FILTER_GRID_17; ++filter) {
    csm_config config = one_map(filter);
    float *first = mask_of(&f, &config);
    for (uint32_t shape = 1; shape < 4; ++shape) {
      if (!getenv("CSM_LONG") && shape == 1 + filter % 3)
        continue;
      config.map_format = shape & 1;
      config.map_reversed = shape >> 1;
      float *other = mask_of(&f, &config);
      uint32_t differ = 0;
      for (uint32_t i = 0; i < pixels; ++i)
        differ += fabsf(first[i] - other[i]) > 1.0f / 255 + 1e-6f;
      if (differ > (filter == CSM_FILTER_LINEAR_DEPTH ? pixels / 1000 : pixels / 10000))
        fail_msg("filter %u: %u pixels differ with format %u, reversed %u", filter, differ, config.map_format,
                 config.map_reversed);
      free(other);
    }
    free(first);
  }
  close_fixture(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(filters_are_the_naive_sums),
      cmocka_unit_test(pcf_n_is_the_fixed_filter),
      cmocka_unit_test(early_out_misses_thin_things_alone),
      cmocka_unit_test(a_plane_is_lit_and_a_covered_one_is_not),
      cmocka_unit_test(formats_tell_the_same),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
