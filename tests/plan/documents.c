/*
 * What the documents that csm was made after get wrong in planning: each formula stands here as they have it, fails
 * what it is for, and csm's own does not. Their shaders' are in document_shaders.c.
 */
#include "support.h"

#include "csm_constants.h"
#include "plan/internal.h"

#include <float.h>
#include <math.h>

static const double sun[3] = {0.3, -1.0, 0.2};

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void slice_corner(const test_camera *camera, const csm_cascade_info *info, int corner, double out[3]) {
  camera_point(camera, corner & 1 ? 1.0 : -1.0, corner & 2 ? 1.0 : -1.0,
               corner & 4 ? info->far_depth : info->near_depth, out);
}

/* ---- OGLDev 49 ---- */

/* numeric_limits<float>::min() is the least above 0, not the lowest. */
static void ogldevs_extents_stay_at_zero(void **state) {
  (void)state;
  test_camera camera = plain_camera();
  csm_config config = default_config();
  config.fit_mode = CSM_FIT_CASCADE;
  double basis[9];
  const char *error = "";
  assert_int_equal(plan_light_basis(basis, sun, &error), CSM_SUCCESS);
  for (int k = 0; k < 3; ++k) /* where all of light space's coordinates are negative */
    camera.eye[k] = -500.0 * basis[k] - 500.0 * basis[3 + k];
  const plan_frame frame = plan_empty(&config, &camera, sun);
  for (uint32_t c = 0; c < 4; ++c) {
    const plan_cascade *cascade = &frame.cascades[c];
    for (int axis = 0; axis < 2; ++axis) {
      float low = FLT_MAX, high = FLT_MIN;
      double highest = -INFINITY;
      for (int corner = 0; corner < 8; ++corner) {
        double p[3];
        slice_corner(&camera, &cascade->info, corner, p);
        low = fminf(low, (float)dot(p, &basis[axis * 3]));
        high = fmaxf(high, (float)dot(p, &basis[axis * 3]));
        highest = fmax(highest, dot(p, &basis[axis * 3]));
      }
      assert_true(highest < -300.0 && high == FLT_MIN);
      /* Ours is as wide as the slice, with the room for filter and jitter */
      const double width = cascade->texel[axis] * (cascade->resolution - 2.0 * plan_padding_texels(&config));
      assert_true((double)high - low > 1.5 * width);
      assert_true(width >= highest - low && width <= (highest - low) * (1.0 + 2.0 / 64.0));
    }
  }
}

static void ogldevs_vertical_field_of_view_is_too_low(void **state) {
  (void)state;
  const double horizontal = 90.0 * M_PI / 180.0, ratio = 0.5; /* height over width */
  const double documents = tan(horizontal * ratio / 2.0), right = tan(horizontal / 2.0) * ratio;
  assert_near(2.0 * atan(documents) * 180.0 / M_PI, 45.0, 1e-9);
  assert_near(2.0 * atan(right) * 180.0 / M_PI, 53.13, 0.005);
  test_camera camera = plain_camera();
  camera.half_width = 1.0;
  camera.half_height = right;
  csm_config config = default_config();
  config.fit_mode = CSM_FIT_CASCADE;
  const plan_frame frame = plan_empty(&config, &camera, (double[]){-1.0, 0.0, 0.0}); /* from the side */
  for (uint32_t c = 0; c < 4; ++c) {
    double p[3], at[3];
    slice_corner(&camera, &frame.cascades[c].info, 7, p);
    assert_true(p[1] > frame.cascades[c].info.far_depth * documents * 1.2); /* above what the document's box holds */
    transform_point(frame.cascades[c].info.world_to_shadow, p, at);
    assert_true(fmin(at[0], at[1]) > 0.0 && fmax(at[0], at[1]) < 1.0);
  }
}

static void ogldevs_near_plane_loses_casters(void **state) {
  (void)state;
  const test_camera camera = plain_camera();
  const csm_config config = default_config();
  double view[16], projection[16];
  plan_frame frame;
  const char *error = "";
  test_scene scene = scene_make(1, 1);
  for (int i = 0; i < 3; ++i)
    scene.instances[0].transform[i * 5] = scene.meshes[0].extent[i] = 1.0;
  const double tower[3] = {0.0, 300.0, -10.0}; /* above all that is seen */
  for (int i = 0; i < 3; ++i)
    scene.instances[0].transform[i * 4 + 3] = tower[i];
  camera_matrices(&camera, view, projection);
  assert_int_equal(plan_made(&frame, &config,
                             &(test_shot){view, projection, camera_reversed(&camera), (double[]){0.0, -1.0, 0.0}},
                             &scene.scene, scene.memory, &error),
                   CSM_SUCCESS);
  const plan_cascade *cascade = &frame.cascades[3];
  double low = INFINITY, high = -INFINITY;
  for (int corner = 0; corner < 8; ++corner) {
    double p[3];
    slice_corner(&camera, &cascade->info, corner, p);
    low = fmin(low, dot(p, &frame.basis[6]));
    high = fmax(high, dot(p, &frame.basis[6]));
  }
  assert_true((dot(tower, &frame.basis[6]) - low) / (high - low) < -0.1);
  const double depth = shadow_depth(&cascade->info, tower);
  assert_true(depth >= 0.0 && depth <= 1.0);
  assert_int_equal(frame.windows[3].list.instance_count, 1);
  scene_free(&scene);
}

/* ---- up vectors ---- */

/* A basis as gluLookAt and its like make it. */
static void look_along(double basis[9], const double direction[3], const double up[3]) {
  double *side = basis, *top = basis + 3, *along = basis + 6;
  const double length = sqrt(dot(direction, direction));
  for (int k = 0; k < 3; ++k)
    along[k] = direction[k] / length;
  for (int k = 0; k < 3; ++k)
    side[k] = along[(k + 1) % 3] * up[(k + 2) % 3] - along[(k + 2) % 3] * up[(k + 1) % 3];
  const double across = sqrt(dot(side, side));
  for (int k = 0; k < 3; ++k)
    side[k] /= across;
  for (int k = 0; k < 3; ++k)
    top[k] = side[(k + 1) % 3] * along[(k + 2) % 3] - side[(k + 2) % 3] * along[(k + 1) % 3];
}

static bool is_orthonormal(const double basis[9]) {
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      if (!(fabs(dot(&basis[a * 3], &basis[b * 3]) - (a == b)) <= 1e-12))
        return false;
  return true;
}

static void check_up_vector(const double up[3]) {
  for (int sign = -1; sign <= 1; sign += 2) {
    const double light[3] = {sign * up[0], sign * up[1], sign * up[2]};
    double documents[9], own[9];
    const char *error = "";
    look_along(documents, sun, up);
    assert_true(is_orthonormal(documents)); /* elsewhere it does */
    look_along(documents, light, up);
    assert_false(is_orthonormal(documents));
    assert_int_equal(plan_light_basis(own, light, &error), CSM_SUCCESS);
    assert_true(is_orthonormal(own));
  }
}

static void ogldevs_up_vector_fails_at_the_zenith(void **state) {
  (void)state;
  check_up_vector((double[]){0.0, 1.0, 0.0});
}

static void nvidias_up_vector_fails_along_x(void **state) {
  (void)state;
  check_up_vector((double[]){1.0, 0.0, 0.0});
}

/* ---- the survey ---- */

static void the_surveys_lambdas_are_not_its_formulas(void **state) {
  (void)state;
  static const struct {
    double lambda, table[3], right[3];
  } rows[] = {{0.5, {5.0, 25.0, 100.0}, {64.1, 133.0, 232.0}},
              {0.75, {3.0, 15.0, 75.0}, {33.5, 74.4, 160.5}},
              {0.9, {2.0, 10.0, 50.0}, {15.1, 39.3, 117.5}}};
  test_camera camera = plain_camera();
  camera.near = 0.5;
  camera.far = 500.0;
  csm_config config = default_config();
  config.shadow_distance = 500.0;
  for (int row = 0; row < 3; ++row) {
    config.split_lambda = rows[row].lambda;
    const plan_frame frame = plan_empty(&config, &camera, sun);
    for (int i = 0; i < 3; ++i) {
      const double share = (i + 1) / 4.0, uniform = 0.5 + 499.5 * share, logarithmic = 0.5 * pow(1000.0, share);
      const double formula = rows[row].lambda * logarithmic + (1.0 - rows[row].lambda) * uniform;
      assert_true(rows[row].table[i] < 0.5 * formula);
      assert_near(frame.cascades[i].info.far_depth, formula, 1e-6);
      assert_near(frame.cascades[i].info.far_depth, rows[row].right[i], 0.05);
    }
  }
}

/* The survey's: the translation of the light's view in floats, on texels of a map of so many metres. */
static double snapped_place(const double right[3], const double eye[3], float radius, const double point[3]) {
  const float texels_per_unit = 2048.0f / (2.0f * radius);
  const float translation = (float)-dot(right, eye);
  const float snapped = floorf(translation * texels_per_unit) / texels_per_unit;
  return (dot(right, point) + (double)snapped) * (double)texels_per_unit;
}

static double off_grid(double texels) {
  return fabs(texels - round(texels));
}

/* How far a still point leaves its place within a texel while the camera walks. */
static void walk(double world, double *documents, double *own, double *in_shader) {
  const csm_config config = default_config();
  const double still[3] = {world + 3.1, 1.0, -8.0};
  double first[3] = {0};
  *documents = *own = *in_shader = 0.0;
  for (int step = 0; step < 300; ++step) {
    test_camera camera = plain_camera();
    camera.eye[0] = world + 0.0137 * step;
    const plan_frame frame = plan_empty(&config, &camera, sun);
    const plan_cascade *cascade = &frame.cascades[0];
    csm_constants constants;
    (void)plan_write_constants((float *)&constants, &frame, &config);
    double at[3], relative = 0.0;
    transform_point(cascade->info.world_to_shadow, still, at);
    for (int k = 0; k < 3; ++k)
      relative += (double)constants.cascades.basis[0][k] * (still[k] - camera.eye[k]);
    const double clip = relative * (double)constants.cascades.scales[0][0] + (double)constants.cascades.offsets[0][0];
    const double places[3] = {snapped_place(frame.basis, camera.eye, (float)(cascade->info.texel_size * 1024.0), still),
                              at[0] * cascade->resolution, (0.5 * clip + 0.5) * cascade->resolution};
    double *const worst[3] = {documents, own, in_shader};
    for (int i = 0; i < 3; ++i) {
      first[i] = step ? first[i] : places[i];
      *worst[i] = fmax(*worst[i], off_grid(places[i] - first[i]));
    }
  }
}

static void the_surveys_snapping_is_lost_in_floats(void **state) {
  (void)state;
  assert_near((double)nextafterf(1e5f, INFINITY) - 1e5, 0.0078, 1e-4);
  assert_near((double)nextafterf(1e6f, INFINITY) - 1e6, 0.0625, 1e-6);
  double documents, own, in_shader;
  walk(0.0, &documents, &own, &in_shader);
  assert_true(documents < 0.01 && own < 0.01 && in_shader < 0.01);
  walk(1e6, &documents, &own, &in_shader);
  assert_true(documents > 0.3);
  assert_true(own < 0.01 && in_shader < 0.01);
}

/* And without a fixed radius it holds nothing, in doubles either: the grid grows and shrinks about the origin. */
static void the_surveys_snapping_needs_a_fixed_radius(void **state) {
  (void)state;
  csm_config box = default_config(), sphere = default_config();
  box.fit_mode = CSM_FIT_CASCADE;
  const double still[3] = {53.1, 1.0, -28.0};
  double worst[2] = {0.0, 0.0}, first[2] = {0.0, 0.0};
  for (int step = 0; step < 100; ++step) {
    test_camera camera = plain_camera();
    camera.eye[0] = 50.0;
    camera_look(&camera, (double[]){sin(step * 0.002), 0.0, -cos(step * 0.002)}, 0.0);
    for (int i = 0; i < 2; ++i) {
      const plan_frame frame = plan_empty(i ? &sphere : &box, &camera, sun);
      double at[3];
      transform_point(frame.cascades[1].info.world_to_shadow, still, at);
      first[i] = step ? first[i] : at[0] * frame.cascades[1].resolution;
      worst[i] = fmax(worst[i], off_grid(at[0] * frame.cascades[1].resolution - first[i]));
    }
  }
  assert_true(worst[0] > 0.3 && worst[1] < 1e-6);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(ogldevs_extents_stay_at_zero),
      cmocka_unit_test(ogldevs_vertical_field_of_view_is_too_low),
      cmocka_unit_test(ogldevs_near_plane_loses_casters),
      cmocka_unit_test(ogldevs_up_vector_fails_at_the_zenith),
      cmocka_unit_test(nvidias_up_vector_fails_along_x),
      cmocka_unit_test(the_surveys_lambdas_are_not_its_formulas),
      cmocka_unit_test(the_surveys_snapping_is_lost_in_floats),
      cmocka_unit_test(the_surveys_snapping_needs_a_fixed_radius),
  };
  return cmocka_run_group_tests_name("plan-documents", tests, NULL, NULL);
}
