/*
 * csm_constants.h: the constants that shaders sample the cascades with, laid out once for C, HLSL and GLSL. All are
 * float4, so that every compiler agrees on the offsets. Positions are world positions relative to csm_binding.origin.
 */
#ifndef CSM_CONSTANTS_H
#define CSM_CONSTANTS_H

#define CSM_CONSTANTS_CASCADES 8

/*
 * Index of each float4. Bias reach is how far from the sample the slope bias must hold, along one axis: to the filter's
 * farthest texel centre, or half a texel under a receiver plane.
 */
#define CSM_C_PARAMS 0    /* cascade count, texels a side, 1 / texels a side, view depth where shadows end */
#define CSM_C_DEPTH 1     /* view depth of a relative position p: dot(p, xyz) + w */
#define CSM_C_BASIS 2     /* three: unit vectors right, up and along the light (its direction of travel) */
#define CSM_C_FILTER 2    /* w alone: the filter's taps a side, 1 (2x2 texels) or 3 (3x3 of such) */
#define CSM_C_BIAS_MODE 3 /* w alone: 0 slope, 1 receiver plane */
#define CSM_C_BIAS 5      /* constant, slope, slope max, normal offset: as configured, in texels */
#define CSM_C_SPLITS 6    /* two: where cascades 0..3 and 4..7 end, as view depth; unused ones repeat the last */
#define CSM_C_TEXELS 8    /* eight: texel size in metres, depth per metre along the light, bias reach in metres */
#define CSM_C_MATRICES 16 /* eight times three rows: relative position to u, v, depth */
#define CSM_C_COUNT 40

/*
 * The mask pass's own block. Handedness is 1, or -1 where image right, image up and back to the viewer are a
 * left-handed basis of the world.
 */
#define CSM_M_INVERSE 0 /* four rows: clip (x, y, z, 1) to relative position times w */
#define CSM_M_SIZE 4    /* width, height, 1 / width, 1 / height */
#define CSM_M_CLEAR 5   /* depth of a pixel without a surface; handedness; scale and offset that decode normals */
#define CSM_M_COUNT 6

/* What C and C++ see: the same block as a struct, for an engine's own buffers and debugging. */
#if defined(__cplusplus) || defined(__STDC_VERSION__)
#include <stddef.h>

typedef struct csm_constants {
  float params[4];
  float depth[4];
  float basis[3][4];
  float bias[4];
  float splits[CSM_CONSTANTS_CASCADES];
  float texels[CSM_CONSTANTS_CASCADES][4];
  float matrices[CSM_CONSTANTS_CASCADES][3][4];
} csm_constants;

#ifdef __cplusplus
#define CSM_CONSTANTS_ASSERT(condition) static_assert(condition, #condition)
#else
#define CSM_CONSTANTS_ASSERT(condition) _Static_assert(condition, #condition)
#endif
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, params) == CSM_C_PARAMS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, depth) == CSM_C_DEPTH * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, basis) == CSM_C_BASIS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, basis[0][3]) == CSM_C_FILTER * 16 + 12);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, basis[1][3]) == CSM_C_BIAS_MODE * 16 + 12);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, bias) == CSM_C_BIAS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, splits) == CSM_C_SPLITS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, texels) == CSM_C_TEXELS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, matrices) == CSM_C_MATRICES * 16);
CSM_CONSTANTS_ASSERT(sizeof(csm_constants) == CSM_C_COUNT * 16);
#undef CSM_CONSTANTS_ASSERT
#endif

#endif
