/* budget.c: budgets of memory, time and error: what is drawn with them is what smaller maps draw, and caps are kept. */
#include "support.h"

#include <stdlib.h>
#include <string.h>

enum { WIDTH = 200, HEIGHT = 120, FRAMES = 260 };

typedef struct fixture {
  record record;
  csm_context *context;
  support_scene scene;
  csm_view *view;
} fixture;

static void open_fixture(fixture *f) {
  memset(f, 0, sizeof *f);
  f->context = support_open_with(&f->record, CSM_CREATE_KEEP_GEOMETRY);
  support_scene_make(&f->scene, f->context);
  f->view = support_view(f->context);
}

static csm_cascades *make(fixture *f, const csm_config *config) {
  csm_cascades *cascades;
  assert_int_equal(csm_cascades_create(f->context, config, &cascades), CSM_SUCCESS);
  return cascades;
}

static csm_stats stats_of(csm_cascades *cascades) {
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(cascades, &stats), CSM_SUCCESS);
  return stats;
}

static csm_stats draw(fixture *f, csm_cascades *cascades, uint32_t frames) {
  for (uint32_t i = 0; i < frames; ++i) {
    assert_int_equal(csm_render_cascades(cascades, shot_frame(&f->scene.shot)), CSM_SUCCESS);
    assert_int_equal(shot_resolve(&f->scene.shot, f->view, cascades, WIDTH, HEIGHT), CSM_SUCCESS);
  }
  return stats_of(cascades);
}

static csm_binding bound(csm_cascades *cascades) {
  csm_binding binding = {.struct_size = sizeof binding};
  assert_int_equal(csm_bind(cascades, &binding), CSM_SUCCESS);
  return binding;
}

/* Maps and mask are those of cascades whose maps are as large as these are now. */
static void expect_as_smaller(fixture *f, csm_cascades *cascades, const csm_config *config) {
  csm_config plain = *config;
  const csm_binding binding = bound(cascades);
  plain.budget = 0;
  for (uint32_t i = 0; i < config->cascade_count; ++i)
    plain.resolutions[i] = binding.resolutions[i];
  csm_cascades *smaller = make(f, &plain);
  float *mask = support_image(f->context, f->view, CSM_READ_MASK, WIDTH, HEIGHT);
  (void)draw(f, smaller, 1);
  float *expected = support_image(f->context, f->view, CSM_READ_MASK, WIDTH, HEIGHT);
  assert_memory_equal(mask, expected, WIDTH * HEIGHT * sizeof *mask);
  free(mask);
  free(expected);
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    const uint32_t side = binding.resolutions[i];
    float *map = support_map(f->context, cascades, i, side), *other = support_map(f->context, smaller, i, side);
    assert_memory_equal(map, other, (size_t)side * side * sizeof *map);
    free(map);
    free(other);
  }
  assert_int_equal(csm_cascades_destroy(smaller), CSM_SUCCESS);
}

static void memory_is_capped_in_every_layout(void **state) {
  (void)state;
  const struct {
    uint32_t layout, format, filter;
    double mib;
  } cases[] = {{CSM_LAYOUT_ARRAY, CSM_MAP_D32, CSM_FILTER_PCF_3X3, 0.9},
               {CSM_LAYOUT_ARRAY, CSM_MAP_D16, CSM_FILTER_PCF_3X3, 0.4},
               {CSM_LAYOUT_ATLAS, CSM_MAP_D32, CSM_FILTER_PCF_5X5, 0.7},
               {CSM_LAYOUT_ATLAS, CSM_MAP_D16, CSM_FILTER_PCF_3X3, 0.5},
               {CSM_LAYOUT_PAGES, CSM_MAP_D32, CSM_FILTER_PCF_3X3, 1.2},
               {CSM_LAYOUT_ARRAY, CSM_MAP_D32, CSM_FILTER_EVSM4, 5.0},
               {CSM_LAYOUT_ARRAY, CSM_MAP_D32, CSM_FILTER_EVSM4, 0.0}};
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    fixture f;
    open_fixture(&f);
    csm_config config = support_config();
    config.resolution = 512;
    config.resolutions[1] = cases[i].layout == CSM_LAYOUT_PAGES ? 0 : 256;
    config.map_layout = cases[i].layout;
    config.map_format = cases[i].format;
    config.filter = cases[i].filter;
    config.budget = CSM_BUDGET_MEMORY;
    /* Maps and moments of 512 texels, but for what the moments are blurred in: only the device tells of that */
    const double cap = cases[i].mib > 0.0 ? cases[i].mib : 5.0 * config.cascade_count;
    config.budget_mib = cap;
    csm_cascades *cascades = make(&f, &config);
    const csm_stats stats = draw(&f, cascades, 1);
    const double mib = (double)(stats.map_bytes + stats.moment_bytes) / 1048576.0;
    assert_true(mib <= cap && mib > 0.2 * cap);
    assert_true(stats.budget_side < 512 && strstr(stats.budget_text, "512 would take"));
    assert_int_equal(bound(cascades).resolutions[0], stats.budget_side);
    assert_int_equal(stats.budget_missed, 0);
    assert_true(stats.budget_ms_predicted < 0 && stats.budget_wrong_predicted < 0);
    expect_as_smaller(&f, cascades, &config);
    /* A cap that all maps fit takes nothing off. */
    config.budget_mib = 100.0;
    assert_int_equal(csm_cascades_configure(cascades, &config), CSM_SUCCESS);
    assert_int_equal(draw(&f, cascades, 1).budget_side, 512);
    assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
    support_close(f.context, &f.record);
  }
}

/* No machine draws in no time: maps get as coarse as they may, in an image that stays, and it is said that it was in vain. */
static void time_makes_maps_coarser_in_place(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  csm_config config = support_config();
  config.resolution = 512;
  config.resolutions[1] = 256;
  config.budget = CSM_BUDGET_TIME;
  config.budget_ms = 1e-6;
  csm_cascades *cascades = make(&f, &config);
  csm_stats stats = draw(&f, cascades, 1);
  const uint64_t maps = bound(cascades).native_maps, bytes = stats.map_bytes;
  assert_int_equal(stats.budget_side, 512);
  assert_true(strstr(stats.budget_text, "not known"));
  stats = draw(&f, cascades, 30);
  assert_true(stats.budget_side < 512 && stats.budget_side > 64);
  expect_as_smaller(&f, cascades, &config);
  stats = draw(&f, cascades, FRAMES);
  assert_int_equal(stats.budget_side, 64);
  assert_int_equal(bound(cascades).resolutions[0], 64);
  assert_int_equal(bound(cascades).resolutions[1], 32);
  assert_int_equal(stats.budget_missed, CSM_BUDGET_TIME);
  assert_true(stats.budget_ms_predicted > 0.0 && strstr(stats.budget_text, "still"));
  assert_true(bound(cascades).native_maps == maps && stats.map_bytes == bytes);
  expect_as_smaller(&f, cascades, &config);
  /* And fine again, as far as there is time. */
  config.budget_ms = 1e6;
  assert_int_equal(csm_cascades_configure(cascades, &config), CSM_SUCCESS);
  stats = draw(&f, cascades, 1);
  assert_int_equal(stats.budget_side, 512);
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  support_close(f.context, &f.record);
}

/* Another device goes on with the sides that were chosen, and measures anew. */
static void a_switch_keeps_sides(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  csm_config config = support_config();
  config.resolution = 512;
  config.budget = CSM_BUDGET_TIME | CSM_BUDGET_MEMORY;
  config.budget_ms = 1e-6;
  config.budget_mib = 2.0;
  csm_cascades *cascades = make(&f, &config);
  csm_stats stats = draw(&f, cascades, 30);
  const uint32_t side = stats.budget_side;
  const csm_create_info info = support_create_info(&f.record);
  assert_true(side < 256 && stats.budget_ms_predicted > 0.0);
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
  assert_true(stats_of(cascades).budget_ms_predicted < 0.0);
  stats = draw(&f, cascades, 1);
  assert_int_equal(stats.budget_side, side);
  assert_true((double)stats.map_bytes <= 2.0 * 1048576.0);
  stats = draw(&f, cascades, 30);
  assert_true(stats.budget_side < side && stats.budget_ms_predicted > 0.0);
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  support_close(f.context, &f.record);
}

/* What may all be wrong gets the coarsest maps; what may not be gets the finest, and is told that it is not kept. */
static void error_follows_the_mask(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  csm_config config = support_config();
  config.resolution = 256;
  config.budget = CSM_BUDGET_ERROR;
  config.budget_wrong = 1e-9;
  csm_cascades *cascades = make(&f, &config);
  csm_stats stats = draw(&f, cascades, FRAMES);
  const double fine = stats.budget_wrong_predicted;
  assert_int_equal(stats.budget_side, 256);
  assert_int_equal(stats.budget_missed, CSM_BUDGET_ERROR);
  assert_true(strstr(stats.budget_text, "still"));

  /* No more pixels than are neither lit nor dark count, and of those that face the light at least the lit ones. */
  float *mask = support_image(f.context, f.view, CSM_READ_MASK, WIDTH, HEIGHT);
  uint32_t unsure = 0, lit = 0;
  for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) {
    unsure += mask[i] > 0 && mask[i] < 1;
    lit += mask[i] > 0;
  }
  free(mask);
  const double most = 1.5 * unsure / lit;
  assert_true(unsure > 100 && fine > 0.0 && fine <= 0.053 * most + 0.32 * most * most);

  config.budget_wrong = 1.0;
  assert_int_equal(csm_cascades_configure(cascades, &config), CSM_SUCCESS);
  stats = draw(&f, cascades, FRAMES);
  assert_int_equal(stats.budget_side, 32);
  assert_int_equal(stats.budget_missed, 0);
  assert_true(stats.budget_wrong_predicted > fine);
  expect_as_smaller(&f, cascades, &config);
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  support_close(f.context, &f.record);
}

static void without_a_budget_nothing_is_said(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  const csm_config config = support_config();
  csm_cascades *cascades = make(&f, &config);
  const csm_stats stats = draw(&f, cascades, 1);
  assert_int_equal(stats.budget_side + stats.budget_missed, 0);
  assert_string_equal(stats.budget_text, "");
  assert_true(stats.clear_gpu_ms < 0.0 && stats.budget_ms_predicted < 0.0 && stats.budget_wrong_predicted < 0.0);
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  support_close(f.context, &f.record);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(memory_is_capped_in_every_layout),
      cmocka_unit_test(time_makes_maps_coarser_in_place),
      cmocka_unit_test(a_switch_keeps_sides),
      cmocka_unit_test(error_follows_the_mask),
      cmocka_unit_test(without_a_budget_nothing_is_said),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof *tests);
}
