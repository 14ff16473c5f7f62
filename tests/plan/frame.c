/* What a frame is told besides a camera and a light: which instances take part, where constants begin, far vertices. */
#include "support.h"

#include "csm_constants.h"
#include <fenv.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { instances = 120, meshes = 5 };

static const double sun[3] = {0.3, -1.0, 0.2};

static plan_frame_info info_of(const csm_config *config, const double matrices[2][16], const plan_scene *scene) {
  return (plan_frame_info){
      .config = config, .view = matrices[0], .projection = matrices[1], .light = sun, .scene = scene};
}

/* ---- flags and layers ---- */

static bool casts(const plan_instance *instance, uint32_t layers) {
  const bool hidden = instance->flags & (PLAN_HIDDEN | PLAN_RECEIVES_ONLY | PLAN_FREE);
  return !hidden && (!layers || !instance->layers || (instance->layers & layers));
}

static bool receives(const plan_instance *instance) {
  return !(instance->flags & (PLAN_HIDDEN | PLAN_CASTS_ONLY | PLAN_FREE));
}

/* A scene of those that take part alone; `slots` says where each one comes from. */
static test_scene those_that(const test_scene *all, bool casters, uint32_t layers, uint32_t slots[instances]) {
  test_scene some = scene_make(instances, meshes);
  uint32_t count = 0;
  memcpy(some.meshes, all->meshes, meshes * sizeof *some.meshes);
  for (uint32_t i = 0; i < instances; ++i)
    if (casters ? casts(&all->instances[i], layers) : receives(&all->instances[i])) {
      some.instances[count] = all->instances[i];
      some.instances[count].flags = some.instances[count].layers = 0;
      some.boxes[count] = all->boxes[i];
      slots[count++] = i;
    }
  some.scene.slot_count = some.scene.caster_count = some.scene.receiver_count = count;
  return some;
}

static void assert_same_list(const plan_list *list, const plan_list *expected, const uint32_t slots[instances]) {
  assert_int_equal(list->instance_count, expected->instance_count);
  assert_int_equal(list->draw_count, expected->draw_count);
  for (uint32_t i = 0; i < list->instance_count; ++i)
    assert_int_equal(list->instances[i], slots[expected->instances[i]]);
}

static void scatter(test_scene *scene, random_state *random) {
  scene_scatter(scene, random, (double[]){0, 0, -30}, 60.0);
  scene->scene.caster_count = scene->scene.receiver_count = 0;
  for (uint32_t i = 0; i < instances; ++i) {
    scene->instances[i].flags = random_below(random, 3) ? 0 : random_below(random, PLAN_FREE * 2);
    scene->instances[i].layers = random_below(random, 2) ? 0 : random_below(random, 8);
    scene->scene.caster_count += casts(&scene->instances[i], 0);
    scene->scene.receiver_count += receives(&scene->instances[i]);
  }
}

/* Plans with the rest in the scene, and without it, are the same, but for what is counted. */
static void only_those_that_cast_for_the_light_are_drawn(void **state) {
  (void)state;
  random_state random = {1};
  const test_camera camera = plain_camera();
  const csm_config config = default_config();
  double matrices[2][16];
  camera_matrices(&camera, matrices[0], matrices[1]);
  uint32_t drawn = 0, left_out = 0;
  for (uint32_t i = 0; i < 160; ++i) {
    test_scene all = scene_make(instances, meshes);
    uint32_t slots[instances];
    const uint32_t layers = i % 8;
    scatter(&all, &random);
    test_scene some = those_that(&all, true, layers, slots);
    plan_frame_info info = info_of(&config, (const double(*)[16])matrices, &all.scene);
    info.light_layers = layers;
    plan_frame frame, expected;
    const char *error = "";
    assert_int_equal(plan_traced(&frame, &info, all.memory, &error), CSM_SUCCESS);
    info.scene = &some.scene;
    assert_int_equal(plan_traced(&expected, &info, some.memory, &error), CSM_SUCCESS);
    for (uint32_t c = 0; c < config.cascade_count; ++c) {
      const plan_list *list = &frame.windows[c].list;
      assert_same_list(list, &expected.windows[c].list, slots);
      assert_memory_equal(&frame.cascades[c].info, &expected.cascades[c].info, sizeof frame.cascades[c].info);
      assert_int_equal(list->culled, all.scene.caster_count - list->instance_count);
      drawn += list->instance_count;
      left_out += list->culled;
    }
    scene_free(&all);
    scene_free(&some);
  }
  assert_true(drawn > 1000 && left_out > 1000);
}

static void only_those_that_receive_are_seen(void **state) {
  (void)state;
  random_state random = {2};
  const test_camera camera = plain_camera();
  double matrices[2][16];
  plan_camera made;
  const char *error = "";
  camera_matrices(&camera, matrices[0], matrices[1]);
  assert_int_equal(plan_camera_make(&made, matrices[0], matrices[1], CSM_REVERSED_BY_MATRIX, &error), CSM_SUCCESS);
  uint32_t seen = 0;
  for (int i = 0; i < 100; ++i) {
    test_scene all = scene_make(instances, meshes);
    uint32_t slots[instances];
    scatter(&all, &random);
    test_scene some = those_that(&all, false, 0, slots);
    plan_list list, expected;
    plan_view_make(&list, &made, &all.scene, NULL, all.memory);
    plan_view_make(&expected, &made, &some.scene, NULL, some.memory);
    assert_same_list(&list, &expected, slots);
    assert_int_equal(list.culled, all.scene.receiver_count - list.instance_count);
    seen += list.instance_count;
    scene_free(&all);
    scene_free(&some);
  }
  assert_true(seen > 1000);
}

/* ---- the origin ---- */

static void the_origin_is_the_cameras_place_or_what_is_given(void **state) {
  (void)state;
  test_camera camera = plain_camera();
  for (int i = 0; i < 3; ++i)
    camera.eye[i] = (double[]){1000.0, 2.0, -500.0}[i];
  csm_config config = default_config();
  const plan_scene nothing = {0};
  double matrices[2][16];
  float without[CSM_C_COUNT * 4], with[CSM_C_COUNT * 4];
  plan_frame frame;
  const char *error = "";
  camera_matrices(&camera, matrices[0], matrices[1]);
  plan_frame_info info = info_of(&config, (const double(*)[16])matrices, &nothing);
  assert_int_equal(plan_traced(&frame, &info, NULL, &error), CSM_SUCCESS);
  assert_memory_equal(frame.origin, frame.camera.position, sizeof frame.origin);
  const uint32_t size = plan_write_constants(without, &frame, &config);
  info.origin = frame.camera.position;
  assert_int_equal(plan_traced(&frame, &info, NULL, &error), CSM_SUCCESS);
  plan_write_constants(with, &frame, &config);
  assert_memory_equal(with, without, size);
  info.origin = (double[]){1024.0, 0.0, -512.0};
  assert_int_equal(plan_traced(&frame, &info, NULL, &error), CSM_SUCCESS);
  assert_memory_equal(frame.origin, info.origin, sizeof frame.origin);
  plan_write_constants(with, &frame, &config);
  assert_memory_not_equal(with, without, size);
}

/* The view depth of a place relative to the origin, which the constants give, is the camera's. */
static void view_depths_follow_the_origin(void **state) {
  (void)state;
  random_state random = {3};
  const plan_scene nothing = {0};
  for (int i = 0; i < 300; ++i) {
    const test_camera camera = random_camera(&random, 500.0);
    csm_config config = default_config();
    config.shadow_distance = 1e6;
    double matrices[2][16], origin[3], p[3], depth = 0.0;
    float constants[CSM_C_COUNT * 4];
    plan_frame frame;
    const char *error = "";
    camera_matrices(&camera, matrices[0], matrices[1]);
    for (int k = 0; k < 3; ++k) {
      origin[k] = camera.eye[k] + random_between(&random, -100.0, 100.0);
      p[k] = camera.eye[k] + random_between(&random, -100.0, 100.0);
      depth += camera.forward[k] * (p[k] - camera.eye[k]);
    }
    plan_frame_info info = info_of(&config, (const double(*)[16])matrices, &nothing);
    info.reversed = camera_reversed(&camera);
    info.origin = origin;
    if (plan_traced(&frame, &info, NULL, &error))
      fail_msg("%s", error);
    plan_write_constants(constants, &frame, &config);
    const float *row = &constants[CSM_C_DEPTH * 4];
    assert_near(row[0] * (p[0] - origin[0]) + row[1] * (p[1] - origin[1]) + row[2] * (p[2] - origin[2]) + row[3], depth,
                1e-4);
  }
}

static void names_an_origin_that_is_none(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  const csm_config config = default_config();
  const plan_scene nothing = {0};
  double matrices[2][16];
  camera_matrices(&camera, matrices[0], matrices[1]);
  const double origins[3][3] = {{0.0, NAN, 0.0}, {INFINITY, 0.0, 0.0}, {0.0, 0.0, -2e30}};
  for (int i = 0; i < 3; ++i) {
    plan_frame frame;
    const char *error = "";
    plan_frame_info info = info_of(&config, (const double(*)[16])matrices, &nothing);
    info.origin = origins[i];
    assert_int_equal(plan_traced(&frame, &info, NULL, &error), i < 2 ? CSM_ERROR_NOT_FINITE : CSM_ERROR_INVALID_VALUE);
    assert_non_null(strstr(error, "origin"));
  }
}

/* ---- vertices far from their mesh's origin ---- */

static void differences_from_the_offset_are_exact(void **state) {
  (void)state;
  random_state random = {4};
  uint32_t moved = 0;
  for (int i = 0; i < 20000; ++i) {
    float low[3], high[3];
    plan_bounds bounds;
    for (int k = 0; k < 3; ++k) {
      const double middle = random_scale(&random, 1e-3, 1e7) * (random_below(&random, 2) ? 1.0 : -1.0);
      const double half = fabs(middle) * random_scale(&random, 1e-9, 1e2);
      low[k] = (float)(middle - half);
      high[k] = (float)(middle + half);
    }
    plan_bounds_make(&bounds, low, high);
    for (int k = 0; k < 3; ++k)
      for (int n = 0; n < 8; ++n) {
        const float at = n == 0   ? low[k]
                         : n == 1 ? high[k]
                                  : (float)random_between(&random, (double)low[k], (double)high[k]);
        const float offset = (float)bounds.offset[k], stored = at - offset;
        assert_true((double)offset == bounds.offset[k]);
        assert_true((double)stored == (double)at - (double)offset);
        moved += offset != 0.0f;
      }
    plan_bounds_in_place(&bounds, low, high);
    assert_true(bounds.offset[0] == 0.0 && bounds.offset[1] == 0.0 && bounds.offset[2] == 0.0);
  }
  assert_true(moved > 10000);
}

/* A square whose vertices lie far away, and that its instance brings back, is drawn as the same square at its origin.
 */
static void far_vertices_are_drawn_as_near_ones(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  const csm_config config = default_config();
  double matrices[2][16];
  camera_matrices(&camera, matrices[0], matrices[1]);
  const float far[] = {0.0f, 1e3f, 1.5e5f, 2e5f, 8e5f};
  float expected[2][16];
  for (int i = 0; i < 5; ++i) {
    const float x = far[i];
    test_scene scene = scene_make(1, 1);
    plan_bounds_make(&scene.meshes[0], (float[]){x - 2, 0, -2}, (float[]){x + 2, 0, 2});
    for (int k = 0; k < 3; ++k)
      scene.instances[0].transform[k * 5] = 1.0;
    scene.instances[0].transform[3] = -(double)x;
    scene.instances[0].transform[11] = -10.0;
    scene_place(&scene);
    plan_frame frame;
    plan_list list;
    float cascade[12], view[16];
    const char *error = "";
    const plan_frame_info info = info_of(&config, (const double(*)[16])matrices, &scene.scene);
    assert_int_equal(plan_traced(&frame, &info, scene.memory, &error), CSM_SUCCESS);
    plan_write_window_matrices(cascade, &frame, 1, &scene.scene);
    assert_int_equal(frame.windows[1].list.instance_count, 1);
    plan_view_make(&list, &frame.camera, &scene.scene, NULL, scene.memory);
    assert_int_equal(list.instance_count, 1);
    plan_write_view_matrices(view, &list, &frame.camera, &scene.scene);
    if (i) {
      assert_memory_equal(cascade, expected[0], sizeof cascade);
      assert_memory_equal(view, expected[1], sizeof view);
    }
    memcpy(expected[0], cascade, sizeof cascade);
    memcpy(expected[1], view, sizeof view);
    scene_free(&scene);
  }
}

/* ---- large numbers ---- */

/* Whatever lies in the scene, its depth is a range that a float holds, and so is its inverse. */
static void a_scene_of_any_size_has_a_range(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  double matrices[2][16];
  camera_matrices(&camera, matrices[0], matrices[1]);
  for (uint32_t mode = 0; mode <= CSM_DEPTH_SCENE_CLIPPED; ++mode)
    for (double away = 1e9; away <= 1e30; away *= 1e3) {
      csm_config config = default_config();
      config.depth_mode = mode;
      test_scene scene = scene_make(2, 1);
      plan_bounds_make(&scene.meshes[0], (float[]){-3e38f, 0, -3e38f}, (float[]){3e38f, 3e38f, 3e38f});
      for (int k = 0; k < 3; ++k) {
        scene.instances[0].transform[k * 5] = scene.instances[1].transform[k * 5] = k % 2 ? 1.0 : away / 1e9;
        scene.instances[0].transform[k * 4 + 3] = away;
        scene.instances[1].transform[k * 4 + 3] = -away;
      }
      scene_place(&scene);
      plan_frame frame;
      const char *error = "";
      const plan_frame_info info = info_of(&config, (const double(*)[16])matrices, &scene.scene);
      assert_int_equal(plan_traced(&frame, &info, scene.memory, &error), CSM_SUCCESS);
      for (uint32_t c = 0; c < config.cascade_count; ++c) {
        const double range = frame.cascades[c].info.depth_range;
        assert_true(isfinite((float)range) && isnormal((float)(1.0 / range)));
        float rows[24];
        plan_write_window_matrices(rows, &frame, c, &scene.scene);
        for (uint32_t k = 0; k < frame.windows[c].list.instance_count * 12; ++k)
          assert_true(isfinite(rows[k]));
      }
      scene_free(&scene);
    }
}

/* ---- history ---- */

/* Another configuration keeps how the maps are turned about the light, as `light_roll` carried has it. */
static void a_new_configuration_keeps_the_roll(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  csm_config config = default_config();
  const plan_scene nothing = {0};
  double matrices[2][16];
  camera_matrices(&camera, matrices[0], matrices[1]);
  config.light_roll = CSM_LIGHT_ROLL_CARRIED;
  plan_history history = {0};
  plan_frame frame;
  const char *error = "";
  for (int i = 0; i <= 60; ++i) { /* a way around the sky that comes back turned */
    const double angle = i / 60.0 * 2.0 * M_PI;
    plan_frame_info info = info_of(&config, (const double(*)[16])matrices, &nothing);
    info.light = (double[]){cos(angle), -1.0, sin(angle)};
    info.before = &history;
    assert_int_equal(plan_traced(&frame, &info, NULL, &error), CSM_SUCCESS);
    history = frame.history;
  }
  history.has_samples = history.has_bounds[1] = true;
  plan_history_reconfigure(&history);
  assert_false(history.has_samples || history.has_bounds[1]);
  plan_frame_info info = info_of(&config, (const double(*)[16])matrices, &nothing);
  info.light = (double[]){1.0, -1.0, 0.0};
  info.before = &history;
  plan_frame after, fresh;
  assert_int_equal(plan_traced(&after, &info, NULL, &error), CSM_SUCCESS);
  info.before = NULL;
  assert_int_equal(plan_traced(&fresh, &info, NULL, &error), CSM_SUCCESS);
  for (int k = 0; k < 9; ++k)
    assert_near(after.basis[k], frame.basis[k], 1e-12);
  assert_true(fabs(fresh.basis[0] - after.basis[0]) > 0.1);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(only_those_that_cast_for_the_light_are_drawn),
      cmocka_unit_test(only_those_that_receive_are_seen),
      cmocka_unit_test(the_origin_is_the_cameras_place_or_what_is_given),
      cmocka_unit_test(view_depths_follow_the_origin),
      cmocka_unit_test(names_an_origin_that_is_none),
      cmocka_unit_test(differences_from_the_offset_are_exact),
      cmocka_unit_test(far_vertices_are_drawn_as_near_ones),
      cmocka_unit_test(a_scene_of_any_size_has_a_range),
      cmocka_unit_test(a_new_configuration_keeps_the_roll),
  };
  return cmocka_run_group_tests_name("plan-frame", tests, NULL, NULL);
}
