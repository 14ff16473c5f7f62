/* misuse.c: every misuse gets its named error and a text, and leaves the context as it was, on every backend alike. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_config config;
  support_scene scene;
} fixture;

static void setup(fixture *f) {
  memset(f, 0, sizeof *f);
  f->context = support_open(&f->record);
  f->record.quiet = true;
  f->config = support_config();
  f->config.resolution = 64;
  support_scene_make(&f->scene, f->context);
  assert_int_equal(csm_cascades_create(f->context, &f->config, &f->cascades), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(f->cascades, &f->scene.frame), CSM_SUCCESS);
}

static void teardown(fixture *f) {
  assert_int_equal(csm_cascades_destroy(f->cascades), CSM_SUCCESS);
  support_close(f->context, &f->record);
}

/* Everything that a caller can see of the cascades, but for times. */
typedef struct snapshot {
  csm_binding binding;
  csm_stats stats;
  float map[64 * 64];
} snapshot;

static void take(const fixture *f, snapshot *out) {
  memset(out, 0, sizeof *out);
  out->binding.struct_size = sizeof out->binding;
  out->stats.struct_size = sizeof out->stats;
  assert_int_equal(csm_bind(f->cascades, &out->binding), CSM_SUCCESS);
  assert_int_equal(csm_get_stats(f->cascades, &out->stats), CSM_SUCCESS);
  float *map = support_read(f->cascades, CSM_READ_MAP, 0, 64, 64);
  memcpy(out->map, map, sizeof out->map);
  free(map);
}

static void expect(const fixture *f, csm_result result, csm_result expected, const char *what) {
  if (result != expected)
    fail_msg("%s: %s, not %s", what, csm_result_name(result), csm_result_name(expected));
  if (!strlen(csm_last_error(f->context)))
    fail_msg("%s: no text", what);
}

static void unchanged(const fixture *f, const snapshot *before) {
  snapshot now;
  take(f, &now);
  assert_memory_equal(&now, before, sizeof now);
}

/* ---- creation ---- */

static void expect_create(const csm_create_info *base, csm_result expected, const char *what) {
  char text[512] = "";
  csm_create_info info = *base;
  info.error = text;
  info.error_size = sizeof text;
  csm_context *context = (csm_context *)&info;
  const csm_result result = csm_create(&info, &context);
  if (result != expected)
    fail_msg("%s: %s (%s), not %s", what, csm_result_name(result), text, csm_result_name(expected));
  assert_null(context);
  if (!strlen(text))
    fail_msg("%s: no text", what);
}

static void creation(void **state) {
  (void)state;
  record record = {0};
  const csm_create_info good = support_create_info(&record);
  record.quiet = true;
  csm_create_info info = good;
  csm_context *context;
  assert_int_equal(csm_create(NULL, &context), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_create(&info, NULL), CSM_ERROR_NULL_POINTER);
  info.struct_size = 0;
  assert_int_equal(csm_create(&info, &context), CSM_ERROR_STRUCT_SIZE);
  info = good, info.backend = NULL;
  expect_create(&info, CSM_ERROR_NULL_POINTER, "no backend");
  info = good, info.flags = 1u << 31;
  expect_create(&info, CSM_ERROR_INVALID_VALUE, "unknown flags");
  info = good, info.version = 0;
  expect_create(&info, CSM_ERROR_INVALID_VALUE, "no version");
  info = good, info.frame_slots = 9;
  expect_create(&info, CSM_ERROR_INVALID_VALUE, "too many slots");
  info = good, info.release = NULL;
  expect_create(&info, CSM_ERROR_INVALID_VALUE, "half an allocator");
  info = good, info.vulkan = (const void *)&good, info.d3d12 = (const void *)&good;
  expect_create(&info, CSM_ERROR_INVALID_VALUE, "engine's devices of two APIs");
  info = good, *(strcmp(good.backend, "vulkan") ? (const void **)&info.vulkan : (const void **)&info.d3d12) = &good;
  expect_create(&info, CSM_ERROR_UNSUPPORTED, "an engine's device of another API");
  info = good, info.backend = "nope";
  expect_create(&info, CSM_ERROR_BACKEND_NOT_FOUND, "a backend that is not there");
  info = good, info.backend = "Not/../a name";
  expect_create(&info, CSM_ERROR_BACKEND_NOT_FOUND, "a path that is not there");
  info = good, info.backend = "Vulkan!";
  expect_create(&info, CSM_ERROR_INVALID_VALUE, "a name with odd letters");
  info = good, info.backend = "/proc/self/status";
  expect_create(&info, CSM_ERROR_BACKEND_BROKEN, "a file that is no library");
  info = good, info.device = "no device has this name";
  if (strcmp(good.backend, "null"))
    expect_create(&info, CSM_ERROR_NO_DEVICE, "a device that is not there");
  assert_int_equal(record.blocks, 0);
}

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

  /* A smaller frame lacks its tail: no draw callback, no command buffer. */
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  csm_frame frame = f.scene.frame;
  frame.struct_size = offsetof(csm_frame, draw);
  frame.draw_user = &frame;
  assert_int_equal(csm_render_cascades(f.cascades, &frame), CSM_SUCCESS);

  /* Outputs are not written past the caller's size. */
  csm_binding binding;
  memset(&binding, 0x5a, sizeof binding);
  binding.struct_size = offsetof(csm_binding, origin);
  assert_int_equal(csm_bind(f.cascades, &binding), CSM_SUCCESS);
  assert_int_equal(binding.cascade_count, f.config.cascade_count);
  for (size_t i = offsetof(csm_binding, origin); i < sizeof binding; ++i)
    assert_int_equal(((const unsigned char *)&binding)[i], 0x5a);
  teardown(&f);
}

/* ---- meshes ---- */

static void meshes(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  snapshot before;
  take(&f, &before);
  float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  uint16_t indices[3] = {0, 1, 2};
  const csm_mesh_info good = {.struct_size = sizeof good,
                              .positions = positions,
                              .vertex_count = 3,
                              .indices = indices,
                              .index_count = 3,
                              .index_size = 2};
  csm_mesh_info info = good;
  csm_mesh mesh = 1;
  assert_int_equal(csm_mesh_create(NULL, &info, &mesh), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_mesh_create(f.context, NULL, &mesh), CSM_ERROR_NULL_POINTER, "no info");
  expect(&f, csm_mesh_create(f.context, &info, NULL), CSM_ERROR_NULL_POINTER, "no mesh");
  const struct {
    const char *what;
    csm_mesh_info info;
    csm_result expected;
  } cases[] = {
#define CASE(name, change, result) {name, (info = good, change, info), result}
      CASE("size", info.struct_size = 0, CSM_ERROR_STRUCT_SIZE),
      CASE("positions", info.positions = NULL, CSM_ERROR_NULL_POINTER),
      CASE("indices", info.indices = NULL, CSM_ERROR_NULL_POINTER),
      CASE("no vertices", info.vertex_count = 0, CSM_ERROR_INVALID_VALUE),
      CASE("no indices", info.index_count = 0, CSM_ERROR_INVALID_VALUE),
      CASE("half a triangle", info.index_count = 2, CSM_ERROR_INVALID_VALUE),
      CASE("index size", info.index_size = 3, CSM_ERROR_INVALID_VALUE),
      CASE("stride", info.position_stride = 8, CSM_ERROR_INVALID_VALUE),
      CASE("odd stride", info.position_stride = 13, CSM_ERROR_INVALID_VALUE),
      CASE("flags", info.flags = 4, CSM_ERROR_INVALID_VALUE),
      CASE("an index out of range", info.vertex_count = 2, CSM_ERROR_INVALID_INDEX),
#undef CASE
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    mesh = 1;
    expect(&f, csm_mesh_create(f.context, &cases[i].info, &mesh), cases[i].expected, cases[i].what);
    assert_int_equal(mesh, 0);
  }
  positions[4] = NAN;
  expect(&f, csm_mesh_create(f.context, &good, &mesh), CSM_ERROR_NOT_FINITE, "NaN");
  positions[4] = INFINITY;
  expect(&f, csm_mesh_create(f.context, &good, &mesh), CSM_ERROR_NOT_FINITE, "infinity");
  positions[4] = 0;
  expect(&f, csm_mesh_destroy(f.context, 0), CSM_ERROR_INVALID_HANDLE, "no handle");
  expect(&f, csm_mesh_destroy(f.context, 12345), CSM_ERROR_INVALID_HANDLE, "a handle from nowhere");
  assert_int_equal(csm_mesh_create(f.context, &good, &mesh), CSM_SUCCESS);
  assert_int_equal(csm_mesh_destroy(f.context, mesh), CSM_SUCCESS);
  expect(&f, csm_mesh_destroy(f.context, mesh), CSM_ERROR_INVALID_HANDLE, "destroyed twice");
  const csm_mesh forged = mesh + (1ull << 32); /* the generation that the empty place has now */
  expect(&f, csm_mesh_destroy(f.context, forged), CSM_ERROR_INVALID_HANDLE, "a forged handle to an empty place");
  csm_mesh next;
  assert_int_equal(csm_mesh_create(f.context, &good, &next), CSM_SUCCESS);
  assert_true(next != mesh);
  expect(&f, csm_mesh_destroy(f.context, mesh), CSM_ERROR_INVALID_HANDLE, "stale: its place was given again");
  assert_int_equal(csm_mesh_destroy(f.context, next), CSM_SUCCESS);
  unchanged(&f, &before);
  teardown(&f);
}

/* ---- configuration ---- */

static void expect_config(fixture *f, const csm_config *config, csm_result expected, const char *what) {
  csm_cascades *made = f->cascades;
  expect(f, csm_cascades_create(f->context, config, &made), expected, what);
  assert_null(made);
  expect(f, csm_cascades_configure(f->cascades, config), expected, what);
}

static void configurations(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  snapshot before;
  take(&f, &before);
  csm_cascades *made;
  assert_int_equal(csm_cascades_create(NULL, &f.config, &made), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_cascades_configure(NULL, &f.config), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_cascades_create(f.context, &f.config, NULL), CSM_ERROR_NULL_POINTER, "no cascades");
  expect_config(&f, NULL, CSM_ERROR_NULL_POINTER, "no configuration");

  /* Every field, by the library's own description of it: just outside its range, and not a number. */
  csm_config_field field = {.struct_size = sizeof field};
  uint32_t fields = 0;
  for (; csm_config_describe(fields, &field) == CSM_SUCCESS; ++fields) {
    for (uint32_t element = 0; element < field.length; ++element) {
      const bool real = field.type == CSM_FIELD_DOUBLE || field.type == CSM_FIELD_DOUBLES;
      const double bad[] = {field.minimum - 1, field.maximum * 1.001 + 1, NAN, INFINITY, -INFINITY};
      for (int i = 0; i < (real ? 5 : 2); ++i) {
        csm_config config = f.config;
        char *place = (char *)&config + field.offset;
        if (!real && bad[i] < 0)
          continue;
        if (real)
          memcpy(place + element * sizeof(double), &bad[i], sizeof bad[i]);
        else
          memcpy(place, &(uint32_t){(uint32_t)bad[i]}, sizeof(uint32_t));
        expect_config(&f, &config, i < 2 ? CSM_ERROR_INVALID_VALUE : CSM_ERROR_NOT_FINITE, field.name);
        assert_non_null(strstr(csm_last_error(f.context), field.name));
      }
    }
  }
  assert_true(fields >= 10);
  assert_int_equal(csm_config_describe(fields, &field), CSM_ERROR_INVALID_INDEX);
  assert_int_equal(csm_config_describe(0, NULL), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_config_default(NULL), CSM_ERROR_NULL_POINTER);

  csm_config config = f.config;
  config.bias_mode = 2;
  expect_config(&f, &config, CSM_ERROR_INVALID_VALUE, "a bias that is not there");
  config = f.config;
  config.split_mode = CSM_SPLIT_MANUAL;
  expect_config(&f, &config, CSM_ERROR_INVALID_VALUE, "manual splits that are not given");
  config.split_distances[0] = 5;
  config.split_distances[1] = 20;
  config.split_distances[2] = 20;
  expect_config(&f, &config, CSM_ERROR_INVALID_VALUE, "manual splits that do not rise");
  config = f.config;
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

/* ---- frames ---- */

static void expect_frame(fixture *f, const csm_frame *frame, csm_result expected, const char *what) {
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = frame, .width = 16, .height = 16};
  expect(f, csm_render_cascades(f->cascades, frame), expected, what);
  if (expected != CSM_ERROR_INVALID_LIGHT)
    expect(f, csm_resolve_mask(f->cascades, &mask), expected, what);
}

static void cameras(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  snapshot before;
  take(&f, &before);
  const csm_frame good = f.scene.frame;
  csm_frame frame = good;
  for (int i = 0; i < 16; ++i) {
    frame = good, frame.view[i] = NAN;
    expect_frame(&f, &frame, CSM_ERROR_NOT_FINITE, "NaN in view");
    frame = good, frame.projection[i] = -INFINITY;
    expect_frame(&f, &frame, CSM_ERROR_NOT_FINITE, "infinity in projection");
  }
  frame = good;
  memset(frame.view, 0, sizeof frame.view);
  frame.view[15] = 1;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_MATRIX, "a singular view");
  frame = good, frame.view[3] = 0.5;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_MATRIX, "a view that is not affine");
  frame = good;
  memset(frame.projection, 0, sizeof frame.projection);
  expect_frame(&f, &frame, CSM_ERROR_INVALID_MATRIX, "a singular projection");
  frame = good;
  support_perspective(frame.projection, 50, 1, 10, 10.0 - 1e-300);
  frame.projection[10] = frame.projection[14] = 0;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_MATRIX, "near equal to far");
  frame = good, frame.projection[10] = -1.5, frame.projection[14] = 0.5;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_CAMERA, "a far plane behind the eye");
  frame = good;
  support_perspective(frame.projection, 50, 1, 100, 0);
  expect(&f, csm_render_cascades(f.cascades, &frame), CSM_ERROR_INVALID_CAMERA, "near beyond the shadow distance");
  unchanged(&f, &before);
  teardown(&f);
}

static void CSM_CALL draw_nothing(void *user, const csm_draw_info *info) {
  (void)user;
  (void)info;
}

static void frames(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  snapshot before;
  take(&f, &before);
  const csm_frame good = f.scene.frame;
  csm_frame frame = good;
  assert_int_equal(csm_render_cascades(NULL, &frame), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_render_cascades(f.cascades, NULL), CSM_ERROR_NULL_POINTER, "no frame");
  frame.struct_size = 0;
  expect_frame(&f, &frame, CSM_ERROR_STRUCT_SIZE, "a forgotten struct_size");
  frame = good, frame.flags = 1u << 30;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_VALUE, "unknown flags");
  frame = good, frame.command_buffer = &frame;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_VALUE, "a command buffer on an own device");
  frame = good, frame.draw = draw_nothing;
  expect_frame(&f, &frame, CSM_ERROR_UNSUPPORTED, "a draw callback");
  frame = good, frame.instances = NULL;
  expect_frame(&f, &frame, CSM_ERROR_NULL_POINTER, "no instances");
  frame = good, frame.light_direction[1] = NAN;
  expect(&f, csm_render_cascades(f.cascades, &frame), CSM_ERROR_NOT_FINITE, "NaN in the light");
  frame = good, memset(frame.light_direction, 0, sizeof frame.light_direction);
  expect_frame(&f, &frame, CSM_ERROR_INVALID_LIGHT, "a zero light");

  csm_instance instances[SUPPORT_INSTANCES];
  frame = good, frame.instances = instances;
  const struct {
    const char *what;
    int element;
    double value;
    csm_result expected;
  } transforms[] = {
      {"NaN in a transform", 5, NAN, CSM_ERROR_NOT_FINITE},
      {"infinity in a transform", 12, INFINITY, CSM_ERROR_NOT_FINITE},
      {"a singular transform", 5, 0, CSM_ERROR_INVALID_MATRIX},
      {"a projective transform", 3, 1, CSM_ERROR_INVALID_MATRIX},
      {"a transform with w = 2", 15, 2, CSM_ERROR_INVALID_MATRIX},
  };
  for (size_t i = 0; i < sizeof transforms / sizeof transforms[0]; ++i) {
    memcpy(instances, good.instances, sizeof instances);
    instances[4].transform[transforms[i].element] = transforms[i].value;
    expect_frame(&f, &frame, transforms[i].expected, transforms[i].what);
  }
  memcpy(instances, good.instances, sizeof instances), instances[3].mesh = 0;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_HANDLE, "an instance without a mesh");
  memcpy(instances, good.instances, sizeof instances), instances[5].mesh ^= 1ull << 40;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_HANDLE, "an instance with a stale mesh");
  memcpy(instances, good.instances, sizeof instances), instances[0].struct_size = 0;
  expect_frame(&f, &frame, CSM_ERROR_STRUCT_SIZE, "an instance without struct_size");
  memcpy(instances, good.instances, sizeof instances), instances[2].struct_size -= 8;
  expect_frame(&f, &frame, CSM_ERROR_STRUCT_SIZE, "instances of two sizes");
  memcpy(instances, good.instances, sizeof instances), instances[1].flags = 4;
  expect_frame(&f, &frame, CSM_ERROR_INVALID_VALUE, "an instance with unknown flags");
  unchanged(&f, &before);
  teardown(&f);
}

static void masks_and_reading(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  snapshot before;
  take(&f, &before);
  const csm_mask_info good = {.struct_size = sizeof good, .frame = &f.scene.frame, .width = 16, .height = 16};
  csm_mask_info mask = good;
  float data[64 * 64];
  const csm_read_info all = {.struct_size = sizeof all, .data = data, .size = sizeof data};
  csm_read_info read = all;
  read.source = CSM_READ_MASK;
  expect(&f, csm_read(f.cascades, &read), CSM_ERROR_INVALID_STATE, "a mask that was never resolved");
  assert_int_equal(csm_resolve_mask(NULL, &mask), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_resolve_mask(f.cascades, NULL), CSM_ERROR_NULL_POINTER, "no mask info");
  mask.width = 0;
  expect(&f, csm_resolve_mask(f.cascades, &mask), CSM_ERROR_INVALID_VALUE, "no width");
  mask = good, mask.height = 1u << 20;
  expect(&f, csm_resolve_mask(f.cascades, &mask), CSM_ERROR_INVALID_VALUE, "absurdly high");
  mask = good, mask.frame = NULL;
  expect(&f, csm_resolve_mask(f.cascades, &mask), CSM_ERROR_NULL_POINTER, "no frame");
  mask = good, mask.flags = 2;
  expect(&f, csm_resolve_mask(f.cascades, &mask), CSM_ERROR_INVALID_VALUE, "unknown flags");
  mask = good, mask.camera_depth = &mask;
  expect(&f, csm_resolve_mask(f.cascades, &mask), CSM_ERROR_UNSUPPORTED, "an engine's depth");
  mask = good, mask.normals = &mask;
  expect(&f, csm_resolve_mask(f.cascades, &mask), CSM_ERROR_UNSUPPORTED, "an engine's normals");
  mask = good, mask.view = 3;
  expect(&f, csm_resolve_mask(f.cascades, &mask), CSM_ERROR_INVALID_VALUE, "no such view");
  assert_non_null(strstr(csm_last_error(f.context), "view 3"));
  mask = good, mask.reserved = 1;
  expect(&f, csm_resolve_mask(f.cascades, &mask), CSM_ERROR_INVALID_VALUE, "something reserved");
  unchanged(&f, &before);

  assert_int_equal(csm_read(NULL, &read), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_read(f.cascades, NULL), CSM_ERROR_NULL_POINTER, "no read info");
  read = all, read.source = 3;
  expect(&f, csm_read(f.cascades, &read), CSM_ERROR_INVALID_VALUE, "no such source");
  read = all, read.cascade = 3;
  expect(&f, csm_read(f.cascades, &read), CSM_ERROR_INVALID_INDEX, "no such cascade");
  read = all, read.data = NULL;
  expect(&f, csm_read(f.cascades, &read), CSM_ERROR_NULL_POINTER, "nowhere to read to");
  read = all, read.size -= 4;
  expect(&f, csm_read(f.cascades, &read), CSM_ERROR_INVALID_VALUE, "too little room");

  csm_binding binding = {0};
  csm_stats stats = {0};
  assert_int_equal(csm_bind(NULL, &binding), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_get_stats(NULL, &stats), CSM_ERROR_NULL_POINTER);
  uint8_t drawn[SUPPORT_INSTANCES];
  assert_int_equal(csm_get_casters(NULL, SUPPORT_INSTANCES, drawn), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_get_casters(f.cascades, SUPPORT_INSTANCES, NULL), CSM_ERROR_NULL_POINTER, "nowhere to tell casters");
  expect(&f, csm_get_casters(f.cascades, SUPPORT_INSTANCES - 1, drawn), CSM_ERROR_INVALID_VALUE, "another count");
  expect(&f, csm_bind(f.cascades, NULL), CSM_ERROR_NULL_POINTER, "no binding");
  expect(&f, csm_bind(f.cascades, &binding), CSM_ERROR_STRUCT_SIZE, "a binding without struct_size");
  expect(&f, csm_get_stats(f.cascades, &stats), CSM_ERROR_STRUCT_SIZE, "stats without struct_size");
  expect(&f, csm_switch_backend(f.context, NULL), CSM_ERROR_NULL_POINTER, "switching to nothing");
  expect(&f, csm_retire(f.context, 1), CSM_ERROR_UNSUPPORTED, "retiring");
  assert_int_equal(csm_switch_backend(NULL, NULL), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_retire(NULL, 1), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_cascades_destroy(NULL), CSM_SUCCESS);
  csm_destroy(NULL);
  assert_string_equal(csm_last_error(NULL), "");

  /* A new configuration has no maps until it has drawn them. */
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  expect(&f, csm_resolve_mask(f.cascades, &good), CSM_ERROR_INVALID_STATE, "a mask before the maps");
  binding.struct_size = sizeof binding;
  expect(&f, csm_bind(f.cascades, &binding), CSM_ERROR_INVALID_STATE, "a binding before the maps");
  expect(&f, csm_read(f.cascades, &all), CSM_ERROR_INVALID_STATE, "a map that was not drawn");
  expect(&f, csm_get_casters(f.cascades, SUPPORT_INSTANCES, drawn), CSM_ERROR_INVALID_STATE, "casters before the maps");
  teardown(&f);
}

/* A resolve of another size that fails, wherever it does, leaves the mask that was there. */
static void a_failed_mask_leaves_the_last(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  csm_mask_info mask = {.struct_size = sizeof mask, .frame = &f.scene.frame, .width = 16, .height = 16};
  assert_int_equal(csm_resolve_mask(f.cascades, &mask), CSM_SUCCESS);
  mask.width = 48;
  csm_result result;
  int64_t failures = 0;
  do {
    f.record.allocations_left = failures++;
    result = csm_resolve_mask(f.cascades, &mask);
    f.record.allocations_left = -1;
    free(support_read(f.cascades, CSM_READ_MASK, 0, result ? 16 : 48, 16));
  } while (result);
  assert_true(failures > 3);
  teardown(&f);
}

/* ---- memory ---- */

/* One frame with everything in it; stops at the first error. */
static csm_result run_all(record *record) {
  csm_context *context = NULL;
  csm_cascades *cascades = NULL;
  csm_mesh mesh;
  csm_create_info info = support_create_info(record);
  info.flags = 0;
  csm_result result = csm_create(&info, &context);
  const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  const uint16_t indices[3] = {0, 1, 2};
  const csm_mesh_info triangle = {.struct_size = sizeof triangle,
                                  .positions = positions,
                                  .vertex_count = 3,
                                  .indices = indices,
                                  .index_count = 3,
                                  .index_size = 2};
  csm_config config = support_config();
  config.resolution = 16;
  support_scene scene;
  float data[16 * 16];
  support_scene_make(&scene, NULL);
  if (!result)
    result = csm_mesh_create(context, &triangle, &mesh);
  if (!result)
    result = csm_cascades_create(context, &config, &cascades);
  for (int i = 0; i < SUPPORT_INSTANCES; ++i)
    scene.instances[i].mesh = mesh;
  if (!result)
    result = csm_render_cascades(cascades, &scene.frame);
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = &scene.frame, .width = 16, .height = 16};
  if (!result)
    result = csm_resolve_mask(cascades, &mask);
  const csm_read_info read = {.struct_size = sizeof read, .source = CSM_READ_MASK, .data = data, .size = sizeof data};
  if (!result)
    result = csm_read(cascades, &read);
  csm_destroy(context);
  return result;
}

/* Each allocation in turn fails: a named error, and nothing is kept. */
static void allocations_may_fail(void **state) {
  (void)state;
  record record = {0};
  support_create_info(&record);
  record.quiet = true;
  csm_result result;
  int64_t failures = 0;
  do {
    record.allocations_left = failures;
    result = run_all(&record);
    if (result && result != CSM_ERROR_OUT_OF_MEMORY && result != CSM_ERROR_OUT_OF_DEVICE_MEMORY)
      fail_msg("allocation %d: %s", (int)failures, csm_result_name(result));
    assert_int_equal(record.blocks, 0);
    ++failures;
  } while (result);
  assert_true(failures > 10);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(creation),
      cmocka_unit_test(struct_sizes),
      cmocka_unit_test(meshes),
      cmocka_unit_test(configurations),
      cmocka_unit_test(the_memory_limit_is_kept),
      cmocka_unit_test(cameras),
      cmocka_unit_test(frames),
      cmocka_unit_test(masks_and_reading),
      cmocka_unit_test(a_failed_mask_leaves_the_last),
      cmocka_unit_test(allocations_may_fail),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
