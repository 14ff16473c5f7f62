/*
 * csm_constants.h: the constants that shaders sample the cascades with, laid out once for C, HLSL and GLSL. All are
 * float4, so that every compiler agrees on the offsets. Positions are world positions relative to csm_binding.origin.
 */
#ifndef CSM_CONSTANTS_H
#define CSM_CONSTANTS_H

#define CSM_CONSTANTS_CASCADES 8

/*
 * Index of each float4. Bias reach is how far from the sample the slope bias must hold, along one axis: to the filter's
 * farthest texel centre, or half a texel under a receiver plane. Enumerations are those of csm_config.
 */
#define CSM_C_PARAMS 0    /* cascade count, texels a side, 1 / texels a side, view depth where shadows end */
#define CSM_C_DEPTH 1     /* view depth of a relative position p: dot(p, xyz) + w */
#define CSM_C_BASIS 2     /* three: unit vectors right, up and along the light (its direction of travel) */
#define CSM_C_FILTER 2    /* w alone: 3 where the filter is pcf_3x3, else 1 */
#define CSM_C_BIAS_MODE 3 /* w alone: 0 slope, 1 receiver plane */
#define CSM_C_BIAS 5      /* constant, slope, slope max, normal offset: as configured, in texels */
#define CSM_C_SPLITS 6    /* two: where cascades 0..3 and 4..7 end, as view depth; unused ones repeat the last */
#define CSM_C_TEXELS                                                                                                   \
  8 /* eight: larger texel side in metres, depth per metre along the light, bias reach in metres,                      \
       right side of a texel / up side */
#define CSM_C_MATRICES 16 /* eight times three rows: relative position to u, v, depth */
#define CSM_C_RECTS 40    /* eight: the map's first texel (x, y), its side in texels, its layer */
#define CSM_C_GRID 48   /* two, a float for each cascade: x + 4096 y, the world's place of the map's lower left texel */
#define CSM_C_MODES 50  /* selection, texels of a map's border that are the filter's alone, beyond, blending */
#define CSM_C_BAND 51   /* blending: share; fading: where it begins, 1 / its length; where the first cascade begins */
#define CSM_C_KERNEL 52 /* filter, its taps or points, radius in texels, 1 / sum of the weights */
#define CSM_C_UNITS 53  /* bias: constant in depth, constant in metres, slope in depth, limit in depth */
#define CSM_C_IMAGE 54  /* 1 / width and 1 / height of the maps' image; 1, or -1 if reversed; normal offset mode */
#define CSM_C_OPTIONS 55 /* early out; unused */
#define CSM_C_WEIGHTS 56 /* four: weights of taps along an axis, from the middle outwards */
#define CSM_C_COUNT 60

/*
 * The mask pass's own block. Handedness is 1, or -1 where image right, image up and back to the viewer are a
 * left-handed basis of the world.
 */
#define CSM_M_INVERSE 0 /* four rows: clip (x, y, z, 1) to relative position times w */
#define CSM_M_SIZE 4    /* width, height, 1 / width, 1 / height */
#define CSM_M_CLEAR 5   /* depth of a pixel without a surface; handedness; scale and offset that decode normals */
#define CSM_M_VIEW 6    /* mask_view alone: CSM_VIEW_* */
#define CSM_M_COUNT 7

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
  float rects[CSM_CONSTANTS_CASCADES][4];
  float grid[CSM_CONSTANTS_CASCADES];
  float modes[4];
  float band[4];
  float kernel[4];
  float units[4];
  float image[4];
  float options[4];
  float weights[16];
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
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, rects) == CSM_C_RECTS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, grid) == CSM_C_GRID * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, modes) == CSM_C_MODES * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, band) == CSM_C_BAND * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, kernel) == CSM_C_KERNEL * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, units) == CSM_C_UNITS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, image) == CSM_C_IMAGE * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, options) == CSM_C_OPTIONS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, weights) == CSM_C_WEIGHTS * 16);
CSM_CONSTANTS_ASSERT(sizeof(csm_constants) == CSM_C_COUNT * 16);
#undef CSM_CONSTANTS_ASSERT
#endif

#endif
