/* The shape of filters: weights, how far they reach, the room they take; as the plan says, and as shaders do. */
#include "support.h"

#include "csm_constants.h"
#include "plan/internal.h"
#include "sampler.h"

#include <math.h>
#include <stdlib.h>

enum { side = 64, middle = 32 };

static csm_config with_filter(uint32_t filter, uint32_t weights, uint32_t taps) {
  csm_config config = default_config();
  config.bias_mode = CSM_BIAS_SLOPE;
  config.cascade_count = 1;
  config.resolution = side;
  config.filter = filter;
  config.filter_weights = weights;
  config.filter_taps = taps;
  return config;
}

/* A map that is all shadow or all light, for sampler_filter with a depth of one half. */
typedef struct test_map {
  csm_constants constants;
  float depths[side * side];
} test_map;

static void map_make(test_map *map, const csm_config *config, float depth) {
  const test_camera camera = plain_camera();
  const char *error = "";
  if (plan_config_check(config, &error))
    fail_msg("%s", error);
  const plan_frame frame = plan_empty(config, &camera, (double[]){0.3, -1.0, 0.2});
  (void)plan_write_constants((float *)&map->constants, &frame, config);
  for (int i = 0; i < side * side; ++i)
    map->depths[i] = depth;
  sampler_bind((const float *)&map->constants, map->depths, side, side, 1);
}

static const struct shape {
  uint32_t filter, taps, count; /* taps a side, or in all */
} shapes[] = {{CSM_FILTER_PCF_2X2, 9, 1},      {CSM_FILTER_PCF_3X3, 9, 3},  {CSM_FILTER_NEAREST, 9, 1},
              {CSM_FILTER_LINEAR_DEPTH, 9, 1}, {CSM_FILTER_PCF_5X5, 9, 5},  {CSM_FILTER_PCF_7X7, 9, 7},
              {CSM_FILTER_PCF_N, 9, 9},        {CSM_FILTER_PCF_N, 31, 31},  {CSM_FILTER_POISSON, 9, 16},
              {CSM_FILTER_VOGEL, 13, 13},      {CSM_FILTER_GRID_17, 9, 17}, {CSM_FILTER_PCF_N, 3, 3}};
enum { shape_count = sizeof shapes / sizeof *shapes };

static void weights_sum_up_and_fall_from_the_middle(void **state) {
  (void)state;
  for (int s = 0; s < shape_count; ++s)
    for (uint32_t kind = CSM_WEIGHTS_UNIFORM; kind <= CSM_WEIGHTS_CASTANO; ++kind) {
      const csm_config config = with_filter(shapes[s].filter, kind, shapes[s].taps);
      const char *error = "";
      assert_int_equal(plan_filter_taps(&config), shapes[s].count);
      if (plan_config_check(&config, &error) || shapes[s].filter >= CSM_FILTER_POISSON)
        continue;
      double weights[PLAN_MAX_WEIGHTS], sum = 0.0;
      const double told = plan_filter_weights(weights, &config);
      for (int tap = 0; tap < (int)shapes[s].count; ++tap)
        sum += weights[abs(tap - (int)shapes[s].count / 2)];
      assert_near(told, sum, 1e-12 * sum);
      for (uint32_t i = 0; i < PLAN_MAX_WEIGHTS; ++i) {
        assert_true((weights[i] > 0.0) == (i <= shapes[s].count / 2));
        assert_true(weights[i] == (double)(float)weights[i]);
        if (i && i <= shapes[s].count / 2)
          assert_true(kind == CSM_WEIGHTS_UNIFORM ? weights[i] == weights[i - 1] : weights[i] < weights[i - 1]);
        if (kind == CSM_WEIGHTS_GAUSSIAN && i <= shapes[s].count / 2)
          assert_near(weights[i], exp(-8.0 * i * i / ((double)shapes[s].count * shapes[s].count)), 1e-7);
      }
      csm_constants constants;
      const test_camera camera = plain_camera();
      const plan_frame frame = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
      (void)plan_write_constants((float *)&constants, &frame, &config);
      for (uint32_t i = 0; i < PLAN_MAX_WEIGHTS; ++i)
        assert_true(constants.settings.weights[i] == (float)weights[i]);
      assert_true(constants.settings.kernel[0] == (float)config.filter &&
                  constants.settings.kernel[1] == (float)shapes[s].count);
      assert_true(constants.settings.kernel[3] == (float)(1.0 / (told * told)));
    }
}

/* Castano's fetches, as published: where each bilinear fetch lies, and its weight, by the place between two texels. */
static int published(double offsets[4], double fetch_weights[4], int taps, double s) {
  const double of_3[2][2] = {{3 - 2 * s, (2 - s) / (3 - 2 * s) - 1}, {1 + 2 * s, s / (1 + 2 * s) + 1}};
  const double of_5[3][2] = {
      {4 - 3 * s, (3 - 2 * s) / (4 - 3 * s) - 2}, {7, (3 + s) / 7}, {1 + 3 * s, s / (1 + 3 * s) + 2}};
  const double of_7[4][2] = {{5 * s - 6, (4 * s - 5) / (5 * s - 6) - 3},
                             {11 * s - 28, (4 * s - 16) / (11 * s - 28) - 1},
                             {-(11 * s + 17), -(7 * s + 5) / -(11 * s + 17) + 1},
                             {-(5 * s + 1), -s / -(5 * s + 1) + 3}};
  const double(*of)[2] = taps == 3 ? of_3 : taps == 5 ? of_5 : of_7;
  const int count = (taps + 1) / 2;
  for (int i = 0; i < count; ++i) {
    fetch_weights[i] = fabs(of[i][0]);
    offsets[i] = of[i][1];
  }
  return count;
}

/* The share of a texel, `away` of the one at or before the place, that these fetches read. */
static double published_share(int taps, double s, int away) {
  double offsets[4], fetch_weights[4], share = 0.0, sum = 0.0;
  const int count = published(offsets, fetch_weights, taps, s);
  for (int i = 0; i < count; ++i) {
    share += fetch_weights[i] * fmax(0.0, 1.0 - fabs(offsets[i] - away));
    sum += fetch_weights[i];
  }
  return share / sum;
}

static void castanos_weights_are_the_published_fetches(void **state) {
  (void)state;
  static const uint32_t filters[] = {CSM_FILTER_PCF_3X3, CSM_FILTER_PCF_5X5, CSM_FILTER_PCF_7X7};
  test_map map;
  for (int f = 0; f < 3; ++f) {
    const int taps = 3 + 2 * f;
    const csm_config config = with_filter(filters[f], CSM_WEIGHTS_CASTANO, 9);
    map_make(&map, &config, 0.0f);
    for (int step = 0; step < 16; ++step)
      for (int y = -taps; y <= taps; ++y)
        for (int x = -taps; x <= taps; ++x) {
          const double s = step / 16.0, t = (15 - step) / 16.0;
          float *texel = &map.depths[(middle + y) * side + middle + x];
          *texel = 1.0f;
          assert_near(sampler_filter((float)(middle + s), (float)(middle + t), 0.5f),
                      published_share(taps, s, x) * published_share(taps, t, y), 1e-6);
          *texel = 0.0f;
        }
  }
}

/* All light is light, all shadow is shadow, and half and half between them is what a mirrored place sees of the rest.
 */
static void shaders_weigh_as_the_plan_says(void **state) {
  (void)state;
  random_state random = {1};
  test_map map;
  for (int s = 0; s < shape_count; ++s)
    for (uint32_t kind = CSM_WEIGHTS_UNIFORM; kind <= CSM_WEIGHTS_CASTANO; ++kind) {
      const csm_config config = with_filter(shapes[s].filter, kind, shapes[s].taps);
      const char *error = "";
      if (plan_config_check(&config, &error))
        continue;
      for (int i = 0; i < 50; ++i) {
        const float x = (float)random_between(&random, 24.0, 40.0), y = (float)random_between(&random, 24.0, 40.0);
        map_make(&map, &config, 1.0f);
        assert_near(sampler_filter(x, y, 0.5f), 1.0, 1e-6);
        map_make(&map, &config, 0.0f);
        assert_true(sampler_filter(x, y, 0.5f) == 0.0f);
        assert_false(sampler_read_outside());
        if (shapes[s].filter == CSM_FILTER_POISSON || shapes[s].filter == CSM_FILTER_VOGEL)
          continue;
        for (int k = 0; k < side * side; ++k)
          map.depths[k] = k % side < middle ? 1.0f : 0.0f;
        const float left = sampler_filter(x, y, 0.5f);
        for (int k = 0; k < side * side; ++k)
          map.depths[k] = k % side >= middle ? 1.0f : 0.0f;
        const float mirrored = sampler_filter(side - 1.0f - x, y, 0.5f);
        assert_near(left, mirrored, 1e-5);
      }
    }
}

/* Looks for the farthest texel that a filter reads, and tells it from one that it does not. */
static void filters_reach_as_far_as_told_and_no_farther(void **state) {
  (void)state;
  random_state random = {2};
  test_map map;
  for (int s = 0; s < shape_count; ++s) {
    csm_config config = with_filter(shapes[s].filter, CSM_WEIGHTS_UNIFORM, shapes[s].taps);
    config.filter_radius_texels = 2.75;
    map_make(&map, &config, 1.0f);
    const double reach = plan_filter_reach_texels(&config);
    double farthest = 0.0;
    for (int i = 0; i < 40; ++i) {
      const float x = (float)(middle + random_between(&random, -0.5, 0.5));
      const float y = (float)(middle + random_between(&random, -0.5, 0.5));
      const float depth = 0.99999f; /* which the least share of a dark texel shadows, where depths are mixed */
      const float all = sampler_filter(x, y, depth);
      for (int k = 0; k < side * side; ++k) {
        map.depths[k] = 0.0f;
        if (sampler_filter(x, y, depth) != all)
          farthest = fmax(farthest, fmax(fabs(k % side - (double)x), fabs(k / side - (double)y)));
        map.depths[k] = 1.0f;
      }
    }
    /* A bilinear depth reads a texel more, but a plane's depth lies on the plane again. */
    const double read = shapes[s].filter == CSM_FILTER_LINEAR_DEPTH ? 1.0 : reach;
    if (!(farthest <= read && farthest > read - (shapes[s].filter >= CSM_FILTER_POISSON ? 0.75 : 0.1)))
      fail_msg("filter %u reaches %g, not %g", shapes[s].filter, farthest, reach);
    assert_int_equal(plan_filter_radius_texels(&config), (uint32_t)ceil(reach));
  }
}

static void padding_is_reach_offset_grid_and_half_a_texel(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 2000; ++i) {
    const csm_config config = random_full_config(&random);
    const double grid = ldexp(1.0, (int)config.snap_power);
    const double moved[] = {grid / 2.0, grid, 0.0};
    const double least = plan_filter_reach_texels(&config) + config.bias_normal_texels + moved[config.snap_mode];
    const double padding = plan_padding_texels(&config);
    assert_true(padding >= least + 0.5 && padding < least + 2.5);
  }
}

/* Where corners and middle agree, what lies between is not looked at; where they do not, nothing changes. */
static void an_early_way_out_is_taken_where_corners_agree(void **state) {
  (void)state;
  random_state random = {4};
  static const uint32_t filters[] = {CSM_FILTER_PCF_5X5, CSM_FILTER_PCF_7X7, CSM_FILTER_PCF_N};
  uint32_t kept = 0;
  for (int i = 0; i < 3000; ++i) {
    csm_config config = with_filter(filters[i % 3], CSM_WEIGHTS_UNIFORM, 9);
    test_map map;
    map_make(&map, &config, 1.0f);
    const double angle = random_between(&random, 0.0, 2.0 * M_PI), away = random_between(&random, -6.0, 6.0);
    for (int k = 0; k < side * side; ++k)
      map.depths[k] =
          cos(angle) * (k % side - middle) + sin(angle) * ((double)(k / side) - middle) > away ? 1.0f : 0.0f;
    const float full = sampler_filter(middle + 0.25f, middle - 0.4f, 0.5f);
    map.constants.settings.options[1] = 1.0f;
    sampler_bind((const float *)&map.constants, map.depths, side, side, 1);
    const float early = sampler_filter(middle + 0.25f, middle - 0.4f, 0.5f);
    const bool out = early == 0.0f || early == 1.0f;
    assert_true(early == full || out);
    kept += !out;
    assert_true(full == 0.0f || full == 1.0f || !out || fabsf(full - early) < 0.25f);
  }
  assert_true(kept > 500);
}

/* ---- the disc's points ---- */

static void poissons_points_fill_the_disc_evenly(void **state) {
  (void)state;
  float points[16][2];
  sampler_poisson(points);
  double mean[2] = {0.0, 0.0}, square = 0.0;
  for (int a = 0; a < 16; ++a) {
    const double length = hypot(points[a][0], points[a][1]);
    assert_true(length <= 1.0);
    square += length * length / 16.0;
    for (int k = 0; k < 2; ++k)
      mean[k] += points[a][k] / 16.0;
    for (int b = 0; b < a; ++b)
      assert_true(hypot(points[a][0] - points[b][0], points[a][1] - points[b][1]) >= 0.4);
  }
  assert_true(hypot(mean[0], mean[1]) < 0.02);
  assert_near(square, 0.5, 0.1); /* of an even disc */
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(weights_sum_up_and_fall_from_the_middle),
      cmocka_unit_test(castanos_weights_are_the_published_fetches),
      cmocka_unit_test(shaders_weigh_as_the_plan_says),
      cmocka_unit_test(filters_reach_as_far_as_told_and_no_farther),
      cmocka_unit_test(padding_is_reach_offset_grid_and_half_a_texel),
      cmocka_unit_test(an_early_way_out_is_taken_where_corners_agree),
      cmocka_unit_test(poissons_points_fill_the_disc_evenly),
  };
  return cmocka_run_group_tests_name("plan-filter", tests, NULL, NULL);
}
