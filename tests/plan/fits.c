/* Every way to fit a map to its slice, and to bring it to the grid of its texels. */
#include "support.h"

#include "csm_constants.h"
#include <math.h>

enum { receivers = 16 };

/* Fits whose size follows from the projection alone. */
static const uint32_t steady_fits[] = {CSM_FIT_MINIMUM_SPHERE, CSM_FIT_CENTROID_SPHERE, CSM_FIT_CASCADE_SQUARE,
                                       CSM_FIT_SCENE_SQUARE};

/* What the filter and a normal offset, which is in the larger texels, reach along an axis. */
static double border(const csm_config *config, const plan_cascade *cascade, int axis) {
  const double larger = cascade->info.texel_size / cascade->texel[axis];
  return (plan_filter_radius_texels(config) + config->bias_normal_texels * larger) / cascade->resolution;
}

static void check_inside(const csm_config *config, const plan_cascade *cascade, const double receiver[3],
                         double world) {
  double at[3];
  transform_point(cascade->info.world_to_shadow, receiver, at);
  for (int axis = 0; axis < 2; ++axis)
    if (!(at[axis] >= border(config, cascade, axis) && at[axis] <= 1.0 - border(config, cascade, axis)))
      fail_msg("fit %u, axis %d: %.12g, border %g", config->fit_mode, axis, at[axis], border(config, cascade, axis));
  const double rounding = 1e-12 + 16.0 * world * 0x1p-52 / cascade->info.depth_range;
  assert_true(at[2] >= -rounding && at[2] <= 1.0 + rounding);
}

static void hold_every_receiver_with_its_filter(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 6000; ++i) {
    const double world = i % 3 ? 100.0 : 1e5;
    const test_camera camera = random_camera(&random, world);
    csm_config config = random_full_config(&random);
    config.fit_mode = (uint32_t)i % (CSM_FIT_SCENE_SQUARE + 1);
    config.depth_mode = random_below(&random, 2) ? CSM_DEPTH_CASTERS : CSM_DEPTH_SLICE;
    double light[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    for (uint32_t c = 0; c < frame.cascade_count; ++c)
      for (int k = 0; k < receivers; ++k) {
        double receiver[3];
        slice_point(&random, &camera, &frame.cascades[c].info, receiver);
        check_inside(&config, &frame.cascades[c], receiver, world + frame.cascades[c].info.far_depth);
      }
  }
}

static void scene_fits_begin_at_the_camera(void **state) {
  (void)state;
  random_state random = {2};
  for (int i = 0; i < 2000; ++i) {
    const test_camera camera = random_camera(&random, 100.0);
    csm_config config = random_full_config(&random);
    config.fit_mode = i % 2 ? CSM_FIT_SCENE : CSM_FIT_SCENE_SQUARE;
    double light[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      csm_cascade_info whole = frame.cascades[c].info;
      whole.near_depth = frame.camera.near_depth;
      for (int k = 0; k < receivers; ++k) {
        double receiver[3];
        slice_point(&random, &camera, &whole, receiver);
        check_inside(&config, &frame.cascades[c], receiver, 100.0 + whole.far_depth);
      }
    }
  }
  /* Which those of the slice alone do not, so that the test can fail. */
  csm_config config = default_config();
  config.fit_mode = CSM_FIT_CASCADE;
  const test_camera camera = plain_camera();
  const plan_frame frame = plan_empty(&config, &camera, (double[]){1.0, -0.2, 0.0});
  double near[3], at[3];
  camera_point(&camera, 0.0, 0.0, camera.near, near);
  transform_point(frame.cascades[3].info.world_to_shadow, near, at);
  assert_true(at[0] < 0.0 || at[0] > 1.0 || at[1] < 0.0 || at[1] > 1.0);
}

static void the_least_sphere_is_never_larger_than_the_centroids(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 2000; ++i) {
    const test_camera camera = random_camera(&random, 10.0);
    csm_config config = random_config(&random);
    const plan_frame least = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    config.fit_mode = CSM_FIT_CENTROID_SPHERE;
    const plan_frame centroid = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    for (uint32_t c = 0; c < least.cascade_count; ++c) {
      const double a = least.cascades[c].info.texel_size, b = centroid.cascades[c].info.texel_size;
      assert_true(a <= b * (1.0 + 1e-12));
    }
  }
  /* By how much less an area, of a camera 60 and 40 degrees high */
  for (int field = 0; field < 2; ++field) {
    test_camera camera = plain_camera();
    camera.half_height = tan((field ? 20.0 : 30.0) * M_PI / 180.0);
    camera.half_width = camera.half_height * 16.0 / 9.0;
    csm_config config = default_config();
    const plan_frame least = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    config.fit_mode = CSM_FIT_CENTROID_SPHERE;
    const plan_frame centroid = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    for (uint32_t c = 0; c < 4; ++c) {
      const double ratio = least.cascades[c].info.texel_size / centroid.cascades[c].info.texel_size;
      assert_true(1.0 - ratio * ratio > (field ? 0.1 : 0.04));
    }
  }
}

static void boxes_fit_their_slice(void **state) {
  (void)state;
  random_state random = {4};
  for (int i = 0; i < 1000; ++i) {
    const test_camera camera = random_camera(&random, 10.0);
    csm_config config = random_config(&random);
    config.fit_mode = CSM_FIT_CASCADE;
    config.snap_mode = CSM_SNAP_OFF;
    config.bias_normal_texels = 0.0;
    config.resolution = 4096;
    double light[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const plan_cascade *cascade = &frame.cascades[c];
      double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
      for (int corner = 0; corner < 8; ++corner) {
        double p[3], at[3];
        camera_point(&camera, corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0,
                     corner & 4 ? cascade->info.far_depth : cascade->info.near_depth, p);
        transform_point(cascade->info.world_to_shadow, p, at);
        for (int axis = 0; axis < 2; ++axis) {
          low[axis] = fmin(low[axis], at[axis] * config.resolution);
          high[axis] = fmax(high[axis], at[axis] * config.resolution);
        }
      }
      /* All but the filter's room, half a texel for floats, and what jitter may show: 1/128 to each side at most */
      const double room = plan_filter_radius_texels(&config) + 0.5;
      for (int axis = 0; axis < 2; ++axis) {
        assert_true(low[axis] >= room - 1e-6 && high[axis] <= config.resolution - room + 1e-6);
        assert_true(high[axis] - low[axis] >= (config.resolution - 2.0 * room) / (1.0 + 2.0 / 64.0));
      }
    }
  }
}

static void sizes_do_not_depend_on_the_view(void **state) {
  (void)state;
  random_state random = {5};
  for (int i = 0; i < 400; ++i) {
    test_camera camera = random_camera(&random, 10.0);
    csm_config config = random_full_config(&random);
    config.fit_mode = steady_fits[i % 4];
    double light[3];
    random_unit(&random, light);
    const plan_frame first = plan_empty(&config, &camera, light);
    for (int k = 0; k < 10; ++k) {
      double forward[3];
      random_unit(&random, forward);
      random_unit(&random, light);
      camera_look(&camera, forward, random_between(&random, 0.0, 6.0));
      for (int axis = 0; axis < 3; ++axis)
        camera.eye[axis] = random_between(&random, -1e4, 1e4);
      const plan_frame frame = plan_empty(&config, &camera, light);
      for (uint32_t c = 0; c < frame.cascade_count; ++c) {
        const plan_cascade *now = &frame.cascades[c], *then = &first.cascades[c];
        assert_true(now->texel[0] == then->texel[0] && now->texel[1] == then->texel[1]);
        assert_true(now->texel[0] == now->texel[1]);
        assert_true(now->info.depth_range == then->info.depth_range);
      }
    }
  }
}

/* ---- the grid ---- */

static double off_grid(double value) {
  return fabs(value - round(value));
}

/* How exactly doubles hold a place in the world, in texels. */
static double rounding_texels(double world, double texel) {
  return 1e-6 + 4.0 * (nextafter(world, INFINITY) - world) / texel;
}

/* A camera that turns and moves: a still point moves by whole steps of the grid. */
static void a_still_point_keeps_its_place_on_the_grid(void **state) {
  (void)state;
  random_state random = {6};
  for (uint32_t snap = CSM_SNAP_ROUND; snap <= CSM_SNAP_FLOOR; ++snap)
    for (uint32_t power = 0; power <= 4; ++power)
      for (int fit = 0; fit < 4; ++fit) {
        const double world = fit % 2 ? 1e6 : 0.0, still[3] = {world + 3.0, 1.0, -7.0};
        test_camera camera = plain_camera();
        csm_config config = default_config();
        config.snap_mode = snap;
        config.snap_power = power;
        config.fit_mode = steady_fits[fit];
        camera.eye[0] = world;
        double before[CSM_MAX_CASCADES][2];
        bool moved = false;
        for (int step = 0; step < 100; ++step) {
          camera_look(&camera, (double[]){sin(step * 0.05), 0.0, -cos(step * 0.05)}, 0.0);
          for (int axis = 0; axis < 3; ++axis)
            camera.eye[axis] += random_between(&random, -0.3, 0.3);
          const plan_frame frame = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
          for (uint32_t c = 0; c < frame.cascade_count; ++c) {
            const plan_cascade *cascade = &frame.cascades[c];
            const double grid = (double)(1u << power);
            double at[3];
            transform_point(cascade->info.world_to_shadow, still, at);
            for (int axis = 0; axis < 2; ++axis) {
              const double texels = at[axis] * cascade->resolution;
              if (step)
                assert_near(grid * off_grid((texels - before[c][axis]) / grid), 0.0,
                            rounding_texels(world + 1.0, cascade->info.texel_size));
              moved = moved || (step && fabs(texels - before[c][axis]) > 0.5);
              before[c][axis] = texels;
              assert_true(fmod(cascade->origin_texels[axis], grid) == 0.0);
            }
          }
        }
        assert_true(moved);
      }
}

/* How far the middle of a steady fit lies from its map's middle, in texels along right and up. */
static void off_middle(double out[2], const plan_frame *frame, const plan_frame *unsnapped, uint32_t cascade) {
  for (int axis = 0; axis < 2; ++axis)
    out[axis] = (unsnapped->cascades[cascade].origin_texels[axis] * unsnapped->cascades[cascade].texel[axis]) /
                    frame->cascades[cascade].texel[axis] -
                frame->cascades[cascade].origin_texels[axis];
}

static void rounding_and_flooring_move_a_map_no_farther_than_they_say(void **state) {
  (void)state;
  random_state random = {7};
  double seen[2][2] = {{0.0, 0.0}, {0.0, 0.0}};
  for (int i = 0; i < 3000; ++i) {
    const test_camera camera = random_camera(&random, 100.0);
    csm_config config = default_config();
    config.shadow_distance = 100.0 + fmax(camera.near, 0.0);
    config.snap_mode = (uint32_t)i % 2;
    config.snap_power = random_below(&random, 5);
    const plan_frame frame = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    const uint32_t c = random_below(&random, 4), axis = random_below(&random, 2);
    const plan_cascade *cascade = &frame.cascades[c];
    csm_config off = config;
    off.snap_mode = CSM_SNAP_OFF;
    off.snap_power = 0;
    const plan_frame unsnapped = plan_empty(&off, &camera, (double[]){0.3, -1.0, 0.2});
    double away[2];
    const plan_cascade *free = &unsnapped.cascades[c];
    const double grid = (double)(1u << config.snap_power);
    off_middle(away, &frame, &unsnapped, c);
    /* Without snapping texels are larger or smaller by the grid's room, and half a map of them lies before the middle
     */
    away[axis] += free->resolution / 2.0 * (free->texel[axis] / cascade->texel[axis] - 1.0);
    const double rounding = 1e-6 * grid + 1e-9 * fabs(cascade->origin_texels[axis]) * 1e-3;
    if (config.snap_mode == CSM_SNAP_FLOOR)
      assert_true(away[axis] >= -rounding && away[axis] <= grid + rounding);
    else
      assert_true(fabs(away[axis]) <= grid / 2.0 + rounding);
    seen[i % 2][0] = fmin(seen[i % 2][0], away[axis] / grid);
    seen[i % 2][1] = fmax(seen[i % 2][1], away[axis] / grid);
  }
  assert_true(seen[CSM_SNAP_ROUND][0] < -0.45 && seen[CSM_SNAP_ROUND][1] > 0.45);
  assert_true(seen[CSM_SNAP_FLOOR][1] > 0.95);
}

static void without_snapping_a_map_follows_the_camera(void **state) {
  (void)state;
  csm_config config = default_config();
  config.snap_mode = CSM_SNAP_OFF;
  test_camera camera = plain_camera();
  const plan_frame first = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
  const double moved[3] = {0.0123, -0.0045, 0.0067};
  for (int axis = 0; axis < 3; ++axis)
    camera.eye[axis] += moved[axis];
  const plan_frame second = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
  for (uint32_t c = 0; c < 4; ++c) {
    double a[3], b[3];
    transform_point(first.cascades[c].info.world_to_shadow, (double[3]){0}, a);
    transform_point(second.cascades[c].info.world_to_shadow, moved, b);
    for (int axis = 0; axis < 2; ++axis)
      assert_near(a[axis], b[axis], 1e-12);
    assert_true(off_grid(first.cascades[c].origin_texels[0]) > 1e-6);
  }
}

/* ---- texels that are no squares ---- */

static void sides_of_texels_agree_wherever_they_are_told(void **state) {
  (void)state;
  random_state random = {8};
  uint32_t uneven = 0;
  for (int i = 0; i < 2000; ++i) {
    const test_camera camera = random_camera(&random, 100.0);
    csm_config config = random_full_config(&random);
    config.fit_mode = i % 2 ? CSM_FIT_CASCADE : CSM_FIT_SCENE;
    double light[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    csm_constants constants;
    (void)plan_write_constants((float *)&constants, &frame, &config);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const plan_cascade *cascade = &frame.cascades[c];
      const csm_cascade_info *info = &cascade->info;
      const float *texel = constants.cascades.texels[c];
      for (int axis = 0; axis < 2; ++axis) {
        const double *m = info->world_to_shadow, side = cascade->texel[axis] * cascade->resolution;
        const double length = sqrt(m[axis] * m[axis] + m[4 + axis] * m[4 + axis] + m[8 + axis] * m[8 + axis]);
        assert_near(length * side, 1.0, 1e-12);
        assert_near(cascade->to_clip[axis * 5] * side, 2.0, 1e-12);
      }
      assert_true(info->texel_size == fmax(cascade->texel[0], cascade->texel[1]));
      assert_true(texel[0] == (float)info->texel_size);
      assert_true(texel[3] == (float)(cascade->texel[0] * cascade->texel[1]));
      assert_true(constants.cascades.rects[c][2] == (float)cascade->resolution);
      uneven += fabs(cascade->texel[0] / cascade->texel[1] - 1.0) > 0.1;
    }
  }
  assert_true(uneven > 1000);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(hold_every_receiver_with_its_filter),
      cmocka_unit_test(scene_fits_begin_at_the_camera),
      cmocka_unit_test(the_least_sphere_is_never_larger_than_the_centroids),
      cmocka_unit_test(boxes_fit_their_slice),
      cmocka_unit_test(sizes_do_not_depend_on_the_view),
      cmocka_unit_test(a_still_point_keeps_its_place_on_the_grid),
      cmocka_unit_test(rounding_and_flooring_move_a_map_no_farther_than_they_say),
      cmocka_unit_test(without_snapping_a_map_follows_the_camera),
      cmocka_unit_test(sides_of_texels_agree_wherever_they_are_told),
  };
  return cmocka_run_group_tests_name("plan-fits", tests, NULL, NULL);
}
