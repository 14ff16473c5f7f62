/* What a camera sees across the light: whatever rounding does to a wide or a flat view, nothing of it is left out. */
#include "support.h"

#include "plan/internal.h"

#include <fenv.h>
#include <math.h>

/* All corners, edges and insides of the view, up to a depth, lie in every half-plane. */
static void check_holds(const plan_hull *hull, const test_camera *camera, const double basis[9], double end) {
  double size = 0.0;
  assert_true(hull->count <= PLAN_HULL_MOST);
  for (int i = 0; i < 27; ++i) {
    const double at[3] = {i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 / 2.0};
    double p[3];
    camera_point(camera, at[0], at[1], camera->near + at[2] * (end - camera->near), p);
    const double x = plan_dot(basis, p), y = plan_dot(&basis[3], p);
    for (int k = 0; k < 3; ++k)
      size = fmax(size, fabs(p[k]));
    for (uint32_t h = 0; h < hull->count; ++h)
      if (!(hull->normals[h][0] * x + hull->normals[h][1] * y <= hull->offsets[h] + 1e-13 * size))
        fail_msg("%g, %g lies %g past a half-plane, of a view that is %g large", x, y,
                 hull->normals[h][0] * x + hull->normals[h][1] * y - hull->offsets[h], size);
  }
}

/* The camera's near plane becomes what is left of it in the matrix. */
static void hull_of(plan_hull *out, double basis[9], test_camera *camera, const double light[3], double end) {
  double view[16], projection[16];
  plan_camera made;
  const char *error = "";
  camera_matrices(camera, view, projection);
  feclearexcept(FE_ALL_EXCEPT);
  if (plan_camera_make(&made, view, projection, camera_reversed(camera), &error) ||
      plan_light_basis(basis, light, &error))
    fail_msg("%s", error);
  plan_view_hull(out, &made, basis, (double[]){made.near_depth, end}, 0.0);
  camera->near = made.near_depth;
  assert_no_exceptions();
}

/* One whose hull once came out with ten points. */
static void a_very_tall_view_has_a_hull(void **state) {
  (void)state;
  const double view[16] = {[0] = 1.0, [5] = 1.0, [10] = 1.0, [15] = 1.0};
  const double near = 1.0, far = 100.0;
  const double projection[16] = {
      [0] = 1.0, [5] = 1e-12, [10] = far / (near - far), [11] = -1.0, [14] = near * far / (near - far)};
  csm_config config = default_config();
  config.caster_set = CSM_CASTER_SET_VIEW;
  config.fit_mode = CSM_FIT_CASCADE;
  test_scene scene = scene_make(1, 1);
  scene.instances[0].transform[0] = scene.instances[0].transform[5] = scene.instances[0].transform[10] = 1.0;
  scene.instances[0].transform[11] = -2.0;
  scene_place(&scene);
  plan_frame frame;
  const char *error = "";
  if (plan_made(&frame, &config, &(test_shot){view, projection, CSM_REVERSED_BY_MATRIX, (double[]){-10.0, -7.0, 0.0}},
                &scene.scene, scene.memory, &error))
    fail_msg("%s", error);
  assert_int_equal(frame.windows[0].list.instance_count, 1);
  scene_free(&scene);
}

static void wide_and_flat_views_are_held(void **state) {
  (void)state;
  random_state random = {1};
  uint32_t more = 0;
  for (int i = 0; i < 100000; ++i) {
    test_camera camera = random_camera(&random, i % 3 ? 0.0 : 1e4);
    double light[3], basis[9];
    plan_hull hull;
    camera.half_width = random_scale(&random, 1e-2, 1e13);
    camera.half_height = i % 2 ? random_scale(&random, 1e-2, 1e13) : camera.half_width;
    random_unit(&random, light);
    if (random_below(&random, 2)) /* with the light along an axis of the picture */
      for (int k = 0; k < 3; ++k)
        light[k] = i % 4 < 2 ? camera.right[k] : camera.forward[k] + 1e-9 * camera.up[k];
    const double end = camera.near + random_scale(&random, 1e-2, 1e4);
    hull_of(&hull, basis, &camera, light, end);
    check_holds(&hull, &camera, basis, end);
    more += hull.count > 8;
  }
  assert_true(more > 0); /* what the bound is for */
}

/* A plain view's hull leaves out what lies beside it. */
static void a_plain_view_has_a_tight_hull(void **state) {
  (void)state;
  random_state random = {2};
  const double end = 100.0;
  for (int i = 0; i < 2000; ++i) {
    test_camera camera = plain_camera();
    double light[3], basis[9], forward[3];
    plan_hull hull;
    random_unit(&random, forward);
    camera_look(&camera, forward, 0.0);
    random_unit(&random, light);
    hull_of(&hull, basis, &camera, light, end);
    assert_true(hull.count >= 3 && hull.count <= 8);
    /* Each half-plane is touched by a corner; sphere.c makes the view larger by a step of its jitter. */
    for (uint32_t h = 0; h < hull.count; ++h) {
      double most = -INFINITY;
      for (int corner = 0; corner < 8; ++corner) {
        double p[3];
        camera_point(&camera, corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? end : camera.near, p);
        most = fmax(most, hull.normals[h][0] * plan_dot(basis, p) + hull.normals[h][1] * plan_dot(&basis[3], p));
      }
      assert_true(most <= hull.offsets[h] + 1e-9 && most >= hull.offsets[h] - 0.02 * end);
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_very_tall_view_has_a_hull),
      cmocka_unit_test(wide_and_flat_views_are_held),
      cmocka_unit_test(a_plain_view_has_a_tight_hull),
  };
  return cmocka_run_group_tests_name("plan-hull", tests, NULL, NULL);
}
