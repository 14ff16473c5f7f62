/* Cameras from poses, matrices and JSON. */
#include "base/linear.h"
#include "scene/camera.h"
#include "scene/camera_json.h"
#include "support.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

static const double pi = 3.14159265358979323846;

static void pose_makes_reversed_right_handed_cameras(void **state) {
  (void)state;
  for (int infinite = 0; infinite < 2; infinite++) {
    const camera_pose pose = {.position = {3, 4, 5},
                              .target = {3, 4, -5},
                              .vertical_fov_deg = 60.0,
                              .near_depth = 0.5,
                              .far_depth = infinite ? INFINITY : 100.0};
    camera made, found;
    assert_null(camera_pose_check(&pose));
    camera_from_pose(&made, &pose, 2.0);
    double view[4], clip[4];
    const double edge[3] = {3.0, 4.0 + 2.0 * tan(pi / 6.0), 3.0}; /* 2 m ahead, at the top of the picture */
    mat_transform(view, made.view, edge, 1.0);
    mat_transform(clip, made.projection, view, view[3]);
    close_to(clip[1] / clip[3], 1.0, 1e-12);
    close_to(clip[2] / clip[3], infinite ? 0.25 : 0.5 / 99.5 * (100.0 / 2.0 - 1.0), 1e-12);
    assert_null(camera_from_matrices(&found, made.view, made.projection, NULL));
    assert_true(found.reversed);
    close_to(found.near_depth, 0.5, 1e-12);
    assert_true(infinite ? isinf(found.far_depth) : fabs(found.far_depth - 100.0) < 1e-9);
    close_to(found.position[2], 5.0, 1e-12);
    close_to(found.forward[2], -1.0, 1e-12);
  }
}

/* Left-handed, not reversed, off-centre; and an orthographic one. */
static void any_projection_is_understood(void **state) {
  (void)state;
  camera found;
  double view[16], projection[16] = {0};
  mat_identity(view);
  projection[0] = projection[5] = 1.0;
  projection[8] = 0.3;
  projection[10] = 10.0 / 9.0;
  projection[11] = 1.0;
  projection[14] = -10.0 / 9.0;
  assert_null(camera_from_matrices(&found, view, projection, NULL));
  assert_false(found.reversed);
  close_to(found.near_depth, 1.0, 1e-12);
  close_to(found.far_depth, 10.0, 1e-12);
  close_to(found.forward[2], 1.0, 1e-12);

  const double orthographic[16] = {0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, -1.0 / 40.0, 0, 0, 0, -10.0 / 40.0, 1};
  assert_null(camera_from_matrices(&found, view, orthographic, NULL));
  assert_false(found.reversed);
  close_to(found.near_depth, 10.0, 1e-12);
  close_to(found.far_depth, 50.0, 1e-12);
  close_to(found.forward[2], -1.0, 1e-12);

  /* A slab from 10 m behind the camera to 30 m before it: either way round */
  const bool yes = true, no = false;
  const double both_sides[16] = {0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, -1.0 / 40.0, 0, 0, 0, 10.0 / 40.0, 1};
  assert_non_null(camera_from_matrices(&found, view, both_sides, NULL));
  assert_null(camera_from_matrices(&found, view, both_sides, &no));
  assert_false(found.reversed);
  close_to(found.near_depth, -10.0, 1e-12);
  close_to(found.far_depth, 30.0, 1e-12);
  close_to(found.forward[2], -1.0, 1e-12);
  assert_null(camera_from_matrices(&found, view, both_sides, &yes));
  assert_true(found.reversed);
  close_to(found.near_depth, -30.0, 1e-12);
  close_to(found.far_depth, 10.0, 1e-12);
  close_to(found.forward[2], 1.0, 1e-12);
  assert_non_null(camera_from_matrices(&found, view, orthographic, &yes)); /* the matrix says otherwise */

  projection[0] = 0.0;
  assert_non_null(camera_from_matrices(&found, view, projection, NULL));
  projection[0] = NAN;
  assert_non_null(camera_from_matrices(&found, view, projection, NULL));
}

static void bad_poses_are_refused(void **state) {
  (void)state;
  const camera_pose good = {.target = {0, 0, -1}, .vertical_fov_deg = 45.0, .near_depth = 0.1, .far_depth = 10.0};
  camera_pose pose = good;
  pose.target[2] = 0.0;
  assert_non_null(camera_pose_check(&pose));
  pose = good;
  pose.near_depth = 0.0;
  assert_non_null(camera_pose_check(&pose));
  pose = good;
  pose.far_depth = 0.1;
  assert_non_null(camera_pose_check(&pose));
  pose = good;
  pose.vertical_fov_deg = 180.0;
  assert_non_null(camera_pose_check(&pose));
}

static void a_camera_survives_json(void **state) {
  (void)state;
  const camera_pose pose = {.position = {0.1, 1e7 + 1.0 / 3.0, -7},
                            .target = {1, 1e7, 2},
                            .vertical_fov_deg = 33.0,
                            .near_depth = 0.1,
                            .far_depth = INFINITY};
  camera made, found;
  camera_from_pose(&made, &pose, 1.7);
  char path[64];
  make_path(path, ".json");
  json_t *object = camera_to_json(&made);
  assert_int_equal(json_dump_file(object, path, JSON_REAL_PRECISION(17)), 0);
  json_decref(object);
  uint32_t width = 0, height = 0;
  assert_int_equal(camera_from_json(&found, &width, &height, path), 0);
  assert_int_equal(width, 0);
  assert_memory_equal(found.view, made.view, sizeof made.view);
  assert_memory_equal(found.projection, made.projection, sizeof made.projection);
  assert_memory_equal(found.position, made.position, sizeof made.position);
  assert_true(found.near_depth == made.near_depth && isinf(found.far_depth) && found.reversed);
  write_text(path, "{\"view\": [1, 2], \"projection\": []}");
  assert_int_equal(camera_from_json(&found, &width, &height, path), 2);
  object = camera_to_json(&made);
  json_object_set_new(object, "reversed", json_false());
  assert_int_equal(json_dump_file(object, path, JSON_REAL_PRECISION(17)), 0);
  json_decref(object);
  assert_int_equal(camera_from_json(&found, &width, &height, path), 2);
  write_text(path, "{\"view\": ");
  assert_int_equal(camera_from_json(&found, &width, &height, path), 2);
  unlink(path);
}

/* From 50 m before the eye to 50 m behind it: the matrix leaves open which end is near. */
static void a_camera_that_leaves_it_open_is_not_reversed(void **state) {
  (void)state;
  char path[64];
  make_path(path, ".json");
  write_text(path, "{\"view\": [1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, -20, 1],"
                   " \"projection\": [0.0625, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, -0.01, 0, 0, 0, 0.5, 1]}");
  camera found;
  uint32_t width = 0, height = 0;
  assert_int_equal(camera_from_json(&found, &width, &height, path), 0);
  assert_false(found.reversed);
  assert_true(fabs(found.forward[1] + 1.0) < 1e-12); /* downwards */
  assert_true(fabs(found.near_depth + 50.0) < 1e-9 && fabs(found.far_depth - 50.0) < 1e-9);
  unlink(path);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(pose_makes_reversed_right_handed_cameras),
      cmocka_unit_test(any_projection_is_understood),
      cmocka_unit_test(bad_poses_are_refused),
      cmocka_unit_test(a_camera_survives_json),
      cmocka_unit_test(a_camera_that_leaves_it_open_is_not_reversed),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
