// csm_sample.hlsl: visibility of the light at a point, from the cascades' maps, for an engine's HLSL. Any stage.
//
//   cbuffer shadows : register(b0) { float4 csm_c[CSM_C_COUNT]; };   // csm_binding.constants, the block of csm_constants.h
//   Texture2DArray<float> csm_maps : register(t0);                   // the maps
//   #include "csm_sample.hlsl"
//   ... csm_visibility(position - origin, normal, view_depth)
//
// csm_constants.h, which this includes, may be included before them. Names are the includer's choice; define, before:
//   CSM_CONSTANTS    what is indexed for a float4 of the block (csm_c)
//   CSM_MAPS         the maps (csm_maps)
//   CSM_POINT        a sampler, point and clamped: four texels are gathered at once then, which is faster
//   CSM_COMPARE(uv, layer, reference)   a bilinear comparison of the includer's own, to read through instead
//   CSM_TEXEL_LIT(texel, layer, reference)   the comparison with one texel, by its index: 1 or 0, likewise
//   CSM_FILTER       0 to 9, as CSM_FILTER_* of csm.h: fixes the filter; if not defined, it is as configured
//   CSM_BIAS_MODE    0 (slope) or 1 (receiver plane): fixes the bias, likewise
//   CSM_EARLY_OUT    0: large boxes never look at corners and middle first; if not defined, it is as configured
// Filter linear_depth reads depths: through comparisons alone it gives the bilinear comparison.
#ifndef CSM_SAMPLE_HLSL
#define CSM_SAMPLE_HLSL

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
// Who compares in a way of their own has maps of their own: at a texel's centre that comparison is the texel's.
#if defined(CSM_COMPARE) && !defined(CSM_TEXEL_LIT)
#define CSM_TEXEL_LIT(texel, layer, reference)                                                                         \
    CSM_COMPARE((texel + 0.5) * CSM_CONSTANT(CSM_C_PARAMS).zw, layer, reference)
#endif
#ifndef CSM_TEXEL_LIT
#define CSM_DEPTH(texel, layer) CSM_MAPS.Load(int4(int2(texel), int(layer), 0))
#define CSM_TEXEL_LIT(texel, layer, reference) float((reference) * CSM_SIDE <= CSM_DEPTH(texel, layer) * CSM_SIDE)
#ifdef CSM_POINT
#define CSM_DEPTHS_4(texel, layer) CSM_MAPS.Gather(CSM_POINT, float3((texel + 1.0) * CSM_CONSTANT(CSM_C_PARAMS).zw, layer)).wzxy
#else
#define CSM_DEPTHS_4(texel, layer)                                                                                     \
    float4(CSM_DEPTH(texel, layer), CSM_DEPTH((texel + float2(1.0, 0.0)), layer),                                      \
           CSM_DEPTH((texel + float2(0.0, 1.0)), layer), CSM_DEPTH((texel + 1.0), layer))
#endif
#endif
#define csm_float2 float2
#define csm_float3 float3
#define csm_float4 float4
#define csm_mad mad
#define CSM_UNROLL [unroll]
#define CSM_LOOP [loop]
#define CSM_STATIC static const

#include "csm_sample.inc"

#endif
