/* The packed floats: they say what the plan says in doubles, to a float's precision, wherever the world is. */
#include "support.h"

#include "csm_constants.h"
#include "plan/internal.h"
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
    assert_int_equal(plan_made(&frame, &config, &(test_shot){view, projection, camera_reversed(&camera), light},
                               &scene.scene, scene.memory, &error),
                     CSM_SUCCESS);
    for (uint32_t c = 0; c < frame.cascade_count; ++c) {
      const plan_cascade *cascade = &frame.cascades[c];
      plan_write_window_matrices(matrices, &frame, c, &scene.scene);
      for (uint32_t k = 0; k < frame.windows[c].list.instance_count; ++k) {
        const uint32_t instance = frame.windows[c].list.instances[k];
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

/* A picture of one row takes its receivers to face the light, and one depth for the whole filter. */
static void one_row_knows_no_plane(void **state) {
  (void)state;
  const csm_config config = default_config();
  random_state random = {1};
  const test_camera planned = random_camera(&random, 10.0);
  const plan_frame frame = plan_empty(&config, &planned, (double[]){0.3, -1.0, 0.2});
  const uint32_t sizes[][2] = {{1, 1}, {16384, 1}, {1, 9}, {2, 2}};
  for (int i = 0; i < 4; ++i)
    for (int normals = 0; normals < 2; ++normals) {
      float m[CSM_M_COUNT * 4];
      plan_write_mask_constants(
          m, &frame,
          &(plan_picture){
              .camera = &frame.camera, .width = sizes[i][0], .height = sizes[i][1], .normals = normals == 1},
          &config);
      const bool thin = i < 3 && !normals;
      /* 0.5, and 10 of a slope that grows over the 2 texels of 3 x 3 */
      assert_true(m[CSM_M_BIAS * 4] == (thin ? 20.5f : 0.5f));
      const float *rows = &m[CSM_M_PLANES * 4];
      const bool flat = rows[0] == 0 && rows[1] == 0 && rows[4] == 0 && rows[5] == 0 && rows[10] == 1 && rows[11] == 0;
      assert_true(flat == thin);
    }
}

static void check_settings(const float *c, const plan_frame *frame, const csm_config *config) {
  const double reach = config->bias_mode ? 0.5 : config->filter == CSM_FILTER_PCF_3X3 ? 2.0 : 1.0;
  const float *bias = &c[CSM_S_BIAS * 4], *modes = &c[CSM_S_MODES * 4], *options = &c[CSM_S_OPTIONS * 4];
  assert_true(bias[0] == (float)config->bias_constant_texels);
  assert_true(bias[1] == (float)(config->bias_slope_texels * reach));
  assert_true(bias[2] == (float)config->bias_slope_max && bias[3] == (float)config->bias_normal_texels);
  const float *own = &c[CSM_S_OWN * 4];
  assert_true(own[0] == (float)fmax(config->bias_plane_max, config->bias_slope_max));
  assert_true(own[1] == (config->filter == CSM_FILTER_PCF_3X3 ? 2.0f : 1.0f));
  assert_true(modes[0] == (float)config->selection && modes[1] == (float)config->out_of_range);
  assert_true(modes[2] == (float)config->blend_mode && modes[3] == (float)config->normal_offset_mode);
  assert_true(options[0] == (float)config->bias_mode && options[1] == (float)config->filter_early_out);
  assert_true(options[2] == (config->map_reversed ? -1.0f : 1.0f) &&
              options[3] == (config->map_reversed ? 0.0f : 1.0f));
  assert_true(c[CSM_S_BAND * 4 + 3] == (float)frame->cascades[0].info.near_depth);
}

/* A point of a cascade's slice, by the plan's matrix and by the constants in floats. */
static void check_point(const float *c, const plan_frame *frame, uint32_t cascade, const double point[3],
                        double world) {
  const csm_cascade_info *info = &frame->cascades[cascade].info;
  double relative[3], shadow[3];
  for (int axis = 0; axis < 3; ++axis)
    relative[axis] = point[axis] - frame->camera.position[axis];
  transform_point(info->world_to_shadow, point, shadow);
  const double expected[3] = {2.0 * shadow[0] - 1.0, 1.0 - 2.0 * shadow[1], shadow[2]};
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const float *row = &c[(CSM_C_BASIS + axis) * 4];
    const double scale = (double)c[(CSM_C_SCALES + cascade) * 4 + axis];
    const double offset = (double)c[(CSM_C_OFFSETS + cascade) * 4 + axis];
    const double light = row_times(row, relative), size = axis == 2 ? info->depth_range : info->texel_size * 16.0;
    const double rounding = 2.0 * row_rounding(row, relative) * fabs(scale) + fabs(offset) * 0x1p-24;
    assert_near(light * scale + offset, expected[axis], rounding + 1e-15 * (16.0 + 32.0 * world / size));
  }
}

static void check_cascades(const float *c, const plan_frame *frame, const csm_config *config, const test_camera *camera,
                           random_state *random, double world) {
  const uint32_t count = frame->cascade_count;
  const float *params = &c[CSM_C_PARAMS * 4], *depth_row = &c[CSM_C_DEPTH * 4];
  assert_true(params[0] == (float)count && params[1] == (float)frame->cascades[count - 1].info.far_depth);
  for (uint32_t axis = 0; axis < 9; ++axis)
    assert_true(c[(CSM_C_BASIS + axis / 3) * 4 + axis % 3] == (float)frame->basis[axis]);
  for (uint32_t k = 0; k < CSM_MAX_CASCADES; ++k) {
    const plan_cascade *cascade = &frame->cascades[k < count ? k : count - 1];
    const csm_cascade_info *info = &cascade->info;
    const float *texel = &c[(CSM_C_TEXELS + k) * 4];
    assert_true(c[CSM_C_SPLITS * 4 + k] == (float)info->far_depth);
    assert_true(texel[0] == (float)info->texel_size && texel[1] == (float)(1.0 / info->depth_range));
    assert_near(texel[2], 1.0 - 2.0 * plan_filter_radius_texels(config) / cascade->resolution, 1e-7);
    assert_true(texel[3] == (float)(cascade->texel[0] * cascade->texel[1]));
    double point[3], relative[3];
    const double x = random_between(random, -1.0, 1.0), y = random_between(random, -1.0, 1.0);
    const double depth = random_between(random, info->near_depth, info->far_depth);
    camera_point(camera, x, y, depth, point);
    for (int axis = 0; axis < 3; ++axis)
      relative[axis] = point[axis] - frame->camera.position[axis];
    assert_near(row_times(depth_row, relative), depth,
                row_rounding(depth_row, relative) + 1e-14 * (world + fabs(depth)));
    if (k < count)
      check_point(c, frame, k, point, world);
    else
      assert_true(c[(CSM_C_SCALES + k) * 4] == 0.0f && c[(CSM_C_OFFSETS + k) * 4] > 1.0f);
  }
}

static void constants_agree_with_the_plan(void **state) {
  (void)state;
  random_state random = {2};
  for (int i = 0; i < 2000; ++i) {
    const double world = i % 2 ? 1e7 : 10.0;
    const test_camera camera = random_camera(&random, world);
    const csm_config config = random_config(&random);
    double direction[3];
    random_unit(&random, direction);
    const plan_frame frame = plan_empty(&config, &camera, direction);
    float c[CSM_C_COUNT * 4];
    assert_int_equal(plan_write_constants(c, &frame, &config), sizeof c);
    check_settings(c, &frame, &config);
    check_cascades(c, &frame, &config, &camera, &random, world);
  }
}

enum { pixels_wide = 640, pixels_high = 360 };

/* A random camera near the planned one, and the mask's constants for it. */
typedef struct mask_case {
  plan_frame frame;
  test_camera camera;
  plan_camera made;
  double projection[16];
  float m[CSM_M_COUNT * 4];
} mask_case;

static void make_mask_case(mask_case *c, random_state *random, double world, bool flipped) {
  const test_camera planned = random_camera(random, world);
  const csm_config config = default_config();
  c->camera = random_camera(random, 0.0);
  for (int k = 0; k < 3 && flipped; ++k)
    c->camera.right[k] = -c->camera.right[k];
  c->frame = plan_empty(&config, &planned, (double[]){0.3, -1.0, 0.2});
  for (int k = 0; k < 3; ++k)
    c->camera.eye[k] = c->frame.camera.position[k] + random_between(random, -3.0, 3.0);
  double view[16];
  const char *error = "";
  camera_matrices(&c->camera, view, c->projection);
  assert_int_equal(plan_camera_make(&c->made, view, c->projection, camera_reversed(&c->camera), &error), CSM_SUCCESS);
  const plan_picture picture = {
      .camera = &c->made, .width = pixels_wide, .height = pixels_high, .show = CSM_SHOW_DENSITY, .unorm_normals = true};
  assert_int_equal(plan_write_mask_constants(c->m, &c->frame, &picture, &config), sizeof c->m);
}

/* What a point of the world, at a place of the image and a view depth, is to the mask: x, y, depth. */
static void pixel_of(const mask_case *c, double x, double y, double depth, double point[3], double pixel[3]) {
  const double w = c->camera.orthographic ? 1.0 : depth, side = c->camera.left_handed ? 1.0 : -1.0;
  camera_point(&c->camera, x, y, depth, point);
  pixel[0] = (x + 1.0) * 0.5 * pixels_wide;
  pixel[1] = (1.0 - y) * 0.5 * pixels_high;
  pixel[2] = (c->projection[10] * side * depth + c->projection[14]) / w;
}

static void check_mask_point(const mask_case *c, random_state *random, double world) {
  const double range = fmin(c->camera.far, 100.0 + c->camera.near) - c->camera.near;
  const double depth = c->camera.near + range * random_between(random, 0.0, 1.0);
  double pixel[3], point[3], relative[3];
  pixel_of(c, random_between(random, -1.0, 1.0), random_between(random, -1.0, 1.0), depth, point, pixel);
  const float *rows = &c->m[CSM_M_LIGHT * 4];
  const double back = row_times(&rows[12], pixel), back_error = row_rounding(&rows[12], pixel);
  assert_true(back_error < back || c->camera.far > 1e6 * c->camera.near);
  if (back_error > 1e-3 * back)
    return; /* floats cannot hold this depth */
  for (int k = 0; k < 3; ++k)
    relative[k] = point[k] - c->frame.camera.position[k];
  for (int axis = 0; axis < 3; ++axis) {
    const double *a = &c->frame.basis[axis * 3];
    const double value = row_times(&rows[axis * 4], pixel) / back;
    const double expected = a[0] * relative[0] + a[1] * relative[1] + a[2] * relative[2];
    const double lost = row_rounding(&rows[axis * 4], pixel) + (fabs(value) + 1.0) * back_error;
    assert_near(value, expected, 2.0 * lost / back + 3e-14 * world);
  }
}

/* Pixels of any camera lead back to the world, relative to the plan's camera. */
static void mask_constants_lead_back_to_the_world(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 5000; ++i) {
    const double world = i % 2 ? 1e7 : 10.0;
    mask_case c;
    make_mask_case(&c, &random, world, i % 7 == 0);
    assert_true(c.m[CSM_M_CLEAR * 4] == (c.camera.reversed ? 0.0f : 1.0f));
    assert_true(c.m[CSM_M_CLEAR * 4 + 1] == CSM_SHOW_DENSITY);
    assert_true(c.m[CSM_M_SIZE * 4] == pixels_wide && c.m[CSM_M_SIZE * 4 + 1] == pixels_high);
    assert_true(c.m[CSM_M_SIZE * 4 + 2] == 1.0f / pixels_wide && c.m[CSM_M_SIZE * 4 + 3] == 1.0f / pixels_high);
    /* 8 bits hold -1 to 1 as 0 to 1 */
    for (int axis = 0; axis < 3; ++axis) {
      const double *a = &c.frame.basis[axis * 3], texel[3] = {0.5 + 0.5 * a[0], 0.5 + 0.5 * a[1], 0.5 + 0.5 * a[2]};
      assert_near(row_times(&c.m[(CSM_M_NORMALS + axis) * 4], texel), 1.0, 1e-6);
    }
    check_mask_point(&c, &random, world);
  }
}

/* A plane through three points of the screen has the normal that they have in the world, on the viewer's side. */
static void planes_on_screen_lead_back_to_normals(void **state) {
  (void)state;
  random_state random = {6};
  uint32_t checked = 0;
  for (int i = 0; i < 5000; ++i) {
    mask_case c;
    make_mask_case(&c, &random, i % 2 ? 1e7 : 10.0, i % 7 == 0);
    double points[3][3], pixels[3][3], sides[2][3], normal[3], light[3] = {0};
    const double depth = c.camera.near + 5.0;
    if (c.camera.far < depth + 2.0 || c.camera.near < 0.01 * depth)
      continue; /* floats of the depth say too little there */
    for (int p = 0; p < 3; ++p)
      pixel_of(&c, p == 1 ? 0.3 : -0.1, p == 2 ? 0.4 : -0.2, depth + random_between(&random, -1.0, 1.0), points[p],
               pixels[p]);
    for (int p = 0; p < 2; ++p)
      for (int k = 0; k < 3; ++k)
        sides[p][k] = points[p + 1][k] - points[0][k];
    plan_cross(normal, sides[0], sides[1]);
    assert_true(plan_normalize(normal));
    const double steps[2] = {(pixels[1][2] - pixels[0][2]) / (pixels[1][0] - pixels[0][0]),
                             (pixels[2][2] - pixels[0][2]) / (pixels[2][1] - pixels[0][1])};
    const double origin = pixels[0][2] - steps[0] * pixels[0][0] - steps[1] * pixels[0][1];
    for (int axis = 0; axis < 3; ++axis) {
      const float *row = &c.m[(CSM_M_PLANES + axis) * 4];
      light[axis] = steps[0] * (double)row[0] + steps[1] * (double)row[1] + origin * (double)row[3] - (double)row[2];
    }
    assert_true(plan_normalize(light));
    double world[3], cosine = 0.0, to_viewer = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double *b = c.frame.basis;
      world[k] = light[0] * b[k] + light[1] * b[3 + k] + light[2] * b[6 + k];
      cosine += world[k] * normal[k];
      to_viewer += world[k] * (c.camera.orthographic ? -c.camera.forward[k] : c.camera.eye[k] - points[0][k]);
    }
    assert_near(fabs(cosine), 1.0, 1e-4);
    assert_true(to_viewer > 0.0);
    ++checked;
  }
  assert_true(checked > 1000);
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
    plan_view_make(&list, &made, &scene.scene, NULL, scene.memory);
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
  assert_int_equal(plan_made(&frame, &in->config,
                             &(test_shot){view, projection, camera_reversed(&in->camera), in->light}, &scene->scene,
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
      cmocka_unit_test(planes_on_screen_lead_back_to_normals),
      cmocka_unit_test(view_matrices_agree_with_the_camera),
      cmocka_unit_test(hash_tells_plans_apart),
      cmocka_unit_test(one_row_knows_no_plane),
  };
  return cmocka_run_group_tests_name("plan-write", tests, NULL, NULL);
}
