// csm_sample.hlsl: visibility of the light at a point, from the cascades' maps, for an engine's HLSL. Any stage.
//
//   cbuffer shadows : register(b0) { float4 csm_c[CSM_C_COUNT]; };   // csm_binding.constants, the block of csm_constants.h
//   Texture2DArray<float> csm_maps : register(t0);                   // the maps
//   SamplerComparisonState csm_compare : register(s0);               // linear, clamped, less or equal
//   #include "csm_sample.hlsl"
//   ... csm_visibility(position - origin, normal, view_depth)
//
// csm_constants.h, which this includes, may be included before them. Names are the includer's choice; define, before:
//   CSM_CONSTANTS    what is indexed for a float4 of the block (csm_c)
//   CSM_MAPS         the maps (csm_maps)
//   CSM_SAMPLER      the sampler (csm_compare)
//   CSM_COMPARE(uv, layer, reference)   the bilinear comparison, instead of the two before
//   CSM_TEXEL_LIT(texel, layer, reference)   the comparison with one texel, by its index: 1 or 0
//   CSM_FILTER_TAPS  1 (2x2 texels) or 3 (3x3 of such): fixes the filter; if not defined, it is as configured
//   CSM_BIAS_MODE    0 (slope) or 1 (receiver plane): fixes the bias, likewise
#ifndef CSM_SAMPLE_HLSL
#define CSM_SAMPLE_HLSL

#include "csm_constants.h"

#ifndef CSM_CONSTANTS
#define CSM_CONSTANTS csm_c
#endif
#ifndef CSM_MAPS
#define CSM_MAPS csm_maps
#endif
#ifndef CSM_SAMPLER
#define CSM_SAMPLER csm_compare
#endif
// Who compares in a way of their own has maps of their own: at a texel's centre that comparison is the texel's.
#if defined(CSM_COMPARE) && !defined(CSM_TEXEL_LIT)
#define CSM_TEXEL_LIT(texel, layer, reference)                                                                         \
    CSM_COMPARE((texel + 0.5) * CSM_CONSTANTS[CSM_C_PARAMS].z, layer, reference)
#endif
#ifndef CSM_COMPARE
#define CSM_COMPARE(uv, layer, reference) CSM_MAPS.SampleCmpLevelZero(CSM_SAMPLER, float3(uv, layer), reference)
#endif
#ifndef CSM_TEXEL_LIT
#define CSM_TEXEL_LIT(texel, layer, reference) float(reference <= CSM_MAPS.Load(int4(int2(texel), int(layer), 0)))
#endif
#define csm_float2 float2
#define csm_float3 float3
#define csm_float4 float4
#define csm_mad mad
#define CSM_UNROLL [unroll]

#include "csm_sample.inc"

#endif
