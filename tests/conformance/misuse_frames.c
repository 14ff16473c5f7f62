/* misuse_frames.c: every misuse of a frame, a mask, or a question about them gets its named error and a text, and
   leaves all as it was, on every backend alike. */
#include "misuse_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- frames ---- */

/* Rendering and resolving answer alike, but that resolving reads no light. */
static csm_result draw(fixture *f, shot *shot, bool resolves) {
  const csm_result rendered = csm_render_cascades(f->cascades, shot_frame(shot));
  if (resolves && shot_resolve(shot, f->view, f->cascades, SIDE, SIDE) != rendered)
    fail_msg("rendering says %s (%s), resolving does not", csm_result_name(rendered), csm_last_error(f->context));
  return rendered;
}

static csm_result draw_camera(fixture *f, const void *camera) {
  shot shot = f->scene.shot;
  memcpy(&shot.camera, camera, sizeof shot.camera);
  return draw(f, &shot, true);
}

static csm_result draw_light(fixture *f, const void *light) {
  shot shot = f->scene.shot;
  memcpy(&shot.light, light, sizeof shot.light);
  return draw(f, &shot, false);
}

static csm_result draw_frame(fixture *f, const void *frame) {
  shot shot = f->scene.shot;
  memcpy(&shot.frame, frame, sizeof shot.frame);
  return draw(f, &shot, true);
}

static csm_result draw_instance(fixture *f, const void *instance) {
  shot shot = f->scene.shot;
  csm_instance instances[SUPPORT_INSTANCES];
  memcpy(instances, f->scene.instances, sizeof instances);
  memcpy(&instances[4], instance, sizeof instances[4]);
  shot.frame.instances = instances;
  return draw(f, &shot, true);
}

#define CAMERA(field) FIELD(csm_camera, field)

static void cameras(void **state) {
  (void)state;
  static const misuse rows[] = {
      {"no size", CAMERA(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "camera"},
      {"reversed of 3", CAMERA(reversed), {3}, CSM_ERROR_INVALID_VALUE, "reversed"},
      {"a view that is not affine", CAMERA(view[3]), {.real = 0.5}, CSM_ERROR_INVALID_MATRIX, "view"},
      {"a view that scales", CAMERA(view[5]), {.real = 30}, CSM_ERROR_INVALID_MATRIX, "view"},
  };
  fixture f;
  snapshot before;
  setup(&f);
  take(&f, &before);
  const csm_camera good = f.scene.shot.camera;
  check_rows(&f, &(row_table){rows, COUNT(rows), &good, sizeof good}, draw_camera);
  for (int i = 0; i < 16; ++i) {
    csm_camera camera = good;
    camera.view[i] = NAN;
    expect(&f, draw_camera(&f, &camera), CSM_ERROR_NOT_FINITE, "NaN in view");
    camera = good, camera.projection[i] = -INFINITY;
    expect(&f, draw_camera(&f, &camera), CSM_ERROR_NOT_FINITE, "infinity in projection");
  }
  csm_camera camera = good;
  memset(camera.view, 0, sizeof camera.view);
  camera.view[15] = 1;
  expect(&f, draw_camera(&f, &camera), CSM_ERROR_INVALID_MATRIX, "a singular view");
  camera = good;
  memset(camera.projection, 0, sizeof camera.projection);
  expect(&f, draw_camera(&f, &camera), CSM_ERROR_INVALID_MATRIX, "a singular projection");
  camera = good, camera.projection[10] = camera.projection[14] = 0;
  expect(&f, draw_camera(&f, &camera), CSM_ERROR_INVALID_MATRIX, "near equal to far");
  camera = good, camera.projection[10] = -1.5, camera.projection[14] = 0.5;
  expect(&f, draw_camera(&f, &camera), CSM_ERROR_INVALID_CAMERA, "a far plane behind the eye");
  unchanged(&f, &before);
  teardown(&f);
}

#define LIGHT(field) FIELD(csm_light, field)

static void lights(void **state) {
  (void)state;
  static const misuse rows[] = {
      {"no size", LIGHT(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "light"},
      {"NaN", LIGHT(direction[1]), {.real = NAN}, CSM_ERROR_NOT_FINITE, "direction"},
      {"a disc of NaN", LIGHT(angular_diameter), {.real = NAN}, CSM_ERROR_NOT_FINITE, "angular_diameter"},
      {"a disc below nothing", LIGHT(angular_diameter), {.real = -1e-9}, CSM_ERROR_INVALID_VALUE, "angular_diameter"},
      {"half a sky", LIGHT(angular_diameter), {.real = 1.01}, CSM_ERROR_INVALID_VALUE, "angular_diameter"},
  };
  fixture f;
  snapshot before;
  setup(&f);
  take(&f, &before);
  csm_light light = f.scene.shot.light;
  check_rows(&f, &(row_table){rows, COUNT(rows), &light, sizeof light}, draw_light);
  memset(light.direction, 0, sizeof light.direction);
  expect(&f, draw_light(&f, &light), CSM_ERROR_INVALID_LIGHT, "no direction");
  unchanged(&f, &before);
  teardown(&f);
}

static void CSM_CALL draw_nothing(void *user, const csm_draw_info *info) {
  (void)user;
  (void)info;
}

#define FRAME(field) FIELD(csm_frame, field)

/* Fields that resolving reads; rendering reads the light, the origin and the callback as well. */
static void frames(void **state) {
  (void)state;
  static const misuse rows[] = {
      {"a forgotten struct_size", FRAME(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "csm_frame"},
      {"unknown flags", FRAME(flags), {1u << 30}, CSM_ERROR_INVALID_VALUE, "flags"},
      {"a command buffer on an own device",
       FRAME(command_buffer),
       {.pointer = draw_nothing},
       CSM_ERROR_INVALID_VALUE,
       "command_buffer"},
      {"a number on an own device", FRAME(frame), {1}, CSM_ERROR_INVALID_VALUE, "frame"},
      {"no instances", FRAME(instances), {0}, CSM_ERROR_NULL_POINTER, "instances"},
      {"reserved", FRAME(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
  };
  static const double bad_origin[3] = {0, NAN, 0};
  fixture f;
  snapshot before;
  setup(&f);
  take(&f, &before);
  const csm_frame good = *shot_frame(&f.scene.shot);
  csm_frame frame = good;
  assert_int_equal(csm_render_cascades(NULL, &frame), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_render_cascades(f.cascades, NULL), CSM_ERROR_NULL_POINTER, "no frame");
  check_rows(&f, &(row_table){rows, COUNT(rows), &good, sizeof good}, draw_frame);
  frame = good, frame.camera = NULL;
  expect(&f, csm_render_cascades(f.cascades, &frame), CSM_ERROR_NULL_POINTER, "no camera");
  frame = good, frame.light = NULL;
  expect(&f, csm_render_cascades(f.cascades, &frame), CSM_ERROR_NULL_POINTER, "no light");
  frame = good, frame.origin = bad_origin;
  expect(&f, csm_render_cascades(f.cascades, &frame), CSM_ERROR_NOT_FINITE, "an origin of NaN");
  frame = good, frame.draw = draw_nothing;
  expect(&f, csm_render_cascades(f.cascades, &frame), CSM_ERROR_UNSUPPORTED, "a draw callback");
  unchanged(&f, &before);
  teardown(&f);
}

static void instances(void **state) {
  (void)state;
  fixture f;
  snapshot before;
  setup(&f);
  take(&f, &before);
  check_instances(&f, &f.scene.instances[4], draw_instance);
  unchanged(&f, &before);
  teardown(&f);
}

/* ---- masks ---- */

static csm_result resolve(fixture *f, const void *info) {
  return csm_resolve_mask(f->view, f->cascades, info);
}

#define MASK(field) FIELD(csm_mask_info, field)

static void masks(void **state) {
  (void)state;
  static const misuse rows[] = {
      {"no size", MASK(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "csm_mask_info"},
      {"no width", MASK(width), {0}, CSM_ERROR_INVALID_VALUE, "0 x 16"},
      {"absurdly high", MASK(height), {1u << 20}, CSM_ERROR_INVALID_VALUE, "1048576"},
      {"no frame", MASK(frame), {0}, CSM_ERROR_NULL_POINTER, "frame"},
      {"unknown flags", MASK(flags), {2}, CSM_ERROR_INVALID_VALUE, "flags"},
      {"an engine's depth", MASK(camera_depth), {.pointer = "an image"}, CSM_ERROR_UNSUPPORTED, "camera_depth"},
      {"an engine's normals", MASK(normals), {.pointer = "an image"}, CSM_ERROR_UNSUPPORTED, "normals"},
      {"an engine's motion", MASK(motion), {.pointer = "an image"}, CSM_ERROR_UNSUPPORTED, "motion"},
      {"a history that is not kept", MASK(show), {CSM_SHOW_HISTORY}, CSM_ERROR_INVALID_VALUE, "history"},
      {"a penumbra that the filter does not find",
       MASK(show),
       {CSM_SHOW_PENUMBRA},
       CSM_ERROR_INVALID_VALUE,
       "penumbra"},
      {"rays that the filter does not send", MASK(show), {CSM_SHOW_RAYS}, CSM_ERROR_INVALID_VALUE, "rays"},
      {"pages that maps do not have", MASK(show), {CSM_SHOW_PAGES}, CSM_ERROR_INVALID_VALUE, "pages"},
      {"nothing to show", MASK(show), {CSM_SHOW_PAGES + 1}, CSM_ERROR_INVALID_VALUE, "no show"},
      {"reserved", MASK(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
  };
  fixture f;
  snapshot before;
  setup(&f);
  take(&f, &before);
  const csm_mask_info good = {
      .struct_size = sizeof good, .frame = shot_frame(&f.scene.shot), .width = SIDE, .height = SIDE};
  assert_int_equal(csm_resolve_mask(NULL, f.cascades, &good), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_resolve_mask(f.view, NULL, &good), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_resolve_mask(f.view, f.cascades, NULL), CSM_ERROR_NULL_POINTER, "no info");
  check_rows(&f, &(row_table){rows, COUNT(rows), &good, sizeof good}, resolve);
  csm_view_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_view_stats(f.view, &stats), CSM_SUCCESS);
  assert_true(stats.width == 0 && stats.bytes == 0);
  unchanged(&f, &before);

  /* A new configuration has no maps until it has drawn them. */
  uint8_t drawn[SUPPORT_INSTANCES];
  csm_binding binding = {.struct_size = sizeof binding};
  float data[RESOLUTION * RESOLUTION];
  const csm_read_info read = {.struct_size = sizeof read, .cascades = f.cascades, .data = data, .size = sizeof data};
  assert_int_equal(csm_cascades_configure(f.cascades, &f.config), CSM_SUCCESS);
  expect(&f, resolve(&f, &good), CSM_ERROR_INVALID_STATE, "a mask before the maps");
  expect(&f, csm_bind(f.cascades, &binding), CSM_ERROR_INVALID_STATE, "a binding before the maps");
  expect(&f, csm_read(f.context, &read), CSM_ERROR_INVALID_STATE, "a map that was not drawn");
  expect(&f, csm_get_casters(f.cascades, SUPPORT_INSTANCES, NULL, drawn), CSM_ERROR_INVALID_STATE,
         "casters before the maps");
  teardown(&f);
}

/* A resolve of another size that fails, wherever it does, leaves the mask that was there. */
static void a_failed_mask_leaves_the_last(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  assert_int_equal(shot_resolve(&f.scene.shot, f.view, f.cascades, SIDE, SIDE), CSM_SUCCESS);
  csm_result result;
  int64_t failures = 0;
  do {
    f.record.allocations_left = failures++;
    result = shot_resolve(&f.scene.shot, f.view, f.cascades, 48, SIDE);
    f.record.allocations_left = -1;
    free(support_image(f.context, f.view, CSM_READ_MASK, result ? SIDE : 48, SIDE));
  } while (result);
  assert_true(failures > 3);
  teardown(&f);
}

/* ---- what is asked afterwards ---- */

static csm_result read_texels(fixture *f, const void *info) {
  return csm_read(f->context, info);
}

#define READ(field) FIELD(csm_read_info, field)

static void reading(void **state) {
  (void)state;
  static float data[RESOLUTION * RESOLUTION];
  static const misuse rows[] = {
      {"no size", READ(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "csm_read_info"},
      {"no such source", READ(source), {CSM_READ_MOMENTS + 1}, CSM_ERROR_INVALID_VALUE, "source"},
      {"no such cascade", READ(cascade), {3}, CSM_ERROR_INVALID_INDEX, "cascade"},
      {"no cascades", READ(cascades), {0}, CSM_ERROR_NULL_POINTER, "cascades"},
      {"nowhere to read to", READ(data), {0}, CSM_ERROR_NULL_POINTER, "data"},
      {"too little room", READ(size), {sizeof data - 4}, CSM_ERROR_INVALID_VALUE, "size"},
      {"reserved", READ(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"a level of a map", READ(level), {1}, CSM_ERROR_INVALID_INDEX, "level 1 of 1"},
      {"reserved beside the level", READ(reserved_level), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"a mask of no view", READ(source), {CSM_READ_MASK}, CSM_ERROR_NULL_POINTER, "view"},
  };
  fixture f;
  snapshot before;
  setup(&f);
  take(&f, &before);
  csm_read_info read = {.struct_size = sizeof read, .cascades = f.cascades, .data = data, .size = sizeof data};
  assert_int_equal(csm_read(NULL, &read), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_read(f.context, NULL), CSM_ERROR_NULL_POINTER, "no read info");
  check_rows(&f, &(row_table){rows, COUNT(rows), &read, sizeof read}, read_texels);
  read.view = f.view;
  for (read.source = CSM_READ_MASK; read.source <= CSM_READ_VIEW_DEPTH; ++read.source)
    expect(&f, csm_read(f.context, &read), CSM_ERROR_INVALID_STATE, "a mask that was never resolved");
  unchanged(&f, &before);
  teardown(&f);
}

static void questions(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  csm_binding binding = {0};
  csm_stats stats = {0};
  csm_view_stats view_stats = {0};
  csm_draw_target target = {0};
  uint8_t drawn[SUPPORT_INSTANCES];
  csm_instance_id ids[SUPPORT_INSTANCES] = {0};
  csm_view *view;
  assert_int_equal(csm_bind(NULL, &binding), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_get_stats(NULL, &stats), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_get_view_stats(NULL, &view_stats), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_get_draw_target(NULL, &target), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_get_casters(NULL, SUPPORT_INSTANCES, NULL, drawn), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_view_create(NULL, &view), CSM_ERROR_NULL_POINTER);
  expect(&f, csm_view_create(f.context, NULL), CSM_ERROR_NULL_POINTER, "no view");
  expect(&f, csm_get_casters(f.cascades, SUPPORT_INSTANCES, NULL, NULL), CSM_ERROR_NULL_POINTER,
         "nowhere to tell casters");
  expect(&f, csm_get_casters(f.cascades, SUPPORT_INSTANCES - 1, NULL, drawn), CSM_ERROR_INVALID_VALUE, "another count");
  expect(&f, csm_get_casters(f.cascades, SUPPORT_INSTANCES, ids, drawn), CSM_ERROR_INVALID_VALUE, "ids of no scene");
  expect(&f, csm_bind(f.cascades, NULL), CSM_ERROR_NULL_POINTER, "no binding");
  expect(&f, csm_bind(f.cascades, &binding), CSM_ERROR_STRUCT_SIZE, "a binding without struct_size");
  expect(&f, csm_get_stats(f.cascades, &stats), CSM_ERROR_STRUCT_SIZE, "stats without struct_size");
  expect(&f, csm_get_view_stats(f.view, &view_stats), CSM_ERROR_STRUCT_SIZE, "a view's stats without struct_size");
  expect(&f, csm_get_view_stats(f.view, NULL), CSM_ERROR_NULL_POINTER, "no view's stats");
  expect(&f, csm_get_draw_target(f.cascades, &target), CSM_ERROR_STRUCT_SIZE, "a target without struct_size");
  expect(&f, csm_get_draw_target(f.cascades, NULL), CSM_ERROR_NULL_POINTER, "no target");
  expect(&f, csm_switch_backend(f.context, NULL), CSM_ERROR_NULL_POINTER, "switching to nothing");
  expect(&f, csm_retire(f.context, 1), CSM_ERROR_UNSUPPORTED, "retiring");
  assert_int_equal(csm_switch_backend(NULL, NULL), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_retire(NULL, 1), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_cascades_destroy(NULL), CSM_SUCCESS);
  assert_int_equal(csm_view_destroy(NULL), CSM_SUCCESS);
  assert_int_equal(csm_scene_destroy(NULL), CSM_SUCCESS);
  csm_destroy(NULL);
  assert_string_equal(csm_last_error(NULL), "");
  teardown(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(cameras),   cmocka_unit_test(lights),    cmocka_unit_test(frames),
      cmocka_unit_test(instances), cmocka_unit_test(masks),     cmocka_unit_test(a_failed_mask_leaves_the_last),
      cmocka_unit_test(reading),   cmocka_unit_test(questions),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
