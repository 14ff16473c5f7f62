/* truth/sun_disc.h: directions to points on the sun's disc. */
#ifndef HOST_TRUTH_SUN_H
#define HOST_TRUTH_SUN_H

#include "scene/scene.h"

/* Several sets of directions, so that neighbouring pixels do not err alike. */
typedef struct truth_sun {
  uint32_t set_count, samples;
  double (*directions)[3]; /* set after set: unit, towards the sun */
} truth_sun;

/*
 * Spreads `samples` directions evenly over the disc's solid angle. The first 1, 2, 4, 8, ... of them are stratified,
 * too. A disc of 0 degrees makes one direction.
 */
void truth_sun_make(truth_sun *out, const scene_light *light, uint32_t samples);
void truth_sun_free(truth_sun *sun);
/* The set of a pixel. */
const double (*truth_sun_set(const truth_sun *sun, uint32_t pixel))[3];

#endif
