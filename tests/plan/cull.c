/* What cascades and cameras draw: nothing that matters is left out, what clearly does not matter is. */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct culled_frame {
  plan_frame frame;
  test_camera camera;
  double light[3];
} culled_frame;

static void is_listed(const plan_list *list, uint32_t instance_count, bool *listed) {
  memset(listed, 0, instance_count);
  for (uint32_t i = 0; i < list->instance_count; ++i) {
    assert_true(list->instances[i] < instance_count);
    assert_false(listed[list->instances[i]]);
    listed[list->instances[i]] = true;
  }
}

/* Ordered by mesh, then by side, then by slot; a draw for each mesh and side; nothing left over. */
static void check_list(const plan_list *list, const plan_scene *scene) {
  uint32_t next = 0;
  for (uint32_t d = 0; d < list->draw_count; ++d) {
    const plan_draw *draw = &list->draws[d];
    assert_int_equal(draw->first, next);
    assert_true(draw->count > 0);
    assert_true(d == 0 || draw->mesh * 2 + draw->mirrored > draw[-1].mesh * 2 + draw[-1].mirrored);
    for (uint32_t i = 0; i < draw->count; ++i) {
      assert_int_equal(scene->instances[list->instances[next + i]].mesh, draw->mesh);
      assert_true(i == 0 || list->instances[next + i] > list->instances[next + i - 1]);
    }
    next += draw->count;
  }
  assert_int_equal(next, list->instance_count);
  assert_int_equal(list->culled, scene->slot_count - list->instance_count);
}

static culled_frame make_frame(random_state *random, test_scene *scene, const csm_config *config, double world) {
  culled_frame made = {.camera = random_camera(random, world)};
  double view[16], projection[16];
  const char *error = "";
  random_unit(random, made.light);
  camera_matrices(&made.camera, view, projection);
  scene_scatter(scene, random, made.camera.eye, random_scale(random, 1.0, 2000.0));
  if (plan_made(&made.frame, config, &(test_shot){view, projection, camera_reversed(&made.camera), made.light},
                &scene->scene, scene->memory, &error))
    fail_msg("%s", error);
  return made;
}

enum { instances = 200, meshes = 9 };

/* Points of every caster's box, corners among them: one over a texel, on the light's side of the end, is a caster. */
static void keeps_all_that_casts_into_a_map(void **state) {
  (void)state;
  random_state random = {1};
  test_scene scene = scene_make(instances, meshes);
  uint32_t kept = 0, culled = 0;
  for (int i = 0; i < 400; ++i) {
    const csm_config config = random_config(&random);
    const culled_frame made = make_frame(&random, &scene, &config, i % 2 ? 10.0 : 1e7);
    for (uint32_t c = 0; c < made.frame.cascade_count; ++c) {
      const plan_cascade *cascade = &made.frame.cascades[c];
      bool listed[instances];
      is_listed(&made.frame.windows[c].list, instances, listed);
      check_list(&made.frame.windows[c].list, &scene.scene);
      const double half = 0.5 / config.resolution;
      for (uint32_t k = 0; k < instances; ++k) {
        bool casts = false;
        for (int p = 0; p < 12 && !casts; ++p) {
          double in_box[3], point[3], at[3];
          for (int axis = 0; axis < 3; ++axis)
            in_box[axis] = p < 8 ? ((p >> axis) & 1 ? 1.0 : -1.0) : random_between(&random, -1.0, 1.0);
          instance_point(&scene.scene, k, in_box, point);
          transform_point(cascade->info.world_to_shadow, point, at);
          casts = at[0] >= half && at[0] <= 1.0 - half && at[1] >= half && at[1] <= 1.0 - half && at[2] <= 1.0;
        }
        if (casts && !listed[k])
          fail_msg("frame %d, cascade %u, instance %u casts and is not drawn", i, c, k);
        kept += listed[k];
        culled += !listed[k];
      }
    }
  }
  assert_true(kept > 10000 && culled > 10000);
  scene_free(&scene);
}

/* A box all of whose corners lie beyond one border, or behind the end, is not drawn. */
static void culls_what_is_outside(void **state) {
  (void)state;
  random_state random = {2};
  test_scene scene = scene_make(instances, meshes);
  for (int i = 0; i < 200; ++i) {
    const csm_config config = random_config(&random);
    const culled_frame made = make_frame(&random, &scene, &config, 10.0);
    for (uint32_t c = 0; c < made.frame.cascade_count; ++c) {
      const plan_cascade *cascade = &made.frame.cascades[c];
      bool listed[instances];
      is_listed(&made.frame.windows[c].list, instances, listed);
      for (uint32_t k = 0; k < instances; ++k) {
        double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
        for (int p = 0; p < 8; ++p) {
          double point[3], at[3];
          instance_point(&scene.scene, k, (double[]){p & 1 ? 1 : -1, p & 2 ? 1 : -1, p & 4 ? 1 : -1}, point);
          transform_point(cascade->info.world_to_shadow, point, at);
          for (int axis = 0; axis < 3; ++axis) {
            low[axis] = fmin(low[axis], at[axis]);
            high[axis] = fmax(high[axis], at[axis]);
          }
        }
        const double off = 1e-9;
        const bool outside =
            low[0] > 1.0 + off || high[0] < -off || low[1] > 1.0 + off || high[1] < -off || low[2] > 1.0 + off;
        if (outside && listed[k])
          fail_msg("frame %d, cascade %u, instance %u is drawn in vain", i, c, k);
      }
    }
  }
  scene_free(&scene);
}

/* A bird far above everything still casts: it is drawn, before the near plane, where hardware clamps it. */
static void keeps_casters_before_the_near_plane(void **state) {
  (void)state;
  test_scene scene = scene_make(1, 1);
  for (int i = 0; i < 3; ++i)
    scene.instances[0].transform[i * 5] = scene.meshes[0].extent[i] = 1.0;
  const test_camera camera = plain_camera();
  csm_config config = default_config();
  config.caster_distance = 10.0;
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  for (double height = 1.0; height <= 1e8; height *= 10.0) {
    const double direction[3] = {0.3, -1.0, 0.2}, below[3] = {0.0, 0.0, -5.0};
    for (int i = 0; i < 3; ++i)
      scene.instances[0].transform[i * 4 + 3] = below[i] - height * direction[i];
    plan_frame frame;
    const char *error = "";
    assert_int_equal(plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), direction},
                               &scene.scene, scene.memory, &error),
                     CSM_SUCCESS);
    assert_int_equal(frame.windows[0].list.instance_count, 1);
    double at[3];
    transform_point(frame.cascades[0].info.world_to_shadow, below, at);
    assert_true(at[2] > 0.0 && at[2] < 1.0);
  }
  scene_free(&scene);
}

static bool in_clip_volume(const double clip[4]) {
  return fabs(clip[0]) <= clip[3] && fabs(clip[1]) <= clip[3] && clip[2] >= 0.0 && clip[2] <= clip[3];
}

static void a_camera_draws_what_it_sees(void **state) {
  (void)state;
  random_state random = {3};
  test_scene scene = scene_make(instances, meshes);
  uint32_t kept = 0, culled = 0;
  for (int i = 0; i < 500; ++i) {
    const test_camera camera = random_camera(&random, i % 2 ? 10.0 : 1e7);
    double view[16], projection[16], matrix[16];
    camera_matrices(&camera, view, projection);
    scene_scatter(&scene, &random, camera.eye, random_scale(&random, 1.0, 2000.0));
    plan_multiply(matrix, projection, view);
    plan_camera made;
    plan_list list;
    const char *error = "";
    assert_int_equal(plan_camera_make(&made, view, projection, camera_reversed(&camera), &error), CSM_SUCCESS);
    plan_view_make(&list, &made, &scene.scene, NULL, scene.memory);
    bool listed[instances];
    is_listed(&list, instances, listed);
    check_list(&list, &scene.scene);
    for (uint32_t k = 0; k < instances; ++k) {
      bool seen = false;
      for (int p = 0; p < 50 && !seen; ++p) {
        double in_box[3], point[3], clip[4];
        for (int axis = 0; axis < 3; ++axis)
          in_box[axis] = random_between(&random, -1.0, 1.0);
        instance_point(&scene.scene, k, in_box, point);
        transform_point(matrix, point, clip);
        clip[3] = matrix[3] * point[0] + matrix[7] * point[1] + matrix[11] * point[2] + matrix[15];
        seen = in_clip_volume(clip);
      }
      if (seen && !listed[k])
        fail_msg("frame %d: instance %u is seen and not drawn", i, k);
      kept += listed[k];
      culled += !listed[k];
    }
  }
  assert_true(kept > 1000 && culled > 10000);
  scene_free(&scene);
}

/* Boxes on each side of a plain frustum, clearly outside. */
static void a_camera_culls_what_it_does_not_see(void **state) {
  (void)state;
  test_scene scene = scene_make(7, 1);
  const double places[7][3] = {{0, 0, -50},  {0, 0, 5},     {0, 0, -1010}, {-70, 0, -50},
                               {70, 0, -50}, {0, -40, -50}, {0, 40, -50}};
  for (int i = 0; i < 7; ++i)
    for (int k = 0; k < 3; ++k) {
      scene.instances[i].transform[k * 5] = 1.0;
      scene.instances[i].transform[k * 4 + 3] = places[i][k];
      scene.meshes[0].extent[k] = 1.0;
    }
  for (int reversed = 0; reversed < 2; ++reversed)
    for (int infinite = 0; infinite < 2; ++infinite) {
      test_camera camera = plain_camera();
      camera.reversed = reversed;
      camera.far = infinite ? INFINITY : 1000.0;
      double view[16], projection[16];
      camera_matrices(&camera, view, projection);
      plan_camera made;
      plan_list list;
      const char *error = "";
      assert_int_equal(plan_camera_make(&made, view, projection, camera_reversed(&camera), &error), CSM_SUCCESS);
      plan_view_make(&list, &made, &scene.scene, NULL, scene.memory);
      assert_int_equal(list.instance_count, infinite ? 2 : 1);
      assert_int_equal(list.instances[0], 0);
      assert_int_equal(list.culled, infinite ? 5 : 6);
    }
  scene_free(&scene);
}

static void an_empty_scene_draws_nothing(void **state) {
  (void)state;
  const csm_config config = default_config();
  const test_camera camera = plain_camera();
  const plan_frame frame = plan_empty(&config, &camera, (double[]){0, -1, 0});
  for (uint32_t c = 0; c < frame.cascade_count; ++c) {
    assert_int_equal(frame.windows[c].list.instance_count, 0);
    assert_int_equal(frame.windows[c].list.draw_count, 0);
    assert_int_equal(frame.windows[c].list.culled, 0);
  }
  plan_list list;
  plan_view_make(&list, &frame.camera, &(plan_scene){0}, NULL, NULL);
  assert_int_equal(list.instance_count, 0);
}

/* Meshes of no extent, and a million instances at one place, in as much memory as is asked for. */
static void takes_points_and_crowds(void **state) {
  (void)state;
  test_scene scene = scene_make(1000000, 3);
  for (uint32_t i = 0; i < 1000000; ++i) {
    for (int k = 0; k < 3; ++k)
      scene.instances[i].transform[k * 5] = 1.0;
    scene.instances[i].transform[11] = -5.0;
    scene.instances[i].mesh = i % 3;
  }
  const csm_config config = default_config();
  const test_camera camera = plain_camera();
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  plan_frame frame;
  const char *error = "";
  assert_int_equal(plan_made(&frame, &config,
                             &(test_shot){view, projection, camera_reversed(&camera), (double[]){0, -1, 0}},
                             &scene.scene, scene.memory, &error),
                   CSM_SUCCESS);
  assert_int_equal(frame.windows[0].list.instance_count, 1000000);
  assert_int_equal(frame.windows[0].list.draw_count, 3);
  check_list(&frame.windows[0].list, &scene.scene);
  scene_free(&scene);
}

/* In exactly the memory that is asked for; a sanitizer build sees the first byte beyond it. */
static void needs_no_more_memory_than_it_says(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  for (uint32_t count = 1; count <= CSM_MAX_CASCADES; ++count)
    for (uint32_t mesh_count = 1; mesh_count <= 2 * instances; mesh_count *= 7) {
      test_scene scene = scene_make(instances, mesh_count);
      memory_free(scene.memory);
      scene.memory = memory_make(instances, mesh_count, count);
      for (uint32_t i = 0; i < instances; ++i) {
        for (int k = 0; k < 3; ++k)
          scene.instances[i].transform[k * 5] = 1.0;
        scene.instances[i].transform[11] = -5.0;
        scene.instances[i].mesh = (i * 31) % mesh_count;
      }
      csm_config config = default_config();
      config.cascade_count = count;
      plan_frame frame;
      const char *error = "";
      assert_int_equal(plan_made(&frame, &config,
                                 &(test_shot){view, projection, camera_reversed(&camera), (double[]){0, -1, 0}},
                                 &scene.scene, scene.memory, &error),
                       CSM_SUCCESS);
      for (uint32_t c = 0; c < count; ++c)
        check_list(&frame.windows[c].list, &scene.scene);
      memory_free(scene.memory);
      scene.memory = memory_make(instances, mesh_count, 0);
      plan_list list;
      plan_view_make(&list, &frame.camera, &scene.scene, NULL, scene.memory);
      assert_int_equal(list.instance_count, instances);
      check_list(&list, &scene.scene);
      scene_free(&scene);
    }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(keeps_all_that_casts_into_a_map),
      cmocka_unit_test(culls_what_is_outside),
      cmocka_unit_test(keeps_casters_before_the_near_plane),
      cmocka_unit_test(a_camera_draws_what_it_sees),
      cmocka_unit_test(a_camera_culls_what_it_does_not_see),
      cmocka_unit_test(an_empty_scene_draws_nothing),
      cmocka_unit_test(takes_points_and_crowds),
      cmocka_unit_test(needs_no_more_memory_than_it_says),
  };
  return cmocka_run_group_tests_name("plan-cull", tests, NULL, NULL);
}
