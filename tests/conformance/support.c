#include "support.h"
#include "../tools/gpu_host.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- contexts ---- */

static void *CSM_CALL count_allocate(void *user, size_t size, size_t alignment) {
  record *record = user;
  if (record->allocations_left == 0)
    return NULL;
  if (record->allocations_left > 0)
    --record->allocations_left;
  ++record->blocks;
  ++record->allocations;
  return test_allocate(NULL, size, alignment);
}

static void CSM_CALL count_release(void *user, void *memory) {
  record *record = user;
  --record->blocks;
  test_release(NULL, memory);
}

static void CSM_CALL count_log(void *user, int32_t level, const char *message) {
  record *record = user;
  record->errors += level == CSM_LOG_ERROR;
  record->warnings += level == CSM_LOG_WARNING;
  const size_t length = strlen(record->said);
  if (level == CSM_LOG_ERROR)
    snprintf(record->said + length, sizeof record->said - length, "%s\n", message);
  if (level <= CSM_LOG_WARNING && !record->quiet)
    fprintf(stderr, "%s: %s\n", record->backend, message);
}

csm_create_info support_create_info(record *record) {
  if (!record->backend)
    *record = (struct record){.backend = support_backend(), .allocations_left = -1};
  return (csm_create_info){
      .struct_size = sizeof(csm_create_info),
      .flags = CSM_CREATE_VALIDATE | CSM_CREATE_NAMES,
      .version = CSM_VERSION,
      .backend = record->backend,
      .allocate = count_allocate,
      .release = count_release,
      .log = count_log,
      .user = record,
  };
}

csm_context *support_open(record *record) {
  return support_open_with(record, 0);
}

csm_context *support_open_with(record *record, uint32_t flags) {
  char text[512] = "";
  csm_create_info info = support_create_info(record);
  info.flags |= flags;
  info.error = text;
  info.error_size = sizeof text;
  csm_context *context;
  const csm_result result = csm_create(&info, &context);
  if (result)
    fail_msg("%s: %s: %s", record->backend, csm_result_name(result), text);
  return context;
}

void support_close(csm_context *context, record *record) {
  csm_destroy(context);
  assert_int_equal(record->blocks, 0);
  assert_int_equal(record->warnings, 0);
  if (!record->quiet)
    assert_int_equal(record->errors, 0);
}

/* ---- geometry ---- */

static const float box_positions[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                          {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
static const uint16_t box_indices[36] = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                         3, 7, 6, 3, 6, 2, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5};
static const float square_positions[4][3] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}};
static const uint16_t square_indices[6] = {0, 2, 1, 0, 3, 2};

static csm_mesh make_mesh(csm_context *context, const csm_mesh_info *info) {
  csm_mesh mesh;
  assert_int_equal(csm_mesh_create(context, info, &mesh), CSM_SUCCESS);
  assert_true(mesh != 0);
  return mesh;
}

csm_mesh support_box(csm_context *context, uint32_t index_size) {
  uint32_t wide[36];
  for (int i = 0; i < 36; ++i)
    wide[i] = box_indices[i];
  return make_mesh(context, &(csm_mesh_info){.struct_size = sizeof(csm_mesh_info),
                                             .positions = box_positions,
                                             .vertex_count = 8,
                                             .indices = index_size == 2 ? (const void *)box_indices : wide,
                                             .index_count = 36,
                                             .index_size = index_size,
                                             .name = "box"});
}

csm_mesh support_square(csm_context *context) {
  return make_mesh(context, &(csm_mesh_info){.struct_size = sizeof(csm_mesh_info),
                                             .positions = square_positions,
                                             .vertex_count = 4,
                                             .indices = square_indices,
                                             .index_count = 6,
                                             .index_size = 2,
                                             .name = "square"});
}

csm_instance support_instance(csm_mesh mesh, double x, double y, double z, double sx, double sy, double sz) {
  return (csm_instance){.struct_size = sizeof(csm_instance),
                        .mesh = mesh,
                        .transform = {sx, 0, 0, 0, 0, sy, 0, 0, 0, 0, sz, 0, x, y, z, 1}};
}

/* ---- cameras ---- */

static double dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

static void normalise(double v[3]) {
  const double length = sqrt(dot(v, v));
  for (int i = 0; i < 3; ++i)
    v[i] /= length;
}

void support_look_at(double view[16], const double eye[3], const double target[3]) {
  double right[3], up[3], back[3] = {eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]};
  normalise(back);
  cross(right, (const double[]){0, 1, 0}, back);
  normalise(right);
  cross(up, back, right);
  const double *rows[3] = {right, up, back};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      view[column * 4 + row] = rows[row][column];
    view[12 + row] = -dot(rows[row], eye);
    view[row * 4 + 3] = 0;
  }
  view[15] = 1;
}

void support_perspective(double projection[16], double fov_y_degrees, double aspect, double near, double far) {
  const double y = 1 / tan(fov_y_degrees * 3.14159265358979323846 / 360);
  memset(projection, 0, 16 * sizeof *projection);
  projection[0] = y / aspect;
  projection[5] = y;
  projection[10] = far > 0 ? near / (far - near) : 0;
  projection[11] = -1;
  projection[14] = far > 0 ? near * far / (far - near) : near;
}

double support_apply(const double m[16], const double p[3], double out[3]) {
  double w = m[15];
  for (int row = 0; row < 3; ++row)
    out[row] = m[row] * p[0] + m[4 + row] * p[1] + m[8 + row] * p[2] + m[12 + row];
  for (int i = 0; i < 3; ++i)
    w += m[i * 4 + 3] * p[i];
  return w;
}

void support_seen(const csm_camera *camera, float depth, double u, double v, double out[3]) {
  const double *p = camera->projection, *view = camera->view;
  const double z = -p[14] / (p[10] + (double)depth), x = u * 2 - 1, y = 1 - v * 2;
  const double local[3] = {x * -z / p[0], y * -z / p[5], z};
  for (int i = 0; i < 3; ++i)
    out[i] = view[i * 4] * (local[0] - view[12]) + view[i * 4 + 1] * (local[1] - view[13]) +
             view[i * 4 + 2] * (local[2] - view[14]);
}

/* ---- shots ---- */

shot shot_make(const csm_instance *instances, uint32_t count) {
  return (shot){
      .frame = {.struct_size = sizeof(csm_frame), .instances = instances, .instance_count = count},
      .camera = {.struct_size = sizeof(csm_camera)},
      .light = {.struct_size = sizeof(csm_light)},
  };
}

const csm_frame *shot_frame(shot *shot) {
  shot->frame.camera = &shot->camera;
  shot->frame.light = &shot->light;
  return &shot->frame;
}

csm_result shot_resolve(shot *shot, csm_view *view, csm_cascades *cascades, uint32_t width, uint32_t height) {
  const csm_mask_info info = {.struct_size = sizeof info, .frame = shot_frame(shot), .width = width, .height = height};
  return csm_resolve_mask(view, cascades, &info);
}

/* ---- the scene ---- */

void support_scene_make(support_scene *scene, csm_context *context) {
  const csm_mesh square = context ? support_square(context) : 0;
  const csm_mesh small = context ? support_box(context, 2) : 0, wide = context ? support_box(context, 4) : 0;
  scene->instances[0] = support_instance(square, 0, 0, 0, 30, 1, 30);
  scene->instances[1] = support_instance(small, 0, 1, 0, 1, 1, 1);
  scene->instances[2] = support_instance(wide, 6, 2, -8, 2, 2, 1);
  scene->instances[3] = support_instance(small, -7, 5, -12, 3, 0.1, 2);
  scene->instances[4] = support_instance(wide, 3, 30, -15, 4, 0.5, 4);
  scene->instances[5] = support_instance(small, -3, 0.5, 4, 0.5, 0.5, 0.5);
  scene->shot = shot_make(scene->instances, SUPPORT_INSTANCES);
  memcpy(scene->shot.light.direction, (const double[]){0.4, -1, 0.25}, sizeof scene->shot.light.direction);
  support_look_at(scene->shot.camera.view, (const double[]){-4, 6, 12}, (const double[]){0, 0, -4});
  support_perspective(scene->shot.camera.projection, 55, 1.5, 0.25, 200);
}

void support_triangles(const support_scene *scene, double corners[SUPPORT_TRIANGLES][3][3]) {
  uint32_t triangle = 0;
  for (uint32_t i = 0; i < SUPPORT_INSTANCES; ++i) {
    const uint32_t count = i ? 12 : 2;
    for (uint32_t t = 0; t < count; ++t, ++triangle)
      for (uint32_t corner = 0; corner < 3; ++corner) {
        const float *p =
            i ? box_positions[box_indices[t * 3 + corner]] : square_positions[square_indices[t * 3 + corner]];
        support_apply(scene->instances[i].transform, (const double[]){p[0], p[1], p[2]}, corners[triangle][corner]);
      }
  }
}

double support_trace(double corners[][3][3], uint32_t count, const double origin[3], const double direction[3],
                     double *edge) {
  double nearest = -1;
  *edge = 1;
  for (uint32_t i = 0; i < count; ++i) {
    double e1[3], e2[3], from[3], p[3], q[3];
    for (int axis = 0; axis < 3; ++axis) {
      e1[axis] = corners[i][1][axis] - corners[i][0][axis];
      e2[axis] = corners[i][2][axis] - corners[i][0][axis];
      from[axis] = origin[axis] - corners[i][0][axis];
    }
    cross(p, direction, e2);
    cross(q, from, e1);
    const double determinant = dot(e1, p);
    if (fabs(determinant) < 1e-12)
      continue;
    const double u = dot(from, p) / determinant, v = dot(direction, q) / determinant, t = dot(e2, q) / determinant;
    const double margin = fmin(fmin(u, v), 1 - u - v);
    if (t <= 0 || margin < -1e-3 || (nearest >= 0 && t > nearest + 1e-9))
      continue;
    if (margin < 0) { /* just missed: whoever compares should look away */
      *edge = fmin(*edge, -margin);
      continue;
    }
    *edge = nearest >= 0 && t > nearest - 1e-9 ? fmax(*edge, margin) : fmin(margin, 1);
    nearest = t;
  }
  return nearest;
}

static int wrapped(int index, int size, uint32_t mode) {
  if (mode == CSM_WRAP_CLAMP)
    return index < 0 ? 0 : index >= size ? size - 1 : index;
  const int period = mode == CSM_WRAP_MIRROR ? 2 * size : size;
  const int inside = ((index % period) + period) % period;
  return mode == CSM_WRAP_MIRROR && inside >= size ? 2 * size - 1 - inside : inside;
}

double support_alpha(const support_texture *t, double u, double v) {
  const double x = u * t->width - 0.5, y = v * t->height - 0.5;
  double sum = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const double wx = i ? x - floor(x) : 1 - (x - floor(x)), wy = j ? y - floor(y) : 1 - (y - floor(y));
      sum += wx * wy *
             t->texels[wrapped((int)floor(y) + j, t->height, t->wrap_v) * t->stride +
                       wrapped((int)floor(x) + i, t->width, t->wrap_u)];
    }
  return sum / 255;
}

static double between(uint32_t *random, double low, double high) {
  *random = *random * 1664525u + 1013904223u;
  return low + (high - low) * (double)(*random >> 8) / 16777216.0;
}

void support_boxes_above(csm_context *context, csm_instance *out, uint32_t count) {
  const csm_mesh ground = support_square(context), box = support_box(context, 2);
  uint32_t random = 1;
  out[0] = support_instance(ground, 0, 0, 0, 200, 1, 200);
  for (uint32_t i = 1; i <= count; ++i) {
    const double x = between(&random, -18, 10), y = between(&random, 9, 20), z = between(&random, -30, 0);
    out[i] = support_instance(box, x, y, z, between(&random, 0.2, 3), 0.3, between(&random, 0.2, 3));
  }
}

csm_config support_config(void) {
  csm_config config = {.struct_size = sizeof config};
  assert_int_equal(csm_config_default(&config), CSM_SUCCESS);
  config.cascade_count = 3;
  config.resolution = 256;
  config.shadow_distance = 60;
  return config;
}

void support_keep_programs(csm_context *context) {
  csm_config config = support_config();
  csm_cascades *kept;
  config.cascade_count = 1;
  config.resolution = 16;
  assert_int_equal(csm_cascades_create(context, &config, &kept), CSM_SUCCESS);
}

csm_view *support_view(csm_context *context) {
  csm_view *view = NULL;
  assert_int_equal(csm_view_create(context, &view), CSM_SUCCESS);
  assert_non_null(view);
  return view;
}

static float *read_texels(csm_context *context, csm_read_info info, uint32_t width, uint32_t height) {
  info.struct_size = sizeof info;
  info.size = (uint64_t)width * height * sizeof(float);
  info.data = malloc(info.size);
  assert_non_null(info.data);
  assert_int_equal(csm_read(context, &info), CSM_SUCCESS);
  return info.data;
}

float *support_map(csm_context *context, csm_cascades *cascades, uint32_t cascade, uint32_t resolution) {
  return read_texels(context, (csm_read_info){.source = CSM_READ_MAP, .cascades = cascades, .cascade = cascade},
                     resolution, resolution);
}

float *support_image(csm_context *context, csm_view *view, uint32_t source, uint32_t width, uint32_t height) {
  return read_texels(context, (csm_read_info){.source = source, .view = view}, width, height);
}

void support_same_binding(const csm_binding *a, const csm_binding *b) {
  assert_int_equal(a->cascade_count, b->cascade_count);
  assert_memory_equal(a->origin, b->origin, sizeof a->origin);
  assert_memory_equal(a->cascades, b->cascades, sizeof a->cascades);
  assert_memory_equal(a->resolutions, b->resolutions, sizeof a->resolutions);
  assert_int_equal(a->cascade_constants_size, b->cascade_constants_size);
  assert_int_equal(a->setting_constants_size, b->setting_constants_size);
  assert_true(a->cascade_constants_size > 0);
  assert_memory_equal(a->cascade_constants, b->cascade_constants, a->cascade_constants_size);
  if (a->setting_constants_size)
    assert_memory_equal(a->setting_constants, b->setting_constants, a->setting_constants_size);
}

/* ---- the program ---- */

static const char *chosen_backend; /* from the command line, before any test runs */

const char *support_backend(void) {
  return chosen_backend;
}

int support_main(int argc, char **argv, const struct CMUnitTest *tests, size_t count) {
  if (argc != 2) {
    fprintf(stderr, "usage: %s BACKEND\n", argv[0]);
    return 2;
  }
  chosen_backend = argv[1];
  return _cmocka_run_group_tests(argv[1], tests, count, NULL, NULL);
}
