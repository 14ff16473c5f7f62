#include "scene/camera_json.h"
#include "base/host.h"
#include "base/json_file.h"
#include "base/linear.h"
#include <math.h>
#include <string.h>

static int read_doubles(const json_t *object, const json_source *from, const char *key, double *out, size_t count) {
  const json_t *array = json_object_get(object, key);
  bool right = json_is_array(array) && json_array_size(array) == count;
  for (size_t i = 0; right && i < count; i++) {
    const json_t *value = json_array_get(array, i);
    right = json_is_number(value);
    out[i] = json_number_value(value);
  }
  char problem[64];
  snprintf(problem, sizeof problem, "must be an array of %zu numbers", count);
  return right ? 0 : json_source_fail(from, key, problem);
}

/* A number, or null for infinity where that is allowed. An absent key leaves *out as it is. */
static int read_depth(const json_t *object, const json_source *from, const char *key, bool infinite_allowed,
                      double *out) {
  const json_t *value = json_object_get(object, key);
  if (!value)
    return 0;
  if (infinite_allowed && json_is_null(value))
    *out = INFINITY;
  else if (json_is_number(value))
    *out = json_number_value(value);
  else
    return json_source_fail(from, key, "must be a number");
  return 0;
}

int camera_from_object(camera *out, const json_t *object, const json_source *from) {
  double view[16], projection[16];
  if (!json_is_object(object))
    return json_source_fail(from, NULL, "is not a camera");
  int code = read_doubles(object, from, "view", view, 16);
  if (code == 0)
    code = read_doubles(object, from, "projection", projection, 16);
  if (code)
    return code;
  const json_t *told = json_object_get(object, "reversed");
  if (told && !json_is_boolean(told))
    return json_source_fail(from, "reversed", "must be true or false");
  const bool reversed = json_boolean_value(told);
  const char *problem = camera_from_matrices(out, view, projection, told ? &reversed : NULL);
  if (problem && !told) /* a matrix that leaves it open is taken as one whose depth grows with the distance */
    problem = camera_from_matrices(out, view, projection, &reversed);
  if (problem)
    return json_source_fail(from, NULL, problem);
  /* the file's own numbers, rather than what is left of them in the projection */
  if (json_object_get(object, "position"))
    code = read_doubles(object, from, "position", out->position, 3);
  if (code == 0)
    code = read_depth(object, from, "near", false, &out->near_depth);
  if (code == 0)
    code = read_depth(object, from, "far", true, &out->far_depth);
  if (code == 0 && !(out->far_depth > out->near_depth))
    code = json_source_fail(from, "far", "must be beyond 'near'");
  return code;
}

static int read_size(const json_t *root, const json_source *from, const char *key, uint32_t *out) {
  const json_t *value = json_object_get(root, key);
  if (!value)
    return 0;
  if (!json_is_integer(value) || json_integer_value(value) < 1 || json_integer_value(value) > 16384)
    return json_source_fail(from, key, "must be 1 to 16384");
  *out = (uint32_t)json_integer_value(value);
  return 0;
}

int light_from_object(scene_light *out, const json_t *object, const json_source *from) {
  if (!json_is_object(object))
    return json_source_fail(from, NULL, "is not a light");
  *out = (scene_light){0};
  const int code = read_doubles(object, from, "direction", out->direction, 3);
  if (code)
    return code;
  if (vec_length(out->direction) == 0.0)
    return json_source_fail(from, "direction", "must not be zero");
  const json_t *disc = json_object_get(object, "disc_deg");
  out->disc_deg = json_number_value(disc);
  if (disc && (!json_is_number(disc) || out->disc_deg < 0.0 || out->disc_deg >= 180.0))
    return json_source_fail(from, "disc_deg", "must be 0 to 180 degrees");
  return 0;
}

int camera_from_json(camera *out, uint32_t *width, uint32_t *height, const char *path) {
  json_t *root = json_file_load("--camera", path);
  if (!root)
    return HOST_BAD_INPUT;
  const json_source from = {.name = "--camera"};
  const json_t *inner = json_object_get(root, "camera");
  int code = camera_from_object(out, inner ? inner : root, &from);
  if (code == 0 && inner)
    code = read_size(root, &from, "width", width);
  if (code == 0 && inner)
    code = read_size(root, &from, "height", height);
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

json_t *light_to_json(const scene_light *light) {
  json_t *object = json_object();
  json_object_set_new(object, "direction", json_from_doubles(light->direction, 3));
  json_object_set_new(object, "disc_deg", json_real(light->disc_deg));
  return object;
}
