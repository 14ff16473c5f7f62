/* Splits and bounds by what the camera saw, in scenes whose depths are known. */
#include "pictures.h"

#include "csm_constants.h"
#include <math.h>
#include <string.h>

/* Something in the middle of the picture alone, ten metres away. */
static double small_thing(const test_camera *camera, double x, double y) {
  (void)camera;
  return fabs(x) < 0.2 && fabs(y) < 0.2 ? 10.0 + x : -INFINITY;
}

/* A slanted surface somewhere in any camera's range. */
static double slanted(const test_camera *camera, double x, double y) {
  const double end = fmin(camera->far, camera->near + 1000.0);
  return camera->near + (end - camera->near) * (0.05 + 0.02 * x + 0.01 * y);
}

/* Right at the near plane. */
static double at_the_near_plane(const test_camera *camera, double x, double y) {
  return camera->near * (1.0 + 1e-6) + (x > 0.0 ? 5.0 + y : 0.0);
}

static void assert_unfitted(const csm_config *config, const test_camera *camera, const picture *seen) {
  const plan_frame fitted = plan_with(config, camera, seen, NULL), plain = plan_with(config, camera, NULL, NULL);
  assert_memory_equal(fitted.cascades, plain.cascades, sizeof plain.cascades);
  assert_false(fitted.history.has_samples);
}

static void splits_and_bounds_hold_what_is_seen(void **state) {
  (void)state;
  depth_field *const fields[] = {ground_and_wall, ground, small_thing};
  for (int field = 0; field < 3; ++field)
    for (uint32_t distribution = CSM_DEPTH_SAMPLES_SPLITS; distribution <= CSM_DEPTH_SAMPLES_BOUNDS; ++distribution)
      for (uint32_t fit = 0; fit <= CSM_FIT_SCENE_SQUARE; ++fit) {
        const test_camera camera = plain_camera();
        csm_config config = sampled_config(distribution);
        config.fit_mode = fit;
        picture seen;
        take(&seen, &camera, fields[field]);
        const plan_frame frame = plan_with(&config, &camera, &seen, NULL);
        check_covered(&config, &frame, &seen);
        const plan_frame unfitted = plan_with(&config, &camera, NULL, NULL);
        assert_true(frame.cascades[0].info.texel_size < unfitted.cascades[0].info.texel_size ||
                    frame.cascades[3].info.texel_size < unfitted.cascades[3].info.texel_size);
      }
}

/* From what is nearest to what is farthest, with the margin, and no more than a step of a quarter of an octave wider.
 */
static void splits_keep_to_the_margin(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  const double step = exp2(0.25);
  picture seen;
  take(&seen, &camera, ground_and_wall);
  double nearest = INFINITY, farthest = 0.0;
  for (int row = 0; row < height; ++row)
    for (int column = 0; column < width; ++column) {
      nearest = fmin(nearest, seen.depths[row][column]);
      farthest = fmax(farthest, seen.depths[row][column]);
    }
  for (int i = 0; i <= 10; ++i) {
    csm_config config = sampled_config(CSM_DEPTH_SAMPLES_SPLITS);
    config.depth_samples_margin = i / 20.0;
    const plan_frame frame = plan_with(&config, &camera, &seen, NULL);
    const double near = nearest * (1.0 - config.depth_samples_margin),
                 end = farthest * (1.0 + config.depth_samples_margin);
    assert_true(frame.cascades[0].info.near_depth <= near * (1.0 + 1e-6));
    assert_true(frame.cascades[0].info.near_depth >= near / step * (1.0 - 1e-6));
    assert_true(end_of(&frame) >= end * (1.0 - 1e-6) && end_of(&frame) <= end * step * (1.0 + 1e-6));
  }
}

/* Shadows fade before their end, not before the end of what is seen. */
static void shadows_fade_where_they_would_without_samples(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  csm_config config = sampled_config(CSM_DEPTH_SAMPLES_SPLITS);
  config.out_of_range = CSM_OUT_OF_RANGE_FADED;
  picture seen;
  take(&seen, &camera, small_thing);
  const plan_frame frames[] = {plan_with(&config, &camera, &seen, NULL), plan_with(&config, &camera, NULL, NULL)};
  assert_true(end_of(&frames[0]) < 0.8 * end_of(&frames[1]));
  for (int i = 0; i < 2; ++i) {
    float constants[CSM_C_COUNT * 4];
    (void)plan_write_constants(constants, &frames[i], &config);
    const double length = config.fade_share * end_of(&frames[1]);
    assert_float_equal(constants[CSM_S_BAND * 4 + 1], end_of(&frames[1]) - length, 1e-3);
    assert_float_equal(constants[CSM_S_BAND * 4 + 2], 1.0 / length, 1e-6);
  }
}

/* Cameras of all kinds, with what each of them sees at some depth. */
static void any_camera_has_what_it_sees(void **state) {
  (void)state;
  random_state random = {1};
  uint32_t fitted = 0, behind = 0;
  for (int i = 0; i < 1200; ++i) {
    const test_camera camera = random_camera(&random, 10.0);
    csm_config config = random_full_config(&random);
    config.bias_normal_texels = 0.0;
    config.depth_samples = CSM_DEPTH_SAMPLES_BOUNDS;
    if (config.split_mode != CSM_SPLIT_MANUAL && i % 2)
      config.depth_samples = CSM_DEPTH_SAMPLES_SPLITS;
    picture seen;
    take(&seen, &camera, slanted);
    const plan_frame frame = plan_with(&config, &camera, &seen, NULL);
    check_covered(&config, &frame, &seen);
    fitted += frame.history.has_samples || frame.history.has_bounds[0];
    behind += camera.orthographic && seen.depths[height / 2][width / 2] < 0.0;
  }
  assert_true(fitted > 800 && behind > 20);
}

static void what_lies_past_the_ends_is_left_out(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  csm_config config = sampled_config(CSM_DEPTH_SAMPLES_BOUNDS);
  picture seen;
  take(&seen, &camera, ground); /* up to 1000 m */
  config.shadow_distance = 50.0;
  plan_frame frame = plan_with(&config, &camera, &seen, NULL);
  assert_true(end_of(&frame) == 50.0);
  check_covered(&config, &frame, &seen);

  config.shadow_distance = 1.0; /* before all that is seen */
  frame = plan_with(&config, &camera, &seen, NULL);
  assert_true(end_of(&frame) == 1.0 && frame.cascades[0].info.near_depth == frame.camera.near_depth);

  take(&seen, &camera, at_the_near_plane);
  config.shadow_distance = 1000.0;
  frame = plan_with(&config, &camera, &seen, NULL);
  assert_true(frame.cascades[0].info.near_depth == frame.camera.near_depth);
  assert_true(end_of(&frame) < 10.0);
  check_covered(&config, &frame, &seen);
}

static void where_nothing_was_seen_nothing_is_fitted(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  picture seen;
  take(&seen, &camera, nothing);
  for (uint32_t distribution = CSM_DEPTH_SAMPLES_OFF; distribution <= CSM_DEPTH_SAMPLES_BOUNDS; ++distribution) {
    const csm_config config = sampled_config(distribution);
    assert_unfitted(&config, &camera, &seen);
    picture none = seen;
    none.samples.columns = none.samples.rows = 0;
    assert_unfitted(&config, &camera, &none);
  }
  take(&seen, &camera, ground_and_wall);
  const csm_config off = sampled_config(CSM_DEPTH_SAMPLES_OFF);
  assert_unfitted(&off, &camera, &seen);
}

static void a_cut_is_not_fitted(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  picture seen;
  take(&seen, &camera, ground_and_wall);
  for (uint32_t distribution = CSM_DEPTH_SAMPLES_SPLITS; distribution <= CSM_DEPTH_SAMPLES_BOUNDS; ++distribution) {
    const csm_config config = sampled_config(distribution);
    test_camera cut = camera;
    assert_true(plan_with(&config, &cut, &seen, NULL).history.has_samples);
    camera_look(&cut, (double[]){1.0, 0.0, 0.0}, 0.0); /* to the side */
    assert_unfitted(&config, &cut, &seen);
    camera_look(&cut, (double[]){0.0, 0.0, 1.0}, 0.0); /* back */
    assert_unfitted(&config, &cut, &seen);
    cut = camera;
    for (int k = 0; k < 3; ++k) { /* to the ground, which turns no side */
      cut.forward[k] = (double[]){0.0, -0.8, -0.6}[k];
      cut.up[k] = (double[]){0.0, 0.6, -0.8}[k];
    }
    assert_unfitted(&config, &cut, &seen);
    cut = camera;
    for (int k = 0; k < 3; ++k) { /* on its head */
      cut.right[k] = -cut.right[k];
      cut.up[k] = -cut.up[k];
    }
    assert_unfitted(&config, &cut, &seen);
    cut = camera;
    cut.eye[0] = 30.0; /* far away */
    assert_unfitted(&config, &cut, &seen);
    cut = camera;
    cut.half_width /= 2.0; /* through a telephoto lens */
    cut.half_height /= 2.0;
    assert_unfitted(&config, &cut, &seen);
    cut = camera;
    cut.orthographic = true;
    assert_unfitted(&config, &cut, &seen);
    cut = camera;
    cut.reversed = true; /* which is no cut: it sees the same */
    assert_true(plan_with(&config, &cut, &seen, NULL).history.has_samples);
  }
}

/* ---- from frame to frame ---- */

static void yaw(double out[3], const double v[3], double angle) {
  out[0] = v[0] * cos(angle) - v[2] * sin(angle);
  out[1] = v[1];
  out[2] = v[2] * cos(angle) + v[0] * sin(angle);
}

static void sway(test_camera *camera, const test_camera *base, double by) {
  *camera = *base;
  camera->eye[0] += 0.02 * by;
  camera->eye[1] += 0.01 * by;
  camera->eye[2] += 0.03 * by;
  yaw(camera->right, base->right, 0.002 * by);
  yaw(camera->up, base->up, 0.002 * by);
  yaw(camera->forward, base->forward, 0.002 * by);
}

static test_camera standing_somewhere(random_state *random) {
  const test_camera plain = plain_camera();
  const double pitch = random_between(random, -0.6, 0.2), angle = random_between(random, -0.5, 0.5);
  test_camera camera = plain;
  yaw(camera.right, plain.right, angle);
  yaw(camera.up, (double[]){0.0, cos(pitch), sin(pitch)}, angle);
  yaw(camera.forward, (double[]){0.0, sin(pitch), -cos(pitch)}, angle);
  for (int axis = 0; axis < 3; ++axis)
    camera.eye[axis] = random_between(random, -1.0, 1.0);
  return camera;
}

/* Samples are a frame old; what is seen by then is held by the margin. */
static void a_moving_camera_has_what_it_sees_now(void **state) {
  (void)state;
  random_state random = {2};
  for (int i = 0; i < 100; ++i) {
    const csm_config config = sampled_config(i % 2 ? CSM_DEPTH_SAMPLES_SPLITS : CSM_DEPTH_SAMPLES_BOUNDS);
    const test_camera base = standing_somewhere(&random);
    plan_history history = {0};
    for (int step = 0; step < 6; ++step) {
      test_camera camera;
      picture seen, now;
      sway(&camera, &base, step - 1);
      take(&seen, &camera, ground_and_wall);
      sway(&camera, &base, step);
      take(&now, &camera, ground_and_wall);
      const plan_frame frame = plan_with(&config, &camera, &seen, &history);
      assert_true(frame.history.has_samples);
      check_covered(&config, &frame, &now);
      history = frame.history;
    }
  }
}

/* Looking around: at each frame a strip comes into the picture that nothing is known of, a tenth of it at most, at the
 * same depths. */
static void the_margin_holds_what_comes_into_the_picture(void **state) {
  (void)state;
  random_state random = {4};
  csm_config config = sampled_config(CSM_DEPTH_SAMPLES_BOUNDS);
  config.split_mode = CSM_SPLIT_MANUAL; /* whatever depth it has */
  for (int c = 0; c < 4; ++c)
    config.split_distances[c] = (double[]){5.0, 15.0, 50.0, 1000.0}[c];
  for (int i = 0; i < 80; ++i) {
    const test_camera plain = plain_camera();
    test_camera base = plain;
    const double around = random_between(&random, 0.0, 2.0 * M_PI); /* so that the light comes from any side */
    yaw(base.right, plain.right, around);
    yaw(base.forward, plain.forward, around);
    for (int axis = 0; axis < 3; ++axis)
      base.eye[axis] = random_between(&random, -1.0, 1.0);
    for (int side = -1; side <= 1; side += 2) {
      test_camera turned = base;
      picture seen, now;
      yaw(turned.right, base.right, side * 0.09);
      yaw(turned.up, base.up, side * 0.09);
      yaw(turned.forward, base.forward, side * 0.09);
      take(&seen, &base, ground);
      take(&now, &turned, ground);
      const plan_frame frame = plan_with(&config, &turned, &seen, NULL);
      assert_true(frame.history.has_bounds[2] || frame.history.has_bounds[3]);
      check_covered(&config, &frame, &now);
    }
  }
}

/* Far moves, up to what counts as a cut: every surface that was seen then lies in a slice and its map, if it is seen
 * now. */
static void what_was_seen_is_found_again_after_a_move(void **state) {
  (void)state;
  random_state random = {5};
  uint32_t found = 0;
  for (int i = 0; i < 240; ++i) {
    csm_config config = sampled_config(CSM_DEPTH_SAMPLES_BOUNDS);
    config.depth_samples_margin = 0.15;
    const test_camera base = standing_somewhere(&random);
    test_camera moved = base;
    const double angle = random_between(&random, -0.2, 0.2);
    yaw(moved.right, base.right, angle);
    yaw(moved.up, base.up, angle);
    yaw(moved.forward, base.forward, angle);
    for (int axis = 0; axis < 3; axis += 2)
      moved.eye[axis] += random_between(&random, -4.0, 4.0);
    picture seen;
    take(&seen, &base, ground_and_wall);
    const plan_frame frame = plan_with(&config, &moved, &seen, NULL);
    if (!frame.history.has_samples)
      continue;
    for (int row = 0; row < height; ++row)
      for (int column = 0; column < width; ++column) {
        double clip[2], p[3], depth = 0.0, across = 0.0, above = 0.0;
        if (!(seen.depths[row][column] > -INFINITY))
          continue;
        pixel_clip(column, row, clip);
        camera_point(&base, clip[0], clip[1], seen.depths[row][column], p);
        for (int k = 0; k < 3; ++k) {
          depth += moved.forward[k] * (p[k] - moved.eye[k]);
          across += moved.right[k] * (p[k] - moved.eye[k]);
          above += moved.up[k] * (p[k] - moved.eye[k]);
        }
        if (depth > moved.near && fabs(across) < depth * moved.half_width && fabs(above) < depth * moved.half_height) {
          check_point(&config, &frame, p, depth);
          ++found;
        }
      }
  }
  assert_true(found > 40000);
}

static void sizes_stay_while_a_camera_sways(void **state) {
  (void)state;
  random_state random = {3};
  /* By then both ends of the way have been seen, and what was too wide at first has let go. */
  const int settled = 20;
  uint32_t needed = 0;
  for (int i = 0; i < 100; ++i) {
    const csm_config config = sampled_config(i % 2 ? CSM_DEPTH_SAMPLES_SPLITS : CSM_DEPTH_SAMPLES_BOUNDS);
    const test_camera base = standing_somewhere(&random);
    test_camera ends[2]; /* of its way */
    picture seen[2];
    plan_frame alone[2];
    plan_history history = {0};
    plan_frame last = {0};
    for (int end = 0; end < 2; ++end) {
      sway(&ends[end], &base, end ? 1.0 : -1.0);
      take(&seen[end], &ends[end], ground_and_wall);
      alone[end] = plan_with(&config, &ends[end], &seen[end], NULL);
    }
    for (int step = 0; step < 60; ++step) {
      const plan_frame frame = plan_with(&config, &ends[step % 2], &seen[step % 2], &history);
      for (uint32_t c = 0; c < frame.cascade_count; ++c) {
        if (step > settled)
          assert_true(frame.cascades[c].texel[0] == last.cascades[c].texel[0] &&
                      frame.cascades[c].texel[1] == last.cascades[c].texel[1] &&
                      frame.cascades[c].info.far_depth == last.cascades[c].info.far_depth);
        needed += step > settled && alone[0].cascades[c].texel[0] != alone[1].cascades[c].texel[0];
      }
      last = frame;
      history = frame.history;
    }
  }
  assert_true(needed > 50); /* what would have changed without the frame before */
}

/* What grows is held at once; what has been too wide for some frames lets go. */
static void sizes_follow_what_is_seen(void **state) {
  (void)state;
  const csm_config config = sampled_config(CSM_DEPTH_SAMPLES_SPLITS);
  const test_camera camera = plain_camera();
  picture wall, horizon;
  take(&wall, &camera, ground_and_wall);
  take(&horizon, &camera, ground);
  const plan_frame first = plan_with(&config, &camera, &wall, NULL);
  assert_true(end_of(&first) < 60.0);
  const plan_frame grown = plan_with(&config, &camera, &horizon, &first.history);
  check_covered(&config, &grown, &horizon);
  plan_history history = grown.history;
  for (int step = 0; step < 15; ++step) {
    const plan_frame held = plan_with(&config, &camera, &wall, &history);
    assert_true(end_of(&held) == end_of(&grown));
    history = held.history;
  }
  const plan_frame shrunk = plan_with(&config, &camera, &wall, &history);
  assert_true(end_of(&shrunk) == end_of(&first));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(splits_and_bounds_hold_what_is_seen),
      cmocka_unit_test(splits_keep_to_the_margin),
      cmocka_unit_test(shadows_fade_where_they_would_without_samples),
      cmocka_unit_test(any_camera_has_what_it_sees),
      cmocka_unit_test(what_lies_past_the_ends_is_left_out),
      cmocka_unit_test(where_nothing_was_seen_nothing_is_fitted),
      cmocka_unit_test(a_cut_is_not_fitted),
      cmocka_unit_test(a_moving_camera_has_what_it_sees_now),
      cmocka_unit_test(the_margin_holds_what_comes_into_the_picture),
      cmocka_unit_test(what_was_seen_is_found_again_after_a_move),
      cmocka_unit_test(sizes_stay_while_a_camera_sways),
      cmocka_unit_test(sizes_follow_what_is_seen),
  };
  return cmocka_run_group_tests_name("plan-depth-samples", tests, NULL, NULL);
}
