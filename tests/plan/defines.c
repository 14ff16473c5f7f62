/* The defines that fix shaders to a configuration: each says what the configuration does, and no more is fixed. */
#include "support.h"

#include <stdio.h>
#include <string.h>

enum { room = 1024 };

static void expect(const csm_config *config, const char *line) {
  char text[room];
  const size_t size = plan_shader_defines(config, text, sizeof text);
  assert_true(size == strlen(text) + 1);
  if (!strstr(text, line))
    fail_msg("no '%s' in\n%s", line, text);
}

static void defines_say_what_is_configured(void **state) {
  (void)state;
  csm_config config = default_config();
  config.filter = CSM_FILTER_VOGEL;
  config.filter_taps = 13;
  config.bias_mode = CSM_BIAS_SLOPE;
  config.selection = CSM_SELECT_BEST;
  config.out_of_range = CSM_OUT_OF_RANGE_FADED;
  config.blend_mode = CSM_BLEND_DITHERED;
  config.map_reversed = 1;
  config.cascade_count = 6;
  static const char *const lines[] = {"#define CSM_FILTER 8\n",        "#define CSM_FILTER_TAPS 13\n",
                                      "#define CSM_BIAS_MODE 0\n",     "#define CSM_SELECTION 2\n",
                                      "#define CSM_OUT_OF_RANGE 2\n",  "#define CSM_BLENDING 2\n",
                                      "#define CSM_MAPS_REVERSED 1\n", "#define CSM_CASCADES 6\n",
                                      "#define CSM_EARLY_OUT 0\n",     "#define CSM_FILTER_WEIGHTS 0\n"};
  for (size_t i = 0; i < sizeof lines / sizeof *lines; ++i)
    expect(&config, lines[i]);
}

/* What changes one define, and to what. */
static void what_is_seldom_asked_for_is_fixed_away(void **state) {
  (void)state;
  const csm_config base = default_config();
  expect(&base, "#define CSM_NORMAL_OFFSET_ON 0\n");
  expect(&base, "#define CSM_BIAS_UNITS 0\n");
  expect(&base, "#define CSM_MAPS_ALIKE 1\n");
  csm_config config = base;
  config.bias_normal_texels = 0.5;
  config.normal_offset_mode = CSM_NORMAL_OFFSET_SINE;
  expect(&config, "#define CSM_NORMAL_OFFSET_ON 1\n");
  expect(&config, "#define CSM_NORMAL_OFFSET_MODE 1\n");
  double *const units[] = {&config.bias_constant_m, &config.bias_slope_range, &config.bias_limit_range};
  for (int i = 0; i < 3; ++i) {
    config = base;
    *units[i] = 0.01;
    expect(&config, "#define CSM_BIAS_UNITS 1\n");
  }
  config = base;
  config.bias_constant_range = 0.01; /* which every shader adds */
  expect(&config, "#define CSM_BIAS_UNITS 0\n");
  config = base;
  config.map_layout = CSM_LAYOUT_ATLAS;
  expect(&config, "#define CSM_MAPS_ALIKE 0\n");
  config.map_layout = CSM_LAYOUT_PAGES;
  expect(&config, "#define CSM_MAPS_ALIKE 2\n");
  config = base;
  config.resolutions[2] = base.resolution / 2;
  expect(&config, "#define CSM_MAPS_ALIKE 0\n");
  config.cascade_count = 2; /* the smaller one is not there */
  expect(&config, "#define CSM_MAPS_ALIKE 1\n");
}

/* vkd3d draws some filters wrong that leave early and have their bias fixed. */
static void early_out_leaves_the_bias_open(void **state) {
  (void)state;
  csm_config config = default_config();
  char text[room];
  config.filter = CSM_FILTER_PCF_7X7;
  config.filter_early_out = 1;
  expect(&config, "#define CSM_EARLY_OUT 1\n");
  (void)plan_shader_defines(&config, text, sizeof text);
  assert_null(strstr(text, "CSM_BIAS_MODE"));
}

static void no_more_is_written_than_there_is_room(void **state) {
  (void)state;
  const csm_config config = default_config();
  char all[room], text[room];
  const size_t size = plan_shader_defines(&config, all, sizeof all);
  assert_true(plan_shader_defines(&config, NULL, 0) == size);
  for (size_t given = 1; given <= size + 1; ++given) {
    memset(text, 'x', sizeof text);
    assert_true(plan_shader_defines(&config, text, given) == size);
    const size_t length = given < size ? given - 1 : size - 1;
    assert_true(strlen(text) == length && memcmp(text, all, length) == 0);
    assert_true(text[length + 1] == 'x');
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(defines_say_what_is_configured),
      cmocka_unit_test(what_is_seldom_asked_for_is_fixed_away),
      cmocka_unit_test(early_out_leaves_the_bias_open),
      cmocka_unit_test(no_more_is_written_than_there_is_room),
  };
  return cmocka_run_group_tests_name("plan-defines", tests, NULL, NULL);
}
