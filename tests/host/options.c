/* What csm-host is told: numbers, options and configurations. */
#include "base/parse.h"
#include "setup/config_json.h"
#include "setup/options.h"
#include "setup/presets.h"
#include "support.h"
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <cmocka.h>

/* ---- the command line ---- */

static int parse(host_options *options, const char *const *words) {
  char *arguments[16] = {(char *)"csm-host"};
  int count = 1;
  for (; *words; words++)
    arguments[count++] = (char *)*words;
  return options_parse(options, count, arguments);
}

static void numbers_are_strict(void **state) {
  (void)state;
  double value;
  assert_true(parse_number("-1.5e2", &value));
  assert_true(value == -150.0);
  const char *const refused[] = {"", " 1", "1 ", "nan", "inf", "1e400", "0x10", "1,2", "--1", "1f"};
  for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++)
    assert_false(parse_number(refused[i], &value));
  uint32_t width, height;
  assert_true(parse_size("640x360", &width, &height));
  assert_int_equal(width, 640);
  assert_int_equal(height, 360);
  const char *const sizes[] = {"640", "640x", "0x360", "640x360x1", "640.5x360", "16385x1", "-1x5"};
  for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
    assert_false(parse_size(sizes[i], &width, &height));
}

static void options_are_understood(void **state) {
  (void)state;
  host_options o;
  assert_int_equal(parse(&o, (const char *const[]){"run", "--scene", "town", "--light", "1,-2,3:0.5", "--size", "64x32",
                                                   "--backend", "d3d12", "--json", "-", NULL}),
                   0);
  assert_int_equal(o.command, COMMAND_RUN);
  assert_string_equal(o.scene, "town");
  assert_true(o.light.direction[1] == -2.0 && o.light.disc_deg == 0.5);
  assert_int_equal(o.width, 64);
  assert_false(o.backends[0]);
  assert_true(o.backends[1]);
  assert_string_equal(options_base_name(&o), "default");
}

static void suns_are_understood(void **state) {
  (void)state;
  host_options o;
  assert_int_equal(parse(&o, (const char *const[]){"run", "--suns", "5", NULL}), 0);
  assert_true(o.has_disc && o.disc_deg == 5.0);
  assert_int_equal(parse(&o, (const char *const[]){"report", "--suns", "0,0.53,5", NULL}), 0);
  assert_true(o.sun_count == 3 && o.suns[1] == 0.53 && !o.has_disc);
  assert_int_equal(parse(&o, (const char *const[]){"measure", "--presets", "low,high", "--against", "medium", "--suns",
                                                   "0,5", NULL}),
                   0);
  assert_int_equal(o.presets.count, 2);
  assert_string_equal(o.against.names[0], "medium");
}

static void bad_options_are_refused(void **state) {
  (void)state;
  host_options o;
  const char *const bad[][4] = {{"frobnicate"},
                                {"run", "--nope", "1"},
                                {"run", "--scene"},
                                {"run", "--light", "0,0,0"},
                                {"run", "--light", "1,2"},
                                {"run", "--light", "1,2,3:-1"},
                                {"run", "--shadow-distance", "0"},
                                {"run", "--shadow-distance", "inf"},
                                {"run", "--size", "10"},
                                {"run", "--backend", "metal"},
                                {"run", "--preset", "nobody"},
                                {"run", "--preset", "all"},
                                {"measure", "--presets", ","},
                                {"hard", "--case"},
                                {"hard", "--case", ","},
                                {"measure", "--presets", "low,nobody"},
                                {"measure", "--presets", "low,low"},
                                {"measure", "--sun-samples", "3"},
                                {"measure", "--sun-samples", "8.5"},
                                {"measure", "--sun-samples", "99999"},
                                {"report", "--cascades", "9"},
                                {"report", "--resolutions", "1024,1024"},
                                {"report", "--suns", ""},
                                {"report", "--suns", "0.5,"},
                                {"report", "--suns", "1,1"},
                                {"report", "--suns", "-1"},
                                {"report", "--suns", "180"},
                                {"run", "--suns", "0,1"},
                                {"measure", "--suns", "0,1"},
                                {"measure", "--against", "low"},
                                {"report", "--minutes", "0"}};
  for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
    assert_int_equal(parse(&o, (const char *const[]){bad[i][0], bad[i][1], bad[i][2], NULL}), 2);
  assert_int_equal(parse(&o, (const char *const[]){NULL}), 2);
  assert_int_equal(parse(&o, (const char *const[]){"--help", NULL}), 0);
}

/* ---- configurations ---- */

static void configurations_are_read(void **state) {
  (void)state;
  char path[64];
  csm_config config, standard = {.struct_size = sizeof standard};
  csm_config_default(&standard);
  make_path(path, ".json");
  assert_int_equal(config_load(&config, NULL, NULL, 77.0), 0);
  assert_true(config.shadow_distance == 77.0 && config.cascade_count == standard.cascade_count);
  write_text(path,
             "{\"cascade_count\": 3.0, \"filter\": \"pcf_2x2\", \"split_lambda\": 1, \"split_distances\": [1, 2.5]}");
  assert_int_equal(config_load(&config, NULL, path, 77.0), 0);
  assert_int_equal(config.cascade_count, 3);
  assert_int_equal(config.filter, CSM_FILTER_PCF_2X2);
  assert_true(config.split_lambda == 1.0 && config.split_distances[1] == 2.5 && config.split_distances[2] == 0.0);
  assert_true(config.shadow_distance == 77.0);
  write_text(path, "{\"shadow_distance\": 12}");
  assert_int_equal(config_load(&config, NULL, path, 77.0), 0);
  assert_true(config.shadow_distance == 12.0);
  const char *const bad[] = {"{\"nope\": 1}",
                             "{\"cascade_count\": \"3\"}",
                             "{\"cascade_count\": 2.5}",
                             "{\"filter\": \"box\"}",
                             "{\"split_lambda\": null}",
                             "{\"split_distances\": 3}",
                             "[]",
                             "{\"split_lambda\": 1",
                             "{\"cascade_count\": -1}"};
  for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
    write_text(path, bad[i]);
    assert_int_equal(config_load(&config, NULL, path, 77.0), 2);
  }
  unlink(path);
}

static void presets_keep_the_scenes_distance(void **state) {
  (void)state;
  csm_preset_info info = {.struct_size = sizeof info};
  uint32_t own = 0, count = 0;
  for (; csm_config_preset_describe(count, &info) == CSM_SUCCESS; count++) {
    csm_config config, library = {.struct_size = sizeof library};
    assert_int_equal(config_load(&config, info.name, NULL, 77.0), 0);
    assert_int_equal(csm_config_preset(info.name, &library), CSM_SUCCESS);
    if (info.flags & CSM_PRESET_SHADOW_DISTANCE)
      own++;
    else
      library.shadow_distance = 77.0;
    assert_memory_equal(&config, &library, sizeof config);
  }
  assert_true(own > 0 && own < count);
  json_t *listed = presets_to_json();
  assert_int_equal(json_object_size(listed), count);
  json_decref(listed);
}

static void presets_are_found_by_name(void **state) {
  (void)state;
  char path[64];
  csm_config config;
  assert_null(preset_find("--preset", "nobody"));
  const char *bevy = preset_find("--preset", "bevy");
  assert_string_equal(bevy, "bevy");
  make_path(path, ".json");
  write_text(path, "{\"resolution\": 512}");
  assert_int_equal(config_load(&config, bevy, path, 77.0), 0);
  assert_true(config.resolution == 512 && config.shadow_distance == 150.0 && config.map_reversed);
  json_t *bad = json_pack("{s:i}", "nope", 1);
  assert_int_equal(config_read(&config, "--preset", bad), 2);
  json_decref(bad);
  unlink(path);
}

static void every_field_is_described(void **state) {
  (void)state;
  csm_config config = {.struct_size = sizeof config};
  csm_config_default(&config);
  json_t *all = config_describe_json(), *values = config_to_json(&config);
  assert_int_equal(json_object_size(all), json_object_size(values));
  const char *key;
  json_t *value;
  json_object_foreach(all, key, value) {
    assert_true(json_is_string(json_object_get(value, "unit")));
    assert_true(json_is_array(json_object_get(value, "range")));
    assert_true(json_equal(json_object_get(value, "default"), json_object_get(values, key)));
  }
  json_decref(all);
  json_decref(values);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(numbers_are_strict),        cmocka_unit_test(options_are_understood),
      cmocka_unit_test(suns_are_understood),       cmocka_unit_test(bad_options_are_refused),
      cmocka_unit_test(configurations_are_read),   cmocka_unit_test(presets_keep_the_scenes_distance),
      cmocka_unit_test(presets_are_found_by_name), cmocka_unit_test(every_field_is_described),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
