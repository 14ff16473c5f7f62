/* Where cascades end. */
#include "support.h"

#include <math.h>

static const double down[3] = {0.2, -1.0, 0.1};

/* Splits do not depend on the fit, and this one is found the quickest. */
static csm_config split_config(void) {
  csm_config config = default_config();
  config.fit_mode = CSM_FIT_CASCADE;
  return config;
}

static void follows_the_formula(void **state) {
  (void)state;
  const struct {
    double lambda, ends[4];
  } cases[] = {
      {0.5, {64.1, 133.0, 232.0, 500.0}}, {0.75, {33.5, 74.4, 160.5, 500.0}}, {0.9, {15.1, 39.3, 117.5, 500.0}}};
  test_camera camera = plain_camera();
  camera.near = 0.5;
  camera.far = 500.0;
  csm_config config = split_config();
  config.shadow_distance = 1000.0;
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    config.split_lambda = cases[i].lambda;
    const plan_frame frame = plan_empty(&config, &camera, down);
    for (int k = 0; k < 4; ++k)
      assert_near(frame.cascades[k].info.far_depth, cases[i].ends[k], 0.05);
  }
}

static void rise_to_the_end_exactly(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 20000; ++i) {
    const test_camera camera = random_camera(&random, 100.0);
    csm_config config = random_config(&random);
    config.fit_mode = CSM_FIT_CASCADE;
    const plan_frame frame = plan_empty(&config, &camera, down);
    const double manual =
        config.split_mode == CSM_SPLIT_MANUAL ? config.split_distances[config.cascade_count - 1] : INFINITY;
    const double end = fmin(fmin(config.shadow_distance, frame.camera.far_depth), manual);
    double last = frame.camera.near_depth;
    assert_int_equal(frame.cascade_count, config.cascade_count);
    for (uint32_t k = 0; k < frame.cascade_count; ++k) {
      assert_true(frame.cascades[k].info.near_depth == last);
      assert_true(frame.cascades[k].info.far_depth > last);
      last = frame.cascades[k].info.far_depth;
    }
    assert_true(last == end);
  }
}

static void hold_for_ranges_up_to_ten_million(void **state) {
  (void)state;
  csm_config config = split_config();
  config.cascade_count = 8;
  config.shadow_distance = 1e9;
  for (double ratio = 2.0; ratio <= 1e7; ratio *= 1.5)
    for (int lambda = 0; lambda <= 4; ++lambda)
      for (int field = 0; field < 3; ++field) {
        const double half_degrees[] = {0.25, 30.0, 85.0};
        test_camera camera = plain_camera();
        camera.half_width = camera.half_height = tan(half_degrees[field] * M_PI / 180.0);
        camera.near = 1e-3;
        camera.far = ratio * 1e-3;
        config.split_lambda = lambda / 4.0;
        const plan_frame frame = plan_empty(&config, &camera, down);
        for (uint32_t k = 0; k < 8; ++k)
          assert_true(frame.cascades[k].info.near_depth < frame.cascades[k].info.far_depth);
      }
}

static void manual_ones_are_kept_where_they_fit(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  csm_config config = split_config();
  config.split_mode = CSM_SPLIT_MANUAL;
  config.cascade_count = 3;
  const double distances[] = {10.0, 24.66, 60.82};
  for (int i = 0; i < 3; ++i)
    config.split_distances[i] = distances[i];
  plan_frame frame = plan_empty(&config, &camera, down);
  for (int i = 0; i < 3; ++i)
    assert_true(frame.cascades[i].info.far_depth == distances[i]);

  config.shadow_distance = 20.0; /* ends before the second one does */
  frame = plan_empty(&config, &camera, down);
  assert_true(frame.cascades[0].info.far_depth == 10.0);
  assert_true(frame.cascades[1].info.far_depth > 19.9 && frame.cascades[1].info.far_depth < 20.0);
  assert_true(frame.cascades[2].info.far_depth == 20.0);
}

/* Its near plane lies behind it. */
static test_camera orthographic_camera(void) {
  test_camera camera = plain_camera();
  camera.orthographic = true;
  camera.half_width = camera.half_height = 20.0;
  camera.near = -20.0;
  camera.far = 80.0;
  return camera;
}

static void orthographic_ones_are_uniform_behind_the_origin(void **state) {
  (void)state;
  const test_camera camera = orthographic_camera();
  const csm_config config = split_config();
  const plan_frame frame = plan_empty(&config, &camera, down);
  for (int i = 0; i < 4; ++i)
    assert_near(frame.cascades[i].info.far_depth, -20.0 + 25.0 * (i + 1), 1e-9);
}

/* No interval holds a depth from the near plane on, and no map a point of the world, in front of it or anywhere. */
static void check_unshadowed(const plan_frame *frame, const csm_config *config) {
  random_state random = {11};
  assert_true(frame->unshadowed);
  for (uint32_t c = 0; c < config->cascade_count; ++c) {
    const csm_cascade_info *info = &frame->cascades[c].info;
    assert_true(info->far_depth < frame->camera.near_depth && info->far_depth < -1e20);
    assert_true(info->near_depth < info->far_depth);
    assert_int_equal(frame->windows[c].list.instance_count, 0);
    for (int i = 0; i < 50; ++i) {
      double p[3], at[3], clip[16], planes[5][4];
      random_unit(&random, p);
      const double far = random_scale(&random, 1e-3, 1e30);
      for (int k = 0; k < 3; ++k)
        p[k] *= far;
      transform_point(info->world_to_shadow, p, at);
      assert_true(at[0] > 1.5 && at[1] > 1.5 && at[2] > 1.5);
      plan_cascade_volume(frame, c, clip, planes);
      bool outside = false;
      for (int plane = 0; plane < 5; ++plane)
        outside |= planes[plane][0] * p[0] + planes[plane][1] * p[1] + planes[plane][2] * p[2] + planes[plane][3] < 0.0;
      assert_true(outside);
    }
  }
}

static void a_near_plane_beyond_the_shadow_distance_means_no_shadows(void **state) {
  (void)state;
  random_state random = {12};
  const test_camera camera = plain_camera();
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  test_scene scene = scene_make(20, 2);
  scene_scatter(&scene, &random, camera.eye, 5.0);
  const double distances[] = {0.05, 0.1};
  for (int i = 0; i < 4; ++i) {
    plan_frame frame;
    const char *error = "";
    csm_config config = random_full_config(&random);
    config.map_reversed = i / 2;
    config.split_mode = CSM_SPLIT_PRACTICAL;
    config.shadow_distance = distances[i % 2];
    plan_history before = {.has_samples = true, .sample_range[1].value = 7.0};
    const plan_frame_info info = {.config = &config,
                                  .view = view,
                                  .projection = projection,
                                  .light = down,
                                  .scene = &scene.scene,
                                  .before = &before};
    assert_int_equal(plan_traced(&frame, &info, scene.memory, &error), CSM_SUCCESS);
    check_unshadowed(&frame, &config);
    for (uint32_t slot = 0; slot < 20; ++slot)
      assert_int_equal(plan_drawn_by(&frame, slot), 0);
    /* What had been fitted is still known when the shadows come back. */
    assert_true(frame.history.has_light && frame.history.has_samples && frame.history.sample_range[1].value == 7.0);
  }
  scene_free(&scene);
}

static void needs_room_for_all_cascades(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  csm_config config = split_config();
  const plan_scene nothing = {0};
  plan_frame frame;
  const char *error = "";
  config.shadow_distance = nextafter(plan_empty(&config, &camera, down).camera.near_depth, 1.0);
  assert_int_equal(plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), down}, &nothing,
                             NULL, &error),
                   CSM_ERROR_INVALID_CAMERA);
  assert_true(error[0]);
}

/* ---- closed forms ---- */

typedef double closed_form(const csm_config *config, double near, double end, uint32_t split);

static double share(const csm_config *config, uint32_t split) {
  return (double)split / config->cascade_count;
}

static double uniform(const csm_config *config, double near, double end, uint32_t split) {
  return near + (end - near) * share(config, split);
}

static double logarithmic(const csm_config *config, double near, double end, uint32_t split) {
  return near * pow(end / near, share(config, split));
}

static double practical(const csm_config *config, double near, double end, uint32_t split) {
  return config->split_lambda * logarithmic(config, near, end, split) +
         (1.0 - config->split_lambda) * uniform(config, near, end, split);
}

static void check_form(const csm_config *config, const test_camera *camera, closed_form *form, double from) {
  const plan_frame frame = plan_empty(config, camera, down);
  const double end = fmin(config->shadow_distance, camera->far);
  assert_near(frame.cascades[0].info.near_depth, camera->near, 1e-9 * fabs(camera->near));
  for (uint32_t i = 1; i < config->cascade_count; ++i) {
    const double expected = form(config, from, end, i);
    assert_near(frame.cascades[i - 1].info.far_depth, expected, 1e-8 * fabs(expected));
  }
  assert_near(frame.cascades[config->cascade_count - 1].info.far_depth, end, 1e-8 * end);
}

/* From the near plane, from split_near where that lies between it and the end, and not from anywhere else. */
static void modes_follow_their_closed_forms(void **state) {
  (void)state;
  random_state random = {2};
  static const uint32_t modes[] = {CSM_SPLIT_UNIFORM, CSM_SPLIT_LOGARITHMIC, CSM_SPLIT_PRACTICAL};
  closed_form *const forms[] = {uniform, logarithmic, practical};
  for (int i = 0; i < 6000; ++i) {
    test_camera camera = plain_camera();
    camera.near = random_scale(&random, 0.01, 1.0);
    camera.far = random_scale(&random, 10.0, 1e4);
    csm_config config = split_config();
    config.cascade_count = 1 + random_below(&random, CSM_MAX_CASCADES);
    config.shadow_distance = random_scale(&random, 10.0, 1e4);
    config.split_lambda = random_between(&random, 0.0, 1.0);
    config.split_mode = modes[i % 3];
    const double end = fmin(config.shadow_distance, camera.far);
    check_form(&config, &camera, forms[i % 3], camera.near);
    config.split_near = random_between(&random, camera.near, end);
    check_form(&config, &camera, forms[i % 3], config.split_near);
    config.split_near =
        i % 2 ? camera.near * random_between(&random, 0.0, 1.0) : end * random_between(&random, 1.0, 2.0);
    check_form(&config, &camera, forms[i % 3], camera.near);
  }
}

/* Its pixels are equally large everywhere, however far away it stands: from the near plane, or from split_near. */
static void orthographic_ones_are_uniform_in_every_mode(void **state) {
  (void)state;
  random_state random = {4};
  static const uint32_t modes[] = {CSM_SPLIT_UNIFORM, CSM_SPLIT_LOGARITHMIC, CSM_SPLIT_PRACTICAL};
  for (int i = 0; i < 300; ++i) {
    test_camera camera = orthographic_camera();
    camera.near = i % 2 ? random_scale(&random, 0.01, 1.0) : -20.0;
    camera.far = random_scale(&random, 10.0, 1e5);
    csm_config config = split_config();
    config.shadow_distance = random_scale(&random, 10.0, 1e5);
    config.split_mode = modes[i % 3];
    check_form(&config, &camera, uniform, camera.near);
    config.split_near = 5.0;
    check_form(&config, &camera, uniform, 5.0);
  }
}

static void shares_are_of_the_way_to_the_end(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 2000; ++i) {
    test_camera camera = plain_camera();
    camera.near = random_scale(&random, 0.01, 1.0);
    camera.far = random_scale(&random, 10.0, 1e4);
    csm_config config = split_config();
    config.split_mode = CSM_SPLIT_FRACTIONS;
    config.cascade_count = 4;
    config.split_near = random_between(&random, 0.0, 10.0); /* is for splits that are not given */
    config.shadow_distance = random_scale(&random, 10.0, 1e4);
    double last = 0.0;
    for (int k = 0; k < 4; ++k)
      config.split_distances[k] = last += random_between(&random, 0.02, 0.25);
    const double length = fmin(config.shadow_distance, camera.far) - camera.near;
    const plan_frame frame = plan_empty(&config, &camera, down);
    for (int k = 0; k < 4; ++k) {
      const double expected = camera.near + length * config.split_distances[k];
      assert_near(frame.cascades[k].info.far_depth, expected, 1e-8 * expected);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(follows_the_formula),
      cmocka_unit_test(rise_to_the_end_exactly),
      cmocka_unit_test(hold_for_ranges_up_to_ten_million),
      cmocka_unit_test(manual_ones_are_kept_where_they_fit),
      cmocka_unit_test(orthographic_ones_are_uniform_behind_the_origin),
      cmocka_unit_test(a_near_plane_beyond_the_shadow_distance_means_no_shadows),
      cmocka_unit_test(needs_room_for_all_cascades),
      cmocka_unit_test(modes_follow_their_closed_forms),
      cmocka_unit_test(orthographic_ones_are_uniform_in_every_mode),
      cmocka_unit_test(shares_are_of_the_way_to_the_end),
  };
  return cmocka_run_group_tests_name("plan-splits", tests, NULL, NULL);
}
