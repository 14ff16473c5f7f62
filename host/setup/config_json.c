#include "setup/config_json.h"
#include "base/host.h"
#include "base/json_file.h"
#include "setup/presets.h"
#include <math.h>
#include <stdbool.h>
#include <string.h>

static bool describe(uint32_t index, csm_config_field *field) {
  *field = (csm_config_field){.struct_size = sizeof *field};
  return csm_config_describe(index, field) == CSM_SUCCESS;
}

static bool find_field(const char *name, csm_config_field *field) {
  for (uint32_t i = 0; describe(i, field); i++)
    if (strcmp(field->name, name) == 0)
      return true;
  return false;
}

/* ---- reading ---- */

static int wrong_type(const char *from, const char *key, const char *wanted) {
  return host_fail(HOST_BAD_INPUT, "%s: '%s' must be %s", from, key, wanted);
}

/* A whole number may be written with a point: 4.0 is 4. */
static int read_uint(void *to, const char *from, const char *key, const json_t *value) {
  const double number = json_number_value(value);
  if (!json_is_number(value) || number != floor(number) || number < 0.0 || number > UINT32_MAX)
    return wrong_type(from, key, "a whole number that is not negative");
  *(uint32_t *)to = (uint32_t)number;
  return 0;
}

static int read_enum(void *to, const char *from, const csm_config_field *field, const json_t *value) {
  const json_int_t number = json_integer_value(value);
  if (json_is_integer(value) && (number < 0 || (double)number > field->maximum))
    return host_fail(HOST_BAD_INPUT, "%s: '%s' has no value %" JSON_INTEGER_FORMAT, from, field->name, number);
  if (json_is_integer(value))
    return read_uint(to, from, field->name, value);
  if (!json_is_string(value))
    return wrong_type(from, field->name, "a name or a number");
  for (uint32_t i = 0; field->values[i]; i++)
    if (strcmp(field->values[i], json_string_value(value)) == 0) {
      *(uint32_t *)to = i;
      return 0;
    }
  return host_fail(HOST_BAD_INPUT, "%s: '%s' has no value '%s'", from, field->name, json_string_value(value));
}

static bool is_array(const csm_config_field *field) {
  return field->type == CSM_FIELD_DOUBLES || field->type == CSM_FIELD_UINTS;
}

static int read_array(void *to, const char *from, const csm_config_field *field, const json_t *value) {
  if (!json_is_array(value) || json_array_size(value) > field->length)
    return host_fail(HOST_BAD_INPUT, "%s: '%s' must be an array of up to %u numbers", from, field->name, field->length);
  const bool doubles = field->type == CSM_FIELD_DOUBLES;
  memset(to, 0, field->length * (doubles ? sizeof(double) : sizeof(uint32_t)));
  int code = 0;
  for (size_t i = 0; i < json_array_size(value) && code == 0; i++) {
    const json_t *element = json_array_get(value, i);
    if (!json_is_number(element))
      code = wrong_type(from, field->name, "an array of numbers");
    else if (doubles)
      ((double *)to)[i] = json_number_value(element);
    else
      code = read_uint((uint32_t *)to + i, from, field->name, element);
  }
  return code;
}

static int read_field(csm_config *config, const char *from, const csm_config_field *field, const json_t *value) {
  void *to = (char *)config + field->offset;
  if (field->type == CSM_FIELD_UINT)
    return read_uint(to, from, field->name, value);
  if (field->type == CSM_FIELD_ENUM)
    return read_enum(to, from, field, value);
  if (is_array(field))
    return read_array(to, from, field, value);
  if (!json_is_number(value))
    return wrong_type(from, field->name, "a number");
  *(double *)to = json_number_value(value);
  return 0;
}

int config_read(csm_config *config, const char *from, json_t *object) {
  int code = 0;
  const char *key;
  json_t *value;
  json_object_foreach(object, key, value) {
    csm_config_field field;
    if (code == 0)
      code = find_field(key, &field) ? read_field(config, from, &field, value)
                                     : host_fail(HOST_BAD_INPUT, "%s: unknown key '%s'", from, key);
  }
  return code;
}

static int check_field(const csm_config *config, const char *from, const csm_config_field *field) {
  const void *at = (const char *)config + field->offset;
  const bool doubles = field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES;
  for (uint32_t i = 0; i < field->length; i++) {
    const double value = doubles ? ((const double *)at)[i] : ((const uint32_t *)at)[i];
    if (!(value >= field->minimum && value <= field->maximum))
      return host_fail(HOST_BAD_INPUT, "%s: '%s' is %g, which is not %g to %g", from, field->name, value,
                       field->minimum, field->maximum);
  }
  return 0;
}

int config_check(const csm_config *config, const char *from) {
  csm_config_field field;
  uint64_t size = 0;
  int code = 0;
  for (uint32_t i = 0; code == 0 && describe(i, &field); i++)
    code = check_field(config, from, &field);
  const csm_result result = code ? CSM_SUCCESS : csm_shader_defines(config, NULL, &size);
  return result ? host_fail(HOST_BAD_INPUT, "%s: its values contradict each other: %s", from, csm_result_name(result))
                : code;
}

int config_load(csm_config *out, const char *preset, const char *path, double shadow_distance) {
  *out = (csm_config){.struct_size = sizeof *out};
  csm_config_default(out);
  out->shadow_distance = shadow_distance;
  if (preset)
    preset_config(out, preset, shadow_distance);
  if (!path)
    return 0;
  json_t *root = json_file_load("--config", path);
  const int code = root ? config_read(out, "--config", root) : HOST_BAD_INPUT;
  json_decref(root);
  return code;
}

/* ---- writing ---- */

static json_t *number_to_json(uint32_t type, double value) {
  return type == CSM_FIELD_UINT || type == CSM_FIELD_UINTS ? json_integer((json_int_t)value) : json_real(value);
}

static json_t *field_to_json(const csm_config *config, const csm_config_field *field) {
  const void *from = (const char *)config + field->offset;
  if (field->type == CSM_FIELD_UINT)
    return json_integer(*(const uint32_t *)from);
  if (field->type == CSM_FIELD_ENUM)
    return json_string(field->values[*(const uint32_t *)from]);
  if (field->type == CSM_FIELD_DOUBLE)
    return json_real(*(const double *)from);
  json_t *array = json_array();
  for (uint32_t i = 0; i < field->length; i++)
    json_array_append_new(array,
                          number_to_json(field->type, field->type == CSM_FIELD_DOUBLES ? ((const double *)from)[i]
                                                                                       : ((const uint32_t *)from)[i]));
  return array;
}

json_t *config_to_json(const csm_config *config) {
  json_t *object = json_object();
  csm_config_field field;
  for (uint32_t i = 0; describe(i, &field); i++)
    json_object_set_new(object, field.name, field_to_json(config, &field));
  return object;
}

static json_t *values_to_json(const char *const *values) {
  json_t *array = json_array();
  for (uint32_t i = 0; values[i]; i++)
    json_array_append_new(array, json_string(values[i]));
  return array;
}

static json_t *range_to_json(const csm_config_field *field) {
  if (field->type == CSM_FIELD_ENUM)
    return values_to_json(field->values);
  json_t *array = json_array();
  json_array_append_new(array, number_to_json(field->type, field->minimum));
  json_array_append_new(array, number_to_json(field->type, field->maximum));
  return array;
}

json_t *config_describe_json(void) {
  static const char *const types[] = {[CSM_FIELD_UINT] = "uint",
                                      [CSM_FIELD_DOUBLE] = "double",
                                      [CSM_FIELD_ENUM] = "enum",
                                      [CSM_FIELD_DOUBLES] = "doubles",
                                      [CSM_FIELD_UINTS] = "uints"};
  csm_config standard = {.struct_size = sizeof standard};
  csm_config_default(&standard);
  json_t *all = json_object();
  csm_config_field field;
  for (uint32_t i = 0; describe(i, &field); i++) {
    json_t *object = json_object();
    json_object_set_new(object, "type", json_string(types[field.type]));
    json_object_set_new(object, "unit", json_string(field.unit));
    json_object_set_new(object, "range", range_to_json(&field));
    json_object_set_new(object, "default", field_to_json(&standard, &field));
    json_object_set_new(object, "about", json_string(field.about));
    json_object_set_new(all, field.name, object);
  }
  return all;
}
