/* Whatever numbers come in, what comes out is finite, or an error with a name and a text. */
#include "support.h"

#include "csm_constants.h"
#include <fenv.h>
#include <math.h>
#include <string.h>

enum { instances = 12, meshes = 3 };

static double from_bits(uint64_t bits) {
  double value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* A number that hurts: any bits, a special one, or the old one at another scale. */
static double odd_number(random_state *random, double old) {
  const double special[] = {0.0,   -0.0,   1.0,    -1.0,   NAN,     INFINITY, -INFINITY,
                            1e300, -1e300, 5e-324, 1e-310, 1.7e308, 1e16,     -1e-16};
  switch (random_below(random, 4)) {
  case 0:
    return from_bits(random_bits(random));
  case 1:
    return special[random_below(random, sizeof special / sizeof *special)];
  case 2:
    return old * random_scale(random, 1e-300, 1e300);
  default:
    return old + random_scale(random, 1e-12, 10.0);
  }
}

static void disturb(random_state *random, double *values, uint32_t count) {
  for (uint32_t changes = random_below(random, 4); changes; --changes) {
    const uint32_t i = random_below(random, count);
    values[i] = odd_number(random, values[i]);
  }
  if (random_below(random, 8) == 0) {
    const double scale = random_scale(random, 1e-300, 1e300);
    for (uint32_t i = 0; i < count; ++i)
      values[i] *= scale;
  }
}

static void assert_finite(const float *values, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i)
    assert_true(isfinite(values[i]));
}

static void check_cascades(const plan_frame *frame) {
  double last = frame->unshadowed ? frame->cascades[0].info.near_depth : frame->camera.near_depth;
  for (uint32_t c = 0; c < frame->cascade_count; ++c) {
    const csm_cascade_info *info = &frame->cascades[c].info;
    assert_true(isfinite(info->far_depth) && info->near_depth == last && info->far_depth > last);
    assert_true(isfinite(info->texel_size) && info->texel_size > 0.0);
    assert_true(isfinite(info->depth_range) && info->depth_range > 0.0);
    assert_true(plan_finite(info->world_to_shadow, 16) && plan_finite(frame->cascades[c].to_clip, 12));
    assert_int_equal(frame->windows[c].list.instance_count + frame->windows[c].list.culled, instances);
    assert_true(!frame->unshadowed || frame->windows[c].list.instance_count == 0);
    last = info->far_depth;
  }
}

static void check_frame(const plan_frame *frame, const csm_config *config, const test_scene *scene) {
  float floats[CSM_C_COUNT * 4 > instances * 16 ? CSM_C_COUNT * 4 : instances * 16];
  feclearexcept(FE_ALL_EXCEPT);
  check_cascades(frame);
  for (uint32_t c = 0; c < frame->cascade_count; ++c) {
    double matrix[16], planes[5][4];
    plan_write_window_matrices(floats, frame, c, &scene->scene);
    assert_finite(floats, frame->windows[c].list.instance_count * 12);
    plan_cascade_volume(frame, c, matrix, planes);
    assert_true(plan_finite(matrix, 16) && plan_finite(planes[0], 20));
  }
  assert_finite(floats, plan_write_constants(floats, frame, config) / (uint32_t)sizeof(float));
  const plan_picture picture = {.camera = &frame->camera, .width = 1, .height = 16384, .unorm_normals = true};
  assert_finite(floats, plan_write_mask_constants(floats, frame, &picture, config) / (uint32_t)sizeof(float));
  plan_hash(frame, config, &scene->scene);
  plan_list list;
  plan_view_make(&list, &frame->camera, &scene->scene, NULL, scene->memory);
  plan_write_view_matrices(floats, &list, &frame->camera, &scene->scene);
  assert_finite(floats, list.instance_count * 16);
  assert_no_exceptions();
}

static bool is_named(csm_result result) {
  return result == CSM_ERROR_NOT_FINITE || result == CSM_ERROR_INVALID_MATRIX || result == CSM_ERROR_INVALID_CAMERA ||
         result == CSM_ERROR_INVALID_LIGHT;
}

/* Transforms of any numbers, where plan_instance_check lets them through. */
static void disturb_scene(random_state *random, test_scene *scene) {
  for (uint32_t i = 0; i < instances; ++i) {
    plan_instance odd = scene->instances[i];
    disturb(random, odd.transform, 12);
    feclearexcept(FE_ALL_EXCEPT);
    const csm_result result = plan_instance_check(&odd);
    assert_no_exceptions();
    if (result)
      assert_true(result == CSM_ERROR_NOT_FINITE || result == CSM_ERROR_INVALID_MATRIX);
    else
      scene->instances[i] = odd;
  }
  for (uint32_t i = 0; i < meshes; ++i)
    for (int k = 0; k < 3; ++k)
      if (random_below(random, 20) == 0)
        scene->meshes[i].extent[k] = random_scale(random, 1e-38, 1e38);
  scene_place(scene);
}

static void any_frame_is_finite_or_has_a_named_error(void **state) {
  (void)state;
  random_state random = {1};
  test_scene scene = scene_make(instances, meshes);
  uint32_t planned = 0, refused = 0;
  for (int i = 0; i < 30000; ++i) {
    const test_camera camera = random_camera(&random, random_scale(&random, 1.0, 1e9));
    csm_config config = random_config(&random);
    double view[16], projection[16], light[3];
    const char *error = "";
    camera_matrices(&camera, view, projection);
    random_unit(&random, light);
    scene_scatter(&scene, &random, camera.eye, 50.0);
    disturb_scene(&random, &scene);
    if (random_below(&random, 2))
      disturb(&random, view, 16);
    if (random_below(&random, 2))
      disturb(&random, projection, 16);
    if (random_below(&random, 2))
      disturb(&random, light, 3);
    config.shadow_distance = fmin(fmax(random_scale(&random, 1e-4, 1e10), 1e-3), 1e9);
    config.depth_mode = random_below(&random, CSM_DEPTH_SCENE_CLIPPED + 1);
    config.fit_mode = random_below(&random, CSM_FIT_SCENE_SQUARE + 1);
    config.caster_set = random_below(&random, CSM_CASTER_SET_VIEW + 1);
    plan_frame frame;
    const csm_result result =
        plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light}, &scene.scene,
                  scene.memory, &error);
    if (result == CSM_SUCCESS) {
      check_frame(&frame, &config, &scene);
      ++planned;
    } else {
      assert_true(is_named(result) && error[0]);
      ++refused;
    }
  }
  assert_true(planned > 5000 && refused > 5000);
  scene_free(&scene);
}

static void any_configuration_is_planned_or_has_a_named_error(void **state) {
  (void)state;
  random_state random = {2};
  const test_camera camera = plain_camera();
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  const plan_scene nothing = {0};
  uint32_t planned = 0, refused = 0;
  for (int i = 0; i < 30000; ++i) {
    csm_config config = random_config(&random);
    const char *error = "";
    for (uint32_t changes = random_below(&random, 3); changes; --changes) {
      uint32_t index = 0;
      for (index = random_below(&random, 60); !plan_config_field(index); --index)
        ;
      const csm_config_field *field = plan_config_field(index);
      char *at = (char *)&config + field->offset;
      if (field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES)
        *(double *)(void *)at = odd_number(&random, *(double *)(void *)at);
      else
        *(uint32_t *)(void *)at = (uint32_t)random_bits(&random);
    }
    feclearexcept(FE_ALL_EXCEPT);
    csm_result result = plan_config_check(&config, &error);
    assert_no_exceptions();
    if (result) {
      assert_true((result == CSM_ERROR_NOT_FINITE || result == CSM_ERROR_INVALID_VALUE) && error[0]);
      ++refused;
      continue;
    }
    plan_frame frame;
    result =
        plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), (double[]){0.1, -1.0, 0.0}},
                  &nothing, NULL, &error);
    assert_true(result == CSM_SUCCESS || (is_named(result) && error[0]));
    for (uint32_t c = 0; !result && c < frame.cascade_count; ++c)
      assert_true(plan_finite(frame.cascades[c].info.world_to_shadow, 16));
    float constants[CSM_C_COUNT * 4];
    if (!result)
      assert_finite(constants, plan_write_constants(constants, &frame, &config) / (uint32_t)sizeof(float));
    assert_no_exceptions();
    ++planned;
  }
  assert_true(planned > 5000 && refused > 500);
}

static void any_matrix_is_inverted_finitely_or_not_at_all(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 200000; ++i) {
    double m[16], inverse[16];
    for (int k = 0; k < 16; ++k)
      m[k] = i % 2 ? odd_number(&random, k % 5 == 0) : random_between(&random, -1.0, 1.0);
    disturb(&random, m, 16);
    feclearexcept(FE_ALL_EXCEPT);
    if (plan_invert(inverse, m))
      assert_true(plan_finite(inverse, 16));
    const csm_result result = plan_check_affine(m);
    assert_no_exceptions();
    assert_true(result == CSM_SUCCESS || result == CSM_ERROR_NOT_FINITE || result == CSM_ERROR_INVALID_MATRIX);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(any_frame_is_finite_or_has_a_named_error),
      cmocka_unit_test(any_configuration_is_planned_or_has_a_named_error),
      cmocka_unit_test(any_matrix_is_inverted_finitely_or_not_at_all),
  };
  return cmocka_run_group_tests_name("plan-fuzz", tests, NULL, NULL);
}
