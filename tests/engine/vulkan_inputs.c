/* vulkan_inputs.c: what an engine hands in: its camera's depth and normals, and its own vertices and indices. */
#include "vulkan_case.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { width = 96, height = 64, pixels = width * height };

static const case_step step = {0, 3, 256, width, height};

/* What an own device draws, and the depth that its camera saw. */
typedef struct own_result {
  case_image image;
  float depth[pixels];
} own_result;

static void draw_own(own_result *out) {
  vulkan_case c;
  case_open(&c, NULL);
  const csm_frame frame = case_frame(&c, step.time);
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = &frame, .width = width, .height = height};
  assert_int_equal(csm_render_cascades(c.cascades, &frame), CSM_SUCCESS);
  assert_int_equal(csm_resolve_mask(c.cascades, &mask), CSM_SUCCESS);
  case_read(&c, 0, &step, &out->image);
  float *depth = support_read(c.cascades, CSM_READ_CAMERA_DEPTH, 0, width, height);
  memcpy(out->depth, depth, sizeof out->depth);
  free(depth);
  case_close(&c);
}

/* The mask of the engine's own depth, and its normals if it has any; the camera needs no instances then. */
static void resolve_view(vulkan_case *c, uint32_t view, const csm_vulkan_image *depth, const csm_vulkan_image *normals,
                         uint8_t *mask) {
  static case_image image;
  vulkan_engine_begin(c->engine);
  csm_frame frame = case_frame(c, step.time);
  assert_int_equal(csm_render_cascades(c->cascades, &frame), CSM_SUCCESS);
  frame.instances = NULL;
  frame.instance_count = 0;
  const csm_mask_info info = {.struct_size = sizeof info,
                              .frame = &frame,
                              .width = width,
                              .height = height,
                              .camera_depth = depth,
                              .normals = normals,
                              .view = view};
  assert_int_equal(csm_resolve_mask(c->cascades, &info), CSM_SUCCESS);
  case_copy(c, &step);
  vulkan_engine_end(c->engine);
  vulkan_engine_run(c->engine, c->engine->frame);
  assert_int_equal(csm_retire(c->context, c->engine->frame), CSM_SUCCESS);
  case_read(c, c->engine->frame, &step, &image);
  memcpy(mask, image.mask, pixels);
}

static void resolve(vulkan_case *c, const csm_vulkan_image *depth, const csm_vulkan_image *normals, uint8_t *mask) {
  resolve_view(c, CSM_VIEW_SHADOW, depth, normals, mask);
}

/* ---- depth ---- */

static void own_depth_gives_the_same_mask(void **state) {
  (void)state;
  static own_result own;
  static uint8_t mask[pixels];
  const VkImageLayout layouts[] = {VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                   VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_GENERAL};
  vulkan_engine engine;
  vulkan_case c;
  draw_own(&own);
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  for (size_t i = 0; i < sizeof layouts / sizeof layouts[0]; ++i) {
    engine_image depth =
        vulkan_engine_image(&engine, VK_FORMAT_D32_SFLOAT, width, height, layouts[i], own.depth, sizeof own.depth);
    memset(mask, 7, sizeof mask);
    resolve(&c, &depth.native, NULL, mask);
    assert_memory_equal(mask, own.image.mask, pixels);
    vulkan_engine_image_destroy(&engine, &depth);
  }
  case_close(&c);
  vulkan_engine_close(&engine);
}

/* ---- normals ---- */

/* Where a pixel's ray met the scene: the camera is the one of case_frame, reversed-Z and right-handed. */
static void world_position(const csm_frame *frame, uint32_t x, uint32_t y, float depth, double out[3]) {
  const double *p = frame->projection, *v = frame->view;
  const double z = -p[14] / (depth + p[10]);
  const double eye[3] = {((x + 0.5) / width * 2 - 1) * -z / p[0] - v[12],
                         (1 - (y + 0.5) / height * 2) * -z / p[5] - v[13], z - v[14]};
  for (int axis = 0; axis < 3; ++axis)
    out[axis] = v[axis * 4] * eye[0] + v[axis * 4 + 1] * eye[1] + v[axis * 4 + 2] * eye[2];
}

/* The scene's faces all point along an axis: the nearest face of the nearest box, or the ground. */
static void face_normal(const support_scene *scene, const double position[3], float normal[4]) {
  double nearest = fabs(position[1]);
  memset(normal, 0, 4 * sizeof *normal);
  int axis = 1, sign = 1;
  for (int i = 1; i < SUPPORT_INSTANCES; ++i) {
    const double *t = scene->instances[i].transform;
    double outside = 0, best = INFINITY;
    int best_axis = 0;
    for (int a = 0; a < 3; ++a) {
      const double beyond = fabs(position[a] - t[12 + a]) - t[a * 5];
      outside = fmax(outside, beyond);
      if (fabs(beyond) < best) {
        best = fabs(beyond);
        best_axis = a;
      }
    }
    if (fmax(outside, best) < nearest) {
      nearest = fmax(outside, best);
      axis = best_axis;
      sign = position[axis] < t[12 + axis] ? -1 : 1;
    }
  }
  normal[axis] = (float)sign;
}

static uint32_t differences(const uint8_t *a, const uint8_t *b, int tolerance) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < pixels; ++i)
    count += abs(a[i] - b[i]) > tolerance;
  return count;
}

static void normals_of_every_coding_agree(void **state) {
  (void)state;
  static own_result own;
  static float floats[pixels][4];
  static uint16_t coded[pixels][4];
  static uint8_t with_floats[pixels], with_coded[pixels], without[pixels];
  vulkan_engine engine;
  vulkan_case c;
  draw_own(&own);
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  const csm_frame frame = case_frame(&c, step.time);
  for (uint32_t i = 0; i < pixels; ++i) {
    double position[3];
    world_position(&frame, i % width, i / width, own.depth[i], position);
    face_normal(&c.scene, position, floats[i]);
    for (int axis = 0; axis < 3; ++axis)
      coded[i][axis] = (uint16_t)lrintf((floats[i][axis] * 0.5f + 0.5f) * 65535);
  }
  const VkImageLayout rest = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
  engine_image images[] = {
      vulkan_engine_image(&engine, VK_FORMAT_D32_SFLOAT, width, height, rest, own.depth, sizeof own.depth),
      vulkan_engine_image(&engine, VK_FORMAT_R32G32B32A32_SFLOAT, width, height, rest, floats, sizeof floats),
      vulkan_engine_image(&engine, VK_FORMAT_R16G16B16A16_UNORM, width, height, rest, coded, sizeof coded)};
  resolve(&c, &images[0].native, &images[1].native, with_floats);
  resolve(&c, &images[0].native, &images[2].native, with_coded);
  /* What depth tells of normals may be wrong at edges. */
  assert_true(differences(with_floats, own.image.mask, 32) < 8);
  assert_true(differences(with_floats, with_coded, 2) < 8);
  /* Views take their normals from the depth; and the mask is the same after them. */
  for (uint32_t view = CSM_VIEW_CASCADE; view <= CSM_VIEW_DENSITY; ++view) {
    resolve_view(&c, view, &images[0].native, NULL, with_coded);
    resolve_view(&c, view, &images[0].native, &images[1].native, without);
    assert_memory_equal(with_coded, without, pixels);
    assert_true(differences(with_coded, with_floats, 2) > pixels / 8);
  }
  resolve(&c, &images[0].native, &images[1].native, without);
  assert_memory_equal(with_floats, without, pixels);
  /* Taken for floats as they are, coded normals are others. */
  images[2].native.format = VK_FORMAT_R16G16B16A16_SFLOAT;
  resolve(&c, &images[0].native, &images[2].native, with_coded);
  assert_true(differences(with_floats, with_coded, 2) > 24);
  for (uint32_t i = 0; i < 3; ++i)
    vulkan_engine_image_destroy(&engine, &images[i]);
  case_close(&c);
  vulkan_engine_close(&engine);
}

/* ---- vertices and indices ---- */

enum { most_corners = 36 };

/* A piece of the scene in world space, its vertices in an order of their own. */
typedef struct piece {
  uint32_t count;
  float positions[most_corners][3];
  uint16_t indices[most_corners];
} piece;

static void cut_scene(const support_scene *scene, piece pieces[SUPPORT_INSTANCES]) {
  static double corners[SUPPORT_TRIANGLES][3][3];
  support_triangles(scene, corners);
  for (uint32_t i = 0, triangle = 0; i < SUPPORT_INSTANCES; ++i) {
    pieces[i].count = i ? 36 : 6;
    for (uint32_t corner = 0; corner < pieces[i].count; ++corner) {
      const uint32_t vertex = pieces[i].count - 1 - corner;
      pieces[i].indices[corner] = (uint16_t)vertex;
      for (int axis = 0; axis < 3; ++axis)
        pieces[i].positions[vertex][axis] = (float)corners[triangle + corner / 3][corner % 3][axis];
    }
    triangle += pieces[i].count / 3;
  }
}

static csm_mesh copied_mesh(csm_context *context, const piece *piece) {
  csm_mesh mesh = 0;
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = piece->positions,
                              .vertex_count = piece->count,
                              .indices = piece->indices,
                              .index_count = piece->count,
                              .index_size = 2};
  assert_int_equal(csm_mesh_create(context, &info, &mesh), CSM_SUCCESS);
  return mesh;
}

typedef struct layout {
  uint32_t stride, vertex_offset, index_size, index_offset;
  bool one_buffer;
} layout;

/* Lays a mesh out as an engine would: positions among other attributes, indices behind them or in another buffer. */
static csm_mesh engine_mesh(vulkan_case *c, const layout *l, const piece *piece, engine_buffer *buffer,
                            engine_buffer *other) {
  const uint32_t index_begin = (l->one_buffer ? 4096 : 0) + l->index_offset;
  *buffer = vulkan_engine_buffer(c->engine, 8192);
  if (!l->one_buffer)
    *other = vulkan_engine_buffer(c->engine, 8192);
  char *indices = l->one_buffer ? buffer->mapped : other->mapped;
  memset(buffer->mapped, 0x7f, buffer->size); /* other attributes: floats of 3e38 */
  for (uint32_t i = 0; i < piece->count; ++i) {
    const uint32_t wide = piece->indices[i];
    memcpy((char *)buffer->mapped + l->vertex_offset + i * l->stride, piece->positions[i], sizeof piece->positions[i]);
    memcpy(indices + index_begin + i * l->index_size, l->index_size == 2 ? (const void *)&piece->indices[i] : &wide,
           l->index_size);
  }
  const csm_vulkan_mesh native = {.struct_size = sizeof native,
                                  .vertex_stride = l->stride,
                                  .vertices = buffer->handle,
                                  .vertex_offset = l->vertex_offset,
                                  .indices = l->one_buffer ? buffer->handle : other->handle,
                                  .index_offset = index_begin};
  csm_mesh_info info = {.struct_size = sizeof info,
                        .vertex_count = piece->count,
                        .index_count = piece->count,
                        .index_size = l->index_size,
                        .vulkan = &native};
  for (int axis = 0; axis < 3; ++axis) {
    info.bounds_min[axis] = info.bounds_max[axis] = piece->positions[0][axis];
    for (uint32_t i = 1; i < piece->count; ++i) {
      info.bounds_min[axis] = fminf(info.bounds_min[axis], piece->positions[i][axis]);
      info.bounds_max[axis] = fmaxf(info.bounds_max[axis], piece->positions[i][axis]);
    }
  }
  csm_mesh mesh = 0;
  assert_int_equal(csm_mesh_create(c->context, &info, &mesh), CSM_SUCCESS);
  return mesh;
}

/* Draws the scene with these meshes, which are destroyed before the frame runs. */
static void draw_meshes(vulkan_case *c, const csm_mesh *meshes, case_image *out) {
  for (uint32_t i = 0; i < SUPPORT_INSTANCES; ++i)
    c->scene.instances[i] = support_instance(meshes[i], 0, 0, 0, 1, 1, 1);
  vulkan_engine_begin(c->engine);
  const csm_frame frame = case_frame(c, step.time);
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = &frame, .width = width, .height = height};
  assert_int_equal(csm_render_cascades(c->cascades, &frame), CSM_SUCCESS);
  assert_int_equal(csm_resolve_mask(c->cascades, &mask), CSM_SUCCESS);
  case_copy(c, &step);
  vulkan_engine_end(c->engine);
  for (uint32_t i = 0; i < SUPPORT_INSTANCES; ++i)
    assert_int_equal(csm_mesh_destroy(c->context, meshes[i]), CSM_SUCCESS);
  vulkan_engine_run(c->engine, c->engine->frame);
  assert_int_equal(csm_retire(c->context, c->engine->frame), CSM_SUCCESS);
  case_read(c, c->engine->frame, &step, out);
}

static void own_buffers_draw_as_copies(void **state) {
  (void)state;
  static const layout layouts[] = {
      {12, 0, 2, 0, false}, {16, 8, 4, 64, true}, {32, 12, 2, 4, true}, {60, 4, 4, 0, false}};
  static piece pieces[SUPPORT_INSTANCES];
  static case_image drawn, expected;
  csm_mesh meshes[SUPPORT_INSTANCES];
  engine_buffer buffers[SUPPORT_INSTANCES][2] = {0};
  vulkan_engine engine;
  vulkan_case c;
  vulkan_engine_open(&engine, VULKAN_ENGINE_BARE);
  case_open(&c, &engine);
  cut_scene(&c.scene, pieces);
  for (uint32_t i = 0; i < SUPPORT_INSTANCES; ++i)
    meshes[i] = copied_mesh(c.context, &pieces[i]);
  draw_meshes(&c, meshes, &expected);
  for (uint32_t i = 0; i < SUPPORT_INSTANCES; ++i)
    meshes[i] = engine_mesh(&c, &layouts[i % 4], &pieces[i], &buffers[i][0], &buffers[i][1]);
  draw_meshes(&c, meshes, &drawn);
  case_compare(&drawn, &expected, &step);
  for (uint32_t i = 0; i < SUPPORT_INSTANCES; ++i)
    for (int b = 0; b < 2; ++b)
      vulkan_engine_buffer_destroy(&engine, &buffers[i][b]);
  case_close(&c);
  vulkan_engine_close(&engine);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(own_depth_gives_the_same_mask),
      cmocka_unit_test(normals_of_every_coding_agree),
      cmocka_unit_test(own_buffers_draw_as_copies),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
