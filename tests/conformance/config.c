/* config.c: every bad value and every contradiction of a configuration is refused by name, and changes nothing. */
#include "support.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { resolution = 64, texels = resolution * resolution };

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_config good;
  csm_binding binding;
  float *map;
} fixture;

static void open_fixture(fixture *f) {
  memset(f, 0, sizeof *f);
  f->context = support_open(&f->record);
  f->record.quiet = true;
  f->good = support_config();
  f->good.resolution = resolution;
  support_scene scene;
  support_scene_make(&scene, f->context);
  assert_int_equal(csm_cascades_create(f->context, &f->good, &f->cascades), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(f->cascades, shot_frame(&scene.shot)), CSM_SUCCESS);
  f->binding.struct_size = sizeof f->binding;
  assert_int_equal(csm_bind(f->cascades, &f->binding), CSM_SUCCESS);
  f->map = support_map(f->context, f->cascades, 0, resolution);
}

/* What was drawn is there as it was. */
static void close_fixture(fixture *f) {
  csm_binding binding = {.struct_size = sizeof binding};
  assert_int_equal(csm_bind(f->cascades, &binding), CSM_SUCCESS);
  support_same_binding(&binding, &f->binding);
  assert_true(binding.native_maps == f->binding.native_maps);
  float *map = support_map(f->context, f->cascades, 0, resolution);
  assert_memory_equal(map, f->map, texels * sizeof *map);
  free(map);
  free(f->map);
  support_close(f->context, &f->record);
}

static void expect(fixture *f, const csm_config *config, csm_result expected, const char *text) {
  csm_cascades *made = (csm_cascades *)f;
  const int64_t blocks = f->record.blocks;
  const csm_result results[2] = {csm_cascades_create(f->context, config, &made),
                                 csm_cascades_configure(f->cascades, config)};
  assert_null(made);
  for (int i = 0; i < 2; ++i)
    if (results[i] != expected || !strstr(csm_last_error(f->context), text))
      fail_msg("%s: %s (%s), not %s", text, csm_result_name(results[i]), csm_last_error(f->context),
               csm_result_name(expected));
  assert_int_equal(f->record.blocks, blocks);
}

/* Each element of each field, just outside its range at either end, and no number at all. */
static void values_out_of_range(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  csm_config_field field = {.struct_size = sizeof field};
  uint32_t refused = 0;
  for (uint32_t i = 0; csm_config_describe(i, &field) == CSM_SUCCESS; ++i)
    for (uint32_t k = 0; k < field.length; ++k) {
      csm_config config = f.good;
      char *const at = (char *)&config + field.offset;
      if (field.type == CSM_FIELD_DOUBLE || field.type == CSM_FIELD_DOUBLES) {
        double *value = (double *)(void *)at + k;
        const double outside[] = {nextafter(field.minimum, -INFINITY), nextafter(field.maximum, INFINITY)};
        for (int end = 0; end < 2; ++end, ++refused) {
          *value = outside[end];
          expect(&f, &config, CSM_ERROR_INVALID_VALUE, field.name);
        }
        *value = NAN;
        expect(&f, &config, CSM_ERROR_NOT_FINITE, field.name);
        *value = -INFINITY;
        expect(&f, &config, CSM_ERROR_NOT_FINITE, field.name);
      } else {
        uint32_t *value = (uint32_t *)(void *)at + k;
        *value = (uint32_t)field.maximum + 1;
        expect(&f, &config, CSM_ERROR_INVALID_VALUE, field.name);
        *value = UINT32_MAX;
        expect(&f, &config, CSM_ERROR_INVALID_VALUE, field.name);
        *value = (uint32_t)field.minimum - 1;
        expect(&f, &config, CSM_ERROR_INVALID_VALUE, field.name);
        ++refused;
      }
    }
  assert_true(refused > 60);
  close_fixture(&f);
}

static void contradictions(void **state) {
  (void)state;
  fixture f;
  open_fixture(&f);
  csm_config c;
  const struct {
    csm_config config;
    const char *text;
  } cases[] = {
#define CASE(what, change) {(c = f.good, change, c), what}
      CASE("split_distances do not rise", c.split_mode = CSM_SPLIT_MANUAL),
      CASE("budget_ms is not above 0", c.budget = CSM_BUDGET_TIME),
      CASE("budget_wrong is not above 0", c.budget = CSM_BUDGET_ERROR),
      CASE("budget_mib is not above 0", c.budget = CSM_BUDGET_MEMORY),
      CASE("budget_mib is less than", (c.budget = CSM_BUDGET_MEMORY, c.budget_mib = 1e-4)),
      CASE("budget has a target of time or error",
           (c.budget = CSM_BUDGET_TIME, c.budget_ms = 1, c.filter = CSM_FILTER_VSM)),
      CASE("budget has a target of time or error",
           (c.budget = CSM_BUDGET_TIME, c.budget_ms = 1, c.map_layout = CSM_LAYOUT_PAGES)),
      CASE("budget has a target of error",
           (c.budget = CSM_BUDGET_ERROR, c.budget_wrong = 0.1, c.filter = CSM_FILTER_GRID_17)),
      CASE("out_of_range faded hides",
           (c.budget = CSM_BUDGET_ERROR, c.budget_wrong = 0.1, c.out_of_range = CSM_OUT_OF_RANGE_FADED)),
      CASE("split_distances do not rise", (c.split_mode = CSM_SPLIT_FRACTIONS, c.split_distances[0] = 0.5)),
      CASE("split_distances are fractions", (c.split_mode = CSM_SPLIT_FRACTIONS, c.split_distances[0] = 0.2,
                                             c.split_distances[1] = 0.5, c.split_distances[2] = 1.5)),
      CASE("depth_samples splits", (c.split_mode = CSM_SPLIT_MANUAL, c.depth_samples = CSM_DEPTH_SAMPLES_SPLITS)),
      CASE("filter_taps of filter pcf_n", (c.filter = CSM_FILTER_PCF_N, c.filter_taps = 4)),
      CASE("filter_taps of filter pcf_n", (c.filter = CSM_FILTER_PCF_N, c.filter_taps = 1)),
      CASE("filter_taps of filter pcf_n", (c.filter = CSM_FILTER_PCF_N, c.filter_taps = 33)),
      CASE("filter_taps of filter vogel", (c.filter = CSM_FILTER_VOGEL, c.filter_taps = 0)),
      CASE("filter_weights", (c.filter = CSM_FILTER_POISSON, c.filter_weights = CSM_WEIGHTS_GAUSSIAN)),
      CASE("filter_weights", (c.filter = CSM_FILTER_PCF_2X2, c.filter_weights = CSM_WEIGHTS_CASTANO)),
      CASE("filter_weights castano", (c.filter = CSM_FILTER_PCF_N, c.filter_weights = CSM_WEIGHTS_CASTANO)),
      CASE("filter_early_out", c.filter_early_out = 1),
      CASE("filter_early_out", (c.filter = CSM_FILTER_VOGEL, c.filter_early_out = 1)),
      CASE("bias_mode receiver_plane", c.filter = CSM_FILTER_LINEAR_DEPTH),
      CASE("snap_power", (c.snap_mode = CSM_SNAP_OFF, c.snap_power = 2)),
      CASE("resolutions", c.resolutions[1] = 15),
      CASE("resolution is too small", (c.resolutions[2] = 24, c.filter = CSM_FILTER_PCF_N, c.filter_taps = 31)),
      CASE("blend_share", (c.blend_mode = CSM_BLEND_DITHERED, c.blend_share = 0)),
      CASE("fade_share", (c.out_of_range = CSM_OUT_OF_RANGE_FADED, c.fade_share = 0)),
#undef CASE
  };
  for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
    expect(&f, &cases[i].config, CSM_ERROR_INVALID_VALUE, cases[i].text);
  close_fixture(&f);
}

/* Making and freeing, with no frame between, holds no memory: ten times what the limit allows would not fit else. */
static void what_is_freed_without_a_frame_is_free(void **state) {
  (void)state;
  record record = {0};
  csm_create_info info = support_create_info(&record);
  info.memory_limit = 16 << 20;
  csm_context *context;
  assert_int_equal(csm_create(&info, &context), CSM_SUCCESS);
  csm_config config = support_config();
  config.cascade_count = 8;
  for (int i = 0; i < 80; ++i) {
    csm_cascades *cascades;
    config.map_layout = (uint32_t)i % 2;
    assert_int_equal(csm_cascades_create(context, &config, &cascades), CSM_SUCCESS);
    assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  }
  support_close(context, &record);
}

/* ---- the text that fixes shaders ---- */

/* Lines of "#define NAME NUMBER" alone, each name once. */
static void check_lines(const char *text) {
  uint32_t lines = 0;
  for (const char *line = text; *line; line = strchr(line, '\n') + 1, ++lines) {
    char name[64];
    unsigned value;
    int length = 0;
    assert_int_equal(sscanf(line, "#define %63[A-Z0-9_] %u%n", name, &value, &length), 2);
    assert_true(line[length] == '\n' && !strncmp(name, "CSM_", 4));
    char again[80];
    snprintf(again, sizeof again, "#define %s ", name);
    assert_null(strstr(line + length, again));
  }
  assert_true(lines > 4);
}

static void defines_are_written_where_they_fit(void **state) {
  (void)state;
  char text[2048], other[2048];
  csm_config config = support_config();
  uint64_t size = 0, room;
  assert_int_equal(csm_shader_defines(&config, NULL, &size), CSM_SUCCESS);
  assert_in_range(size, 64, sizeof text);
  memset(text, 'x', sizeof text);
  room = size - 1;
  assert_int_equal(csm_shader_defines(&config, text, &room), CSM_ERROR_INVALID_VALUE);
  assert_true(room == size && text[0] == 'x'); /* told, and nothing is written */
  assert_int_equal(csm_shader_defines(&config, text, &room), CSM_SUCCESS);
  assert_true(room == size && strlen(text) + 1 == size && text[size] == 'x');
  check_lines(text);
  config.filter = CSM_FILTER_PCF_2X2;
  room = sizeof other;
  assert_int_equal(csm_shader_defines(&config, other, &room), CSM_SUCCESS);
  check_lines(other);
  assert_string_not_equal(text, other);
}

static void defines_of_what_is_wrong(void **state) {
  (void)state;
  const csm_config good = support_config();
  csm_config config = good;
  char text[16] = "as it was";
  uint64_t size = sizeof text;
  assert_int_equal(csm_shader_defines(&good, text, NULL), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_shader_defines(NULL, text, &size), CSM_ERROR_NULL_POINTER);
  config.struct_size = 0;
  assert_int_equal(csm_shader_defines(&config, text, &size), CSM_ERROR_STRUCT_SIZE);
  config = good, config.shadow_distance = NAN;
  assert_int_equal(csm_shader_defines(&config, text, &size), CSM_ERROR_NOT_FINITE);
  config = good, config.filter = 99;
  assert_int_equal(csm_shader_defines(&config, text, &size), CSM_ERROR_INVALID_VALUE);
  assert_true(size == sizeof text);
  assert_string_equal(text, "as it was");
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(values_out_of_range),
      cmocka_unit_test(contradictions),
      cmocka_unit_test(what_is_freed_without_a_frame_is_free),
      cmocka_unit_test(defines_are_written_where_they_fit),
      cmocka_unit_test(defines_of_what_is_wrong),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
