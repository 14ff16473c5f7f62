/* moments.c: what making moments records, read from the null backend's log. */
#include "../conformance/support.h"

#include <stdlib.h>
#include <string.h>

typedef struct commands {
  uint32_t dispatches, breaches;
  bool drawn_after; /* a pass came after the first dispatch */
} commands;

typedef struct fixture {
  commands commands;
  csm_context *context;
  csm_cascades *cascades;
  csm_scene *scene;
  csm_config config;
  support_scene instances;
  csm_instance_id ids[SUPPORT_INSTANCES];
} fixture;

static void CSM_CALL take_line(void *user, int32_t level, const char *message) {
  commands *log = user;
  log->dispatches += strncmp(message, "dispatch ", 9) == 0;
  log->drawn_after |= log->dispatches && strncmp(message, "pass_begin", 10) == 0;
  log->breaches += level == CSM_LOG_ERROR;
}

static int set_up(void **state) {
  fixture *f = calloc(1, sizeof *f);
  const csm_create_info info = {
      .struct_size = sizeof info, .version = CSM_VERSION, .backend = "null", .log = take_line, .user = &f->commands};
  *state = f;
  f->config = support_config();
  f->config.filter = CSM_FILTER_EVSM4;
  f->config.moment_blur_texels = 3;
  if (csm_create(&info, &f->context) || csm_cascades_create(f->context, &f->config, &f->cascades) ||
      csm_scene_create(f->context, &f->scene))
    return -1;
  support_scene_make(&f->instances, f->context);
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = SUPPORT_INSTANCES, .ids = f->ids, .instances = f->instances.instances};
  return csm_scene_add(f->scene, &batch);
}

static int tear_down(void **state) {
  fixture *f = *state;
  csm_destroy(f->context);
  free(f);
  return 0;
}

/* A frame of the scene; returns how many dispatches it took. */
static uint32_t render(fixture *f) {
  csm_frame frame = *shot_frame(&f->instances.shot);
  frame.scene = f->scene;
  frame.instances = NULL;
  frame.instance_count = 0;
  f->commands = (commands){0};
  assert_int_equal(csm_render_cascades(f->cascades, &frame), CSM_SUCCESS);
  assert_int_equal(f->commands.breaches, 0);
  return f->commands.dispatches;
}

static void configure(fixture *f) {
  assert_int_equal(csm_cascades_configure(f->cascades, &f->config), CSM_SUCCESS);
}

static void move(fixture *f, uint32_t instance, double x) {
  double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, 1, 0, 1};
  const csm_scene_batch batch = {.struct_size = sizeof batch, .count = 1, .ids = &f->ids[instance], .matrices = matrix};
  assert_int_equal(csm_scene_move(f->scene, &batch), CSM_SUCCESS);
}

static void a_blur_takes_two_dispatches_and_a_level_one(void **state) {
  fixture *f = *state;
  const uint32_t cascades = f->config.cascade_count;
  assert_int_equal(render(f), 2 * cascades);
  assert_false(f->commands.drawn_after);
  f->config.moment_levels = 6;
  configure(f);
  assert_int_equal(render(f), 2 * cascades + 5);
  f->config.moment_blur_texels = 0;
  f->config.moment_levels = 1;
  configure(f);
  assert_int_equal(render(f), 1);
}

static void what_is_as_it_was_is_kept(void **state) {
  fixture *f = *state;
  const uint32_t all = 2 * f->config.cascade_count;
  assert_int_equal(render(f), all);
  assert_int_equal(render(f), 0);
  move(f, 1, 0.5);
  assert_in_range(render(f), 2, all);
  assert_int_equal(render(f), 0);
  static const float positions[8][3] = {{-1, -1, -1}, {2, 2, 2}};
  const csm_mesh_update_info update = {.struct_size = sizeof update, .positions = positions};
  assert_int_equal(csm_mesh_update(f->context, f->instances.instances[1].mesh, &update), CSM_SUCCESS);
  assert_in_range(render(f), 2, all);
  assert_int_equal(render(f), 0);
  f->instances.shot.light.direction[0] += 0.1;
  assert_int_equal(render(f), all);
  assert_int_equal(render(f), 0);
}

/* What nobody vouches for is made anew: other settings, a list, a frame after one without shadows. */
static void what_is_not_known_is_made_anew(void **state) {
  fixture *f = *state;
  const uint32_t all = 2 * f->config.cascade_count;
  render(f);
  configure(f);
  assert_int_equal(render(f), all);
  assert_int_equal(render(f), 0);
  f->commands = (commands){0};
  for (int i = 0; i < 2; ++i)
    assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&f->instances.shot)), CSM_SUCCESS);
  assert_int_equal(f->commands.dispatches, 2 * all);
  assert_int_equal(render(f), all);
  double projection[16];
  memcpy(projection, f->instances.shot.camera.projection, sizeof projection);
  support_perspective(f->instances.shot.camera.projection, 60, 1.5, 2 * f->config.shadow_distance, 0);
  assert_int_equal(render(f), 0); /* the camera sees nothing that has shadows */
  memcpy(f->instances.shot.camera.projection, projection, sizeof projection);
  assert_int_equal(render(f), all);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_blur_takes_two_dispatches_and_a_level_one, set_up, tear_down),
      cmocka_unit_test_setup_teardown(what_is_as_it_was_is_kept, set_up, tear_down),
      cmocka_unit_test_setup_teardown(what_is_not_known_is_made_anew, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
