#include "camera_json.h"
#include "host.h"
#include "json_file.h"
#include <math.h>
#include <string.h>

static int read_doubles(const json_t *object, const char *key, double *out, size_t count) {
  const json_t *array = json_object_get(object, key);
  if (!json_is_array(array) || json_array_size(array) != count)
    return host_fail(HOST_BAD_INPUT, "--camera: '%s' must be an array of %zu numbers", key, count);
  for (size_t i = 0; i < count; i++) {
    const json_t *value = json_array_get(array, i);
    if (!json_is_number(value))
      return host_fail(HOST_BAD_INPUT, "--camera: '%s' must be an array of %zu numbers", key, count);
    out[i] = json_number_value(value);
  }
  return 0;
}

/* A positive number, or null for infinity where that is allowed; an absent key leaves *out as it is. */
static int read_depth(const json_t *object, const char *key, bool infinite_allowed, double *out) {
  const json_t *value = json_object_get(object, key);
  if (!value)
    return 0;
  if (infinite_allowed && json_is_null(value))
    *out = INFINITY;
  else if (json_is_number(value))
    *out = json_number_value(value);
  else
    return host_fail(HOST_BAD_INPUT, "--camera: '%s' must be a number", key);
  return 0;
}

static int read_camera(camera *out, const json_t *object) {
  double view[16], projection[16];
  int code = read_doubles(object, "view", view, 16);
  if (code == 0)
    code = read_doubles(object, "projection", projection, 16);
  if (code)
    return code;
  const char *problem = camera_from_matrices(out, view, projection);
  if (problem)
    return host_fail(HOST_BAD_INPUT, "--camera: %s", problem);
  const json_t *reversed = json_object_get(object, "reversed");
  if (reversed && (!json_is_boolean(reversed) || json_boolean_value(reversed) != out->reversed))
    return host_fail(HOST_BAD_INPUT, "--camera: 'reversed' contradicts the projection");
  /* the file's own numbers, rather than what is left of them in the projection */
  if (json_object_get(object, "position"))
    code = read_doubles(object, "position", out->position, 3);
  if (code == 0)
    code = read_depth(object, "near", false, &out->near_depth);
  if (code == 0)
    code = read_depth(object, "far", true, &out->far_depth);
  if (code == 0 && !(out->far_depth > out->near_depth))
    code = host_fail(HOST_BAD_INPUT, "--camera: 'far' must be beyond 'near'");
  return code;
}

static int read_size(const json_t *root, const char *key, uint32_t *out) {
  const json_t *value = json_object_get(root, key);
  if (!value)
    return 0;
  if (!json_is_integer(value) || json_integer_value(value) < 1 || json_integer_value(value) > 16384)
    return host_fail(HOST_BAD_INPUT, "--camera: '%s' must be 1 to 16384", key);
  *out = (uint32_t)json_integer_value(value);
  return 0;
}

int camera_from_json(camera *out, uint32_t *width, uint32_t *height, const char *path) {
  json_t *root = json_file_load("--camera", path);
  if (!root)
    return HOST_BAD_INPUT;
  const json_t *inner = json_object_get(root, "camera");
  int code = read_camera(out, inner ? inner : root);
  if (code == 0 && inner)
    code = read_size(root, "width", width);
  if (code == 0 && inner)
    code = read_size(root, "height", height);
  if (code == 0 && (*width == 0) != (*height == 0))
    code = host_fail(HOST_BAD_INPUT, "--camera: 'width' and 'height' belong together");
  json_decref(root);
  return code;
}

json_t *json_from_doubles(const double *values, size_t count) {
  json_t *array = json_array();
  for (size_t i = 0; i < count; i++)
    json_array_append_new(array, json_real(values[i]));
  return array;
}

json_t *camera_to_json(const camera *from) {
  json_t *object = json_object();
  json_object_set_new(object, "position", json_from_doubles(from->position, 3));
  json_object_set_new(object, "view", json_from_doubles(from->view, 16));
  json_object_set_new(object, "projection", json_from_doubles(from->projection, 16));
  json_object_set_new(object, "near", json_real(from->near_depth));
  json_object_set_new(object, "far", isinf(from->far_depth) ? json_null() : json_real(from->far_depth));
  json_object_set_new(object, "reversed", json_boolean(from->reversed));
  return object;
}
