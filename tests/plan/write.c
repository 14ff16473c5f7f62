/* The packed floats: they say what the plan says in doubles, to a float's precision, wherever the world is. */
#include "support.h"

#include "csm_constants.h"
#include <math.h>
#include <string.h>

enum { instances = 60, meshes = 5 };

static double row_times(const float row[4], const double p[3]) {
  return (double)row[0] * p[0] + (double)row[1] * p[1] + (double)row[2] * p[2] + (double)row[3];
}

/* What rounding a row's four entries to floats may change in its product. */
static double row_rounding(const float row[4], const double p[3]) {
  double sum = fabs((double)row[3]);
  for (int k = 0; k < 3; ++k)
    sum += fabs((double)row[k] * p[k]);
  return sum * 0x1p-24 + 1e-30;
}

/* Object to clip, and world to shadow, lead to the same place of the map. */
static void cascade_matrices_agree_with_world_to_shadow(void **state) {
  (void)state;
  random_state random = {1};
  test_scene scene = scene_make(instances, meshes);
  float matrices[instances * 12];
  for (int i = 0; i < 200; ++i) {
    const double world = i % 2 ? 1e7 : 10.0;
    const test_camera camera = random_camera(&random, world);
    const csm_config config = random_config(&random);
    double view[16], projection[16], light[3];
    const char *error = "";
    random_unit(&random, light);
    camera_matrices(&camera, view, projection);
    scene_scatter(&scene, &random, camera.eye, 20.0);
    plan_frame frame;
    assert_int_equal(plan_made(&frame, &config, view, projection, camera_reversed(&camera), light, &scene.scene,
                               scene.memory, &error),
                     CSM_SUCCESS);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const plan_cascade *cascade = &frame.cascades[c];
      plan_write_cascade_matrices(matrices, &frame, c, &scene.scene);
      for (uint32_t k = 0; k < cascade->list.instance_count; ++k) {
        const uint32_t instance = cascade->list.instances[k];
        const plan_bounds *bounds = &scene.meshes[scene.instances[instance].mesh];
        double at[3], object[3], point[3], shadow[3];
        for (int axis = 0; axis < 3; ++axis) {
          at[axis] = random_between(&random, -1.0, 1.0);
          object[axis] = bounds->center[axis] + at[axis] * bounds->extent[axis];
        }
        instance_point(&scene.scene, instance, at, point);
        transform_point(cascade->info.world_to_shadow, point, shadow);
        const double expected[3] = {2.0 * shadow[0] - 1.0, 1.0 - 2.0 * shadow[1], shadow[2]};
        const double sizes[3] = {cascade->info.texel_size * config.resolution / 2.0,
                                 cascade->info.texel_size * config.resolution / 2.0, cascade->info.depth_range};
        for (int row = 0; row < 3; ++row) {
          const float *m = &matrices[k * 12 + (uint32_t)row * 4];
          assert_near(row_times(m, object), expected[row],
                      row_rounding(m, object) + 1e-15 * (16.0 + 16.0 * world / sizes[row]));
        }
      }
    }
  }
  scene_free(&scene);
}

static void constants_agree_with_the_plan(void **state) {
  (void)state;
  random_state random = {2};
  for (int i = 0; i < 2000; ++i) {
    const double world = i % 2 ? 1e7 : 10.0;
    const test_camera camera = random_camera(&random, world);
    const csm_config config = random_config(&random);
    double light[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    float c[CSM_C_COUNT * 4];
    assert_int_equal(plan_write_constants(c, &frame, &config), sizeof c);
    const uint32_t count = frame.cascade_count;
    const double reach = config.bias_mode ? 0.5 : config.filter == CSM_FILTER_PCF_3X3 ? 2.0 : 1.0;
    assert_true(c[CSM_C_PARAMS * 4] == (float)count && c[CSM_C_PARAMS * 4 + 1] == (float)config.resolution);
    assert_true(c[CSM_C_PARAMS * 4 + 2] == (float)(1.0 / config.resolution));
    assert_true(c[CSM_C_PARAMS * 4 + 3] == (float)frame.cascades[count - 1].info.far_depth);
    assert_true(c[CSM_C_FILTER * 4 + 3] == (config.filter == CSM_FILTER_PCF_3X3 ? 3.0f : 1.0f));
    assert_true(c[CSM_C_BIAS * 4] == (float)config.bias_constant_texels);
    assert_true(c[CSM_C_BIAS * 4 + 3] == (float)config.bias_normal_texels);
    for (uint32_t axis = 0; axis < 9; ++axis)
      assert_true(c[(CSM_C_BASIS + axis / 3) * 4 + axis % 3] == (float)frame.basis[axis]);
    for (uint32_t k = 0; k < CSM_MAX_CASCADES; ++k) {
      const csm_cascade_info *info = &frame.cascades[k < count ? k : count - 1].info;
      const float *texel = &c[(CSM_C_TEXELS + k) * 4];
      assert_true(c[CSM_C_SPLITS * 4 + k] == (float)info->far_depth);
      assert_true(texel[0] == (float)info->texel_size && texel[1] == (float)(1.0 / info->depth_range));
      assert_true(texel[2] == (float)(reach * info->texel_size));
      double point[3], relative[3], shadow[3];
      const double x = random_between(&random, -1.0, 1.0), y = random_between(&random, -1.0, 1.0);
      const double depth = random_between(&random, info->near_depth, info->far_depth);
      camera_point(&camera, x, y, depth, point);
      for (int axis = 0; axis < 3; ++axis)
        relative[axis] = point[axis] - frame.camera.position[axis];
      const float *row = &c[CSM_C_DEPTH * 4];
      assert_near(row_times(row, relative), depth, row_rounding(row, relative) + 1e-14 * (world + fabs(depth)));
      transform_point(info->world_to_shadow, point, shadow);
      for (int axis = 0; axis < 3; ++axis) {
        row = &c[(CSM_C_MATRICES + k * 3 + (uint32_t)axis) * 4];
        const double size = axis == 2 ? info->depth_range : info->texel_size * config.resolution;
        assert_near(row_times(row, relative), shadow[axis],
                    row_rounding(row, relative) + 1e-15 * (16.0 + 16.0 * world / size));
      }
    }
  }
}

static void image_basis(const test_camera *camera, double *handedness) {
  const double *a = camera->right, *b = camera->up, *f = camera->forward;
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    sum += (a[j] * b[k] - a[k] * b[j]) * -f[i];
  }
  *handedness = sum < 0.0 ? -1.0 : 1.0;
}

/* Clip space of any camera leads back to the world, relative to the plan's camera. */
static void mask_constants_lead_back_to_the_world(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 5000; ++i) {
    const double world = i % 2 ? 1e7 : 10.0;
    const test_camera planned = random_camera(&random, world);
    test_camera camera = random_camera(&random, 0.0);
    if (i % 7 == 0)
      for (int k = 0; k < 3; ++k)
        camera.right[k] = -camera.right[k];
    const csm_config config = default_config();
    const plan_frame frame = plan_empty(&config, &planned, (double[]){0.3, -1.0, 0.2});
    for (int k = 0; k < 3; ++k)
      camera.eye[k] = frame.camera.position[k] + random_between(&random, -3.0, 3.0);
    double view[16], projection[16], handedness;
    camera_matrices(&camera, view, projection);
    plan_camera made;
    const char *error = "";
    assert_int_equal(plan_camera_make(&made, view, projection, camera_reversed(&camera), &error), CSM_SUCCESS);
    float m[CSM_M_COUNT * 4];
    assert_int_equal(plan_write_mask_constants(m, &frame, &made, 640, 360, false, CSM_VIEW_DENSITY), sizeof m);
    assert_true(m[CSM_M_VIEW * 4] == CSM_VIEW_DENSITY);
    image_basis(&camera, &handedness);
    assert_true(m[CSM_M_CLEAR * 4] == (camera.reversed ? 0.0f : 1.0f));
    assert_true(m[CSM_M_CLEAR * 4 + 1] == (float)handedness);
    assert_true(m[CSM_M_SIZE * 4] == 640.0f && m[CSM_M_SIZE * 4 + 1] == 360.0f);
    assert_true(m[CSM_M_SIZE * 4 + 2] == 1.0f / 640.0f && m[CSM_M_SIZE * 4 + 3] == 1.0f / 360.0f);

    const double depth =
        camera.near + (fmin(camera.far, 100.0 + camera.near) - camera.near) * random_between(&random, 0.0, 1.0);
    double clip[3] = {random_between(&random, -1.0, 1.0), random_between(&random, -1.0, 1.0), 0.0}, point[3];
    camera_point(&camera, clip[0], clip[1], depth, point);
    const double w = camera.orthographic ? 1.0 : depth, side = camera.left_handed ? 1.0 : -1.0;
    clip[2] = (projection[10] * side * depth + projection[14]) / w;
    const float *rows = &m[CSM_M_INVERSE * 4];
    const double back = row_times(&rows[12], clip), back_error = row_rounding(&rows[12], clip);
    assert_true(back_error < back || camera.far > 1e6 * camera.near);
    if (back_error > 1e-3 * back)
      continue; /* floats cannot hold this depth */
    for (int axis = 0; axis < 3; ++axis) {
      const double value = row_times(&rows[axis * 4], clip) / back,
                   relative = point[axis] - frame.camera.position[axis];
      const double lost = row_rounding(&rows[axis * 4], clip) + (fabs(value) + 1.0) * back_error;
      assert_near(value, relative, 2.0 * lost / back + 1e-14 * world);
    }
  }
}

static void view_matrices_agree_with_the_camera(void **state) {
  (void)state;
  random_state random = {4};
  test_scene scene = scene_make(instances, meshes);
  float matrices[instances * 16];
  for (int i = 0; i < 300; ++i) {
    const double world = i % 2 ? 1e7 : 10.0;
    const test_camera camera = random_camera(&random, world);
    double view[16], projection[16];
    camera_matrices(&camera, view, projection);
    scene_scatter(&scene, &random, camera.eye, 20.0);
    plan_camera made;
    plan_list list;
    const char *error = "";
    assert_int_equal(plan_camera_make(&made, view, projection, camera_reversed(&camera), &error), CSM_SUCCESS);
    plan_view_make(&list, &made, &scene.scene, scene.memory);
    plan_write_view_matrices(matrices, &list, &made, &scene.scene);
    for (uint32_t k = 0; k < list.instance_count; ++k) {
      const plan_bounds *bounds = &scene.meshes[scene.instances[list.instances[k]].mesh];
      double at[3], object[3], point[3], seen[4];
      for (int axis = 0; axis < 3; ++axis) {
        at[axis] = random_between(&random, -1.0, 1.0);
        object[axis] = bounds->center[axis] + at[axis] * bounds->extent[axis];
      }
      instance_point(&scene.scene, list.instances[k], at, point);
      transform_point(view, point, seen);
      seen[3] = 1.0;
      for (int row = 0; row < 4; ++row) {
        double expected = 0.0, scale = 0.0;
        for (int j = 0; j < 4; ++j) {
          expected += projection[j * 4 + row] * seen[j];
          scale += fabs(projection[j * 4 + row]);
        }
        const float *m = &matrices[k * 16 + (uint32_t)row * 4];
        assert_near(row_times(m, object), expected, row_rounding(m, object) + 1e-14 * scale * (world + 100.0));
      }
    }
  }
  scene_free(&scene);
}

typedef struct hashed {
  csm_config config;
  test_camera camera;
  double light[3];
} hashed;

static uint64_t hash_of(const hashed *in, const test_scene *scene) {
  double view[16], projection[16];
  const char *error = "";
  plan_frame frame;
  camera_matrices(&in->camera, view, projection);
  assert_int_equal(plan_made(&frame, &in->config, view, projection, camera_reversed(&camera), in->light, &scene->scene,
                             scene->memory, &error),
                   CSM_SUCCESS);
  return plan_hash(&frame, &in->config, &scene->scene);
}

static void hash_tells_plans_apart(void **state) {
  (void)state;
  random_state random = {5};
  test_scene scene = scene_make(instances, meshes);
  scene_scatter(&scene, &random, (double[]){0.0, 0.0, -10.0}, 5.0);
  scene.instances[1] = scene.instances[0];
  const hashed base = {.config = default_config(), .camera = plain_camera(), .light = {0.3, -1.0, 0.2}};
  const uint64_t hash = hash_of(&base, &scene);
  assert_true(hash_of(&base, &scene) == hash);

  hashed other = base;
  other.light[0] += 1e-6;
  assert_false(hash_of(&other, &scene) == hash);
  other = base;
  other.config.bias_constant_texels = 0.2;
  assert_false(hash_of(&other, &scene) == hash);
  other = base;
  other.config.split_lambda = 0.7;
  assert_false(hash_of(&other, &scene) == hash);
  other = base;
  other.camera.eye[1] = 1e-6;
  assert_false(hash_of(&other, &scene) == hash);

  /* Signs, the top bits of words, do not cancel each other */
  for (int i = 0; i < 2; ++i)
    for (int row = 0; row < 3; ++row)
      scene.instances[i].transform[row * 4 + 1] *= -1.0;
  assert_false(hash_of(&base, &scene) == hash);
  for (int i = 0; i < 2; ++i)
    for (int row = 0; row < 3; ++row)
      scene.instances[i].transform[row * 4 + 1] *= -1.0;
  assert_true(hash_of(&base, &scene) == hash);

  scene.instances[instances / 2].transform[3] += 1e-3;
  const uint64_t moved = hash_of(&base, &scene);
  assert_false(moved == hash);
  scene.instances[instances / 2].mesh = (scene.instances[instances / 2].mesh + 1) % meshes;
  assert_false(hash_of(&base, &scene) == moved);
  scene_free(&scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cascade_matrices_agree_with_world_to_shadow),
      cmocka_unit_test(constants_agree_with_the_plan),
      cmocka_unit_test(mask_constants_lead_back_to_the_world),
      cmocka_unit_test(view_matrices_agree_with_the_camera),
      cmocka_unit_test(hash_tells_plans_apart),
  };
  return cmocka_run_group_tests_name("plan-write", tests, NULL, NULL);
}
