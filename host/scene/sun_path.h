/* scene/sun_path.h: a light's way through a day and a night. */
#ifndef HOST_SUN_PATH_H
#define HOST_SUN_PATH_H

#include "scene/scene.h"

/* Whether --light-path's text is such a path ("day:48") and not a file. */
bool sun_path_is(const char *text);

/*
 * COUNT lights evenly over 24 hours, from midnight on: the sun of an equinox at 45 degrees of latitude. It rises in +x,
 * stands in -z at noon, and goes on below the horizon; y is up. Each has `disc_deg`. The caller frees *lights. 0, or
 * HOST_BAD_INPUT after a message.
 */
int sun_path_load(scene_light **lights, uint32_t *count, const char *text, double disc_deg);

#endif
