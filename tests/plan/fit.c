/* Where maps lie: around every receiver of their slice, on a grid that nothing but projection and configuration moves.
 */
#include "support.h"

#include <math.h>

enum { receivers = 16 };

/* Texels that the filter and the normal offset reach from a sample, in shadow space. */
static double reach_texels(const csm_config *config) {
  return (config->filter == CSM_FILTER_PCF_3X3 ? 2.0 : 1.0) + config->bias_normal_texels;
}

static void holds_every_receiver_with_its_filter(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 4000; ++i) {
    const test_camera camera = random_camera(&random, i % 3 ? 100.0 : 1e6);
    const csm_config config = random_config(&random);
    double light[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const csm_cascade_info *info = &frame.cascades[c].info;
      const double border = reach_texels(&config) / config.resolution;
      for (int k = 0; k < receivers; ++k) {
        double receiver[3], at[3];
        slice_point(&random, &camera, info, receiver);
        transform_point(info->world_to_shadow, receiver, at);
        const bool inside = at[0] >= border && at[0] <= 1.0 - border && at[1] >= border && at[1] <= 1.0 - border &&
                            at[2] >= 0.0 && at[2] <= 1.0;
        if (!inside)
          fail_msg("camera %d, cascade %u: %.12g %.12g %.12g, border %g", i, c, at[0], at[1], at[2], border);
      }
    }
  }
}

/* A view that is not quite rigid, as engines' floats may leave it, and as far as the plan takes it. */
static void holds_every_receiver_of_a_sloppy_view(void **state) {
  (void)state;
  random_state random = {9};
  const test_camera camera = plain_camera(); /* whose view space is the world */
  csm_config config = default_config();
  config.resolution = 16384;
  uint32_t planned = 0;
  for (int i = 0; i < 4000; ++i) {
    double view[16], projection[16], inverse[16], light[3];
    camera_matrices(&camera, view, projection);
    for (int k = 0; k < 9; ++k)
      view[k / 3 * 4 + k % 3] += random_between(&random, -3e-4, 3e-4);
    random_unit(&random, light);
    plan_frame frame;
    const char *error = "";
    if (plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light}, &(plan_scene){0},
                  NULL, &error))
      continue;
    assert_true(plan_invert(inverse, view));
    ++planned;
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const csm_cascade_info *info = &frame.cascades[c].info;
      double seen[3], receiver[3], at[3];
      slice_point(&random, &camera, info, seen);
      transform_point(inverse, seen, receiver);
      transform_point(info->world_to_shadow, receiver, at);
      for (int axis = 0; axis < 3; ++axis)
        assert_true(at[axis] >= (axis < 2 ? 2.0 / 16384.0 : 0.0) && at[axis] <= 1.0 - (axis < 2 ? 2.0 / 16384.0 : 0.0));
    }
  }
  assert_true(planned > 1000);
}

/* A slice's least sphere: around the far face's circle, or through both faces' corners. */
static double symmetric_radius(const test_camera *camera, double near, double far) {
  const double square = camera->half_width * camera->half_width + camera->half_height * camera->half_height;
  const double center = fmin((near + far) / 2.0 * (1.0 + square), far);
  return sqrt((far - center) * (far - center) + far * far * square);
}

static void wastes_less_than_one_percent(void **state) {
  (void)state;
  random_state random = {2};
  for (int i = 0; i < 3000; ++i) {
    test_camera camera = plain_camera();
    camera.half_height = tan(random_scale(&random, 0.25, 80.0) * M_PI / 180.0);
    camera.half_width = camera.half_height * random_scale(&random, 0.3, 3.0);
    camera.near = random_scale(&random, 1e-3, 10.0);
    const csm_config config = default_config();
    const plan_frame frame = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const csm_cascade_info *info = &frame.cascades[c].info;
      const double radius = symmetric_radius(&camera, info->near_depth, info->far_depth);
      const double least = 2.0 * radius / (config.resolution - 6.0);
      assert_true(info->texel_size >= least);
      assert_near(info->texel_size, least, 0.01 * least);
    }
  }
}

/* Walks towards the farthest of eight points in ever smaller steps (Badoiu and Clarkson, 2003); from above. */
static double walked_radius(const double points[8][3]) {
  double center[3] = {0};
  double least = INFINITY;
  for (int step = 0; step < 20000; ++step) {
    int farthest = 0;
    double square = -1.0;
    for (int i = 0; i < 8; ++i) {
      double sum = 0.0;
      for (int k = 0; k < 3; ++k)
        sum += (points[i][k] - center[k]) * (points[i][k] - center[k]);
      if (sum > square) {
        square = sum;
        farthest = i;
      }
    }
    least = fmin(least, sqrt(square));
    for (int k = 0; k < 3; ++k)
      center[k] += (points[farthest][k] - center[k]) / (step + 2.0);
  }
  return least;
}

/* Off-centre slices too have the least sphere, around what jitter may show of them: half of 1/64 to each side. */
static void has_the_least_sphere_off_centre(void **state) {
  (void)state;
  random_state random = {8};
  for (int i = 0; i < 150; ++i) {
    test_camera camera = random_camera(&random, 0.0);
    for (int k = 0; k < 2; ++k)
      camera.center[k] = round(random_between(&random, -128.0, 128.0)) / 64.0;
    csm_config config = default_config();
    config.cascade_count = 2;
    const plan_frame frame = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    const csm_cascade_info *info = &frame.cascades[i % 2].info;
    double corners[8][3];
    for (int k = 0; k < 8; ++k)
      camera_point(&camera, k & 1 ? 1.0 + 1.0 / 128.0 : -1.0 - 1.0 / 128.0,
                   k & 2 ? 1.0 + 1.0 / 128.0 : -1.0 - 1.0 / 128.0, k & 4 ? info->far_depth : info->near_depth,
                   corners[k]);
    const double radius = info->texel_size * (config.resolution - 6.0) / 2.0 / 1.0005;
    const double walked = walked_radius(corners);
    assert_true(radius <= walked * (1.0 + 1e-6));
    assert_true(radius >= walked * (1.0 - 1e-4));
  }
}

static void texel_size_does_not_depend_on_the_view(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 300; ++i) {
    test_camera camera = random_camera(&random, 10.0);
    const csm_config config = random_config(&random);
    double light[3];
    random_unit(&random, light);
    const plan_frame first = plan_empty(&config, &camera, light);
    for (int k = 0; k < 20; ++k) {
      double forward[3];
      random_unit(&random, forward);
      random_unit(&random, light);
      camera_look(&camera, forward, random_between(&random, 0.0, 6.0));
      for (int axis = 0; axis < 3; ++axis)
        camera.eye[axis] = random_between(&random, -1e6, 1e6);
      const plan_frame frame = plan_empty(&config, &camera, light);
      for (uint32_t c = 0; c < frame.cascade_count; ++c) {
        assert_true(frame.cascades[c].info.texel_size == first.cascades[c].info.texel_size);
        assert_true(frame.cascades[c].info.depth_range == first.cascades[c].info.depth_range);
      }
    }
  }
}

/* Half a pixel, in images of 128 pixels and more. */
static void texel_size_does_not_depend_on_jitter(void **state) {
  (void)state;
  random_state random = {4};
  for (int i = 0; i < 500; ++i) {
    test_camera camera = random_camera(&random, 10.0);
    const double base[2] = {round(random_between(&random, -32.0, 32.0)) / 32.0, 0.0};
    const csm_config config = random_config(&random);
    camera.center[0] = base[0];
    camera.center[1] = base[1];
    const plan_frame first = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
    for (int k = 0; k < 20; ++k) {
      for (int axis = 0; axis < 2; ++axis)
        camera.center[axis] = base[axis] + random_between(&random, -1.0, 1.0) / 129.0;
      const plan_frame frame = plan_empty(&config, &camera, (double[]){0.3, -1.0, 0.2});
      for (uint32_t c = 0; c < frame.cascade_count; ++c)
        assert_true(frame.cascades[c].info.texel_size == first.cascades[c].info.texel_size);
    }
  }
}

/* Distance of a value from the nearest whole number. */
static double off_grid(double value) {
  return fabs(value - round(value));
}

/* How exactly doubles hold a place in the world, in texels. */
static double rounding_texels(double world, double texel) {
  return 1e-6 + 4.0 * (nextafter(world, INFINITY) - world) / texel;
}

static void texels_are_whole_from_the_worlds_origin(void **state) {
  (void)state;
  random_state random = {5};
  for (int i = 0; i < 2000; ++i) {
    const double world = i % 2 ? random_scale(&random, 1.0, 1e7) : 0.0;
    const test_camera camera = random_camera(&random, world);
    const csm_config config = random_config(&random);
    double light[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const csm_cascade_info *info = &frame.cascades[c].info;
      double at[3];
      transform_point(info->world_to_shadow, (double[3]){0}, at);
      for (int axis = 0; axis < 2; ++axis) {
        const double texels = at[axis] * config.resolution;
        assert_near(off_grid(texels), 0.0, 1e-6 + 4e-16 * fabs(texels));
      }
    }
  }
}

/* A camera that turns and moves in small steps: texels' borders stay where they are in the world, and so does depth. */
static void nothing_swims_while_the_camera_moves(void **state) {
  (void)state;
  random_state random = {6};
  const double worlds[] = {0.0, 1e3, 1e5, 1e7};
  for (int w = 0; w < 4; ++w) {
    test_camera camera = plain_camera();
    const csm_config config = default_config();
    const double light[3] = {0.3, -1.0, 0.2}, still[3] = {worlds[w] + 3.0, 1.0, -worlds[w] - 7.0};
    camera.eye[0] = worlds[w];
    camera.eye[2] = -worlds[w];
    double texels[CSM_MAX_CASCADES][2], depths[CSM_MAX_CASCADES];
    uint32_t depth_changes = 0;
    for (int step = 0; step < 3600; ++step) {
      const double angle = step * 0.1 * M_PI / 180.0;
      camera_look(&camera, (double[]){sin(angle), 0.0, -cos(angle)}, 0.0);
      for (int axis = 0; axis < 3; ++axis)
        camera.eye[axis] += random_between(&random, -1e-3, 1e-3);
      const plan_frame frame = plan_empty(&config, &camera, light);
      for (uint32_t c = 0; c < frame.cascade_count; ++c) {
        const csm_cascade_info *info = &frame.cascades[c].info;
        double at[3];
        transform_point(info->world_to_shadow, still, at);
        const double allowed = rounding_texels(worlds[w] + 1.0, info->texel_size);
        for (int axis = 0; axis < 2 && step; ++axis)
          assert_near(off_grid(at[axis] * config.resolution - texels[c][axis]), 0.0, allowed);
        depth_changes += step && fabs(at[2] - depths[c]) * info->depth_range > allowed * info->texel_size;
        texels[c][0] = at[0] * config.resolution;
        texels[c][1] = at[1] * config.resolution;
        depths[c] = at[2];
      }
    }
    /* Turning once moves a slice's centre along the light by less than a diameter there and back: each way it passes
       at most 9 steps, in each of 4 cascades; jitter across a step may repeat a few. */
    assert_in_range(depth_changes, 0, 4 * 2 * 9 + 20);
  }
}

/* Moves everything by whole texels of one cascade, and by whole depth ranges, which are whole depth steps. */
static void moving_the_world_by_whole_texels_changes_nothing(void **state) {
  (void)state;
  random_state random = {7};
  for (int i = 0; i < 4000; ++i) {
    test_camera camera = random_camera(&random, 50.0), moved = camera;
    csm_config config = random_config(&random);
    config.caster_distance = 0.0;
    double light[3];
    random_unit(&random, light);
    const double world = random_scale(&random, 1e3, 1e7);
    const plan_frame frame = plan_empty(&config, &camera, light);
    const uint32_t c = random_below(&random, frame.cascade_count);
    const csm_cascade_info *info = &frame.cascades[c].info;
    const double units[3] = {info->texel_size, info->texel_size, info->depth_range};
    double way[3], offset[3] = {0};
    random_unit(&random, way);
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 3; ++k)
        offset[k] += round(way[axis] * world / units[axis]) * units[axis] * frame.basis[axis * 3 + k];
    for (int k = 0; k < 3; ++k)
      moved.eye[k] += offset[k];
    const plan_frame after = plan_empty(&config, &moved, light);
    double receiver[3], at[3], moved_at[3];
    slice_point(&random, &camera, info, receiver);
    transform_point(info->world_to_shadow, receiver, at);
    for (int k = 0; k < 3; ++k)
      receiver[k] += offset[k];
    transform_point(after.cascades[c].info.world_to_shadow, receiver, moved_at);
    const double allowed = rounding_texels(2.0 * world, info->texel_size);
    for (int axis = 0; axis < 2; ++axis)
      assert_near(moved_at[axis] * config.resolution, at[axis] * config.resolution, allowed);
    assert_near(moved_at[2] * info->depth_range / info->texel_size, at[2] * info->depth_range / info->texel_size,
                allowed);
  }
}

static void depth_reaches_casters_as_far_as_configured(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  double view[16], projection[16], light[3] = {0.0, -1.0, 0.0};
  camera_matrices(&camera, view, projection);
  test_scene scene = scene_make(1, 1);
  for (int i = 0; i < 3; ++i)
    scene.instances[0].transform[i * 5] = scene.meshes[0].extent[i] = 1.0;
  csm_config config = default_config();
  const plan_frame without = plan_empty(&config, &camera, light);
  double last_range = 0.0;
  for (double height = 1.0; height < 1e6; height *= 1.3) {
    const double at[3] = {0.0, height, -60.0};
    for (int i = 0; i < 3; ++i)
      scene.instances[0].transform[i * 4 + 3] = at[i];
    plan_frame frame;
    const char *error = "";
    assert_int_equal(plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light},
                               &scene.scene, scene.memory, &error),
                     CSM_SUCCESS);
    const plan_cascade *cascade = &frame.cascades[3];
    assert_int_equal(frame.windows[3].list.instance_count, 1); /* however near to the light */
    double top[3];
    transform_point(cascade->info.world_to_shadow, (double[]){0.0, height + 1.0, -60.0}, top);
    const double radius = without.cascades[3].info.depth_range / 2.25;
    if (height + radius < config.caster_distance)
      assert_true(top[2] >= 0.0 && top[2] <= 1.0);
    assert_true(cascade->info.depth_range >= last_range);
    assert_true(cascade->info.depth_range < 2.75 * radius + config.caster_distance);
    last_range = cascade->info.depth_range;
    assert_true(frame.cascades[0].info.depth_range == without.cascades[0].info.depth_range); /* not in its column */
  }
  assert_true(last_range > config.caster_distance);
  scene_free(&scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(holds_every_receiver_with_its_filter),
      cmocka_unit_test(holds_every_receiver_of_a_sloppy_view),
      cmocka_unit_test(wastes_less_than_one_percent),
      cmocka_unit_test(has_the_least_sphere_off_centre),
      cmocka_unit_test(texel_size_does_not_depend_on_the_view),
      cmocka_unit_test(texel_size_does_not_depend_on_jitter),
      cmocka_unit_test(texels_are_whole_from_the_worlds_origin),
      cmocka_unit_test(nothing_swims_while_the_camera_moves),
      cmocka_unit_test(moving_the_world_by_whole_texels_changes_nothing),
      cmocka_unit_test(depth_reaches_casters_as_far_as_configured),
  };
  return cmocka_run_group_tests_name("plan-fit", tests, NULL, NULL);
}
