/* camera_json.h: cameras in JSON, as frame.json has them. */
#ifndef HOST_CAMERA_JSON_H
#define HOST_CAMERA_JSON_H

#include "camera.h"
#include <jansson.h>
#include <stdint.h>

/*
 * Reads a `camera` object, or a whole frame.json, whose width and height are then given too (else they stay as they
 * are). The matrices are taken as they are. 0, or HOST_BAD_INPUT after a message that names the key.
 */
int camera_from_json(camera *out, uint32_t *width, uint32_t *height, const char *path);

/* A new `camera` object. */
json_t *camera_to_json(const camera *from);

/* A new array of reals. */
json_t *json_from_doubles(const double *values, size_t count);

#endif
