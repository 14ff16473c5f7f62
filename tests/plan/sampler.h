/*
 * sampler.h: shaders/include/csm_sample.inc, the arithmetic of all shaders, run on the CPU. Its numbers are floats, as
 * a GPU's are.
 */
#ifndef TEST_PLAN_SAMPLER_H
#define TEST_PLAN_SAMPLER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What it samples: the block of csm_constants.h, and depths of layers of width times height texels. Both are kept. */
void sampler_bind(const float *constants, const float *depths, uint32_t width, uint32_t height, uint32_t layers);
/* Whether anything outside of the depths was read since the last bind. */
int sampler_read_outside(void);

int sampler_select(float view_depth);
int sampler_cascade(const float position[3], const float normal[3], float view_depth);
float sampler_bias(int cascade, const float normal[3]);
void sampler_plane(float out[2], int cascade, const float normal[3]);
float sampler_blend(int cascade, const float position[3], const float normal[3], float view_depth);
float sampler_visibility(const float position[3], const float normal[3], float view_depth);
float sampler_visibility_point(const float position[3], float view_depth);
/* The configured filter at a place of cascade 0's map, in texels from the centre of the first. */
float sampler_filter(float x, float y, float depth);

/* Moments: four floats a texel, of levels from the largest on, each with all its layers. They are kept. */
void sampler_bind_moments(const float *texels, uint32_t side, uint32_t layers, uint32_t levels);
/* Whether any beyond the border would have counted since. */
int sampler_moments_read_outside(void);
/* What a texel of this depth holds, as the bound constants have it. */
void sampler_moments_of(float out[4], float depth, float slice);
/* What a filter is told of a place in cascade 0's map; csm_spot says what each is. */
typedef struct sampler_spot {
  float place[2], depth, across[2], down[2], slope, texel, metre, room;
} sampler_spot;
float sampler_filter_spot(const sampler_spot *at);
/* A step in light space, in the texels of a cascade's map. */
void sampler_in_texels(float out[2], int cascade, const float step[3]);
float sampler_less_bleeding(float lit);
void sampler_poisson(float out[16][2]);

#ifdef __cplusplus
}
#endif
#endif
