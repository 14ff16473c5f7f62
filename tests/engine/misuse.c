/* misuse.c: what an engine may get wrong is told by name, and changes nothing. */
#include "stage.h"

#include <string.h>

static const picture_size size = {96, 64};

/* ---- devices ---- */

/* What csm_create says, into `text`; whatever it made is destroyed again. */
static csm_result create(csm_create_info info, record *record, char text[512]) {
  csm_context *context = NULL;
  text[0] = '\0';
  record->quiet = true;
  info.error = text;
  info.error_size = 512;
  const csm_result result = csm_create(&info, &context);
  csm_destroy(context);
  assert_int_equal(record->blocks, 0);
  return result;
}

static void expect_device(rig *rig, const rig_native *device, const misuse *row) {
  record record = {0};
  char text[512];
  csm_create_info info = stage_create_info(rig, &record);
  rig_give_device(device, &info);
  const csm_result result = create(info, &record, text);
  misuse_expect(row, result, text);
}

/* A struct of a later header, with a tail: of zeros, and not. */
static void expect_later_device(rig *rig, const rig_native *good) {
  static const misuse zero = {.what = "a later struct, whose tail is zero"};
  static const misuse other = {
      .what = "a later struct, whose tail is not", .expected = CSM_ERROR_STRUCT_SIZE, .words = "struct_size"};
  rig_native later = *good;
  const uint32_t known = rig_struct_size(RIG_DEVICE), larger = known + 16;
  memcpy(&later, &larger, sizeof larger);
  expect_device(rig, &later, &zero);
  later.bytes[larger - 1] = 1;
  expect_device(rig, &later, &other);
}

static void devices_are_checked(void **state) {
  (void)state;
  static const misuse fine = {.what = "a good device"};
  misuse rows[MISUSE_ROWS];
  rig_native good;
  rig *rig = rig_open(RIG_TYPICAL);
  const uint32_t count = rig_misuses(rig, RIG_DEVICE, NULL, NULL, &good, rows);
  expect_device(rig, &good, &fine);
  for (uint32_t i = 0; i < count; ++i) {
    rig_native device = good;
    misuse_apply(&rows[i], &device);
    expect_device(rig, &device, &rows[i]);
  }
  expect_later_device(rig, &good);
  rig_close(rig);
}

static void other_apis_are_refused(void **state) {
  (void)state;
  record record = {0};
  char text[512];
  rig *rig = rig_open(RIG_BARE);
  csm_create_info info = stage_create_info(NULL, &record);
  rig_give_foreign_device(&info);
  assert_int_equal(create(info, &record, text), CSM_ERROR_UNSUPPORTED);
  assert_true(text[0]);
  rig_give(rig, &info);
  assert_int_equal(create(info, &record, text), CSM_ERROR_INVALID_VALUE); /* two devices */
  assert_true(text[0]);
  info = stage_create_info(rig, &record);
  info.backend = "null";
  assert_int_equal(create(info, &record, text), CSM_ERROR_UNSUPPORTED);
  assert_true(text[0]);

  stage stage;
  stage_open(&stage, rig);
  stage.record.quiet = true;
  csm_mesh_info mesh_info = {
      .struct_size = sizeof mesh_info, .vertex_count = 3, .index_count = 3, .index_size = 2, .bounds_max = {1, 1, 1}};
  csm_mesh mesh;
  rig_give_foreign_mesh(&mesh_info);
  assert_int_equal(csm_mesh_create(stage.context, &mesh_info, &mesh), CSM_ERROR_UNSUPPORTED);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- what is handed in later ---- */

typedef struct fixture {
  rig *rig;
  stage stage;
  rig_image *image;
  rig_buffer buffer;
} fixture;

static void fixture_open(fixture *f) {
  static const float texels[96 * 64];
  f->rig = rig_open(RIG_TYPICAL);
  stage_open(&f->stage, f->rig);
  f->image = rig_image_make(
      f->rig, &(rig_image_info){
                  .format = RIG_DEPTH_32, .way = rig_depth_ways - 1, .width = 96, .height = 64, .texels = texels});
  f->buffer = rig_buffer_make(f->rig, RIG_GEOMETRY, 4096);
  f->stage.record.quiet = true;
}

/* The context still draws, what an own device draws, and holds nothing. */
static void fixture_close(fixture *f) {
  stage own;
  stage_open(&own, NULL);
  picture expected = stage_draw_at(&own, 0, size), drawn = stage_draw_at(&f->stage, 0, size);
  picture_expect_equal(&expected, &drawn);
  picture_free(&expected);
  stage_close(&own);
  rig_image_free(f->rig, f->image);
  rig_buffer_free(f->rig, &f->buffer);
  stage_close(&f->stage);
  rig_close(f->rig);
}

/* With an alpha mask, or 0. */
static void expect_tested_mesh(fixture *f, const rig_native *native, csm_alpha_mask alpha_mask, const misuse *row) {
  csm_mesh_info info = {.struct_size = sizeof info,
                        .vertex_count = 3,
                        .index_count = 3,
                        .index_size = 2,
                        .bounds_min = {-1, -1, -1},
                        .bounds_max = {1, 1, 1},
                        .alpha_mask = alpha_mask,
                        .alpha_cutoff = alpha_mask ? 0.5f : 0};
  csm_mesh mesh = 1;
  rig_give_mesh(native, &info);
  const csm_result result = csm_mesh_create(f->stage.context, &info, &mesh);
  misuse_expect(row, result, csm_last_error(f->stage.context)); /* the backend's words, which name the field */
  assert_true((mesh != 0) == !result);
  if (!result)
    assert_int_equal(csm_mesh_destroy(f->stage.context, mesh), CSM_SUCCESS);
}

static void expect_mesh(fixture *f, const rig_native *native, const misuse *row) {
  expect_tested_mesh(f, native, 0, row);
}

static void meshes_are_checked(void **state) {
  (void)state;
  static const misuse fine = {.what = "a good mesh"};
  static const misuse later = {
      .what = "a later struct, whose tail is not zero", .expected = CSM_ERROR_STRUCT_SIZE, .words = "struct_size"};
  misuse rows[MISUSE_ROWS];
  rig_native good, native;
  fixture f;
  fixture_open(&f);
  const uint32_t count = rig_misuses(f.rig, RIG_MESH, f.image, &f.buffer, &good, rows);
  expect_mesh(&f, &good, &fine);
  for (uint32_t i = 0; i < count; ++i) {
    native = good;
    misuse_apply(&rows[i], &native);
    expect_mesh(&f, &native, &rows[i]);
  }
  native = good;
  const uint32_t larger = rig_struct_size(RIG_MESH) + 8;
  memcpy(&native, &larger, sizeof larger);
  native.bytes[larger - 1] = 1;
  expect_mesh(&f, &native, &later);
  fixture_close(&f);
}

/* Where uvs lie is read, and checked, for a mesh with an alpha mask alone. */
static void alpha_tested_meshes_are_checked(void **state) {
  (void)state;
  static const misuse fine = {.what = "a good mesh"};
  static const uint8_t texel = 255;
  const csm_alpha_mask_info info = {.struct_size = sizeof info, .width = 1, .height = 1, .texels = &texel};
  misuse rows[MISUSE_ROWS];
  rig_native good;
  fixture f;
  csm_alpha_mask mask;
  fixture_open(&f);
  assert_int_equal(csm_alpha_mask_create(f.stage.context, &info, &mask), CSM_SUCCESS);
  const uint32_t count = rig_misuses(f.rig, RIG_TESTED_MESH, f.image, &f.buffer, &good, rows);
  expect_tested_mesh(&f, &good, mask, &fine);
  for (uint32_t i = 0; i < count; ++i) {
    rig_native native = good;
    misuse_apply(&rows[i], &native);
    expect_tested_mesh(&f, &native, mask, &rows[i]);
    expect_mesh(&f, &native, &fine);
  }
  fixture_close(&f);
}

/* In a frame that is open, whose maps are drawn. */
static void expect_images(fixture *f, const void *depth, const void *normals, const void *motion, const misuse *row) {
  shot shot = stage_shot(&f->stage, 0);
  const csm_mask_info mask = {.struct_size = sizeof mask,
                              .frame = shot_frame(&shot),
                              .width = size.width,
                              .height = size.height,
                              .camera_depth = depth,
                              .normals = normals,
                              .motion = motion};
  const csm_result result = csm_resolve_mask(f->stage.view, f->stage.cascades, &mask);
  misuse_expect(row, result, csm_last_error(f->stage.context));
}

/* In place of depth, or of normals and of motion beside a good depth. */
static void expect_image_rows(fixture *f, const rig_image *image, const rig_native *depth) {
  misuse rows[MISUSE_ROWS];
  rig_native good;
  const uint32_t count = rig_misuses(f->rig, RIG_IMAGE, image, &f->buffer, &good, rows);
  for (uint32_t i = 0; i < count; ++i) {
    rig_native wrong = good;
    misuse_apply(&rows[i], &wrong);
    expect_images(f, depth ? depth : (const void *)&wrong, depth ? &wrong : NULL, NULL, &rows[i]);
    if (depth)
      expect_images(f, depth, NULL, &wrong, &rows[i]);
  }
}

static void images_are_checked(void **state) {
  (void)state;
  static const float texels[96 * 64 * 4];
  static const misuse fine = {.what = "good images"};
  static const misuse no_depth = {.what = "normals for depth", .expected = CSM_ERROR_INVALID_VALUE, .words = "depth"};
  static const misuse no_normals = {
      .what = "depth for normals", .expected = CSM_ERROR_INVALID_VALUE, .words = "normals"};
  static const misuse no_motion = {.what = "depth for motion", .expected = CSM_ERROR_INVALID_VALUE, .words = "motion"};
  misuse rows[MISUSE_ROWS];
  rig_native depth, normals;
  fixture f;
  fixture_open(&f);
  f.stage.config.history = CSM_HISTORY_ON; /* motion is read */
  stage_configure(&f.stage);
  rig_image *image = rig_image_make(
      f.rig, &(rig_image_info){.format = RIG_RGBA_FLOAT_32, .width = 96, .height = 64, .texels = texels});
  rig_misuses(f.rig, RIG_IMAGE, f.image, &f.buffer, &depth, rows);
  rig_misuses(f.rig, RIG_IMAGE, image, &f.buffer, &normals, rows);
  rig_begin(f.rig);
  shot shot = stage_shot(&f.stage, 0);
  stage_render(&f.stage, &shot);
  expect_image_rows(&f, f.image, NULL);
  expect_image_rows(&f, image, &depth);
  expect_images(&f, &normals, NULL, NULL, &no_depth);
  expect_images(&f, &depth, &depth, NULL, &no_normals);
  expect_images(&f, &depth, NULL, &depth, &no_motion);
  expect_images(&f, &depth, &normals, &normals, &fine);
  stage_finish(&f.stage);
  rig_image_free(f.rig, image);
  fixture_close(&f);
}

/* ---- frames ---- */

static csm_result render(const stage *stage, uint64_t number, void *commands) {
  shot shot = stage_shot(stage, 0);
  shot.frame.frame = number;
  shot.frame.command_buffer = commands;
  return csm_render_cascades(stage->cascades, shot_frame(&shot));
}

static csm_result resolve(const stage *stage, uint64_t number, void *commands) {
  shot shot = stage_shot(stage, 0);
  shot.frame.frame = number;
  shot.frame.command_buffer = commands;
  return shot_resolve(&shot, stage->view, stage->cascades, size.width, size.height);
}

static void frames_are_counted(void **state) {
  (void)state;
  stage own, stage;
  float texels[4];
  stage_open(&own, NULL);
  picture expected = stage_draw_at(&own, 0, size);
  stage_close(&own);
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  stage.record.quiet = true;
  void *commands = rig_begin(rig);
  assert_int_equal(csm_retire(stage.context, 1), CSM_SUCCESS); /* the engine had frames without csm */
  assert_int_equal(render(&stage, 1, commands), CSM_ERROR_INVALID_VALUE);
  assert_int_equal(resolve(&stage, 1, commands), CSM_ERROR_INVALID_STATE);
  assert_int_equal(render(&stage, 2, NULL), CSM_ERROR_NULL_POINTER);
  assert_int_equal(render(&stage, 0, commands), CSM_ERROR_INVALID_VALUE);
  for (uint64_t i = 1; i <= RIG_FRAMES; ++i) {
    if (i > 1) {
      rig_end(rig);
      commands = rig_begin(rig);
    }
    assert_int_equal(render(&stage, 10 * i, commands), CSM_SUCCESS);
    assert_int_equal(render(&stage, 10 * i, commands), CSM_SUCCESS);
    assert_int_equal(render(&stage, 10 * i - 1, commands), CSM_ERROR_INVALID_VALUE);
  }
  /* The last command buffer is open: what is refused leaves no trace in it. */
  assert_int_equal(render(&stage, 40, commands), CSM_ERROR_INVALID_STATE);
  assert_int_equal(resolve(&stage, 41, commands), CSM_ERROR_INVALID_STATE);
  assert_int_equal(resolve(&stage, 30, commands), CSM_SUCCESS);
  const csm_read_info read = {
      .struct_size = sizeof read, .cascades = stage.cascades, .data = texels, .size = sizeof texels};
  assert_int_equal(csm_read(stage.context, &read), CSM_ERROR_UNSUPPORTED);
  picture_copy copy = stage_record(&stage, size);
  rig_end(rig);
  rig_run(rig, rig_frame(rig));
  picture drawn = picture_take(rig, &copy);
  picture_expect_equal(&expected, &drawn);
  picture_free(&expected);
  assert_int_equal(csm_retire(stage.context, 10), CSM_SUCCESS);
  commands = rig_begin(rig);
  assert_int_equal(render(&stage, 40, commands), CSM_SUCCESS);
  assert_int_equal(render(&stage, 41, commands), CSM_ERROR_INVALID_STATE);
  rig_end(rig);
  rig_run(rig, rig_frame(rig));
  assert_int_equal(csm_retire(stage.context, 40), CSM_SUCCESS);
  stage_close(&stage);
  rig_close(rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(devices_are_checked),
      cmocka_unit_test(other_apis_are_refused),
      cmocka_unit_test(meshes_are_checked),
      cmocka_unit_test(images_are_checked),
      cmocka_unit_test(alpha_tested_meshes_are_checked),
      cmocka_unit_test(frames_are_counted),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
