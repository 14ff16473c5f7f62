/* commands_test.c: what a frame records, read from the null backend's log. */
#include "../conformance/support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LOG_SIZE = 1 << 16, SIDE = 64 };

/* The commands since the last `forget`, a line each, and the rules of gpu.h that were broken. */
typedef struct commands {
  char text[LOG_SIZE];
  size_t length;
  uint32_t breaches;
} commands;

typedef struct fixture {
  commands commands;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  support_scene scene;
} fixture;

static void CSM_CALL take_line(void *user, int32_t level, const char *message) {
  commands *log = user;
  if (level == CSM_LOG_TRACE)
    log->length += (size_t)snprintf(log->text + log->length, LOG_SIZE - log->length, "%s\n", message);
  assert_true(log->length < LOG_SIZE);
  log->breaches += level == CSM_LOG_ERROR;
}

static void forget(commands *log) {
  log->length = 0;
  log->text[0] = '\0';
}

/* How many commands begin so. */
static uint32_t count(const char *text, const char *beginning) {
  uint32_t found = 0;
  for (const char *line = text; line && *line; line = strchr(line, '\n'), line += line != NULL)
    found += strncmp(line, beginning, strlen(beginning)) == 0;
  return found;
}

/* Where the first command that begins so stands; fails if there is none. */
static const char *first(const char *text, const char *beginning) {
  for (const char *line = text; line && *line; line = strchr(line, '\n'), line += line != NULL)
    if (strncmp(line, beginning, strlen(beginning)) == 0)
      return line;
  fail_msg("no \"%s\" among these:\n%s", beginning, text);
  return NULL;
}

static int set_up(void **state) {
  fixture *f = calloc(1, sizeof *f);
  const csm_create_info info = {
      .struct_size = sizeof info, .version = CSM_VERSION, .backend = "null", .log = take_line, .user = &f->commands};
  csm_config config = support_config();
  config.cascade_count = 3;
  config.resolution = SIDE;
  *state = f;
  if (csm_create(&info, &f->context) || csm_cascades_create(f->context, &config, &f->cascades))
    return -1;
  f->view = support_view(f->context);
  support_scene_make(&f->scene, f->context);
  forget(&f->commands);
  return 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  csm_destroy(f->context);
  free(f);
  return 0;
}

static void render(fixture *f) {
  forget(&f->commands);
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&f->scene.shot)), CSM_SUCCESS);
}

static void test_a_frame(void **state) {
  fixture *f = *state;
  const char *text = f->commands.text;
  render(f);
  assert_int_equal(f->commands.breaches, 0);
  assert_int_equal(count(text, "begin "), 1);
  assert_int_equal(count(text, "end"), 1);
  assert_int_equal(count(text, "timestamp"), 0);

  /* Every map is cleared at once, after the uploads and before the first pass. */
  assert_int_equal(count(text, "clear_depth"), 1);
  assert_true(count(text, "copy_buffer") >= 1);
  assert_true(first(text, "copy_buffer") < first(text, "clear_depth"));
  assert_true(first(text, "clear_depth") < first(text, "pass_begin"));
  assert_int_equal(count(first(text, "clear_depth"), "copy_buffer"), 0);

  /* One pass for each cascade that draws something, with one program and one draw for each mesh. */
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(f->cascades, &stats), CSM_SUCCESS);
  uint32_t passes = 0, drawn = 0, instances = 0;
  for (uint32_t i = 0; i < stats.cascade_count; i++) {
    passes += stats.cascades[i].casters_drawn > 0;
    drawn += stats.cascades[i].casters_drawn;
  }
  assert_true(passes > 0);
  assert_int_equal(count(text, "pass_begin"), passes);
  assert_int_equal(count(text, "pass_end"), passes);
  assert_int_equal(count(text, "program "), passes);
  for (const char *draw = strstr(text, "\ndraw "); draw; draw = strstr(draw + 1, "\ndraw "))
    instances += (uint32_t)atoi(strstr(draw, "instances=") + strlen("instances="));
  assert_int_equal(instances, drawn);

  /* The maps are handed to shaders after the last pass. */
  assert_int_equal(count(first(text, "make_readable"), "pass_begin"), 0);
}

static void test_uploads_once(void **state) {
  fixture *f = *state;
  render(f);
  assert_true(count(f->commands.text, "copy_buffer") > 0);
  render(f);
  assert_int_equal(count(f->commands.text, "copy_buffer"), 0);
  assert_int_equal(count(f->commands.text, "clear_depth"), 1);
  assert_int_equal(f->commands.breaches, 0);
}

/* An update waits for nobody and records nothing; the next frame uploads it, once. */
static void test_an_update_is_uploaded_once(void **state) {
  fixture *f = *state;
  static const float positions[8][3] = {{-1, -1, -1}, {2, 2, 2}};
  const csm_mesh_update_info info = {.struct_size = sizeof info, .positions = positions};
  render(f);
  render(f);
  forget(&f->commands);
  assert_int_equal(csm_mesh_update(f->context, f->scene.instances[1].mesh, &info), CSM_SUCCESS);
  assert_string_equal(f->commands.text, "");
  render(f);
  assert_int_equal(count(f->commands.text, "copy_buffer"), 1);
  assert_int_equal(count(f->commands.text, "wait "), 1); /* the one that each frame has */
  render(f);
  assert_int_equal(count(f->commands.text, "copy_buffer"), 0);
  assert_int_equal(f->commands.breaches, 0);
}

static void test_slots_in_turn(void **state) {
  fixture *f = *state;
  for (int frame = 0; frame < 7; frame++) {
    render(f);
    char line[32]; /* three slots by default, the first recording takes slot 1; waited for before it is used again */
    snprintf(line, sizeof line, "wait %d\nbegin %d\n", (frame + 1) % 3, (frame + 1) % 3);
    assert_ptr_equal(strstr(f->commands.text, line), f->commands.text);
  }
}

static void test_timestamps(void **state) {
  fixture *f = *state;
  f->scene.shot.frame.flags = CSM_FRAME_TIMESTAMPS;
  render(f);
  const char *text = f->commands.text;
  assert_int_equal(count(text, "timestamp"), 2 + 3);
  for (int i = 0; i < 4; i++) {
    char earlier[32], later[32];
    snprintf(earlier, sizeof earlier, "timestamp %d", i);
    snprintf(later, sizeof later, "timestamp %d", i + 1);
    assert_true(first(text, earlier) < first(text, later));
  }
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(f->cascades, &stats), CSM_SUCCESS);
  for (int i = 0; i < 3; i++)
    assert_true(stats.cascades[i].gpu_ms == 1.0); /* what the null backend's clock says */
}

static void test_a_mask(void **state) {
  fixture *f = *state;
  render(f);
  forget(&f->commands);
  assert_int_equal(shot_resolve(&f->scene.shot, f->view, f->cascades, 40, 30), CSM_SUCCESS);
  const char *text = f->commands.text;
  assert_int_equal(f->commands.breaches, 0);
  assert_int_equal(count(text, "pass_begin"), 2);
  assert_int_equal(count(text, "clear_depth"), 1);

  /* The camera's depth is drawn, and made readable, before the mask binds it and draws one triangle. */
  assert_true(first(text, "make_readable") < first(text, "bind "));
  assert_int_equal(count(text, "bind "), 1);
  const char *bind = first(text, "bind ");
  assert_int_equal(count(bind, "draw "), 1);
  assert_int_equal(count(bind, "draw count=3 instances=1"), 1);
}

/* Puts the scene's instances into one that stays. */
static csm_scene *stay(fixture *f, csm_instance_id ids[SUPPORT_INSTANCES]) {
  const csm_scene_batch all = {
      .struct_size = sizeof all, .count = SUPPORT_INSTANCES, .ids = ids, .instances = f->scene.instances};
  csm_scene *scene;
  assert_int_equal(csm_scene_create(f->context, &scene), CSM_SUCCESS);
  assert_int_equal(csm_scene_add(scene, &all), CSM_SUCCESS);
  f->scene.shot.frame.instances = NULL;
  f->scene.shot.frame.instance_count = 0;
  f->scene.shot.frame.scene = scene;
  return scene;
}

/* A mask draws the depth that a reduction drew only where it would draw another one. */
static void test_a_depth(void **state) {
  fixture *f = *state;
  const char *text = f->commands.text;
  shot *shot = &f->scene.shot;
  csm_instance_id ids[SUPPORT_INSTANCES];
  stay(f, ids);
  csm_mask_info info = {.struct_size = sizeof info, .frame = shot_frame(shot), .width = 40, .height = 30};
  forget(&f->commands);
  assert_int_equal(csm_reduce_depth(f->view, &info), CSM_SUCCESS);
  assert_int_equal(count(text, "clear_depth"), 1);
  assert_int_equal(count(text, "pass_begin"), 2);
  assert_int_equal(count(text, "copy_image"), 1);
  shot->frame.depth_view = f->view;
  render(f);
  for (int i = 0; i < 2; ++i) { /* as often as it is asked for */
    forget(&f->commands);
    assert_int_equal(shot_resolve(shot, f->view, f->cascades, 40, 30), CSM_SUCCESS);
    assert_int_equal(count(text, "clear_depth"), 0);
    assert_int_equal(count(text, "pass_begin"), 1);
  }
  shot->frame.depth_view = NULL;
  render(f);
  forget(&f->commands);
  assert_int_equal(shot_resolve(shot, f->view, f->cascades, 41, 30), CSM_SUCCESS);
  assert_int_equal(count(text, "clear_depth"), 1);
  forget(&f->commands);
  assert_int_equal(shot_resolve(shot, f->view, f->cascades, 40, 30), CSM_SUCCESS); /* which was drawn over */
  assert_int_equal(count(text, "clear_depth"), 1);
  assert_int_equal(csm_reduce_depth(f->view, &info), CSM_SUCCESS);
  shot->camera.view[12] += 0.01;
  forget(&f->commands);
  assert_int_equal(shot_resolve(shot, f->view, f->cascades, 40, 30), CSM_SUCCESS);
  assert_int_equal(count(text, "clear_depth"), 1);
  assert_int_equal(csm_reduce_depth(f->view, &info), CSM_SUCCESS);
  assert_int_equal(csm_scene_remove(shot->frame.scene, 1, ids), CSM_SUCCESS);
  forget(&f->commands);
  assert_int_equal(shot_resolve(shot, f->view, f->cascades, 40, 30), CSM_SUCCESS);
  assert_int_equal(count(text, "clear_depth"), 1);
  assert_int_equal(f->commands.breaches, 0);
}

/* Pages that are there are neither cleared nor drawn; what moves is, in a part of what clip space covers. */
static void test_pages(void **state) {
  fixture *f = *state;
  const char *text = f->commands.text;
  csm_config config = support_config();
  csm_instance_id ids[SUPPORT_INSTANCES];
  csm_scene *scene = stay(f, ids);
  config.map_layout = CSM_LAYOUT_PAGES;
  config.resolution = SIDE;
  assert_int_equal(csm_cascades_configure(f->cascades, &config), CSM_SUCCESS);
  render(f);
  assert_int_equal(count(text, "clear_depth"), 1);
  assert_true(count(text, "draw ") > 0);
  render(f);
  assert_int_equal(count(text, "clear_depth") + count(text, "pass_begin") + count(text, "draw "), 0);

  double moved[16];
  memcpy(moved, f->scene.instances[1].transform, sizeof moved);
  moved[12] += 0.5;
  const csm_scene_batch one = {.struct_size = sizeof one, .count = 1, .ids = &ids[1], .matrices = moved};
  assert_int_equal(csm_scene_move(scene, &one), CSM_SUCCESS);
  render(f);
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(f->cascades, &stats), CSM_SUCCESS);
  assert_true(stats.pages_drawn > 0 && stats.pages_drawn < stats.pages_valid / 2);
  assert_int_equal(count(text, "clear_depth"), 0);
  uint32_t cleared = 0, drawn = 0;
  for (const char *pass = strstr(text, "pass_begin"); pass; pass = strstr(pass + 1, "pass_begin")) {
    const char *end = strchr(pass, '\n'), *depth = strstr(pass, "depth 1"), *clip = strstr(pass, "clip 0 0 64 64");
    cleared += depth && depth < end;
    drawn += clip && clip < end;
  }
  assert_true(cleared > 0 && drawn > 0);
  assert_int_equal(count(text, "pass_begin"), cleared + drawn);

  /* What moves again keeps moving: it is drawn over copies of its pages, which a second image holds from then on. */
  for (int again = 0; again < 2; ++again) {
    const uint64_t bytes = stats.map_bytes;
    moved[12] += 0.5;
    assert_int_equal(csm_scene_move(scene, &one), CSM_SUCCESS);
    render(f);
    assert_int_equal(csm_get_stats(f->cascades, &stats), CSM_SUCCESS);
    assert_true(stats.pages_copied > 0 && stats.pages_copied <= stats.pages_drawn);
    assert_int_equal(stats.map_bytes > bytes, again == 0);
    assert_int_equal(count(text, "clear_depth"), again == 0);
    assert_true(count(text, "draw count=6") > 0);
  }
  assert_int_equal(f->commands.breaches, 0);
}

static void test_an_error_records_nothing(void **state) {
  fixture *f = *state;
  render(f);
  forget(&f->commands);
  shot shot = f->scene.shot;
  memset(shot.light.direction, 0, sizeof shot.light.direction);
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&shot)), CSM_ERROR_INVALID_LIGHT);
  assert_string_equal(f->commands.text, "");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_a_frame, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_uploads_once, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_an_update_is_uploaded_once, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_slots_in_turn, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_timestamps, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_a_mask, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_a_depth, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_pages, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_an_error_records_nothing, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
