#include "support.h"

#include <fenv.h>
#include <math.h>
#include <stdlib.h>

/* splitmix64 */
uint64_t random_bits(random_state *random) {
  uint64_t z = random->value += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

double random_between(random_state *random, double low, double high) {
  return low + (high - low) * ((double)(random_bits(random) >> 11) * 0x1p-53);
}

double random_scale(random_state *random, double low, double high) {
  return exp(random_between(random, log(low), log(high)));
}

uint32_t random_below(random_state *random, uint32_t count) {
  return (uint32_t)(random_bits(random) % count);
}

void random_unit(random_state *random, double out[3]) {
  const double z = random_between(random, -1.0, 1.0), angle = random_between(random, 0.0, 2.0 * M_PI);
  const double r = sqrt(1.0 - z * z);
  out[0] = r * cos(angle);
  out[1] = r * sin(angle);
  out[2] = z;
}

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3]) {
  for (int i = 0; i < 3; ++i)
    out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

void camera_look(test_camera *camera, const double forward[3], double roll) {
  double least[3] = {0}, side[3], up[3];
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (fabs(forward[i]) < fabs(forward[axis]))
      axis = i;
  least[axis] = 1.0;
  cross(side, forward, least);
  const double length = sqrt(dot(side, side));
  for (int i = 0; i < 3; ++i)
    side[i] /= length;
  cross(up, side, forward);
  for (int i = 0; i < 3; ++i) {
    camera->forward[i] = forward[i];
    camera->right[i] = cos(roll) * side[i] + sin(roll) * up[i];
    camera->up[i] = cos(roll) * up[i] - sin(roll) * side[i];
  }
}

test_camera plain_camera(void) {
  const double half = tan(M_PI / 6.0);
  return (test_camera){.right = {1, 0, 0},
                       .up = {0, 1, 0},
                       .forward = {0, 0, -1},
                       .half_width = half * 16.0 / 9.0,
                       .half_height = half,
                       .near = 0.1,
                       .far = 1000.0};
}

test_camera random_camera(random_state *random, double world) {
  test_camera camera = {.orthographic = random_below(random, 4) == 0,
                        .reversed = random_below(random, 2),
                        .left_handed = random_below(random, 2),
                        .mirrored = random_below(random, 4) == 0};
  double forward[3];
  random_unit(random, forward);
  camera_look(&camera, forward, random_between(random, 0.0, 2.0 * M_PI));
  const double degree = M_PI / 180.0, aspect = random_scale(random, 0.3, 3.0);
  camera.half_height =
      camera.orthographic ? random_scale(random, 1.0, 500.0) : tan(random_scale(random, 0.25, 80.0) * degree);
  camera.half_width = camera.half_height * aspect;
  camera.near = random_scale(random, 1e-3, 2.0);
  camera.far = camera.near * random_scale(random, 2.0, 1e7);
  if (camera.orthographic && random_below(random, 2))
    camera.near = -random_between(random, 0.0, 0.5) * camera.far;
  if (!camera.orthographic && random_below(random, 4) == 0)
    camera.far = INFINITY;
  for (int i = 0; i < 2; ++i)
    if (random_below(random, 2))
      camera.center[i] =
          random_below(random, 2) ? random_between(random, -1.5, 1.5) : random_between(random, -1.0, 1.0) / 256.0;
  for (int i = 0; i < 3; ++i)
    camera.eye[i] = random_between(random, -world, world);
  return camera;
}

void camera_matrices(const test_camera *camera, double view[16], double projection[16]) {
  const double z_sign = camera->left_handed ? 1.0 : -1.0, x_sign = camera->mirrored ? -1.0 : 1.0;
  for (int i = 0; i < 3; ++i) {
    view[i * 4] = x_sign * camera->right[i];
    view[i * 4 + 1] = camera->up[i];
    view[i * 4 + 2] = z_sign * camera->forward[i];
    view[i * 4 + 3] = 0.0;
  }
  for (int row = 0; row < 3; ++row)
    view[12 + row] = -(view[row] * camera->eye[0] + view[4 + row] * camera->eye[1] + view[8 + row] * camera->eye[2]);
  view[15] = 1.0;

  /* Clip z over w is a + b / depth, or a + b depth, with the planes at 0 and 1, or at 1 and 0 */
  const double n = camera->near, f = camera->far;
  double a, b;
  if (camera->orthographic) {
    b = (camera->reversed ? -1.0 : 1.0) / (f - n);
    a = camera->reversed ? f / (f - n) : -n / (f - n);
  } else if (isinf(f)) {
    a = camera->reversed ? 0.0 : 1.0;
    b = camera->reversed ? n : -n;
  } else {
    a = camera->reversed ? -n / (f - n) : f / (f - n);
    b = (camera->reversed ? f : -f) * n / (f - n);
  }
  for (int i = 0; i < 16; ++i)
    projection[i] = 0.0;
  projection[0] = x_sign / camera->half_width;
  projection[5] = 1.0 / camera->half_height;
  if (camera->orthographic) {
    projection[10] = z_sign * b;
    projection[12] = camera->center[0];
    projection[13] = camera->center[1];
    projection[14] = a;
    projection[15] = 1.0;
  } else {
    projection[8] = z_sign * camera->center[0];
    projection[9] = z_sign * camera->center[1];
    projection[10] = z_sign * a;
    projection[11] = z_sign;
    projection[14] = b;
  }
}

void camera_point(const test_camera *camera, double x, double y, double depth, double out[3]) {
  const double scale = camera->orthographic ? 1.0 : depth;
  const double across = (x - camera->center[0]) * camera->half_width * scale;
  const double above = (y - camera->center[1]) * camera->half_height * scale;
  for (int i = 0; i < 3; ++i)
    out[i] = camera->eye[i] + (across * camera->right[i] + above * camera->up[i] + depth * camera->forward[i]);
}

csm_config default_config(void) {
  csm_config config;
  plan_config_default(&config);
  return config;
}

csm_config random_config(random_state *random) {
  csm_config config = default_config();
  config.cascade_count = 1 + random_below(random, CSM_MAX_CASCADES);
  config.resolution = 16u << random_below(random, 11);
  if (random_below(random, 4) == 0)
    config.resolution = 16 + random_below(random, 5000);
  config.filter = random_below(random, 2);
  config.shadow_distance = random_scale(random, 3.0, 1e5);
  config.split_lambda = random_between(random, 0.0, 1.0);
  config.caster_distance = random_below(random, 4) ? random_scale(random, 1.0, 1e5) : 0.0;
  config.bias_normal_texels = random_below(random, 2) ? 0.0 : random_between(random, 0.0, 4.0);
  if (random_below(random, 3) == 0) {
    config.split_mode = CSM_SPLIT_MANUAL;
    double last = 0.0;
    for (uint32_t i = 0; i < config.cascade_count; ++i)
      config.split_distances[i] = last += random_scale(random, 0.1, 1000.0);
    config.split_distances[config.cascade_count - 1] = fmax(last, 3.0);
  }
  return config;
}

csm_config random_full_config(random_state *random) {
  static const uint32_t taps[] = {3, 9, 31};
  csm_config config;
  const char *error = "";
  do {
    config = random_config(random);
    config.fit_mode = random_below(random, CSM_FIT_SCENE_SQUARE + 1);
    config.snap_mode = random_below(random, CSM_SNAP_OFF + 1);
    config.snap_power = config.snap_mode == CSM_SNAP_OFF ? 0 : random_below(random, 5);
    config.filter = random_below(random, CSM_FILTER_GRID_17 + 1);
    config.filter_taps = taps[random_below(random, 3)];
    config.filter_radius_texels = random_between(random, 0.0, 16.0);
    config.bias_mode = CSM_BIAS_SLOPE;
    config.map_reversed = random_below(random, 2);
    if (config.split_mode == CSM_SPLIT_PRACTICAL)
      config.split_mode = random_below(random, 2) ? CSM_SPLIT_UNIFORM : CSM_SPLIT_LOGARITHMIC;
    for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i)
      config.resolutions[i] = random_below(random, 2) ? 0 : 16 + random_below(random, 5000);
  } while (plan_config_check(&config, &error));
  return config;
}

plan_frame plan_empty(const csm_config *config, const test_camera *camera, const double light[3]) {
  double view[16], projection[16];
  const char *error = "";
  const plan_scene nothing = {0};
  plan_frame frame;
  camera_matrices(camera, view, projection);
  const csm_result result =
      plan_made(&frame, config, &(test_shot){view, projection, camera_reversed(camera), light}, &nothing, NULL, &error);
  if (result)
    fail_msg("%d: %s", result, error);
  return frame;
}

void *CSM_CALL support_allocate(void *user, size_t size, size_t align) {
  (void)user;
  return aligned_alloc(align, (size + align - 1) / align * align);
}

void CSM_CALL support_release(void *user, void *memory) {
  (void)user;
  free(memory);
}

plan_memory *memory_make(uint32_t most, uint32_t mesh_count, uint32_t window_count) {
  plan_memory *memory = malloc(sizeof *memory);
  assert_non_null(memory);
  *memory = (plan_memory){.at = malloc(plan_memory_size(most, mesh_count, window_count)), .most = most};
  assert_non_null(memory->at);
  return memory;
}

void memory_free(plan_memory *memory) {
  free(memory->at);
  free(memory);
}

test_scene scene_make(uint32_t instance_count, uint32_t mesh_count) {
  test_scene scene = {.instances = calloc(instance_count, sizeof *scene.instances),
                      .boxes = calloc(instance_count, sizeof *scene.boxes),
                      .meshes = calloc(mesh_count, sizeof *scene.meshes),
                      .memory = memory_make(instance_count, mesh_count, PLAN_WINDOWS_MOST)};
  assert_non_null(scene.instances);
  assert_non_null(scene.boxes);
  assert_non_null(scene.meshes);
  scene.scene = (plan_scene){.instances = scene.instances,
                             .boxes = scene.boxes,
                             .slot_count = instance_count,
                             .caster_count = instance_count,
                             .receiver_count = instance_count,
                             .meshes = scene.meshes,
                             .mesh_count = mesh_count};
  return scene;
}

void scene_free(test_scene *scene) {
  free(scene->instances);
  free(scene->boxes);
  free(scene->meshes);
  memory_free(scene->memory);
}

void scene_scatter(test_scene *scene, random_state *random, const double center[3], double spread) {
  for (uint32_t i = 0; i < scene->scene.mesh_count; ++i)
    for (int k = 0; k < 3; ++k) {
      scene->meshes[i].center[k] = random_between(random, -2.0, 2.0);
      scene->meshes[i].extent[k] = random_below(random, 5) ? random_scale(random, 0.01, 4.0) : 0.0;
    }
  for (uint32_t i = 0; i < scene->scene.slot_count; ++i) {
    double *t = scene->instances[i].transform;
    const double size = random_scale(random, 0.01, 30.0);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        t[row * 4 + column] = size * random_between(random, -1.0, 1.0);
      t[row * 4 + 3] = center[row] + random_between(random, -spread, spread);
    }
    scene->instances[i].mesh = random_below(random, scene->scene.mesh_count);
  }
  scene_place(scene);
}

void scene_place(test_scene *scene) {
  for (uint32_t i = 0; i < scene->scene.slot_count; ++i) {
    assert_int_equal(plan_instance_check(&scene->instances[i]), CSM_SUCCESS);
    plan_instance_box(&scene->boxes[i], &scene->instances[i], &scene->meshes[scene->instances[i].mesh]);
  }
}

void instance_point(const plan_scene *scene, uint32_t instance, const double at[3], double out[3]) {
  const plan_instance *placed = &scene->instances[instance];
  const plan_bounds *bounds = &scene->meshes[placed->mesh];
  double object[3];
  for (int i = 0; i < 3; ++i)
    object[i] = bounds->center[i] + at[i] * bounds->extent[i];
  for (int row = 0; row < 3; ++row)
    out[row] = dot(&placed->transform[row * 4], object) + placed->transform[row * 4 + 3];
}

void transform_point(const double m[16], const double p[3], double out[3]) {
  for (int row = 0; row < 3; ++row)
    out[row] = (double)((long double)m[row] * p[0] + (long double)m[4 + row] * p[1] + (long double)m[8 + row] * p[2] +
                        (long double)m[12 + row]);
}

double shadow_depth(const csm_cascade_info *info, const double p[3]) {
  double at[3];
  transform_point(info->world_to_shadow, p, at);
  return at[2];
}

void slice_point(random_state *random, const test_camera *camera, const csm_cascade_info *info, double out[3]) {
  double at[3];
  for (int i = 0; i < 3; ++i)
    at[i] = random_below(random, 2) ? random_between(random, -1.0, 1.0) : (random_below(random, 2) ? 1.0 : -1.0);
  const double share = (at[2] + 1.0) / 2.0;
  camera_point(camera, at[0], at[1],
               share < 1.0 ? info->near_depth + share * (info->far_depth - info->near_depth) : info->far_depth, out);
}

void assert_near(double value, double expected, double tolerance) {
  if (!(fabs(value - expected) <= tolerance))
    fail_msg("%.17g is not %.17g within %g", value, expected, tolerance);
}

uint32_t camera_reversed(const test_camera *camera) {
  return camera->reversed ? CSM_REVERSED_YES : CSM_REVERSED_NO;
}

csm_result plan_traced(plan_frame *out, const plan_frame_info *info, plan_memory *memory, const char **error) {
  feclearexcept(FE_ALL_EXCEPT);
  const csm_result result = plan_frame_make(out, info, memory, error);
  assert_no_exceptions();
  return result;
}

void assert_no_exceptions(void) {
  const int raised = fetestexcept(FE_INVALID | FE_DIVBYZERO | FE_OVERFLOW);
  if (raised)
    fail_msg("raised%s%s%s", raised & FE_INVALID ? " FE_INVALID" : "", raised & FE_DIVBYZERO ? " FE_DIVBYZERO" : "",
             raised & FE_OVERFLOW ? " FE_OVERFLOW" : "");
}

csm_result plan_made(plan_frame *out, const csm_config *config, const test_shot *shot, const plan_scene *scene,
                     plan_memory *memory, const char **error) {
  const plan_frame_info info = {.config = config,
                                .view = shot->view,
                                .projection = shot->projection,
                                .reversed = shot->reversed,
                                .light = shot->light,
                                .scene = scene};
  return plan_traced(out, &info, memory, error);
}
