/* scene/camera_json.h: cameras and lights in JSON, as frame.json has them. */
#ifndef HOST_CAMERA_JSON_H
#define HOST_CAMERA_JSON_H

#include "base/json_source.h"
#include "scene/scene.h"
#include <jansson.h>
#include <stdint.h>

/*
 * Reads a `camera` object, or a whole frame.json, which gives width and height, too. The matrices are taken as they
 * are. 0, or HOST_BAD_INPUT after a message that names the key.
 */
int camera_from_json(camera *out, uint32_t *width, uint32_t *height, const char *path);

/* Reads an object as frame.json's `camera`. 0, or HOST_BAD_INPUT after a message that names the key. */
int camera_from_object(camera *out, const json_t *object, const json_source *from);
/* Reads an object as frame.json's `light`. 0, or HOST_BAD_INPUT after a message that names the key. */
int light_from_object(scene_light *out, const json_t *object, const json_source *from);

/* A new `camera` object. */
json_t *camera_to_json(const camera *from);
/* A new `light` object. */
json_t *light_to_json(const scene_light *light);

/* A new array of reals. */
json_t *json_from_doubles(const double *values, size_t count);

#endif
