/*
 * Every preset draws a yard on every backend, and these agree. One device serves all: opening one takes longer. The yard
 * has a few boxes and balls, and maps are small, for a CPU draws them.
 */
#include "base/host.h"
#include "hard/hard.h"
#include "setup/presets.h"
#include "stage/compare.h"
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

static char *backend; /* as --backend has it */

typedef struct fixture {
  host_options options;
  host_setup setup;
  stage stages[HOST_BACKENDS];
  uint32_t count;
} fixture;

static void open_fixture(fixture *f) {
  char *words[] = {"csm-host", "run", "--backend", backend};
  memset(f, 0, sizeof *f);
  assert_int_equal(options_parse(&f->options, sizeof words / sizeof words[0], words), 0);
  hard_setup_begin(&f->setup, 160, 90);
  hard_yard(&f->setup, true);
  assert_int_equal(stage_open_all(f->stages, &f->count, &f->options), 0);
  for (uint32_t i = 0; i < f->count; i++)
    assert_int_equal(stage_load(&f->stages[i], &f->setup), 0);
}

static void close_fixture(fixture *f) {
  for (uint32_t i = 0; i < f->count; i++)
    stage_close(&f->stages[i]);
  setup_free(&f->setup);
}

static void draw(fixture *f, const char *name, stage_frame *frames) {
  preset_config(&f->setup.config, name, f->setup.shadow_distance);
  if (f->setup.config.resolution > 256)
    f->setup.config.resolution = 256;
  f->setup.config.soft_radius_max_texels = fmin(f->setup.config.soft_radius_max_texels, 64.0); /* half of one is room */
  for (uint32_t i = 0; i < f->count; i++) {
    stage_stats stats;
    assert_int_equal(stage_restart(&f->stages[i], &f->setup.config), 0);
    assert_int_equal(stage_draw(&f->stages[i], &stats), 0);
    assert_int_equal(stage_read(&f->stages[i], true, &frames[i]), 0);
    assert_int_equal(stage_read_views(&f->stages[i], &frames[i]), 0);
  }
}

static uint32_t count_shaded(const stage_frame *frame, size_t pixels) {
  uint32_t shaded = 0;
  for (size_t i = 0; i < pixels; i++)
    shaded += frame->mask[i] < 0.9f; /* some let much light through */
  return shaded;
}

static void every_preset_draws_the_same(void **state) {
  (void)state;
  fixture f;
  uint32_t count = 0;
  open_fixture(&f);
  const size_t pixels = (size_t)f.setup.width * f.setup.height;
  for (const char *name; (name = preset_name(count)); count++) {
    stage_frame frames[HOST_BACKENDS] = {0};
    agreement found = {.agrees = true, .plans_equal = true};
    draw(&f, name, frames);
    if (f.count == HOST_BACKENDS)
      compare_frames(&found, &f.stages[0], &frames[0], &f.stages[1], &frames[1]);
    const uint32_t shaded = count_shaded(&frames[0], pixels);
    if (!found.agrees || !found.plans_equal || shaded < pixels / 200 || shaded == pixels)
      fail_msg("%s: agrees %d, plans equal %d, %u pixels in shadow", name, found.agrees, found.plans_equal, shaded);
    for (uint32_t i = 0; i < f.count; i++)
      stage_frame_free(&frames[i]);
  }
  assert_true(count > 30);
  close_fixture(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(every_preset_draws_the_same)};
  if (argc != 2)
    return 2;
  backend = argv[1];
  return cmocka_run_group_tests_name("presets agree", tests, NULL, NULL);
}
