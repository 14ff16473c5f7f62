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
void sampler_poisson(float out[16][2]);

#ifdef __cplusplus
}
#endif
#endif
