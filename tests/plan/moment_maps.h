/* moment_maps.h: images of moments, made and rounded as a GPU makes and rounds them, for csm_sample.inc to read. */
#ifndef TEST_PLAN_MOMENT_MAPS_H
#define TEST_PLAN_MOMENT_MAPS_H

#include "support.h"

#include "csm_constants.h"
#include "sampler.h"

enum { moment_side = 64, moment_floats = 4 * moment_side * moment_side * 4 * 2 };

typedef struct moment_map {
  csm_config config;
  csm_constants constants;
  uint32_t levels;
  bool nearest;                /* whether float16 is stored as the nearest, and not rounded towards zero */
  float texels[moment_floats]; /* as sampler_bind_moments takes them */
} moment_map;

/* Every moment filter in both formats, with and without what is read of more than one texel; and layers. */
typedef struct moment_case {
  uint32_t filter, format, blur_texels, levels, layers;
} moment_case;

enum { moment_case_count = 25 };
const moment_case *moment_case_at(int index);
const char *moment_case_name(const moment_case *c);

/* One cascade of moment_side texels and no bias but what the plan gives a format by itself; no reduction of bleeding. */
csm_config moment_config(const moment_case *c);
/* Plans, and leaves the moments to be filled. */
void moment_map_plan(moment_map *map, const csm_config *config);
/* Depths of moment_side x moment_side texels, 0 at the light's side, to moments, blurred and brought down; and binds them. */
void moment_map_make(moment_map *map, const float *depths);
/* All depths are this one. */
void moment_map_flat(moment_map *map, float depth);
/* All texels hold `share` of the moments of a depth and the rest of another's. */
void moment_map_mix(moment_map *map, float nearer, float farther, double share);
/* Visibility in the middle of the map, of a receiver that faces the light, with the bias that the format has. */
float moment_map_visibility(const moment_map *map, double depth);

/* The nearest number that a format holds; infinite beyond it. */
float moment_rounded(uint32_t format, float v);

#endif
