/* The table of csm_config's fields, the defaults and the checks that follow from it. */
#include "support.h"

#include <math.h>
#include <string.h>

static bool is_double(const csm_config_field *field) {
  return field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES;
}

static void set(csm_config *config, const csm_config_field *field, uint32_t element, double value) {
  char *at = (char *)config + field->offset;
  if (is_double(field))
    ((double *)(void *)at)[element] = value;
  else
    ((uint32_t *)(void *)at)[element] = (uint32_t)value;
}

static void expect(const csm_config *config, const csm_config_field *field, csm_result expected) {
  const char *error = "";
  const csm_result result = plan_config_check(config, &error);
  if (result != expected)
    fail_msg("%s: %d, not %d (%s)", field->name, result, expected, error);
  if (expected && strncmp(error, field->name, strlen(field->name)))
    fail_msg("%s is not named by '%s'", field->name, error);
}

static void describes_every_byte(void **state) {
  (void)state;
  bool described[sizeof(csm_config)] = {false};
  memset(&described[offsetof(csm_config, struct_size)], 1, sizeof(uint32_t));
  memset(&described[offsetof(csm_config, reserved)], 1, sizeof(uint32_t));
  memset(&described[offsetof(csm_config, reserved_moments)], 1, sizeof(uint32_t));
  memset(&described[offsetof(csm_config, reserved_soft)], 1, sizeof(uint32_t));
  memset(&described[offsetof(csm_config, reserved_history)], 1, sizeof(uint32_t));
  memset(&described[offsetof(csm_config, reserved_budget)], 1, sizeof(uint32_t));
  for (uint32_t i = 0; plan_config_field(i); ++i) {
    const csm_config_field *field = plan_config_field(i);
    assert_int_equal(field->struct_size, sizeof *field);
    assert_true(field->name[0] && field->about[0] && field->unit);
    assert_true(field->minimum <= field->default_value && field->default_value <= field->maximum);
    assert_true((field->type == CSM_FIELD_ENUM) == (field->values != NULL));
    for (uint32_t k = 0; field->values && k <= field->maximum; ++k)
      assert_non_null(field->values[k]);
    if (field->values)
      assert_null(field->values[(uint32_t)field->maximum + 1]);
    const size_t bytes = field->length * (is_double(field) ? sizeof(double) : sizeof(uint32_t));
    for (size_t k = 0; k < bytes; ++k) {
      assert_false(described[field->offset + k]);
      described[field->offset + k] = true;
    }
  }
  for (size_t i = 0; i < sizeof described; ++i)
    assert_true(described[i]);
  assert_null(plan_config_field(UINT32_MAX));
}

static void defaults_are_sound(void **state) {
  (void)state;
  const csm_config config = default_config();
  const char *error = "";
  assert_int_equal(plan_config_check(&config, &error), CSM_SUCCESS);
  assert_int_equal(config.struct_size, sizeof config);
  assert_int_equal(config.cascade_count, 4);
  assert_int_equal(config.resolution, 2048);
  assert_int_equal(config.filter, CSM_FILTER_PCF_3X3);
  assert_true(config.shadow_distance == 150.0 && config.split_lambda == 0.75);
}

/* The defaults, with room for any bit of a budget. */
static csm_config any_budget(void) {
  csm_config config = default_config();
  config.budget_ms = config.budget_wrong = 1.0;
  config.budget_mib = 1e4;
  return config;
}

static void takes_ranges_and_refuses_what_is_beyond(void **state) {
  (void)state;
  for (uint32_t i = 0; plan_config_field(i); ++i) {
    const csm_config_field *field = plan_config_field(i);
    for (uint32_t element = 0; element < field->length; ++element) {
      csm_config config = any_budget();
      set(&config, field, element, field->minimum);
      expect(&config, field, CSM_SUCCESS);
      if (field->type != CSM_FIELD_ENUM) { /* manual splits have a condition of their own */
        set(&config, field, element, field->maximum);
        expect(&config, field, CSM_SUCCESS);
      }
      set(&config, field, element, is_double(field) ? nextafter(field->maximum, INFINITY) : field->maximum + 1);
      expect(&config, field, CSM_ERROR_INVALID_VALUE);
      if (is_double(field)) {
        set(&config, field, element, nextafter(field->minimum, -INFINITY));
        expect(&config, field, CSM_ERROR_INVALID_VALUE);
        set(&config, field, element, NAN);
        expect(&config, field, CSM_ERROR_NOT_FINITE);
        set(&config, field, element, -INFINITY);
        expect(&config, field, CSM_ERROR_NOT_FINITE);
      } else if (field->minimum > 0.0) {
        set(&config, field, element, field->minimum - 1);
        expect(&config, field, CSM_ERROR_INVALID_VALUE);
      }
    }
  }
}

static void manual_splits_rise(void **state) {
  (void)state;
  const double good[] = {1.0, 2.0, 3.0, 4.0};
  const struct {
    int index;
    double value;
  } bad[] = {{0, 0.0}, {1, 1.0}, {2, 1.5}, {3, 0.0}};
  csm_config config = default_config();
  const char *error = "";
  config.split_mode = CSM_SPLIT_MANUAL;
  memcpy(config.split_distances, good, sizeof good);
  assert_int_equal(plan_config_check(&config, &error), CSM_SUCCESS);
  for (int i = 0; i < 4; ++i) {
    memcpy(config.split_distances, good, sizeof good);
    config.split_distances[bad[i].index] = bad[i].value;
    assert_int_equal(plan_config_check(&config, &error), CSM_ERROR_INVALID_VALUE);
    assert_non_null(strstr(error, "split_distances"));
  }
}

/* Each target by itself; a bit without its target, and what the target cannot be kept with. */
static void budgets_have_their_targets(void **state) {
  (void)state;
  const struct {
    uint32_t bits;
    double ms, wrong, mib;
    uint32_t filter, layout, out_of_range;
    const char *error;
  } cases[] = {
      {CSM_BUDGET_TIME, 0.1, 0.0, 0.0, CSM_FILTER_PCF_3X3, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, NULL},
      {CSM_BUDGET_ERROR, 0.0, 0.1, 0.0, CSM_FILTER_PCF_2X2, CSM_LAYOUT_ATLAS, CSM_OUT_OF_RANGE_LIT, NULL},
      {CSM_BUDGET_MEMORY, 0.0, 0.0, 3.0, CSM_FILTER_VSM, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_FADED, NULL},
      {CSM_BUDGET_MEMORY, 0.0, 0.0, 3.0, CSM_FILTER_PCF_3X3, CSM_LAYOUT_PAGES, CSM_OUT_OF_RANGE_LIT, NULL},
      {CSM_BUDGET_TIME, 9.0, 0.0, 0.0, CSM_FILTER_EXACT, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_FADED, NULL},
      {CSM_BUDGET_TIME, 0.0, 1.0, 9.0, CSM_FILTER_PCF_3X3, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, "budget_ms"},
      {CSM_BUDGET_ERROR, 9.0, 0.0, 9.0, CSM_FILTER_PCF_3X3, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, "budget_wrong"},
      {CSM_BUDGET_MEMORY, 9.0, 1.0, 0.0, CSM_FILTER_PCF_3X3, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, "budget_mib"},
      {CSM_BUDGET_MEMORY, 0.0, 0.0, 0.9, CSM_FILTER_PCF_3X3, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, "coarsest maps"},
      {CSM_BUDGET_TIME, 9.0, 0.0, 0.0, CSM_FILTER_VSM, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, "moments"},
      {CSM_BUDGET_ERROR, 0.0, 0.1, 0.0, CSM_FILTER_VSSM, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, "moments"},
      {CSM_BUDGET_TIME, 9.0, 0.0, 0.0, CSM_FILTER_PCF_3X3, CSM_LAYOUT_PAGES, CSM_OUT_OF_RANGE_LIT, "pages"},
      {CSM_BUDGET_ERROR, 0.0, 0.1, 0.0, CSM_FILTER_EXACT, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, "filters pcf_2x2"},
      {CSM_BUDGET_ERROR, 0.0, 0.1, 0.0, CSM_FILTER_PCF_5X5, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_LIT, "filters pcf_2x2"},
      {CSM_BUDGET_ERROR, 0.0, 0.1, 0.0, CSM_FILTER_PCF_3X3, CSM_LAYOUT_ARRAY, CSM_OUT_OF_RANGE_FADED, "faded"},
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
    csm_config config = default_config();
    const char *error = "";
    config.budget = cases[i].bits;
    config.budget_ms = cases[i].ms;
    config.budget_wrong = cases[i].wrong;
    config.budget_mib = cases[i].mib;
    config.filter = cases[i].filter;
    config.moment_levels = cases[i].filter == CSM_FILTER_VSSM ? 4 : 1;
    config.map_layout = cases[i].layout;
    config.out_of_range = cases[i].out_of_range;
    const csm_result result = plan_config_check(&config, &error);
    if (result != (cases[i].error ? CSM_ERROR_INVALID_VALUE : CSM_SUCCESS) ||
        (cases[i].error && (!strstr(error, cases[i].error) || !strstr(error, "budget"))))
      fail_msg("case %zu: %d (%s)", i, result, error);
  }
  csm_config config = default_config();
  const char *error = "";
  config.reserved_budget = 1;
  assert_int_equal(plan_config_check(&config, &error), CSM_ERROR_INVALID_VALUE);
  assert_string_equal(error, "reserved is not 0");
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(describes_every_byte),
      cmocka_unit_test(defaults_are_sound),
      cmocka_unit_test(takes_ranges_and_refuses_what_is_beyond),
      cmocka_unit_test(manual_splits_rise),
      cmocka_unit_test(budgets_have_their_targets),
  };
  return cmocka_run_group_tests_name("plan-config", tests, NULL, NULL);
}
