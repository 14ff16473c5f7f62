/* What the plan reads from a view and a projection, and the matrix operations under it. */
#include "support.h"

#include <math.h>
#include <string.h>

/* A far plane is what is left of a difference from 1, rounded to 2^-53, times far / near. */
static double far_tolerance(const test_camera *camera) {
  return camera->far * (1e-9 + 4e-16 * camera->far / fabs(camera->near));
}

static void check_camera(const test_camera *camera, const plan_camera *made, double world) {
  assert_int_equal(made->orthographic, camera->orthographic);
  assert_int_equal(made->reversed, camera->reversed);
  const double span = camera->orthographic ? camera->far - camera->near : 0.0;
  assert_near(made->near_depth, camera->near, fabs(camera->near) * 1e-8 + span * 1e-12);
  if (isinf(camera->far))
    assert_true(isinf(made->far_depth));
  else
    assert_near(made->far_depth, camera->far, far_tolerance(camera));
  for (int i = 0; i < 3; ++i) {
    assert_near(made->position[i], camera->eye[i], 1e-15 * 16 * (world + 1.0));
    assert_near(made->forward[i], camera->forward[i], 1e-14);
  }
}

static void reads_what_a_camera_was_made_from(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 20000; ++i) {
    const double world = i % 2 ? 0.0 : random_scale(&random, 1.0, 1e7);
    const test_camera camera = random_camera(&random, world);
    double view[16], projection[16];
    camera_matrices(&camera, view, projection);
    plan_camera made;
    const char *error = "";
    if (plan_camera_make(&made, view, projection, camera_reversed(&camera), &error))
      fail_msg("%s", error);
    check_camera(&camera, &made, world);
  }
}

static void takes_a_projection_of_any_scale(void **state) {
  (void)state;
  random_state random = {2};
  for (int i = 0; i < 2000; ++i) {
    const test_camera camera = random_camera(&random, 10.0);
    double view[16], projection[16];
    camera_matrices(&camera, view, projection);
    const double scale = random_scale(&random, 1e-250, 1e250);
    for (int k = 0; k < 16; ++k)
      projection[k] *= scale;
    plan_camera made;
    const char *error = "";
    if (plan_camera_make(&made, view, projection, camera_reversed(&camera), &error))
      fail_msg("%s", error);
    check_camera(&camera, &made, 10.0);
  }
}

static void takes_float_matrices(void **state) {
  (void)state;
  test_camera camera = plain_camera();
  random_state random = {3};
  for (int i = 0; i < 1000; ++i) {
    double view[16], projection[16], forward[3];
    random_unit(&random, forward);
    camera_look(&camera, forward, random_between(&random, 0.0, 6.0));
    camera_matrices(&camera, view, projection);
    for (int k = 0; k < 16; ++k) {
      view[k] = (float)view[k];
      projection[k] = (float)projection[k];
    }
    plan_camera made;
    const char *error = "";
    if (plan_camera_make(&made, view, projection, camera_reversed(&camera), &error))
      fail_msg("%s", error);
    assert_near(made.near_depth, 0.1, 1e-7);
    assert_near(made.far_depth, 1000.0, 2.0);
  }
}

/* ---- which way it looks ---- */

static csm_result make(plan_camera *out, const test_camera *camera, uint32_t reversed, const char **error) {
  double view[16], projection[16];
  camera_matrices(camera, view, projection);
  return plan_camera_make(out, view, projection, reversed, error);
}

static void assert_refused(const test_camera *camera, uint32_t reversed, const char *words) {
  plan_camera made;
  const char *error = "";
  assert_int_equal(make(&made, camera, reversed, &error), CSM_ERROR_INVALID_CAMERA);
  if (!strstr(error, words))
    fail_msg("\"%s\" does not say \"%s\"", error, words);
}

static void assert_made(const test_camera *camera, uint32_t reversed) {
  plan_camera made;
  const char *error = "";
  if (make(&made, camera, reversed, &error))
    fail_msg("near %g, far %g: %s", camera->near, camera->far, error);
  check_camera(camera, &made, 20.0);
}

/* From 20 m above, as far behind the camera as before it, or farther: only the engine knows where down is. */
static void an_orthographic_camera_looks_where_it_is_told(void **state) {
  (void)state;
  const double planes[][2] = {{0.1, 60}, {-50, 51}, {-50, 50}, {-50, 40}, {-500, 400}};
  for (int i = 0; i < 5 * 2 * 2; ++i) {
    test_camera camera = plain_camera();
    camera_look(&camera, (double[]){0.0, -1.0, 0.0}, 0.0);
    camera.orthographic = true;
    camera.eye[1] = 20.0;
    camera.reversed = i / 5 % 2;
    camera.left_handed = i / 10;
    camera.near = planes[i % 5][0];
    camera.far = planes[i % 5][1];
    assert_made(&camera, camera_reversed(&camera));
    if (camera.near > 0.0) {
      assert_made(&camera, CSM_REVERSED_BY_MATRIX);
      assert_refused(&camera, camera.reversed ? CSM_REVERSED_NO : CSM_REVERSED_YES, "reversed");
    } else {
      assert_refused(&camera, CSM_REVERSED_BY_MATRIX, "CSM_REVERSED_YES or CSM_REVERSED_NO");
    }
  }
}

static void an_orthographic_camera_that_begins_at_its_place_tells(void **state) {
  (void)state;
  random_state random = {7};
  for (int i = 0; i < 1000; ++i) {
    test_camera camera = plain_camera();
    camera.orthographic = true;
    camera.left_handed = i % 2;
    camera.reversed = i / 2 % 2;
    camera.far = random_scale(&random, 0.1, 1e4);
    camera.near = i % 3 ? 0.0 : -camera.far * 1e-8; /* what rounding leaves of 0 */
    plan_camera made;
    const char *error = "";
    if (make(&made, &camera, CSM_REVERSED_BY_MATRIX, &error))
      fail_msg("%s", error);
    assert_int_equal(made.reversed, camera.reversed);
    assert_near(made.far_depth, camera.far, 1e-6 * camera.far);
    assert_near(made.near_depth, 0.0, 1e-6 * camera.far);
    for (int k = 0; k < 3; ++k)
      assert_near(made.forward[k], camera.forward[k], 1e-14);
  }
}

static void a_perspective_camera_tells_and_is_not_contradicted(void **state) {
  (void)state;
  for (int i = 0; i < 4; ++i) {
    test_camera camera = plain_camera();
    camera.reversed = i % 2;
    camera.far = i / 2 ? INFINITY : 1000.0;
    assert_made(&camera, CSM_REVERSED_BY_MATRIX);
    assert_made(&camera, camera_reversed(&camera));
    assert_refused(&camera, camera.reversed ? CSM_REVERSED_NO : CSM_REVERSED_YES, "reversed");
    plan_camera made;
    const char *error = "";
    assert_int_equal(make(&made, &camera, CSM_REVERSED_NO + 1, &error), CSM_ERROR_INVALID_VALUE);
    assert_non_null(strstr(error, "reversed"));
  }
}

/* ---- what is refused ---- */

typedef struct bad_camera {
  const char *what;
  int matrix; /* 0: the view, 1: the projection */
  int index;
  double value;
  csm_result result;
} bad_camera;

static void names_what_is_wrong(void **state) {
  (void)state;
  const bad_camera cases[] = {
      {"NaN in the view", 0, 5, NAN, CSM_ERROR_NOT_FINITE},
      {"infinity in the view", 0, 12, -INFINITY, CSM_ERROR_NOT_FINITE},
      {"NaN in the projection", 1, 3, NAN, CSM_ERROR_NOT_FINITE},
      {"infinity in the projection", 1, 10, INFINITY, CSM_ERROR_NOT_FINITE},
      {"a view that projects", 0, 3, 0.1, CSM_ERROR_INVALID_MATRIX},
      {"a view with w of 2", 0, 15, 2.0, CSM_ERROR_INVALID_MATRIX},
      {"a scaled view", 0, 0, 1.01, CSM_ERROR_INVALID_MATRIX},
      {"a flat view", 0, 0, 0.0, CSM_ERROR_INVALID_MATRIX},
      {"a sheared view", 0, 4, 0.01, CSM_ERROR_INVALID_MATRIX},
      {"a huge view", 0, 0, 1e300, CSM_ERROR_INVALID_MATRIX},
      {"no width", 1, 0, 0.0, CSM_ERROR_INVALID_MATRIX},
      {"no clip w", 1, 11, 0.0, CSM_ERROR_INVALID_MATRIX},
      {"a near plane of 0", 1, 14, 0.0, CSM_ERROR_INVALID_MATRIX},
      {"w from view x", 1, 3, 0.1, CSM_ERROR_INVALID_CAMERA},
      {"w from view z and a constant", 1, 15, 0.5, CSM_ERROR_INVALID_CAMERA},
      {"all of it before the near plane", 1, 10, 0.5, CSM_ERROR_INVALID_CAMERA},
      {"a place beyond all sense", 0, 12, 1e31, CSM_ERROR_INVALID_MATRIX},
      {"next to no width", 1, 0, 1e-31, CSM_ERROR_INVALID_CAMERA},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    double matrices[2][16];
    const test_camera camera = plain_camera();
    camera_matrices(&camera, matrices[0], matrices[1]);
    matrices[cases[i].matrix][cases[i].index] = cases[i].value;
    plan_camera made;
    const char *error = "";
    const csm_result result = plan_camera_make(&made, matrices[0], matrices[1], camera_reversed(&camera), &error);
    if (result != cases[i].result)
      fail_msg("%s: %d, not %d", cases[i].what, result, cases[i].result);
    assert_non_null(strstr(error, cases[i].matrix ? "projection" : "view"));
  }
}

/* ---- oblique near planes ---- */

/*
 * Lengyel, "Oblique View Frustum Depth Projection and Clipping" (2005), for depth from 0 to 1: clip z becomes the distance
 * from a plane that crosses the view axis at a depth, scaled so that the corner of the image that rises fastest from
 * it ends at 1. `tilt` is how the plane's normal leans from the axis, as view x and y. Returns the least depth it leaves.
 */
static double make_oblique(double projection[16], const test_camera *camera, const double tilt[2], double depth) {
  const double z_sign = camera->left_handed ? 1.0 : -1.0, x_sign = camera->mirrored ? -1.0 : 1.0;
  const double plane[4] = {tilt[0], tilt[1], z_sign, -depth};
  double fastest = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double x = x_sign * ((i & 1 ? 1.0 : -1.0) - camera->center[0]) * camera->half_width;
    const double y = ((i & 2 ? 1.0 : -1.0) - camera->center[1]) * camera->half_height;
    fastest = fmax(fastest, tilt[0] * x + tilt[1] * y + 1.0);
  }
  for (int k = 0; k < 4; ++k) {
    const double w = k == 2 ? z_sign : 0.0, z = plane[k] / fastest;
    projection[k * 4 + 2] = camera->reversed ? w - z : z;
  }
  return depth / fastest;
}

static void a_near_plane_may_be_oblique(void **state) {
  (void)state;
  random_state random = {8};
  for (int i = 0; i < 5000; ++i) {
    test_camera camera = random_camera(&random, 100.0);
    camera.orthographic = false;
    camera.half_height = fmin(camera.half_height, 10.0);
    camera.half_width = fmin(camera.half_width, 10.0);
    const double tilt[2] = {random_between(&random, -1.0, 1.0), random_between(&random, 0.01, 1.0)};
    const double depth = random_scale(&random, 0.01, 100.0);
    double view[16], projection[16];
    camera_matrices(&camera, view, projection);
    const double least = make_oblique(projection, &camera, tilt, depth);
    if (!(least < 100.0 * depth)) /* next to nothing of the image meets the plane */
      continue;
    plan_camera made;
    const char *error = "";
    if (plan_camera_make(&made, view, projection, i % 2 ? camera_reversed(&camera) : CSM_REVERSED_BY_MATRIX, &error))
      fail_msg("%s", error);
    assert_true(made.oblique && made.reversed == camera.reversed);
    assert_near(made.near_depth, least, 1e-9 * least);
    assert_true(isinf(made.far_depth));
    for (int k = 0; k < 3; ++k)
      assert_near(made.forward[k], camera.forward[k], 1e-14);
    /* A place in the picture and its depth are a place in the world */
    const double x = random_between(&random, -1.0, 1.0), y = random_between(&random, -1.0, 1.0);
    const double far = least * random_scale(&random, 1.0, 1e3);
    const double at[2] = {(x - camera.center[0]) * camera.half_width * far * (camera.mirrored ? -1.0 : 1.0),
                          (y - camera.center[1]) * camera.half_height * far};
    const double clip = (projection[2] * at[0] + projection[6] * at[1] +
                         (camera.left_handed ? far : -far) * projection[10] + projection[14]) /
                        far;
    const plan_pixel pixel = {x, y, clip};
    assert_near(plan_convert_depth(&made, NULL, &pixel), far, 1e-9 * far);
    plan_camera own;
    plan_depth_camera_make(&own, &made, &(plan_list){0}, &(plan_scene){0});
    assert_true(own.reversed && own.oblique);
    const plan_pixel turned = {x, y, camera.reversed ? clip : 1.0 - clip};
    assert_near(plan_convert_depth(&own, &made, &turned), clip, 1e-15);
    assert_near(plan_convert_depth(&own, NULL, &turned), far, 1e-9 * far);
  }
}

static void oblique_planes_that_say_nothing_are_refused(void **state) {
  (void)state;
  test_camera camera = plain_camera();
  double view[16], projection[16];
  plan_camera made;
  const char *error = "";
  camera_matrices(&camera, view, projection);
  (void)make_oblique(projection, &camera, (const double[]){0.3, 0.4}, 2.0);
  assert_int_equal(plan_camera_make(&made, view, projection, CSM_REVERSED_YES, &error), CSM_ERROR_INVALID_CAMERA);
  assert_non_null(strstr(error, "reversed"));
  /* The camera lies beyond the plane, and sees none of what it leaves */
  (void)make_oblique(projection, &camera, (const double[]){0.3, 0.4}, -2.0);
  projection[14] = 0.0;
  assert_int_equal(plan_camera_make(&made, view, projection, CSM_REVERSED_BY_MATRIX, &error), CSM_ERROR_INVALID_MATRIX);
  camera.orthographic = true;
  camera_matrices(&camera, view, projection);
  projection[2] = 0.2;
  assert_int_equal(plan_camera_make(&made, view, projection, CSM_REVERSED_BY_MATRIX, &error), CSM_ERROR_INVALID_CAMERA);
  assert_non_null(strstr(error, "oblique"));
}

static void refuses_planes_behind_the_camera(void **state) {
  (void)state;
  for (int reversed = 0; reversed < 2; ++reversed) {
    test_camera camera = plain_camera();
    camera.reversed = reversed;
    camera.near = -1.0;
    camera.far = 100.0;
    double view[16], projection[16];
    camera_matrices(&camera, view, projection);
    plan_camera made;
    const char *error = "";
    assert_int_equal(plan_camera_make(&made, view, projection, camera_reversed(&camera), &error),
                     CSM_ERROR_INVALID_CAMERA);
  }
  test_camera camera = plain_camera();
  camera.orthographic = true;
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  projection[15] = -1.0;
  plan_camera made;
  const char *error = "";
  assert_int_equal(plan_camera_make(&made, view, projection, camera_reversed(&camera), &error),
                   CSM_ERROR_INVALID_CAMERA);
}

static void inverts_matrices_of_any_scale(void **state) {
  (void)state;
  random_state random = {4};
  for (int i = 0; i < 5000; ++i) {
    double m[16], inverse[16], product[16];
    double row_scale[4], column_scale[4];
    for (int k = 0; k < 4; ++k) {
      row_scale[k] = random_scale(&random, 1e-60, 1e60);
      column_scale[k] = random_scale(&random, 1e-60, 1e60);
    }
    for (int k = 0; k < 16; ++k)
      m[k] = (random_between(&random, -1.0, 1.0) + (k % 5 == 0 ? 3.0 : 0.0)) * row_scale[k % 4] * column_scale[k / 4];
    assert_true(plan_invert(inverse, m));
    plan_multiply(product, m, inverse);
    for (int k = 0; k < 16; ++k)
      assert_near(product[k], k % 5 == 0, 1e-12 * row_scale[k % 4] / row_scale[k / 4]);
  }
}

static void finds_singular_matrices(void **state) {
  (void)state;
  random_state random = {5};
  for (int i = 0; i < 2000; ++i) {
    double m[16], inverse[16];
    for (int k = 0; k < 12; ++k)
      m[k] = random_between(&random, -1.0, 1.0) * 1e-100;
    for (int k = 0; k < 4; ++k)
      m[12 + k] = 0.3 * m[k] - 2.0 * m[4 + k] + m[8 + k];
    assert_false(plan_invert(inverse, m));
    memset(&m[12], 0, 4 * sizeof *m);
    assert_false(plan_invert(inverse, m));
  }
}

static void checks_transforms(void **state) {
  (void)state;
  random_state random = {6};
  for (int i = 0; i < 5000; ++i) {
    double m[16] = {[15] = 1.0};
    const double scale = random_scale(&random, 1e-150, 1e150);
    for (int column = 0; column < 3; ++column) {
      random_unit(&random, &m[column * 4]);
      for (int row = 0; row < 3; ++row)
        m[column * 4 + row] *= scale * (column == 1 ? 1e-3 : 1.0);
      m[column * 4 + 3] = 0.0;
      m[12 + column] = random_between(&random, -1e7, 1e7);
    }
    assert_int_equal(plan_check_affine(m), CSM_SUCCESS);
    double bad[16];
    memcpy(bad, m, sizeof bad);
    bad[random_below(&random, 4) * 4 + 3] += 0.1;
    assert_int_equal(plan_check_affine(bad), CSM_ERROR_INVALID_MATRIX);
    memcpy(bad, m, sizeof bad);
    bad[random_below(&random, 16)] = NAN;
    assert_int_equal(plan_check_affine(bad), CSM_ERROR_NOT_FINITE);
    memcpy(bad, m, sizeof bad);
    for (int row = 0; row < 3; ++row)
      bad[8 + row] = 0.5 * bad[row];
    assert_int_equal(plan_check_affine(bad), CSM_ERROR_INVALID_MATRIX);
    memset(&bad[4], 0, 3 * sizeof *bad);
    assert_int_equal(plan_check_affine(bad), CSM_ERROR_INVALID_MATRIX);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(reads_what_a_camera_was_made_from),
      cmocka_unit_test(takes_a_projection_of_any_scale),
      cmocka_unit_test(takes_float_matrices),
      cmocka_unit_test(an_orthographic_camera_looks_where_it_is_told),
      cmocka_unit_test(an_orthographic_camera_that_begins_at_its_place_tells),
      cmocka_unit_test(a_perspective_camera_tells_and_is_not_contradicted),
      cmocka_unit_test(names_what_is_wrong),
      cmocka_unit_test(a_near_plane_may_be_oblique),
      cmocka_unit_test(oblique_planes_that_say_nothing_are_refused),
      cmocka_unit_test(refuses_planes_behind_the_camera),
      cmocka_unit_test(inverts_matrices_of_any_scale),
      cmocka_unit_test(finds_singular_matrices),
      cmocka_unit_test(checks_transforms),
  };
  return cmocka_run_group_tests_name("plan-camera", tests, NULL, NULL);
}
