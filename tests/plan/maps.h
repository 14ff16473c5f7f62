/* maps.h: maps of planes, for sampling what was planned as shaders do. */
#ifndef TEST_PLAN_MAPS_H
#define TEST_PLAN_MAPS_H

#include "support.h"

#include "csm_constants.h"
#include "sampler.h"

enum { maps_side = 128 };

typedef struct test_maps {
  csm_config config;
  plan_frame frame;
  csm_constants constants;
  float depths[CSM_MAX_CASCADES][maps_side][maps_side];
} test_maps;

/* Plans with maps_side texels a side, from plain_camera, whose place is the world's origin; all maps are empty. */
void maps_make(test_maps *maps, const csm_config *config, const double light[3]);
/* Draws the plane through a point into every map, moved towards the light by so many metres. */
void maps_draw_plane(test_maps *maps, const double normal[3], const double point[3], double nearer);
/* Binds them for sampler_*. */
void maps_bind(const test_maps *maps);
float maps_visibility(const double position[3], const double normal[3]);

#endif
