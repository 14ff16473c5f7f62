/* The camera that csm draws depths of its own with, and what a depth is in another camera's buffer. */
#include "support.h"

#include <fenv.h>
#include <math.h>
#include <string.h>

/* ---- closed forms ---- */

/* What a buffer holds at a view depth, reversed or not: 0 and 1 at the planes, linear in 1 / depth or in depth. */
static double depth_of(const test_camera *camera, bool reversed, double depth) {
  const double n = camera->near, f = camera->far;
  double from_far; /* 1 at the near plane, 0 at the far one, without a difference of large numbers */
  if (camera->orthographic)
    from_far = (f - depth) / (f - n);
  else
    from_far = isinf(f) ? n / depth : n * (f - depth) / (depth * (f - n));
  return reversed ? from_far : 1.0 - from_far;
}

/* How much of it the matrix's own rounding may take: the entry that meets the depth is near 1, to 2^-53. */
static double matrix_rounding(const test_camera *camera) {
  return camera->orthographic ? 1e-15 * fmax(fabs(camera->near), camera->far) / (camera->far - camera->near) : 1e-15;
}

typedef struct fixture {
  test_camera camera;
  plan_camera made, own;
  test_scene scene;
  plan_list seen;
} fixture;

static double clip_depth(const plan_camera *camera, double depth) {
  const double *p = camera->projection, row[3] = {camera->view[2], camera->view[6], camera->view[10]};
  const double side = row[0] * camera->forward[0] + row[1] * camera->forward[1] + row[2] * camera->forward[2];
  const double z = side < 0.0 ? -depth : depth;
  return (p[10] * z + p[14]) / (p[11] * z + p[15]);
}

static double convert(const plan_camera *from, const plan_camera *to, double depth) {
  return plan_convert_depth(from, to, &(plan_pixel){.depth = depth});
}

static void make(fixture *f) {
  double view[16], projection[16];
  const char *error = "";
  camera_matrices(&f->camera, view, projection);
  if (plan_camera_make(&f->made, view, projection, camera_reversed(&f->camera), &error))
    fail_msg("%s", error);
  plan_view_make(&f->seen, &f->made, &f->scene.scene, NULL, f->scene.memory);
  feclearexcept(FE_ALL_EXCEPT);
  plan_depth_camera_make(&f->own, &f->made, &f->seen, &f->scene.scene);
  assert_no_exceptions();
}

/* ---- what it sees ---- */

static void it_sees_the_same_in_reversed_depth(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 20000; ++i) {
    fixture f = {.camera = random_camera(&random, 1000.0)};
    make(&f);
    assert_true(f.own.reversed && f.own.orthographic == f.camera.orthographic);
    assert_memory_equal(f.own.view, f.made.view, sizeof f.own.view);
    for (int entry = 0; entry < 16; ++entry)
      if (entry % 4 != 2)
        assert_true(f.own.projection[entry] == f.made.projection[entry]);
    const double n = f.camera.near, far = isinf(f.camera.far) ? 1e9 * n : f.camera.far;
    for (int k = 0; k <= 10; ++k) {
      const double share = k / 10.0;
      const double depth = f.camera.orthographic ? n + (far - n) * share : n * pow(far / n, share);
      assert_near(clip_depth(&f.own, depth), depth_of(&f.camera, true, depth), 4.0 * matrix_rounding(&f.camera));
    }
  }
}

/* The nearest float of a depth leads back to the place: of a near plane of 1 mm and a far one of 10 km, not reversed. */
static void a_float_holds_every_distance(void **state) {
  (void)state;
  static const double planes[][2] = {{1e-3, 1e4}, {1e-3, INFINITY}, {1e-3, 2e-3}, {1e3, 1e10}, {0.1, 1e6}};
  for (int i = 0; i < 5 * 4; ++i) {
    fixture f = {.camera = plain_camera()};
    f.camera.near = planes[i / 4][0];
    f.camera.far = planes[i / 4][1];
    f.camera.reversed = i % 2;
    f.camera.left_handed = i / 2 % 2;
    make(&f);
    const double far = fmin(f.camera.far, 1e10 * f.camera.near);
    for (int k = 0; k < 1000; ++k) {
      const double depth = f.camera.near * pow(far / f.camera.near, k / 1000.0);
      const float stored = (float)depth_of(&f.camera, true, depth);
      /* Half a step of the float, and what rounding takes off the matrix where far / near is large */
      const double rounding = 0x1p-24 + 2e-15 * depth / f.camera.near;
      assert_near(plan_view_depth(&f.own, stored), depth, depth * rounding);
      assert_near(convert(&f.own, NULL, stored), depth, depth * rounding);
    }
  }
}

/* ---- orthographic ---- */

/* A box of half size 1 some way ahead of the camera, `half` metres deep along the view to each side. */
static void add_box(fixture *f, uint32_t slot, double ahead, double half) {
  plan_instance *box = &f->scene.instances[slot];
  *box = (plan_instance){0};
  for (int row = 0; row < 3; ++row) {
    box->transform[row * 4] = f->camera.right[row];
    box->transform[row * 4 + 1] = f->camera.up[row];
    box->transform[row * 4 + 2] = f->camera.forward[row] * half;
    box->transform[row * 4 + 3] = f->camera.eye[row] + ahead * f->camera.forward[row];
  }
}

static void orthographic_depths_end_where_the_scene_does(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 2000; ++i) {
    fixture f = {.camera = random_camera(&random, 1000.0)};
    f.camera.orthographic = true;
    f.camera.near = -random_scale(&random, 1.0, 1e6);
    f.camera.far = random_scale(&random, 1.0, 1e6);
    f.camera.center[0] = f.camera.center[1] = 0.0;
    f.scene = scene_make(2, 1);
    plan_bounds_make(&f.scene.meshes[0], (float[]){-1, -1, -1}, (float[]){1, 1, 1});
    const double length = f.camera.far - f.camera.near;
    double at[2], half[2];
    for (uint32_t slot = 0; slot < 2; ++slot) {
      at[slot] = f.camera.near + length * random_between(&random, 0.1, 0.9);
      half[slot] = i % 4 ? random_between(&random, 0.0, 0.01) * length : 0.0;
      add_box(&f, slot, at[slot], fmax(half[slot], 1e-9));
    }
    scene_place(&f.scene);
    make(&f);
    const double first = fmin(at[0] - half[0], at[1] - half[1]), last = fmax(at[0] + half[0], at[1] + half[1]);
    const double room = (last - first) / 64.0 + f.camera.half_width / 512.0;
    const double rounding = 1e-9 * length + 1e-5 + 0x1p-20 * fmax(half[0], half[1]); /* with the boxes' own in floats */
    assert_near(f.own.near_depth, fmax(f.camera.near, first - room), rounding);
    assert_near(f.own.far_depth, fmin(f.camera.far, last + room), rounding);
    /* So neither end of the scene is clipped, nor where nothing is */
    assert_true(clip_depth(&f.own, first) < 1.0 && clip_depth(&f.own, last) > 0.0);
    for (int k = 0; k <= 10; ++k) {
      const double depth = first + (last - first) * k / 10.0, stored = clip_depth(&f.own, depth);
      assert_near(plan_view_depth(&f.own, stored), depth, 1e-9 * length);
      assert_near(convert(&f.own, &f.made, stored), depth_of(&f.camera, f.camera.reversed, depth), 1e-8);
    }
    scene_free(&f.scene);
  }
}

static void orthographic_depths_stay_within_the_planes(void **state) {
  (void)state;
  fixture f = {.camera = plain_camera()};
  f.camera.orthographic = true;
  f.camera.half_width = f.camera.half_height = 10.0;
  f.camera.near = 5.0;
  f.camera.far = 20.0;
  f.scene = scene_make(1, 1);
  plan_bounds_make(&f.scene.meshes[0], (float[]){-1, -1, -1}, (float[]){1, 1, 1});
  add_box(&f, 0, 12.0, 100.0);
  scene_place(&f.scene);
  make(&f);
  assert_near(f.own.near_depth, 5.0, 1e-9);
  assert_near(f.own.far_depth, 20.0, 1e-9);
  scene_free(&f.scene);
}

/* ---- in another buffer ---- */

static void depths_are_converted(void **state) {
  (void)state;
  random_state random = {4};
  for (int i = 0; i < 5000; ++i) {
    fixture f = {.camera = random_camera(&random, 10.0)};
    make(&f);
    const double clear = f.camera.reversed ? 0.0 : 1.0;
    assert_true(plan_clear_depth(&f.made) == clear && plan_clear_depth(&f.own) == 0.0);
    assert_true(convert(&f.own, &f.made, 0.0) == clear);
    assert_true(isinf(convert(&f.own, NULL, 0.0)));
    const double n = f.camera.near, far = isinf(f.camera.far) ? 1e6 * n : f.camera.far;
    const double depth = n + (far - n) * random_between(&random, 0.001, 0.999);
    const double expected = depth_of(&f.camera, f.camera.reversed, depth);
    assert_near(convert(&f.own, &f.made, clip_depth(&f.own, depth)), expected, 16.0 * matrix_rounding(&f.camera));
    /* A camera's own depths are not touched */
    assert_true(convert(&f.own, &f.own, 0.3) == 0.3);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(it_sees_the_same_in_reversed_depth),
      cmocka_unit_test(a_float_holds_every_distance),
      cmocka_unit_test(orthographic_depths_end_where_the_scene_does),
      cmocka_unit_test(orthographic_depths_stay_within_the_planes),
      cmocka_unit_test(depths_are_converted),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
