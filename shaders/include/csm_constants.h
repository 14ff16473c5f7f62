/*
 * csm_constants.h: the constants that shaders sample the cascades with, laid out once for C, HLSL and GLSL. All are
 * float4, so that every compiler agrees on the offsets. Positions are world positions relative to csm_binding.origin.
 *
 * There are two blocks. The first says where the maps lie, and never changes. The second holds the settings of the
 * technique that reads them. Both may be bound as one array of CSM_C_COUNT float4: the second begins at CSM_S_BEGIN.
 */
#ifndef CSM_CONSTANTS_H
#define CSM_CONSTANTS_H

#define CSM_CONSTANTS_CASCADES 8

/*
 * The cascades. Light space has three axes: right, up, and along the light's way. A map's own space is clip space:
 * right and up from -1 to 1 over the map, and depth from 0 to 1. A cascade takes light space there by a scale and an
 * offset.
 */
#define CSM_C_PARAMS 0   /* cascade count, view depth where shadows end, 1 / width and 1 / height of the maps' image */
#define CSM_C_DEPTH 1    /* view depth of a relative position p: dot(p, xyz) + w */
#define CSM_C_BASIS 2    /* three: unit vectors right, up and along the light */
#define CSM_C_SPLITS 5   /* two: where cascades 0..3 and 4..7 end, as view depth; unused ones repeat the last */
#define CSM_C_SCALES 7   /* eight: scale of right, up and depth; texels to the right by which this frame's map is jittered */
#define CSM_C_OFFSETS 15 /* eight: offset of right, up and depth; texels up by which it is jittered */
/* Eight: larger texel side in metres, depth per metre, share of the map that samples may lie in, texel area in m2 */
#define CSM_C_TEXELS 23
#define CSM_C_RECTS 31 /* eight: the map's first texel (x, y), its side in texels, its layer */
#define CSM_C_GRID 39  /* two, a float for each cascade: x + 4096 y, the world's place of the map's lower left texel */
#define CSM_C_CASCADES_COUNT 41

/* The settings. Enumerations are those of csm_config; csm_enums.h has their names. */
#define CSM_S_BEGIN 48
#define CSM_S_BIAS 48    /* constant in texels, slope in texels, slope max, normal offset in texels */
#define CSM_S_UNITS 49   /* constant in depth, constant in metres, slope in depth, limit in depth */
#define CSM_S_MODES 50   /* selection, out of range, blending, normal offset mode */
#define CSM_S_BAND 51    /* blending: share; fading: where it begins, 1 / its length; where the first cascade begins */
#define CSM_S_KERNEL 52  /* filter, its taps or points, radius in texels, 1 / sum of the weights */
#define CSM_S_OPTIONS 53 /* bias mode, early out, 1 or -1 if maps are reversed, an empty map's depth times that */
#define CSM_S_WEIGHTS 54 /* four: weights of taps along an axis, from the middle outwards */
/* Slope max of a receiver's own surface, the filter's reach in texels, least share that says it; what a variance may be off */
#define CSM_S_OWN 58
/* Exponent (msm4: 1 if moments are packed), negative exponent, moment bias, layers of depth */
#define CSM_S_MOMENTS 59
/* Least variance of z (-1 to 1) by range and format; deviation in m, in texels of slope; 1 / the image's side in map's texels */
#define CSM_S_VARIANCE 60
#define CSM_S_BLEEDING 61 /* reduction, 1 / (1 - reduction), power, curve */
/* Highest level; variance of where the blur's texels lie, in map's texels; most samples; texels of moments for one of the map */
#define CSM_S_LEVELS 62
#define CSM_S_SOFT 63      /* tangent of half the light's diameter, search taps, taps, most texels around */
/* Penumbra, light's size as a share of a map, least texels around; where frames are mixed, 1 + the pattern's phase, or 3 + it
   of jittered maps, else 0 */
#define CSM_S_SOFT_MORE 64
/* Rays. Where the constants' origin lies in the world: as floats, and what these leave of it. */
#define CSM_R_BEGIN 65
#define CSM_R_HIGH 65   /* x, y, z; rays to the light's disc */
#define CSM_R_LOW 66    /* x, y, z; first row of the instances' records, in 1024 rows */
#define CSM_R_SCALE 67  /* of a position to the grid of the instances' tree; how many nodes it has */
#define CSM_R_OFFSET 68 /* of it; a share of the view depth: what lies no farther than that from a triangle's plane is on it */
/* Squares of the cosines to the light to which a ray decides: where a pixel's plane is unsure, and wherever it is known; 1: maps
   hold what a draw callback drew, of which rays know nothing */
#define CSM_R_UNSURE 69
#define CSM_C_COUNT 70

/*
 * The mask pass's own block. A pixel's place is (x, y, depth, 1): x and y in pixels, the depth as in the camera's depth
 * buffer.
 */
#define CSM_M_LIGHT 0 /* four rows: a pixel's place to light space (right, up, along) times w, and w */
/* Three rows: a plane on screen (depth's change to the right and downwards, -1, depth at pixel 0, 0) to its normal in
   light space, on the viewer's side */
#define CSM_M_PLANES 4
#define CSM_M_NORMALS 7 /* three rows: a texel of the engine's normals (x, y, z, 1) to light space */
#define CSM_M_SIZE 10   /* width, height, 1 / width, 1 / height */
/* Depth of a pixel without a surface; CSM_SHOW_*; how much what normals come from may be off: a share of itself, and more */
#define CSM_M_CLEAR 11
#define CSM_M_DEPTH 12  /* view depth of a point of light space: dot(p, xyz) + w */
#define CSM_M_BIAS 13   /* CSM_S_BIAS' constant, slope and slope max, and CSM_S_UNITS' constant, as this picture needs them */
#define CSM_M_DEPTH_OFF 14 /* how much the camera's depth may be off: a share of itself, and more */
#define CSM_M_COUNT 15

/* What C and C++ see: the same blocks as structs, for an engine's own buffers and debugging. */
#if defined(__cplusplus) || defined(__STDC_VERSION__)
#include <stddef.h>

typedef struct csm_cascades_block {
  float params[4];
  float depth[4];
  float basis[3][4];
  float splits[CSM_CONSTANTS_CASCADES];
  float scales[CSM_CONSTANTS_CASCADES][4];
  float offsets[CSM_CONSTANTS_CASCADES][4];
  float texels[CSM_CONSTANTS_CASCADES][4];
  float rects[CSM_CONSTANTS_CASCADES][4];
  float grid[CSM_CONSTANTS_CASCADES];
} csm_cascades_block;

typedef struct csm_settings_block {
  float bias[4];
  float units[4];
  float modes[4];
  float band[4];
  float kernel[4];
  float options[4];
  float weights[16];
  float own[4];
  float moments[4];
  float variance[4];
  float bleeding[4];
  float levels[4];
  float soft[4];
  float soft_more[4];
} csm_settings_block;

typedef struct csm_rays_block {
  float high[4];
  float low[4];
  float scale[4];
  float offset[4];
  float unsure[4];
} csm_rays_block;

/* All, one after the other. */
typedef struct csm_constants {
  csm_cascades_block cascades;
  float unused[CSM_S_BEGIN - CSM_C_CASCADES_COUNT][4];
  csm_settings_block settings;
  csm_rays_block rays;
} csm_constants;

#ifdef __cplusplus
#define CSM_CONSTANTS_ASSERT(condition) static_assert(condition, #condition)
#else
#define CSM_CONSTANTS_ASSERT(condition) _Static_assert(condition, #condition)
#endif
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, params) == CSM_C_PARAMS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, depth) == CSM_C_DEPTH * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, basis) == CSM_C_BASIS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, splits) == CSM_C_SPLITS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, scales) == CSM_C_SCALES * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, offsets) == CSM_C_OFFSETS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, texels) == CSM_C_TEXELS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, rects) == CSM_C_RECTS * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_cascades_block, grid) == CSM_C_GRID * 16);
CSM_CONSTANTS_ASSERT(sizeof(csm_cascades_block) == CSM_C_CASCADES_COUNT * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, bias) == (CSM_S_BIAS - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, units) == (CSM_S_UNITS - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, modes) == (CSM_S_MODES - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, band) == (CSM_S_BAND - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, kernel) == (CSM_S_KERNEL - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, options) == (CSM_S_OPTIONS - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, weights) == (CSM_S_WEIGHTS - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, own) == (CSM_S_OWN - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, moments) == (CSM_S_MOMENTS - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, variance) == (CSM_S_VARIANCE - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, bleeding) == (CSM_S_BLEEDING - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, levels) == (CSM_S_LEVELS - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, soft) == (CSM_S_SOFT - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_settings_block, soft_more) == (CSM_S_SOFT_MORE - CSM_S_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_rays_block, high) == (CSM_R_HIGH - CSM_R_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_rays_block, low) == (CSM_R_LOW - CSM_R_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_rays_block, scale) == (CSM_R_SCALE - CSM_R_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_rays_block, offset) == (CSM_R_OFFSET - CSM_R_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_rays_block, unsure) == (CSM_R_UNSURE - CSM_R_BEGIN) * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, settings) == CSM_S_BEGIN * 16);
CSM_CONSTANTS_ASSERT(offsetof(csm_constants, rays) == CSM_R_BEGIN * 16);
CSM_CONSTANTS_ASSERT(sizeof(csm_constants) == CSM_C_COUNT * 16);
#undef CSM_CONSTANTS_ASSERT
#endif

#endif
