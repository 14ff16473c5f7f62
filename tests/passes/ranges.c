/* ranges.c: what a frame with ranges records, read from the null backend's log. */
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

enum { STEPS = 3 };

static void CSM_CALL take_line(void *user, int32_t level, const char *message) {
  commands *log = user;
  log->dispatches += strncmp(message, "dispatch ", 9) == 0;
  log->drawn_after |= log->dispatches && strncmp(message, "pass_begin", 10) == 0;
  log->breaches += level == CSM_LOG_ERROR;
}

static int set_up(void **state) {
  fixture *f = calloc(1, sizeof *f);
  const csm_create_info info = {.struct_size = sizeof info,
                                .version = CSM_VERSION,
                                .flags = CSM_CREATE_RAYS,
                                .backend = "null",
                                .log = take_line,
                                .user = &f->commands};
  *state = f;
  f->config = support_config();
  f->config.filter = CSM_FILTER_EXACT_SOFT;
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

static uint64_t configure(fixture *f) {
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_cascades_configure(f->cascades, &f->config), CSM_SUCCESS);
  assert_int_equal(csm_get_stats(f->cascades, &stats), CSM_SUCCESS);
  return stats.range_bytes;
}

/* They come after the maps. Maps that come out as they were have the ranges that they had. */
static void ranges_follow_their_maps(void **state) {
  fixture *f = *state;
  double matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 1, 0, 1};
  const csm_scene_batch moved = {.struct_size = sizeof moved, .count = 1, .ids = &f->ids[1], .matrices = matrix};
  assert_int_equal(render(f), STEPS);
  assert_false(f->commands.drawn_after);
  assert_int_equal(render(f), 0);
  assert_int_equal(csm_scene_move(f->scene, &moved), CSM_SUCCESS);
  assert_int_equal(render(f), STEPS);
  assert_int_equal(render(f), 0);
  f->instances.shot.light.direction[0] += 0.1;
  assert_int_equal(render(f), STEPS);
  configure(f);
  assert_int_equal(render(f), STEPS);
  assert_int_equal(render(f), 0);
}

/* Who reads none has none: other filters, a textbook's penumbra, and maps of pages. */
static void no_others_have_ranges(void **state) {
  fixture *f = *state;
  const uint64_t blocks = (f->config.resolution + 15) / 16;
  assert_in_range(configure(f), blocks * blocks * 36 * f->config.cascade_count, 1 << 20);
  const csm_config good = f->config;
  f->config.filter = CSM_FILTER_PCSS;
  assert_int_equal(configure(f), 0);
  assert_int_equal(render(f), 0);
  f->config.filter = CSM_FILTER_EXACT;
  assert_int_equal(configure(f), 0);
  assert_int_equal(render(f), 0);
  f->config = good;
  f->config.soft_penumbra = CSM_PENUMBRA_RATIO;
  assert_int_equal(configure(f), 0);
  assert_int_equal(render(f), 0);
  f->config = good;
  f->config.map_layout = CSM_LAYOUT_PAGES;
  assert_int_equal(configure(f), 0);
  assert_int_equal(render(f), 0);
  f->config = good;
  assert_true(configure(f) > 0);
  assert_int_equal(render(f), STEPS);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(ranges_follow_their_maps, set_up, tear_down),
      cmocka_unit_test_setup_teardown(no_others_have_ranges, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
