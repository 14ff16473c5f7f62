/*
 * memory.c: eight maps of 16384 x 16384, and masks as large, where there is little memory: by the context's own limit, by
 * the engine's budget, and because the system gives no more. Each is refused by name, and all is left as it was.
 */
#include "../conformance/outcome.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { HUGE_SIDE = 16384 };

static const uint64_t little = 64u << 20, none = UINT64_MAX;

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  support_scene scene;
  outcome before;
  int64_t blocks;
} fixture;

static void open_fixture(fixture *f, uint64_t memory_limit, csm_budget_function budget) {
  memset(f, 0, sizeof *f);
  csm_create_info info = support_create_info(&f->record);
  csm_config config = support_config();
  info.memory_limit = memory_limit;
  info.budget = budget;
  f->record.quiet = true;
  assert_int_equal(csm_create(&info, &f->context), CSM_SUCCESS);
  support_scene_make(&f->scene, f->context);
  f->view = support_view(f->context);
  assert_int_equal(csm_cascades_create(f->context, &config, &f->cascades), CSM_SUCCESS);
  for (int i = 0; i < 3; ++i) { /* all that grows has grown */
    outcome_free(&f->before);
    f->before = outcome_draw(f->context, f->cascades, f->view, &f->scene.shot);
  }
  f->blocks = f->record.blocks;
}

static void close_fixture(fixture *f) {
  outcome_free(&f->before);
  support_close(f->context, &f->record);
}

static csm_config huge(uint32_t layout, uint32_t format) {
  csm_config config = support_config();
  config.cascade_count = CSM_MAX_CASCADES;
  config.resolution = HUGE_SIDE;
  config.map_layout = layout;
  config.map_format = format;
  return config;
}

static void expect_refused(fixture *f, csm_result result, bool by_limit, const char *what) {
  const bool named = by_limit ? result == CSM_ERROR_LIMIT_EXCEEDED
                              : result == CSM_ERROR_OUT_OF_DEVICE_MEMORY || result == CSM_ERROR_OUT_OF_MEMORY ||
                                    result == CSM_ERROR_LIMIT_EXCEEDED;
  if (!named || !csm_last_error(f->context)[0])
    fail_msg("%s: %s (%s)", what, csm_result_name(result), csm_last_error(f->context));
}

/* The same picture as before, and no host memory is held that was not. */
static void expect_unchanged(fixture *f, const char *what) {
  outcome after = outcome_draw(f->context, f->cascades, f->view, &f->scene.shot);
  outcome_expect_same(&f->before, &after, what);
  assert_true(f->record.blocks <= f->blocks);
}

/* `limit` and `unlimit` are around what is too large. */
static void ask_for_too_much(fixture *f, bool by_limit, void (*limit)(void), void (*unlimit)(void)) {
  for (uint32_t i = 0; i < 4; ++i) {
    const csm_config config = huge(i % 2 ? CSM_LAYOUT_ATLAS : CSM_LAYOUT_ARRAY, i / 2 ? CSM_MAP_D16 : CSM_MAP_D32);
    csm_cascades *cascades = f->cascades;
    limit();
    const csm_result created = csm_cascades_create(f->context, &config, &cascades);
    unlimit();
    assert_null(cascades);
    expect_refused(f, created, by_limit, "csm_cascades_create");
    limit();
    const csm_result configured = csm_cascades_configure(f->cascades, &config);
    unlimit();
    expect_refused(f, configured, by_limit, "csm_cascades_configure");
    expect_unchanged(f, "after maps that were too large");
  }
  limit();
  const csm_result resolved = shot_resolve(&f->scene.shot, f->view, f->cascades, HUGE_SIDE, HUGE_SIDE);
  unlimit();
  expect_refused(f, resolved, by_limit, "csm_resolve_mask");
  expect_unchanged(f, "after a mask that was too large");
}

static void nothing(void) {
}

static void the_contexts_limit(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, little, NULL);
  ask_for_too_much(&f, true, nothing, nothing);
  close_fixture(&f);
}

static uint64_t CSM_CALL tell_little(void *user) {
  (void)user;
  return little;
}

static void the_engines_budget(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f, 0, tell_little);
  ask_for_too_much(&f, true, nothing, nothing);
  close_fixture(&f);
}

/* ---- what the system gives ---- */

static uint64_t address_space(void) {
  unsigned long long pages = 0;
  FILE *file = fopen("/proc/self/statm", "r");
  assert_non_null(file);
  assert_int_equal(fscanf(file, "%llu", &pages), 1);
  fclose(file);
  return pages * 4096;
}

static void set_limit(uint64_t bytes) {
  struct rlimit limit;
  assert_int_equal(getrlimit(RLIMIT_AS, &limit), 0);
  limit.rlim_cur = bytes == none ? limit.rlim_max : bytes;
  assert_int_equal(setrlimit(RLIMIT_AS, &limit), 0);
}

/* Room for what a driver needs besides, and for no part of what is asked for. */
static void give_no_more(void) {
  set_limit(address_space() + (128u << 20));
}

static void give_all(void) {
  set_limit(none);
}

static uint64_t CSM_CALL tell_all(void *user) {
  (void)user;
  return none;
}

static void the_systems_memory(void **state) {
  (void)state;
  if (!ADDRESS_LIMIT) /* a sanitizer takes all addresses */
    skip();
  fixture f;
  open_fixture(&f, 0, tell_all);
  ask_for_too_much(&f, false, give_no_more, give_all);
  close_fixture(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_contexts_limit),
      cmocka_unit_test(the_engines_budget),
      cmocka_unit_test(the_systems_memory),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
