/* misuse.c: every misuse of a context, a mesh or a configuration gets its named error and a text, and leaves all as it
   was, on every backend alike. */
#include "misuse_support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- creation ---- */

static void expect_create(const csm_create_info *base, const misuse *row) {
  char text[512] = "";
  csm_create_info info = *base;
  misuse_apply(row, &info);
  info.error = text;
  info.error_size = sizeof text;
  csm_context *context = (csm_context *)&info;
  const csm_result result = csm_create(&info, &context);
  misuse_expect(row, result, text);
  assert_null(context);
}

#define CREATE(field) FIELD(csm_create_info, field)

static void creation(void **state) {
  (void)state;
  static const misuse rows[] = {
      {"no size", CREATE(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, ""},
      {"no backend", CREATE(backend), {0}, CSM_ERROR_NULL_POINTER, "backend"},
      {"unknown flags", CREATE(flags), {1u << 31}, CSM_ERROR_INVALID_VALUE, "flags"},
      {"no version", CREATE(version), {0}, CSM_ERROR_INVALID_VALUE, "version"},
      {"too many slots", CREATE(frame_slots), {9}, CSM_ERROR_INVALID_VALUE, "frame_slots"},
      {"half an allocator", CREATE(release), {0}, CSM_ERROR_INVALID_VALUE, "release"},
      {"a backend that is not there", CREATE(backend), {.pointer = "nope"}, CSM_ERROR_BACKEND_NOT_FOUND, "nope"},
      {"a path that is not there",
       CREATE(backend),
       {.pointer = "Not/../a name"},
       CSM_ERROR_BACKEND_NOT_FOUND,
       "Not/../a name"},
      {"a name with odd letters", CREATE(backend), {.pointer = "Vulkan!"}, CSM_ERROR_INVALID_VALUE, "Vulkan!"},
      {"a file that is no library",
       CREATE(backend),
       {.pointer = "/proc/self/status"},
       CSM_ERROR_BACKEND_BROKEN,
       "/proc/self/status"},
      {"a folder", CREATE(backend), {.pointer = "/proc/self/"}, CSM_ERROR_BACKEND_BROKEN, "regular file"},
  };
  static const misuse no_device = {
      "a device that is not there", CREATE(device), {.pointer = "no such"}, CSM_ERROR_NO_DEVICE, "no such"};
  record record = {0};
  const csm_create_info good = support_create_info(&record);
  record.quiet = true;
  csm_context *context;
  assert_int_equal(csm_create(NULL, &context), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_create(&good, NULL), CSM_ERROR_NULL_POINTER);
  for (size_t i = 0; i < COUNT(rows); ++i)
    expect_create(&good, &rows[i]);
  if (strcmp(good.backend, "null"))
    expect_create(&good, &no_device);
  const bool vulkan = !strcmp(good.backend, "vulkan");
  const misuse other = {"an engine's device of another API",
                        offsetof(csm_create_info, d3d12),
                        sizeof(void *),
                        {.pointer = &good},
                        CSM_ERROR_UNSUPPORTED,
                        "device"};
  const misuse another = {
      "an engine's device of another API", CREATE(vulkan), {.pointer = &good}, CSM_ERROR_UNSUPPORTED, "device"};
  expect_create(&good, vulkan ? &other : &another);
  csm_create_info both = good;
  both.vulkan = (const void *)&good;
  const misuse two = {
      "engine's devices of two APIs", CREATE(d3d12), {.pointer = &good}, CSM_ERROR_INVALID_VALUE, "vulkan"};
  expect_create(&both, &two);
  assert_int_equal(record.blocks, 0);
}

/* A named pipe would be waited for, for ever: it is refused before it is opened. */
static void a_pipe_is_no_backend(void **state) {
  (void)state;
  char folder[] = "/tmp/csm-pipe-XXXXXX", path[sizeof folder + 16];
  record record = {0};
  const csm_create_info good = support_create_info(&record);
  record.quiet = true;
  assert_non_null(mkdtemp(folder));
  snprintf(path, sizeof path, "%s/libcsm-pipe.so", folder);
  assert_int_equal(mkfifo(path, 0600), 0);
  const misuse row = {"a pipe", CREATE(backend), {.pointer = path}, CSM_ERROR_BACKEND_BROKEN, "regular file"};
  expect_create(&good, &row);
  assert_int_equal(unlink(path), 0);
  assert_int_equal(rmdir(folder), 0);
  assert_int_equal(record.blocks, 0);
}

/* ---- structs of other versions ---- */

/* A larger struct from a later header is taken if the part that is not known is zero. */
static void struct_sizes(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  struct {
    csm_config config;
    uint64_t tail[2];
  } later = {.config = f.config};
  later.config.struct_size = sizeof later;
  assert_int_equal(csm_cascades_configure(f.cascades, &later.config), CSM_SUCCESS);
  later.tail[1] = 1;
  expect(&f, csm_cascades_configure(f.cascades, &later.config), CSM_ERROR_STRUCT_SIZE, "a tail that is not zero");
  later.config.struct_size = 0;
  expect(&f, csm_cascades_configure(f.cascades, &later.config), CSM_ERROR_STRUCT_SIZE, "size 0");
  later.config.struct_size = UINT32_MAX - 3;
  expect(&f, csm_cascades_configure(f.cascades, &later.config), CSM_ERROR_STRUCT_SIZE, "an absurd size");

  /* A smaller frame lacks its tail: no draw callback. A smaller camera lacks all that a camera must have. */
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  shot shot = f.scene.shot;
  shot.frame.struct_size = offsetof(csm_frame, draw);
  shot.frame.draw_user = &shot;
  assert_int_equal(csm_render_cascades(f.cascades, shot_frame(&shot)), CSM_SUCCESS);
  shot.camera.struct_size = offsetof(csm_camera, projection);
  expect(&f, csm_render_cascades(f.cascades, shot_frame(&shot)), CSM_ERROR_INVALID_MATRIX, "no projection");

  /* Outputs are not written past the caller's size. */
  csm_binding binding;
  memset(&binding, 0x5a, sizeof binding);
  binding.struct_size = offsetof(csm_binding, origin);
  binding.view = NULL;
  assert_int_equal(csm_bind(f.cascades, &binding), CSM_SUCCESS);
  assert_int_equal(binding.cascade_count, f.config.cascade_count);
  for (size_t i = offsetof(csm_binding, origin); i < sizeof binding; ++i)
    assert_int_equal(((const unsigned char *)&binding)[i], 0x5a);
  teardown(&f);
}

/* ---- meshes ---- */

static csm_result make_mesh(fixture *f, const void *info) {
  csm_mesh mesh = 1;
  const csm_result result = csm_mesh_create(f->context, info, &mesh);
  assert_true((mesh != 0) == !result);
  return result;
}

#define MESH(field) FIELD(csm_mesh_info, field)

static void meshes(void **state) {
  (void)state;
  static float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  static const float not_a_number[9] = {0, 0, 0, 1, NAN, 0, 0, 1, 0}, infinite[9] = {0, 0, 0, 1, INFINITY, 0, 0, 1, 0};
  static const uint16_t indices[3] = {0, 1, 2};
  static const misuse rows[] = {
      {"no size", MESH(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "csm_mesh_info"},
      {"no positions", MESH(positions), {0}, CSM_ERROR_NULL_POINTER, "positions"},
      {"no indices", MESH(indices), {0}, CSM_ERROR_NULL_POINTER, "indices"},
      {"0 vertices", MESH(vertex_count), {0}, CSM_ERROR_INVALID_VALUE, "vertex_count"},
      {"0 indices", MESH(index_count), {0}, CSM_ERROR_INVALID_VALUE, "index_count"},
      {"half a triangle", MESH(index_count), {2}, CSM_ERROR_INVALID_VALUE, "index_count"},
      {"3 bytes an index", MESH(index_size), {3}, CSM_ERROR_INVALID_VALUE, "index_size"},
      {"a stride below a position", MESH(position_stride), {8}, CSM_ERROR_INVALID_VALUE, "position_stride"},
      {"an odd stride", MESH(position_stride), {13}, CSM_ERROR_INVALID_VALUE, "position_stride"},
      {"unknown flags", MESH(flags), {4}, CSM_ERROR_INVALID_VALUE, "flags"},
      {"an index out of range", MESH(vertex_count), {2}, CSM_ERROR_INVALID_INDEX, "index"},
      {"NaN", MESH(positions), {.pointer = not_a_number}, CSM_ERROR_NOT_FINITE, "position"},
      {"infinity", MESH(positions), {.pointer = infinite}, CSM_ERROR_NOT_FINITE, "position"},
      {"an alpha mask from nowhere", MESH(alpha_mask), {77}, CSM_ERROR_INVALID_HANDLE, "alpha"},
  };
  const csm_mesh_info good = {.struct_size = sizeof good,
                              .positions = positions,
                              .vertex_count = 3,
                              .indices = indices,
                              .index_count = 3,
                              .index_size = 2};
  fixture f;
  snapshot before;
  csm_mesh mesh = 1, next;
  setup(&f);
  take(&f, &before);
  assert_int_equal(csm_mesh_create(NULL, &good, &mesh), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_mesh_create(f.context, NULL, &mesh), CSM_ERROR_NULL_POINTER, "no info");
  expect(&f, csm_mesh_create(f.context, &good, NULL), CSM_ERROR_NULL_POINTER, "no mesh");
  check_rows(&f, &(row_table){rows, COUNT(rows), &good, sizeof good}, make_mesh);
  expect(&f, csm_mesh_destroy(f.context, 0), CSM_ERROR_INVALID_HANDLE, "no handle");
  expect(&f, csm_mesh_destroy(f.context, 12345), CSM_ERROR_INVALID_HANDLE, "a handle from nowhere");
  assert_int_equal(csm_mesh_create(f.context, &good, &mesh), CSM_SUCCESS);
  assert_int_equal(csm_mesh_destroy(f.context, mesh), CSM_SUCCESS);
  expect(&f, csm_mesh_destroy(f.context, mesh), CSM_ERROR_INVALID_HANDLE, "destroyed twice");
  const csm_mesh forged = mesh + (1ull << 32); /* the generation that the empty place has now */
  expect(&f, csm_mesh_destroy(f.context, forged), CSM_ERROR_INVALID_HANDLE, "a forged handle to an empty place");
  assert_int_equal(csm_mesh_create(f.context, &good, &next), CSM_SUCCESS);
  assert_true(next != mesh);
  expect(&f, csm_mesh_destroy(f.context, mesh), CSM_ERROR_INVALID_HANDLE, "stale: its place was given again");
  assert_int_equal(csm_mesh_destroy(f.context, next), CSM_SUCCESS);
  unchanged(&f, &before);
  teardown(&f);
}

static csm_result update_mesh(fixture *f, const void *info) {
  return csm_mesh_update(f->context, f->scene.instances[1].mesh, info);
}

#define UPDATE(field) FIELD(csm_mesh_update_info, field)

static void updates(void **state) {
  (void)state;
  static const float positions[24] = {0}, not_a_number[24] = {NAN};
  static const misuse rows[] = {
      {"no size", UPDATE(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "csm_mesh_update_info"},
      {"no positions", UPDATE(positions), {0}, CSM_ERROR_NULL_POINTER, "positions"},
      {"flags", UPDATE(flags), {1}, CSM_ERROR_INVALID_VALUE, "flags"},
      {"a stride below a position", UPDATE(position_stride), {8}, CSM_ERROR_INVALID_VALUE, "position_stride"},
      {"an odd stride", UPDATE(position_stride), {14}, CSM_ERROR_INVALID_VALUE, "position_stride"},
      {"reserved", UPDATE(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"NaN", UPDATE(positions), {.pointer = not_a_number}, CSM_ERROR_NOT_FINITE, "position"},
  };
  const csm_mesh_update_info good = {.struct_size = sizeof good, .positions = positions};
  fixture f;
  snapshot before;
  setup(&f);
  take(&f, &before);
  assert_int_equal(csm_mesh_update(NULL, f.scene.instances[1].mesh, &good), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_mesh_update(f.context, f.scene.instances[1].mesh, NULL), CSM_ERROR_NULL_POINTER, "no info");
  expect(&f, csm_mesh_update(f.context, 12345, &good), CSM_ERROR_INVALID_HANDLE, "a mesh from nowhere");
  check_rows(&f, &(row_table){rows, COUNT(rows), &good, sizeof good}, update_mesh);
  unchanged(&f, &before);
  /* What was refused is not drawn either. */
  assert_int_equal(csm_render_cascades(f.cascades, shot_frame(&f.scene.shot)), CSM_SUCCESS);
  float *map = support_map(f.context, f.cascades, 0, RESOLUTION);
  assert_memory_equal(map, before.map, sizeof before.map);
  free(map);
  teardown(&f);
}

/* ---- cascades ---- */

static void expect_config(fixture *f, const csm_config *config, csm_result expected, const char *what) {
  csm_cascades *made = f->cascades;
  expect(f, csm_cascades_create(f->context, config, &made), expected, what);
  assert_null(made);
  expect(f, csm_cascades_configure(f->cascades, config), expected, what);
}

/* Values out of range and contradictions are config.c's. */
static void configurations(void **state) {
  (void)state;
  fixture f;
  snapshot before;
  csm_cascades *made;
  csm_config_field field = {.struct_size = sizeof field};
  setup(&f);
  take(&f, &before);
  assert_int_equal(csm_cascades_create(NULL, &f.config, &made), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_cascades_configure(NULL, &f.config), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_cascades_create(f.context, &f.config, NULL), CSM_ERROR_NULL_POINTER, "no cascades");
  expect_config(&f, NULL, CSM_ERROR_NULL_POINTER, "no configuration");
  assert_int_equal(csm_config_describe(10000, &field), CSM_ERROR_INVALID_INDEX);
  assert_int_equal(csm_config_describe(0, NULL), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_config_default(NULL), CSM_ERROR_NULL_POINTER);
  csm_config config = f.config;
  config.resolution = 16384;
  config.cascade_count = 8;
  expect_config(&f, &config, CSM_ERROR_LIMIT_EXCEEDED, "maps that no device can hold");
  unchanged(&f, &before);
  teardown(&f);
}

static void the_memory_limit_is_kept(void **state) {
  (void)state;
  record record = {0};
  csm_create_info info = support_create_info(&record);
  record.quiet = true;
  info.memory_limit = 4 << 20;
  csm_context *context;
  assert_int_equal(csm_create(&info, &context), CSM_SUCCESS);
  csm_config config = support_config();
  csm_cascades *cascades;
  config.cascade_count = 4;
  config.resolution = 1024;
  assert_int_equal(csm_cascades_create(context, &config, &cascades), CSM_ERROR_LIMIT_EXCEEDED);
  config.resolution = 256;
  assert_int_equal(csm_cascades_create(context, &config, &cascades), CSM_SUCCESS);
  support_close(context, &record); /* the cascades go with it */
}

/* A mesh of nine megabytes, made and freed. */
static void come_and_go(csm_context *context) {
  enum { INDICES = 3 * 786432 };
  static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  static uint32_t indices[INDICES];
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = corners,
                              .vertex_count = 3,
                              .indices = indices,
                              .index_count = INDICES,
                              .index_size = 4};
  csm_mesh mesh;
  assert_int_equal(csm_mesh_create(context, &info, &mesh), CSM_SUCCESS);
  assert_int_equal(csm_mesh_destroy(context, mesh), CSM_SUCCESS);
}

/* No recording comes by that would free what they leave; one mesh waits for it all the while. */
static void meshes_that_go_leave_room(void **state) {
  (void)state;
  record record = {0};
  csm_create_info info = support_create_info(&record);
  info.memory_limit = 64 << 20;
  csm_context *context;
  csm_cascades *cascades, *large;
  csm_config config = support_config();
  support_scene scene;
  assert_int_equal(csm_create(&info, &context), CSM_SUCCESS);
  support_scene_make(&scene, context);
  config.resolution = RESOLUTION;
  assert_int_equal(csm_cascades_create(context, &config, &cascades), CSM_SUCCESS);
  for (int round = 0; round < 2; ++round) { /* before the first frame, and after it */
    support_box(context, 2);
    for (int i = 0; i < 12; ++i)
      come_and_go(context);
    assert_int_equal(csm_render_cascades(cascades, shot_frame(&scene.shot)), CSM_SUCCESS);
  }
  come_and_go(context);
  config.cascade_count = 2; /* 32 MiB of maps: where meshes lay */
  config.resolution = 2048;
  assert_int_equal(csm_cascades_create(context, &config, &large), CSM_SUCCESS);
  support_close(context, &record);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(creation),
      cmocka_unit_test(a_pipe_is_no_backend),
      cmocka_unit_test(struct_sizes),
      cmocka_unit_test(meshes),
      cmocka_unit_test(updates),
      cmocka_unit_test(configurations),
      cmocka_unit_test(the_memory_limit_is_kept),
      cmocka_unit_test(meshes_that_go_leave_room),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
