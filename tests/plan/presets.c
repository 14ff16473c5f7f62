/* presets.c: every preset is a sound configuration. What each one says is compared with its file by preset_files.py. */
#include "support.h"

#include "plan/presets.h"
#include <string.h>

static void every_preset_is_sound(void **state) {
  (void)state;
  assert_true(plan_preset_count >= 38);
  for (uint32_t i = 0; i < plan_preset_count; ++i) {
    csm_config config;
    const char *error = NULL;
    plan_preset_config(&config, &plan_presets[i]);
    if (plan_config_check(&config, &error) != CSM_SUCCESS)
      fail_msg("%s: %s", plan_presets[i].name, error);
  }
}

/* A preset that sets nothing is the defaults; one that sets an array's element leaves the others. */
static void settings_go_over_the_defaults(void **state) {
  (void)state;
  const plan_setting settings[] = {
      {.offset = offsetof(csm_config, split_distances[2]), .number = 0.25},
      {.offset = offsetof(csm_config, resolutions[7]), .number = 512.0},
      {.offset = offsetof(csm_config, filter), .value = "vogel"},
  };
  const plan_preset preset = {.name = "made here", .settings = settings, .setting_count = 3};
  csm_config expected, config;
  plan_config_default(&expected);
  plan_preset_config(&config, &(plan_preset){.name = "empty"});
  assert_memory_equal(&config, &expected, sizeof config);
  plan_preset_config(&config, &preset);
  expected.split_distances[2] = 0.25;
  expected.resolutions[7] = 512;
  expected.filter = CSM_FILTER_VOGEL;
  assert_memory_equal(&config, &expected, sizeof config);
}

/* A value that its enumeration lacks is one that the check refuses, and not the first one silently. */
static void an_unknown_value_is_refused(void **state) {
  (void)state;
  const plan_setting setting = {.offset = offsetof(csm_config, snap_mode), .value = "sometimes"};
  csm_config config;
  const char *error = NULL;
  plan_preset_config(&config, &(plan_preset){.name = "wrong", .settings = &setting, .setting_count = 1});
  assert_int_equal(plan_config_check(&config, &error), CSM_ERROR_INVALID_VALUE);
  assert_non_null(strstr(error, "snap_mode"));
}

/* A preset that mends another one has its name, and is another configuration. */
static void what_is_fixed_errs_without(void **state) {
  (void)state;
  static const char mended[] = "-fixed";
  const size_t ending = sizeof mended - 1;
  uint32_t pairs = 0;
  for (uint32_t i = 0; i < plan_preset_count; ++i) {
    char name[64] = "";
    const size_t length = strlen(plan_presets[i].name);
    assert_true(length < sizeof name);
    if (length <= ending || strcmp(plan_presets[i].name + length - ending, mended) != 0)
      continue;
    memcpy(name, plan_presets[i].name, length - ending);
    const plan_preset *errs = plan_preset_find(name);
    if (!errs)
      fail_msg("%s mends no preset", plan_presets[i].name);
    csm_config with, without;
    plan_preset_config(&with, errs);
    plan_preset_config(&without, &plan_presets[i]);
    assert_memory_not_equal(&with, &without, sizeof with);
    ++pairs;
  }
  assert_true(pairs >= 8);
}

static void names_are_found(void **state) {
  (void)state;
  for (uint32_t i = 0; i < plan_preset_count; ++i)
    assert_ptr_equal(plan_preset_find(plan_presets[i].name), &plan_presets[i]);
  const char *const none[] = {"", "Default", "defaul", "default ", "bevy.json"};
  for (size_t i = 0; i < sizeof none / sizeof *none; ++i)
    assert_null(plan_preset_find(none[i]));
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_preset_is_sound),
      cmocka_unit_test(settings_go_over_the_defaults),
      cmocka_unit_test(an_unknown_value_is_refused),
      cmocka_unit_test(what_is_fixed_errs_without),
      cmocka_unit_test(names_are_found),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
