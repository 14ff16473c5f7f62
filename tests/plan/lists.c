/*
 * Instances whose transform turns faces around: drawn apart by a cascade, which may leave faces out, whatever
 * face_culling is; a watertight mesh's are left out without it.
 */
#include "support.h"

#include <math.h>
#include <string.h>

enum { instances = 150, meshes = 6 };

static void mirrors_are_told_by_the_determinant_at_any_scale(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 20000; ++i) {
    plan_instance instance = {0};
    double *t = instance.transform;
    for (int k = 0; k < 12; ++k)
      t[k] = k % 4 == 3 ? 0.0 : random_between(&random, -1.0, 1.0);
    const double determinant =
        t[0] * (t[5] * t[10] - t[6] * t[9]) - t[4] * (t[1] * t[10] - t[2] * t[9]) + t[8] * (t[1] * t[6] - t[2] * t[5]);
    if (fabs(determinant) < 1e-9)
      continue;
    for (int column = 0; column < 3; ++column) {
      const double scale = random_scale(&random, 1e-50, 1e29);
      for (int row = 0; row < 3; ++row)
        t[row * 4 + column] *= scale;
    }
    assert_int_equal(plan_instance_check(&instance), CSM_SUCCESS);
    assert_true(instance.mirrored == (determinant < 0.0) && instance.flags == 0);
    for (int row = 0; row < 3; ++row)
      t[row * 4] = -t[row * 4];
    assert_int_equal(plan_instance_check(&instance), CSM_SUCCESS);
    assert_true(instance.mirrored == (determinant > 0.0) && instance.flags == 0);
  }
}

static void check_draws(const plan_list *list, const plan_scene *scene, bool sides) {
  uint32_t next = 0, last_key = 0;
  for (uint32_t d = 0; d < list->draw_count; ++d) {
    const plan_draw *draw = &list->draws[d];
    const uint32_t key = draw->mesh * 2 + draw->mirrored;
    assert_true(draw->first == next && draw->count > 0);
    assert_true(d == 0 || key > last_key);
    assert_true(draw->mirrored <= (uint32_t)sides);
    for (uint32_t i = 0; i < draw->count; ++i) {
      const plan_instance *instance = &scene->instances[list->instances[next + i]];
      assert_int_equal(instance->mesh, draw->mesh);
      assert_true(!sides || instance->mirrored == draw->mirrored);
      assert_true(i == 0 || list->instances[next + i] > list->instances[next + i - 1]);
    }
    next += draw->count;
    last_key = key;
  }
  assert_int_equal(next, list->instance_count);
  assert_int_equal(list->culled, scene->slot_count - list->instance_count);
}

static void listed(const plan_list *list, bool *out) {
  memset(out, 0, instances);
  for (uint32_t i = 0; i < list->instance_count; ++i) {
    assert_false(out[list->instances[i]]);
    out[list->instances[i]] = true;
  }
}

static void sides_are_apart_in_a_cascade(void **state) {
  (void)state;
  random_state random = {2};
  test_scene scene = scene_make(instances, meshes);
  bool without[CSM_MAX_CASCADES][instances], with[instances];
  uint32_t apart = 0;
  for (int i = 0; i < 300; ++i) {
    const test_camera camera = random_camera(&random, 100.0);
    csm_config config = random_config(&random);
    double view[16], projection[16], light[3];
    camera_matrices(&camera, view, projection);
    scene_scatter(&scene, &random, camera.eye, 60.0);
    random_unit(&random, light);
    for (uint32_t cull = CSM_FACE_CULLING_NONE; cull <= CSM_FACE_CULLING_BACK; ++cull) {
      plan_frame frame;
      const char *error = "";
      config.face_culling = cull;
      assert_int_equal(plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light},
                                 &scene.scene, scene.memory, &error),
                       0);
      for (uint32_t c = 0; c < frame.cascade_count; ++c) {
        const plan_list *list = &frame.windows[c].list;
        check_draws(list, &scene.scene, true);
        listed(list, cull ? with : without[c]);
        if (cull)
          assert_memory_equal(with, without[c], sizeof with);
        apart += list->draw_count > meshes;
      }
    }
  }
  assert_true(apart > 100);
  scene_free(&scene);
}

/* A camera's own depth draws both sides of all faces. */
static void a_view_does_not_tell_sides_apart(void **state) {
  (void)state;
  random_state random = {3};
  test_scene scene = scene_make(instances, meshes);
  for (int i = 0; i < 100; ++i) {
    const test_camera camera = random_camera(&random, 100.0);
    double view[16], projection[16];
    plan_camera made;
    plan_list list;
    const char *error = "";
    camera_matrices(&camera, view, projection);
    scene_scatter(&scene, &random, camera.eye, 60.0);
    assert_int_equal(plan_camera_make(&made, view, projection, camera_reversed(&camera), &error), CSM_SUCCESS);
    plan_view_make(&list, &made, &scene.scene, NULL, scene.memory);
    check_draws(&list, &scene.scene, false);
  }
  scene_free(&scene);
}

/* Each instance a key of its own: as many draws as memory is laid out for. */
static void memory_holds_as_many_draws_as_there_can_be(void **state) {
  (void)state;
  const uint32_t count = 40;
  test_scene scene = scene_make(count, count / 2);
  for (uint32_t i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k)
      scene.instances[i].transform[k * 5] = k == 0 && i % 2 ? -1.0 : 1.0;
    scene.instances[i].transform[11] = -10.0;
    scene.instances[i].mesh = i / 2;
    scene.instances[i].mirrored = i % 2;
  }
  for (uint32_t i = 0; i < count / 2; ++i)
    for (int k = 0; k < 3; ++k)
      scene.meshes[i].extent[k] = 1.0;
  csm_config config = default_config();
  config.face_culling = CSM_FACE_CULLING_BACK;
  config.cascade_count = CSM_MAX_CASCADES;
  const test_camera camera = plain_camera();
  double view[16], projection[16];
  plan_frame frame;
  const char *error = "";
  camera_matrices(&camera, view, projection);
  assert_int_equal(plan_made(&frame, &config,
                             &(test_shot){view, projection, camera_reversed(&camera), (double[]){0.0, 0.0, -1.0}},
                             &scene.scene, scene.memory, &error),
                   CSM_SUCCESS);
  for (uint32_t c = 0; c < CSM_MAX_CASCADES; ++c) {
    assert_int_equal(frame.windows[c].list.draw_count, count);
    check_draws(&frame.windows[c].list, &scene.scene, true);
  }
  scene_free(&scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(mirrors_are_told_by_the_determinant_at_any_scale),
      cmocka_unit_test(sides_are_apart_in_a_cascade),
      cmocka_unit_test(a_view_does_not_tell_sides_apart),
      cmocka_unit_test(memory_holds_as_many_draws_as_there_can_be),
  };
  return cmocka_run_group_tests_name("plan-lists", tests, NULL, NULL);
}
