/* moments.c: what making moments records, read from the null backend's log. */
#include "dispatches.h"

#include <string.h>

static int set_up(void **state) {
  csm_config config = support_config();
  config.filter = CSM_FILTER_EVSM4;
  config.moment_blur_texels = 3;
  return fixture_begin(state, 0, &config);
}

static void configure(fixture *f) {
  assert_int_equal(csm_cascades_configure(f->cascades, &f->config), CSM_SUCCESS);
}

static void a_blur_takes_two_dispatches_and_a_level_one(void **state) {
  fixture *f = *state;
  const uint32_t cascades = f->config.cascade_count;
  assert_int_equal(fixture_render(f), 2 * cascades);
  assert_false(f->commands.drawn_after);
  f->config.moment_levels = 6;
  configure(f);
  assert_int_equal(fixture_render(f), 2 * cascades + 5);
  f->config.moment_blur_texels = 0;
  f->config.moment_levels = 1;
  configure(f);
  assert_int_equal(fixture_render(f), 1);
}

static void what_is_as_it_was_is_kept(void **state) {
  fixture *f = *state;
  const uint32_t all = 2 * f->config.cascade_count;
  assert_int_equal(fixture_render(f), all);
  assert_int_equal(fixture_render(f), 0);
  fixture_move(f, 1, 0.5);
  assert_in_range(fixture_render(f), 2, all);
  assert_int_equal(fixture_render(f), 0);
  static const float positions[8][3] = {{-1, -1, -1}, {2, 2, 2}};
  const csm_mesh_update_info update = {.struct_size = sizeof update, .positions = positions};
  assert_int_equal(csm_mesh_update(f->context, f->instances.instances[1].mesh, &update), CSM_SUCCESS);
  assert_in_range(fixture_render(f), 2, all);
  assert_int_equal(fixture_render(f), 0);
  f->instances.shot.light.direction[0] += 0.1;
  assert_int_equal(fixture_render(f), all);
  assert_int_equal(fixture_render(f), 0);
}

/* What nobody vouches for is made anew: other settings, a list, a frame after one without shadows. */
static void what_is_not_known_is_made_anew(void **state) {
  fixture *f = *state;
  const uint32_t all = 2 * f->config.cascade_count;
  fixture_render(f);
  configure(f);
  assert_int_equal(fixture_render(f), all);
  assert_int_equal(fixture_render(f), 0);
  f->commands = (commands){0};
  for (int i = 0; i < 2; ++i)
    assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&f->instances.shot)), CSM_SUCCESS);
  assert_int_equal(f->commands.dispatches, 2 * all);
  assert_int_equal(fixture_render(f), all);
  double projection[16];
  memcpy(projection, f->instances.shot.camera.projection, sizeof projection);
  support_perspective(f->instances.shot.camera.projection, 60, 1.5, 2 * f->config.shadow_distance, 0);
  assert_int_equal(fixture_render(f), 0); /* the camera sees nothing that has shadows */
  memcpy(f->instances.shot.camera.projection, projection, sizeof projection);
  assert_int_equal(fixture_render(f), all);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(a_blur_takes_two_dispatches_and_a_level_one, set_up, fixture_end),
      cmocka_unit_test_setup_teardown(what_is_as_it_was_is_kept, set_up, fixture_end),
      cmocka_unit_test_setup_teardown(what_is_not_known_is_made_anew, set_up, fixture_end),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
