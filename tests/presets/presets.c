/*
 * presets.c: csm_config_preset and csm_config_preset_describe: sizes of structs, and misuse.
 *
 * `presets tell` prints every preset and the defaults, as "NAME FIELD VALUE..." lines, for files.py.
 */
#include "csm/csm.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

/* ---- telling ---- */

static void print_value(const csm_config_field *field, const void *at, uint32_t element) {
  const bool is_double = field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES;
  if (field->type == CSM_FIELD_ENUM)
    printf(" %s", field->values[*(const uint32_t *)at]);
  else if (is_double)
    printf(" %.17g", ((const double *)at)[element]);
  else
    printf(" %u", ((const uint32_t *)at)[element]);
}

static void tell(const char *name, const csm_config *config) {
  csm_config_field field = {.struct_size = sizeof field};
  for (uint32_t i = 0; csm_config_describe(i, &field) == CSM_SUCCESS; ++i) {
    printf("%s %s", name, field.name);
    for (uint32_t k = 0; k < field.length; ++k)
      print_value(&field, (const char *)config + field.offset, k);
    printf("\n");
  }
}

static void tell_texts(const csm_preset_info *info) {
  printf("%s (about) %s\n%s (read_in) %s\n", info->name, info->about, info->name, info->read_in);
  for (uint32_t i = 0; info->notes[i]; ++i)
    printf("%s (note) %s\n", info->name, info->notes[i]);
  if (info->flags & CSM_PRESET_SHADOW_DISTANCE)
    printf("%s (own_distance)\n", info->name);
}

static int tell_all(void) {
  csm_config config = {.struct_size = sizeof config};
  csm_preset_info info = {.struct_size = sizeof info};
  csm_result result = csm_config_default(&config);
  tell("(defaults)", &config);
  for (uint32_t i = 0; result == CSM_SUCCESS && csm_config_preset_describe(i, &info) == CSM_SUCCESS; ++i) {
    config = (csm_config){.struct_size = sizeof config};
    result = csm_config_preset(info.name, &config);
    tell(info.name, &config);
    tell_texts(&info);
  }
  return result == CSM_SUCCESS ? 0 : 1;
}

/* ---- tests ---- */

enum { SPARE = 64 };

/* A struct with room behind it, all of one byte. */
typedef union padded {
  csm_config config;
  csm_preset_info info;
  unsigned char bytes[sizeof(csm_config) + SPARE];
} padded;

static padded filled(uint32_t size) {
  padded out;
  memset(&out, 0xa5, sizeof out);
  memcpy(&out, &size, sizeof size);
  return out;
}

static void an_older_struct_gets_what_it_holds(void **state) {
  (void)state;
  csm_config whole = {.struct_size = sizeof whole};
  assert_int_equal(csm_config_preset("godot", &whole), CSM_SUCCESS);
  for (uint32_t size = sizeof(uint32_t); size < sizeof(csm_config); size += 4) {
    padded before = filled(size), config = before;
    assert_int_equal(csm_config_preset("godot", &config.config), CSM_SUCCESS);
    assert_int_equal(config.config.struct_size, size);
    assert_memory_equal(config.bytes + sizeof size, (const unsigned char *)&whole + sizeof size, size - sizeof size);
    assert_memory_equal(config.bytes + size, before.bytes + size, sizeof before - size);
  }
}

static void a_newer_struct_keeps_its_tail(void **state) {
  (void)state;
  padded config;
  memset(&config, 0, sizeof config);
  config.config.struct_size = sizeof config.bytes;
  assert_int_equal(csm_config_preset("godot", &config.config), CSM_SUCCESS);
  assert_int_equal(config.config.struct_size, sizeof config.bytes);
  for (size_t i = sizeof(csm_config); i < sizeof config.bytes; ++i)
    assert_int_equal(config.bytes[i], 0);
}

static void expect_config(const char *name, uint32_t size, csm_result expected) {
  padded before = filled(size), config = before;
  assert_int_equal(csm_config_preset(name, &config.config), expected);
  assert_memory_equal(&config, &before, sizeof config);
}

static void misuse_changes_nothing(void **state) {
  (void)state;
  const char *const none[] = {"", "nobody", "Godot", "godot.json"};
  for (size_t i = 0; i < sizeof none / sizeof *none; ++i)
    expect_config(none[i], sizeof(csm_config), CSM_ERROR_INVALID_VALUE);
  expect_config(NULL, sizeof(csm_config), CSM_ERROR_NULL_POINTER);
  expect_config("godot", 0, CSM_ERROR_STRUCT_SIZE);
  expect_config("godot", 7, CSM_ERROR_STRUCT_SIZE);
  expect_config("godot", sizeof(csm_config) + 8, CSM_ERROR_STRUCT_SIZE); /* its unknown tail is not zero */
  expect_config("nobody", 0, CSM_ERROR_STRUCT_SIZE);
  assert_int_equal(csm_config_preset("godot", NULL), CSM_ERROR_NULL_POINTER);
}

static void expect_info(uint32_t index, uint32_t size, csm_result expected) {
  padded before = filled(size), info = before;
  assert_int_equal(csm_config_preset_describe(index, &info.info), expected);
  assert_memory_equal(&info, &before, sizeof info);
}

static void descriptions_end(void **state) {
  (void)state;
  csm_preset_info info = {.struct_size = sizeof info};
  uint32_t count = 0;
  while (csm_config_preset_describe(count, &info) == CSM_SUCCESS)
    ++count;
  assert_true(count >= 38);
  expect_info(count, sizeof info, CSM_ERROR_INVALID_INDEX);
  expect_info(UINT32_MAX, sizeof info, CSM_ERROR_INVALID_INDEX);
  expect_info(0, 0, CSM_ERROR_STRUCT_SIZE);
  expect_info(0, sizeof info + 8, CSM_ERROR_STRUCT_SIZE);
  assert_int_equal(csm_config_preset_describe(0, NULL), CSM_ERROR_NULL_POINTER);

  padded before = filled(offsetof(csm_preset_info, about)), older = before;
  assert_int_equal(csm_config_preset_describe(0, &older.info), CSM_SUCCESS);
  assert_string_equal(older.info.name, "default");
  const size_t size = offsetof(csm_preset_info, about);
  assert_memory_equal(older.bytes + size, before.bytes + size, sizeof before - size);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_older_struct_gets_what_it_holds),
      cmocka_unit_test(a_newer_struct_keeps_its_tail),
      cmocka_unit_test(misuse_changes_nothing),
      cmocka_unit_test(descriptions_end),
  };
  return argc > 1 && strcmp(argv[1], "tell") == 0 ? tell_all() : cmocka_run_group_tests(tests, NULL, NULL);
}
