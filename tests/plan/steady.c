/* From frame to frame: sizes that stay while a camera zooms, and grids that stay where they are while the light turns.
 */
#include "support.h"

#include <math.h>
#include <string.h>

static const uint32_t steady_fits[] = {CSM_FIT_MINIMUM_SPHERE, CSM_FIT_CENTROID_SPHERE, CSM_FIT_CASCADE_SQUARE,
                                       CSM_FIT_SCENE_SQUARE};

static const double plain_light[3] = {0.3, -1.0, 0.2};

/* The next frame; its history takes the place of the last one's. */
static plan_frame plan_next(plan_history *history, const csm_config *config, const test_camera *camera,
                            const double light[3]) {
  const plan_scene nothing = {0};
  double view[16], projection[16];
  const char *error = "";
  plan_frame frame;
  camera_matrices(camera, view, projection);
  const plan_frame_info info = {.config = config,
                                .view = view,
                                .projection = projection,
                                .reversed = camera_reversed(camera),
                                .light = light,
                                .scene = &nothing,
                                .before = history};
  if (plan_traced(&frame, &info, NULL, &error))
    fail_msg("%s", error);
  *history = frame.history;
  return frame;
}

static void set_field(test_camera *camera, double vertical_deg, double aspect) {
  camera->half_height = tan(vertical_deg * M_PI / 360.0);
  camera->half_width = camera->half_height * aspect;
}

/* ---- sizes ---- */

static bool same_sizes(const plan_frame *a, const plan_frame *b) {
  bool same = true;
  for (uint32_t c = 0; c < a->cascade_count; ++c)
    same = same && a->cascades[c].info.texel_size == b->cascades[c].info.texel_size &&
           a->cascades[c].info.depth_range == b->cascades[c].info.depth_range;
  return same;
}

/* Every receiver lies in its map with the filter around it, and sizes are less than 1.4 times what is needed. */
static void check_held(random_state *random, const csm_config *config, const test_camera *camera,
                       const plan_frame *frame) {
  const plan_frame exact = plan_empty(config, camera, plain_light);
  for (uint32_t c = 0; c < frame->cascade_count; ++c) {
    const csm_cascade_info *info = &frame->cascades[c].info;
    const double border = (double)plan_filter_radius_texels(config) / frame->cascades[c].resolution;
    assert_true(info->texel_size < 1.4 * exact.cascades[c].info.texel_size);
    double receiver[3], at[3];
    slice_point(random, camera, info, receiver);
    transform_point(info->world_to_shadow, receiver, at);
    for (int axis = 0; axis < 3; ++axis)
      assert_true(at[axis] >= (axis < 2 ? border : 0.0) && at[axis] <= 1.0 - (axis < 2 ? border : 0.0));
  }
}

/* Steps of size while the field of view goes an octave by 0.1 % a frame. */
static uint32_t steps_of_zoom(random_state *random, const csm_config *config, test_camera camera, double from,
                              double factor) {
  plan_history history = {0};
  plan_frame last = {0};
  uint32_t steps = 0;
  for (int i = 0; i <= 693; ++i) { /* 1.001^693 is 2 */
    set_field(&camera, from * pow(factor, i), 16.0 / 9.0);
    const plan_frame frame = plan_next(&history, config, &camera, plain_light);
    check_held(random, config, &camera, &frame);
    steps += i && !same_sizes(&frame, &last);
    last = frame;
  }
  return steps;
}

static void an_octave_of_zoom_takes_four_steps(void **state) {
  (void)state;
  random_state random = {1};
  for (int fit = 0; fit < 4; ++fit) {
    csm_config config = default_config();
    config.fit_mode = steady_fits[fit];
    test_camera camera = plain_camera();
    camera.center[0] = fit % 2 ? 0.5 : 0.0; /* scaled with the image, as a shift of the lens is */
    for (double wide = 120.0; wide > 1.0; wide /= 2.0) {
      const uint32_t in = steps_of_zoom(&random, &config, camera, wide, 1.0 / 1.001);
      const uint32_t out = steps_of_zoom(&random, &config, camera, wide / 2.0, 1.001);
      assert_in_range(in, 1, 4);
      assert_in_range(out, 1, 4);
    }
  }
}

static void an_octave_of_shape_takes_four_steps(void **state) {
  (void)state;
  random_state random = {2};
  const csm_config config = default_config();
  for (int way = 0; way < 4; ++way) {
    test_camera camera = plain_camera();
    camera.orthographic = way >= 2;
    plan_history history = {0};
    plan_frame last = {0};
    uint32_t steps = 0;
    for (int i = 0; i <= 693; ++i) {
      set_field(&camera, 50.0, (way % 2 ? 1.0 : 2.0) * pow(way % 2 ? 1.001 : 1.0 / 1.001, i));
      if (camera.orthographic)
        camera.half_width *= 40.0, camera.half_height *= 40.0;
      const plan_frame frame = plan_next(&history, &config, &camera, plain_light);
      check_held(&random, &config, &camera, &frame);
      steps += i && !same_sizes(&frame, &last);
      last = frame;
    }
    assert_in_range(steps, 1, 4);
  }
}

/* A zoom that wavers, as one that follows a breath, around any place between two steps. */
static void a_wavering_zoom_steps_once(void **state) {
  (void)state;
  const csm_config config = default_config();
  for (double start = 40.0; start < 70.0; start += 1.7) {
    test_camera camera = plain_camera();
    plan_history history = {0};
    plan_frame last = {0};
    uint32_t steps = 0;
    for (int i = 0; i < 400; ++i) {
      const double to = i < 100 ? 40.0 + (start - 40.0) * i / 100.0 : start * (1.0 + 0.015 * sin(i * 0.3));
      set_field(&camera, to, 16.0 / 9.0);
      const plan_frame frame = plan_next(&history, &config, &camera, plain_light);
      steps += i > 100 && !same_sizes(&frame, &last);
      last = frame;
    }
    assert_in_range(steps, 0, 1);
  }
}

/* A picture whose sides are rounded to whole pixels at every scale: what dynamic resolution does to the aspect. */
static void rounded_pictures_change_no_size(void **state) {
  (void)state;
  const csm_config config = default_config();
  test_camera camera = plain_camera();
  plan_history history = {0};
  set_field(&camera, 60.0, 1280.0 / 720.0);
  const plan_frame first = plan_next(&history, &config, &camera, plain_light);
  for (int height = 720; height >= 360; --height) {
    set_field(&camera, 60.0, round(height * 16.0 / 9.0) / height);
    const plan_frame frame = plan_next(&history, &config, &camera, plain_light);
    assert_true(same_sizes(&frame, &first));
  }
}

static void a_first_frame_and_a_cut_are_exact(void **state) {
  (void)state;
  const csm_config config = default_config();
  test_camera camera = plain_camera();
  plan_history history = {0};
  for (int i = 0; i < 6; ++i) {
    set_field(&camera, i % 2 ? 20.0 : 60.0, 16.0 / 9.0);
    const plan_frame frame = plan_next(&history, &config, &camera, plain_light);
    const plan_frame exact = plan_empty(&config, &camera, plain_light);
    assert_true(same_sizes(&frame, &exact));
  }
  set_field(&camera, 61.0, 16.0 / 9.0); /* from 20: a cut again; then a little wider, which is none */
  (void)plan_next(&history, &config, &camera, plain_light);
  set_field(&camera, 63.0, 16.0 / 9.0);
  const plan_frame wider = plan_next(&history, &config, &camera, plain_light);
  plan_frame exact = plan_empty(&config, &camera, plain_light);
  assert_false(same_sizes(&wider, &exact));
  plan_history_reconfigure(&history);
  const plan_frame anew = plan_next(&history, &config, &camera, plain_light);
  assert_true(same_sizes(&anew, &exact));
}

/* ---- anchors ---- */

/* The texel of the grid, with fractions, at which a cascade counts a point. */
static void counted_at(double out[2], const plan_cascade *cascade, const double p[3]) {
  double at[3];
  transform_point(cascade->info.world_to_shadow, p, at);
  for (int axis = 0; axis < 2; ++axis) {
    const double up = axis ? 1.0 - at[1] : at[0];
    out[axis] = up * cascade->resolution + cascade->place_texels[axis];
  }
}

/*
 * A light that turns while the camera turns and walks, near the world's origin and far from it. The middle of a slice's
 * sphere lies on the view axis at the slice's end, for a picture so wide. There the grid stays, but for the turn times
 * the way to the grid's next point, which is the anchor, and what doubles hold.
 */
static void check_turning(const csm_config *config, double world, double turn) {
  test_camera camera = plain_camera();
  plan_history history = {0};
  plan_frame last = {0};
  const double grid = (double)(1u << config->snap_power);
  camera.eye[0] = world;
  for (int step = 0; step < 60; ++step) {
    const double angle = step * turn, light[3] = {cos(angle) * 0.6, -0.8, sin(angle) * 0.6};
    camera_look(&camera, (double[]){sin(step * 0.03), 0.0, -cos(step * 0.03)}, 0.0);
    camera.eye[2] -= 0.07;
    const plan_frame frame = plan_next(&history, config, &camera, light);
    for (uint32_t c = 0; step && c < frame.cascade_count; ++c) {
      const plan_cascade *now = &frame.cascades[c];
      double middle[3], then_at[2], now_at[2];
      camera_point(&camera, 0.0, 0.0, now->info.far_depth, middle);
      counted_at(then_at, &last.cascades[c], middle);
      counted_at(now_at, now, middle);
      const double rounding = 1e-6 + 8.0 * (nextafter(world + 1.0, INFINITY) - world - 1.0) / now->info.texel_size;
      for (int axis = 0; axis < 2; ++axis)
        assert_near(now_at[axis], then_at[axis], 2.0 * turn * grid + rounding);
    }
    last = frame;
    if (step % 10 == 9)
      plan_history_reconfigure(&history); /* which does not move the grid */
  }
}

static void grids_stay_in_the_middle_of_their_maps(void **state) {
  (void)state;
  const double worlds[] = {0.0, 1e3, 1e5, 1e7}, turns[] = {1e-5, 2e-4, 1e-2};
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) {
      csm_config config = default_config();
      config.snap_power = (uint32_t)i;
      config.snap_mode = k % 2 ? CSM_SNAP_FLOOR : CSM_SNAP_ROUND;
      config.light_roll = k == 2 ? CSM_LIGHT_ROLL_CARRIED : CSM_LIGHT_ROLL_FIXED;
      check_turning(&config, worlds[i], turns[k]);
    }
}

/* A light that rests, after it has turned: whatever the camera does, every point keeps its place on the grid. */
static void a_resting_light_leaves_every_point_in_its_place(void **state) {
  (void)state;
  random_state random = {3};
  csm_config config = default_config();
  test_camera camera = plain_camera();
  plan_history history = {0};
  for (int i = 0; i < 5; ++i)
    (void)plan_next(&history, &config, &camera, (double[]){0.3, -1.0, 0.2 + i * 0.01});
  plan_frame last = {0};
  for (int i = 0; i < 100; ++i) {
    double still[3] = {20.0, -3.0, 40.0}, then_at[2], now_at[2], forward[3];
    random_unit(&random, forward);
    camera_look(&camera, forward, 0.0);
    for (int axis = 0; axis < 3; ++axis)
      camera.eye[axis] += random_between(&random, -5.0, 5.0);
    const plan_frame frame = plan_next(&history, &config, &camera, (double[]){0.3, -1.0, 0.24});
    for (uint32_t c = 0; i && c < frame.cascade_count; ++c) {
      counted_at(then_at, &last.cascades[c], still);
      counted_at(now_at, &frame.cascades[c], still);
      for (int axis = 0; axis < 2; ++axis)
        assert_near(now_at[axis], then_at[axis], 1e-6);
      /* And its depth, in steps of an eighth of the sphere, which is a ninth of the range */
      const double depths[2] = {shadow_depth(&last.cascades[c].info, still),
                                shadow_depth(&frame.cascades[c].info, still)};
      const double steps = 9.0 * (depths[1] - depths[0]);
      assert_near(steps, round(steps), 1e-6);
    }
    last = frame;
  }
}

/* A light that turns far away leaves the grids' points there; after a cut back they start from the world's origin. */
static void a_cut_from_far_away_counts_from_the_origin(void **state) {
  (void)state;
  const csm_config config = default_config();
  const test_camera camera = plain_camera();
  const plan_frame first = plan_empty(&config, &camera, plain_light);
  test_camera away = camera;
  away.eye[0] += 1e11;
  plan_history history = {0};
  (void)plan_next(&history, &config, &away, (double[]){0.31, -1.0, 0.2});
  (void)plan_next(&history, &config, &away, plain_light);
  const plan_frame back = plan_next(&history, &config, &camera, plain_light);
  for (uint32_t c = 0; c < first.cascade_count; ++c)
    for (int i = 0; i < 16; ++i)
      assert_true(back.cascades[c].info.world_to_shadow[i] == first.cascades[c].info.world_to_shadow[i]);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_octave_of_zoom_takes_four_steps),
      cmocka_unit_test(an_octave_of_shape_takes_four_steps),
      cmocka_unit_test(a_wavering_zoom_steps_once),
      cmocka_unit_test(rounded_pictures_change_no_size),
      cmocka_unit_test(a_first_frame_and_a_cut_are_exact),
      cmocka_unit_test(grids_stay_in_the_middle_of_their_maps),
      cmocka_unit_test(a_resting_light_leaves_every_point_in_its_place),
      cmocka_unit_test(a_cut_from_far_away_counts_from_the_origin),
  };
  return cmocka_run_group_tests_name("plan-steady", tests, NULL, NULL);
}
