/* ranges.c: what a frame with ranges records, read from the null backend's log. */
#include "dispatches.h"

enum { STEPS = 3 };

static int set_up(void **state) {
  csm_config config = support_config();
  config.filter = CSM_FILTER_EXACT_SOFT;
  return fixture_begin(state, CSM_CREATE_RAYS, &config);
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
  assert_int_equal(fixture_render(f), STEPS);
  assert_false(f->commands.drawn_after);
  assert_int_equal(fixture_render(f), 0);
  fixture_move(f, 1, 0.5);
  assert_int_equal(fixture_render(f), STEPS);
  assert_int_equal(fixture_render(f), 0);
  f->instances.shot.light.direction[0] += 0.1;
  assert_int_equal(fixture_render(f), STEPS);
  configure(f);
  assert_int_equal(fixture_render(f), STEPS);
  assert_int_equal(fixture_render(f), 0);
}

/* Who reads none has none: other filters, a textbook's penumbra, and maps of pages. */
static void no_others_have_ranges(void **state) {
  fixture *f = *state;
  const uint64_t blocks = (f->config.resolution + 15) / 16;
  assert_in_range(configure(f), blocks * blocks * 36 * f->config.cascade_count, 1 << 20);
  const csm_config good = f->config;
  f->config.filter = CSM_FILTER_PCSS;
  assert_int_equal(configure(f), 0);
  assert_int_equal(fixture_render(f), 0);
  f->config.filter = CSM_FILTER_EXACT;
  assert_int_equal(configure(f), 0);
  assert_int_equal(fixture_render(f), 0);
  f->config = good;
  f->config.soft_penumbra = CSM_PENUMBRA_RATIO;
  assert_int_equal(configure(f), 0);
  assert_int_equal(fixture_render(f), 0);
  f->config = good;
  f->config.map_layout = CSM_LAYOUT_PAGES;
  assert_int_equal(configure(f), 0);
  assert_int_equal(fixture_render(f), 0);
  f->config = good;
  assert_true(configure(f) > 0);
  assert_int_equal(fixture_render(f), STEPS);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(ranges_follow_their_maps, set_up, fixture_end),
      cmocka_unit_test_setup_teardown(no_others_have_ranges, set_up, fixture_end),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
