// csm_sample.glsl: visibility of the light at a point, from the cascades' maps, for an engine's GLSL (4.50). Any stage.
//
//   layout(binding = 0) uniform shadows { vec4 csm_c[CSM_C_COUNT]; };  // csm_binding.constants; std140
//   layout(binding = 1) uniform sampler2DArrayShadow csm_maps;         // the maps with the sampler
//   #include "csm_sample.glsl"
//   ... csm_visibility(position - origin, normal, view_depth)
//
// csm_constants.h, which this includes, may be included before them. Names are the includer's choice; define, before:
//   CSM_CONSTANTS    what is indexed for a vec4 of the block (csm_c)
//   CSM_MAPS         the maps (csm_maps)
//   CSM_SAMPLER      a samplerShadow, where CSM_MAPS is a texture2DArray without one
//   CSM_DEPTHS       a sampler2DArray of the same maps, point and clamped: faster, and needed for filter linear_depth,
//                    which through comparisons alone gives the bilinear comparison
//   CSM_COMPARE(uv, layer, reference)   a bilinear comparison of the includer's own, to read through instead
//   CSM_TEXEL_LIT(texel, layer, reference)   the comparison with one texel, by its index: 1 or 0, likewise
//   CSM_FILTER       0 to 9, as CSM_FILTER_* of csm.h: fixes the filter; if not defined, it is as configured
//   CSM_BIAS_MODE    0 (slope) or 1 (receiver plane): fixes the bias, likewise
//   CSM_EARLY_OUT    0: large boxes never look at corners and middle first; if not defined, it is as configured
#ifndef CSM_SAMPLE_GLSL
#define CSM_SAMPLE_GLSL

#include "csm_constants.h"
#include "csm_enums.h"

#ifndef CSM_CONSTANTS
#define CSM_CONSTANTS csm_c
#endif
#ifndef CSM_CONSTANT
#define CSM_CONSTANT(i) CSM_CONSTANTS[i]
#endif
#ifndef CSM_MAPS
#define CSM_MAPS csm_maps
#endif
#ifdef CSM_SAMPLER
#define CSM_SHADOWS sampler2DArrayShadow(CSM_MAPS, CSM_SAMPLER)
#else
#define CSM_SHADOWS CSM_MAPS
#endif
#if !defined(CSM_COMPARE) && !defined(CSM_TEXEL_LIT)
#define CSM_CENTRE(texel) (((texel) + 1.0) * CSM_CONSTANT(CSM_C_PARAMS).zw)
#ifdef CSM_DEPTHS
#define CSM_DEPTHS_4(texel, layer) textureGather(CSM_DEPTHS, vec3(CSM_CENTRE(texel), layer)).wzxy
#else
#define CSM_GATHER_LIT(texel, layer, reference)                                                                        \
    textureGather(CSM_SHADOWS, vec3(CSM_CENTRE(texel), layer), reference).wzxy
#endif
#endif
// Core GLSL has no textureLod of an array with comparison; without gradients this is level 0, in branches too.
#ifndef CSM_COMPARE
#define CSM_COMPARE(uv, layer, reference) textureGrad(CSM_SHADOWS, vec4(uv, layer, reference), vec2(0.0), vec2(0.0))
#endif
// At a texel's centre the bilinear comparison is that texel's own; GLSL cannot fetch from a sampler that compares.
#ifndef CSM_TEXEL_LIT
#define CSM_TEXEL_LIT(texel, layer, reference)                                                                         \
    CSM_COMPARE((texel + 0.5) * CSM_CONSTANT(CSM_C_PARAMS).zw, layer, reference)
#endif
#define csm_float2 vec2
#define csm_float3 vec3
#define csm_float4 vec4
#define csm_mad fma
#define CSM_UNROLL
#define CSM_LOOP
#define CSM_STATIC const

#include "csm_sample.inc"

#endif
