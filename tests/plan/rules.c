/* What csm_config's fields say of each other. */
#include "support.h"

#include <stdio.h>
#include <string.h>

static const csm_config_field *field_named(const char *name) {
  for (uint32_t i = 0; plan_config_field(i); ++i)
    if (strcmp(plan_config_field(i)->name, name) == 0)
      return plan_config_field(i);
  fail_msg("no field %s", name);
  return NULL;
}

static void set(csm_config *config, const char *name, double value) {
  const csm_config_field *field = field_named(name);
  void *at = (char *)config + field->offset;
  if (field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES)
    *(double *)at = value;
  else
    *(uint32_t *)at = (uint32_t)value;
}

static void every_field_says_what_it_is(void **state) {
  (void)state;
  for (uint32_t i = 0; plan_config_field(i); ++i) {
    const csm_config_field *field = plan_config_field(i);
    if (!(field->minimum < field->maximum))
      fail_msg("%s has no range", field->name);
    if ((field->unit[0] == 0) != (field->type == CSM_FIELD_ENUM))
      fail_msg("%s has the unit '%s'", field->name, field->unit);
    if (field->about[strlen(field->about) - 1] != '.')
      fail_msg("%s is told of in no sentence", field->name);
    if (field->type == CSM_FIELD_UINT || field->type == CSM_FIELD_UINTS)
      assert_true(field->default_value == (uint32_t)field->default_value);
    if (field->type == CSM_FIELD_ENUM)
      assert_true(field->minimum == 0.0);
    for (uint32_t k = 0; k < i; ++k)
      assert_string_not_equal(field->name, plan_config_field(k)->name);
    for (uint32_t a = 0; field->values && field->values[a]; ++a)
      for (uint32_t b = 0; b < a; ++b)
        assert_string_not_equal(field->values[a], field->values[b]);
  }
}

/* Two values, each sound alone, that contradict each other; the error names the field. */
typedef struct contradiction {
  const char *fields[2];
  double values[2];
  const char *named;
} contradiction;

/* One that every value of a contradiction is sound in. */
static csm_config base_config(void) {
  csm_config config = default_config();
  config.filter = CSM_FILTER_PCF_5X5;
  config.bias_mode = CSM_BIAS_SLOPE;
  for (int i = 0; i < 4; ++i)
    config.split_distances[i] = 0.25 * (i + 1);
  return config;
}

static void expect(const csm_config *config, csm_result expected, const char *named, const char *what) {
  const char *error = "";
  const csm_result result = plan_config_check(config, &error);
  if (result != expected)
    fail_msg("%s: %d, not %d (%s)", what, result, expected, error);
  if (expected && !strstr(error, named))
    fail_msg("%s: %s is not named by '%s'", what, named, error);
}

static void check_contradiction(const contradiction *c) {
  char what[160];
  (void)snprintf(what, sizeof what, "%s %g with %s %g", c->fields[0], c->values[0], c->fields[1], c->values[1]);
  for (int first = 0; first < 2; ++first) {
    csm_config config = base_config();
    set(&config, c->fields[first], c->values[first]);
    expect(&config, CSM_SUCCESS, "", what);
    set(&config, c->fields[!first], c->values[!first]);
    expect(&config, CSM_ERROR_INVALID_VALUE, c->named, what);
  }
}

static void contradictions_are_found_and_named(void **state) {
  (void)state;
  static const contradiction all[] = {
      {{"depth_samples", "split_mode"}, {CSM_DEPTH_SAMPLES_SPLITS, CSM_SPLIT_MANUAL}, "depth_samples"},
      {{"depth_samples", "split_mode"}, {CSM_DEPTH_SAMPLES_SPLITS, CSM_SPLIT_FRACTIONS}, "depth_samples"},
      {{"split_distances", "split_mode"}, {0.0, CSM_SPLIT_MANUAL}, "split_distances"},
      {{"split_distances", "split_mode"}, {0.5, CSM_SPLIT_MANUAL}, "split_distances"},
      {{"split_distances", "split_mode"}, {0.5, CSM_SPLIT_FRACTIONS}, "split_distances"},
      {{"filter", "filter_taps"}, {CSM_FILTER_PCF_N, 0}, "filter_taps"},
      {{"filter", "filter_taps"}, {CSM_FILTER_PCF_N, 1}, "filter_taps"},
      {{"filter", "filter_taps"}, {CSM_FILTER_PCF_N, 4}, "filter_taps"},
      {{"filter", "filter_taps"}, {CSM_FILTER_PCF_N, 33}, "filter_taps"},
      {{"filter", "filter_taps"}, {CSM_FILTER_VOGEL, 0}, "filter_taps"},
      {{"filter", "filter_weights"}, {CSM_FILTER_PCF_N, CSM_WEIGHTS_CASTANO}, "filter_weights"},
      {{"filter", "bias_mode"}, {CSM_FILTER_LINEAR_DEPTH, CSM_BIAS_RECEIVER_PLANE}, "bias_mode"},
      {{"snap_mode", "snap_power"}, {CSM_SNAP_OFF, 1}, "snap_power"},
      {{"resolution", "snap_power"}, {16, 4}, "resolution"},
      {{"resolution", "bias_normal_texels"}, {16, 4.0}, "resolution"},
      {{"resolutions", "snap_power"}, {16, 4}, "resolution"},
      {{"blend_mode", "blend_share"}, {CSM_BLEND_LINEAR, 0.0}, "blend_share"},
      {{"blend_mode", "blend_share"}, {CSM_BLEND_DITHERED, 0.0}, "blend_share"},
      {{"out_of_range", "fade_share"}, {CSM_OUT_OF_RANGE_FADED, 0.0}, "fade_share"},
      {{"map_layout", "fit_mode"}, {CSM_LAYOUT_PAGES, CSM_FIT_CASCADE}, "fit_mode"},
      {{"map_layout", "fit_mode"}, {CSM_LAYOUT_PAGES, CSM_FIT_SCENE}, "fit_mode"},
      {{"map_layout", "snap_mode"}, {CSM_LAYOUT_PAGES, CSM_SNAP_OFF}, "snap_mode"},
      {{"map_layout", "snap_power"}, {CSM_LAYOUT_PAGES, 1}, "snap_power"},
      {{"map_layout", "resolution"}, {CSM_LAYOUT_PAGES, 1000}, "multiple of 64"},
      {{"map_layout", "resolutions"}, {CSM_LAYOUT_PAGES, 1024}, "resolutions"},
      {{"map_layout", "filter"}, {CSM_LAYOUT_PAGES, CSM_FILTER_EVSM4}, "moments"},
  };
  for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
    check_contradiction(&all[i]);
}

/* Weights and the early way out are for boxes of taps alone. */
static void filters_take_what_they_can_use(void **state) {
  (void)state;
  for (uint32_t filter = 0; filter <= CSM_FILTER_GRID_17; ++filter) {
    const bool large = filter == CSM_FILTER_PCF_5X5 || filter == CSM_FILTER_PCF_7X7 || filter == CSM_FILTER_PCF_N;
    const bool weighs = large || filter == CSM_FILTER_PCF_3X3;
    csm_config config = base_config();
    config.filter = filter;
    expect(&config, CSM_SUCCESS, "", "the filter alone");
    config.filter_weights = CSM_WEIGHTS_GAUSSIAN;
    expect(&config, weighs ? CSM_SUCCESS : CSM_ERROR_INVALID_VALUE, "filter_weights", "gaussian");
    config.filter_weights = CSM_WEIGHTS_CASTANO;
    expect(&config, weighs && filter != CSM_FILTER_PCF_N ? CSM_SUCCESS : CSM_ERROR_INVALID_VALUE, "filter_weights",
           "castano");
    config.filter_weights = CSM_WEIGHTS_UNIFORM;
    config.filter_early_out = 1;
    expect(&config, large ? CSM_SUCCESS : CSM_ERROR_INVALID_VALUE, "filter_early_out", "early out");
  }
  csm_config config = base_config();
  config.filter = CSM_FILTER_PCF_N;
  for (config.filter_taps = 3; config.filter_taps <= 31; config.filter_taps += 2)
    expect(&config, CSM_SUCCESS, "", "odd taps");
  config.filter = CSM_FILTER_VOGEL;
  for (config.filter_taps = 1; config.filter_taps <= 64; ++config.filter_taps)
    expect(&config, CSM_SUCCESS, "", "points");
}

/* What is kept cannot move in every frame. */
static void pages_are_not_jittered(void **state) {
  (void)state;
  csm_config config = base_config();
  config.map_layout = CSM_LAYOUT_PAGES;
  config.history_jitter = 1;
  expect(&config, CSM_SUCCESS, "", "a jitter without a history");
  config.history = CSM_HISTORY_ON;
  expect(&config, CSM_ERROR_INVALID_VALUE, "history_jitter", "a jitter");
  config.history_jitter = 0;
  expect(&config, CSM_SUCCESS, "", "a history");
}

static void shares_end_at_one(void **state) {
  (void)state;
  csm_config config = base_config();
  config.split_mode = CSM_SPLIT_FRACTIONS;
  expect(&config, CSM_SUCCESS, "", "fractions");
  config.split_distances[3] = 1.0 + 1e-12;
  expect(&config, CSM_ERROR_INVALID_VALUE, "split_distances", "a share above 1");
  config.split_mode = CSM_SPLIT_MANUAL;
  expect(&config, CSM_SUCCESS, "", "a distance above 1");
}

static void single_resolutions_count_where_there_is_a_cascade(void **state) {
  (void)state;
  for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i) {
    csm_config config = base_config();
    config.resolutions[i] = 15;
    expect(&config, i < config.cascade_count ? CSM_ERROR_INVALID_VALUE : CSM_SUCCESS, "resolutions", "15 texels");
    config.resolutions[i] = 16;
    expect(&config, CSM_SUCCESS, "", "16 texels");
    config.filter = CSM_FILTER_PCF_N;
    config.filter_taps = 31;
    expect(&config, i < config.cascade_count ? CSM_ERROR_INVALID_VALUE : CSM_SUCCESS, "resolution", "no room");
  }
}

/* ---- the tail ---- */

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_field_says_what_it_is),
      cmocka_unit_test(contradictions_are_found_and_named),
      cmocka_unit_test(filters_take_what_they_can_use),
      cmocka_unit_test(pages_are_not_jittered),
      cmocka_unit_test(shares_end_at_one),
      cmocka_unit_test(single_resolutions_count_where_there_is_a_cascade),
  };
  return cmocka_run_group_tests_name("plan-rules", tests, NULL, NULL);
}
