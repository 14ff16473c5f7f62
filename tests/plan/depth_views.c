/* Depth samples of several views, and of buffers that hold no depths. */
#include "pictures.h"

#include <math.h>

/* Near on one side of the picture; a wall behind everything on the other: as two eyes, or two halves, may have it. */
static double near_thing(const test_camera *camera, double x, double y) {
  (void)camera;
  return fabs(y) < 0.5 ? 3.0 + x : -INFINITY;
}

static double far_thing(const test_camera *camera, double x, double y) {
  (void)camera;
  return fabs(y) < 0.5 ? 300.0 + 10.0 * x : -INFINITY;
}

static plan_frame plan_both(const csm_config *config, const test_camera *camera, const plan_depth_samples views[2]) {
  const plan_scene empty = {0};
  double view[16], projection[16];
  const char *error = "";
  plan_frame frame;
  camera_matrices(camera, view, projection);
  const plan_frame_info info = {.config = config,
                                .view = view,
                                .projection = projection,
                                .reversed = camera_reversed(camera),
                                .light = picture_light,
                                .scene = &empty,
                                .samples = views,
                                .sample_count = 2};
  if (plan_traced(&frame, &info, NULL, &error))
    fail_msg("%s", error);
  return frame;
}

static void what_any_view_saw_is_held(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  static picture near, far;
  take(&near, &camera, near_thing);
  take(&far, &camera, far_thing);
  for (uint32_t distribution = CSM_DEPTH_SAMPLES_SPLITS; distribution <= CSM_DEPTH_SAMPLES_BOUNDS; ++distribution)
    for (int order = 0; order < 2; ++order) {
      const csm_config config = sampled_config(distribution);
      const plan_depth_samples views[2] = {order ? far.samples : near.samples, order ? near.samples : far.samples};
      const plan_frame frame = plan_both(&config, &camera, views);
      assert_true(frame.history.has_samples);
      assert_true(frame.cascades[0].info.near_depth > 1.0 && end_of(&frame) < 600.0);
      check_covered(&config, &frame, &near);
      check_covered(&config, &frame, &far);
    }
}

/* Nothing is fitted to half of what is seen. */
static void one_view_that_is_of_no_use_leaves_all_unfitted(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  test_camera cut = camera;
  static picture good, nothing_seen, other;
  const csm_config config = sampled_config(CSM_DEPTH_SAMPLES_BOUNDS);
  camera_look(&cut, (double[]){1.0, 0.0, 0.0}, 0.0);
  take(&good, &camera, ground_and_wall);
  take(&nothing_seen, &camera, nothing);
  take(&other, &cut, ground_and_wall);
  const plan_frame plain = plan_with(&config, &camera, NULL, NULL);
  for (int i = 0; i < 6; ++i) {
    plan_depth_samples bad = i % 3 == 0 ? other.samples : nothing_seen.samples;
    if (i % 3 == 2)
      bad.columns = bad.rows = 0;
    const plan_depth_samples views[2] = {i < 3 ? bad : good.samples, i < 3 ? good.samples : bad};
    const plan_frame frame = plan_both(&config, &camera, views);
    assert_false(frame.history.has_samples);
    assert_memory_equal(frame.cascades, plain.cascades, sizeof plain.cascades);
  }
}

/* What a driver may leave in a buffer: numbers that are no depths. */
static void no_depth_of_a_buffer_raises_an_exception(void **state) {
  (void)state;
  random_state random = {9};
  static picture seen;
  for (int i = 0; i < 400; ++i) {
    test_camera camera = plain_camera();
    camera.reversed = i % 2;
    camera.far = i / 2 % 2 ? INFINITY : 1000.0;
    take(&seen, &camera, ground_and_wall);
    const float odd[] = {0.0f, 1.0f, NAN, INFINITY, -INFINITY, 1e-40f, 3e38f, -1.0f, 0.5f, nextafterf(1.0f, 0.0f)};
    for (int k = 0; k < 10; ++k)
      seen.tiles[random_below(&random, rows * columns)][k % 2] = odd[random_below(&random, 10)];
    const csm_config config = sampled_config(CSM_DEPTH_SAMPLES_BOUNDS);
    const plan_frame frame = plan_with(&config, &camera, &seen, NULL);
    for (uint32_t c = 0; c < frame.cascade_count; ++c)
      assert_true(plan_finite(frame.cascades[c].info.world_to_shadow, 16));
  }
}

/* By 90 degrees, as for a display that stands upright. */
static void turn(double projection[16]) {
  for (double *column = projection; column < projection + 16; column += 4) {
    const double x = column[0];
    column[0] = column[1];
    column[1] = -x;
  }
}

/* Depths are the same in whichever way the picture is turned, and so are splits. */
static void a_turned_picture_is_fitted(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  const plan_scene empty = {0};
  const csm_config config = sampled_config(CSM_DEPTH_SAMPLES_SPLITS);
  static picture seen;
  double view[16], projection[16];
  const char *error = "";
  plan_frame frame;
  take(&seen, &camera, ground_and_wall);
  const plan_frame straight = plan_with(&config, &camera, &seen, NULL);
  camera_matrices(&camera, view, projection);
  turn(projection);
  plan_depth_samples turned = seen.samples;
  turn(turned.camera.projection);
  turned.maps_camera = turned.camera;
  assert_true(plan_depth_samples_count(&turned, config.depth_samples_margin));
  const plan_frame_info info = {.config = &config,
                                .view = view,
                                .projection = projection,
                                .reversed = camera_reversed(&camera),
                                .light = picture_light,
                                .scene = &empty,
                                .samples = &turned,
                                .sample_count = 1};
  assert_int_equal(plan_traced(&frame, &info, NULL, &error), CSM_SUCCESS);
  assert_true(straight.history.has_samples && frame.history.has_samples);
  for (uint32_t i = 0; i < frame.cascade_count; ++i)
    assert_near(frame.cascades[i].info.far_depth, straight.cascades[i].info.far_depth, 1e-9);
}

/* A view that looks another way than its maps' camera does not count, whatever it saw. */
static void a_reflection_does_not_count(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  test_camera other = camera;
  static picture seen, mirrored;
  camera_look(&other, (double[]){1.0, 0.0, 0.0}, 0.0);
  take(&seen, &camera, ground_and_wall);
  take(&mirrored, &other, ground_and_wall);
  plan_depth_samples samples = seen.samples;
  samples.maps_camera = seen.samples.camera;
  assert_true(plan_depth_samples_count(&samples, 0.1));
  samples.maps_camera = mirrored.samples.camera;
  assert_false(plan_depth_samples_count(&samples, 0.1));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_any_view_saw_is_held),
      cmocka_unit_test(one_view_that_is_of_no_use_leaves_all_unfitted),
      cmocka_unit_test(no_depth_of_a_buffer_raises_an_exception),
      cmocka_unit_test(a_turned_picture_is_fitted),
      cmocka_unit_test(a_reflection_does_not_count),
  };
  return cmocka_run_group_tests_name("plan-depth-views", tests, NULL, NULL);
}
