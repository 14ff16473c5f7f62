// csm_sample.hlsl: visibility of the light at a point, from the cascades' maps.
//
// The including file declares, at registers of its choice:
//   cbuffer with        float4 csm_c[CSM_C_COUNT];           the block of csm_constants.h
//   Texture2DArray<float>      csm_maps;                     the maps
//   SamplerComparisonState     csm_compare;                  linear, clamped, less or equal
// and may define CSM_FILTER_TAPS, the filter's taps a side: 1 (hardware 2x2) or 3 (hardware 3x3, the default).
//
// All arithmetic that a result depends on is a mad chain with the constant innermost: compilers that differ in how they
// contract other forms keep this one, so that every backend gives the same bits.
#ifndef CSM_SAMPLE_HLSL
#define CSM_SAMPLE_HLSL

#include "include/csm_constants.h"

#ifndef CSM_FILTER_TAPS
#define CSM_FILTER_TAPS 3
#endif

float csm_row(float4 row, float3 p)
{
    return mad(p.x, row.x, mad(p.y, row.y, mad(p.z, row.z, row.w)));
}

float csm_dot(float3 a, float3 b)
{
    return mad(a.x, b.x, mad(a.y, b.y, a.z * b.z));
}

// View depth of a position relative to the constants' origin.
float csm_view_depth(float3 position)
{
    return csm_row(csm_c[CSM_C_DEPTH], position);
}

// The cascade whose interval holds a view depth; the cascade count beyond the last one.
uint csm_select(float view_depth)
{
    float4 near = csm_c[CSM_C_SPLITS];
    float4 far = csm_c[CSM_C_SPLITS + 1];
    uint passed = (view_depth > near.x) + (view_depth > near.y) + (view_depth > near.z) + (view_depth > near.w) +
                  (view_depth > far.x) + (view_depth > far.y) + (view_depth > far.z) + (view_depth > far.w);
    return view_depth > csm_c[CSM_C_PARAMS].w ? (uint)csm_c[CSM_C_PARAMS].x : passed;
}

// Depth bias towards the light, in metres. On the receiver's plane the depth changes by |slope right| + |slope up| for
// each texel of reach, so that this much, and no more, keeps every tap of the filter off a plane.
float csm_bias(float4 texel, float3 normal)
{
    float along = max(abs(csm_dot(normal, csm_c[CSM_C_BASIS + 2].xyz)), 1e-4);
    float across = abs(csm_dot(normal, csm_c[CSM_C_BASIS].xyz)) + abs(csm_dot(normal, csm_c[CSM_C_BASIS + 1].xyz));
    float slope = min(across / along, csm_c[CSM_C_BIAS].z);
    return mad(slope * csm_c[CSM_C_BIAS].y, texel.z, csm_c[CSM_C_BIAS].x * texel.x);
}

float csm_filter(float2 uv, float layer, float reference)
{
#if CSM_FILTER_TAPS == 1
    return csm_maps.SampleCmpLevelZero(csm_compare, float3(uv, layer), reference);
#else
    float lit = 0.0;
    float texel = csm_c[CSM_C_PARAMS].z;
    [unroll] for (int y = -(CSM_FILTER_TAPS / 2); y <= CSM_FILTER_TAPS / 2; ++y)
    {
        [unroll] for (int x = -(CSM_FILTER_TAPS / 2); x <= CSM_FILTER_TAPS / 2; ++x)
        {
            float2 tap = float2(mad((float)x, texel, uv.x), mad((float)y, texel, uv.y));
            lit += csm_maps.SampleCmpLevelZero(csm_compare, float3(tap, layer), reference);
        }
    }
    return lit * (1.0 / (CSM_FILTER_TAPS * CSM_FILTER_TAPS));
#endif
}

// Visibility, 1 lit to 0 shadowed. position: world, relative to the constants' origin; normal: world, unit, on the
// viewer's side; view_depth: as csm_view_depth gives.
float csm_visibility(float3 position, float3 normal, float view_depth)
{
    uint cascade = csm_select(view_depth);
    if (cascade >= (uint)csm_c[CSM_C_PARAMS].x)
        return 1.0;
    float4 texel = csm_c[CSM_C_TEXELS + cascade];
    float4 row_u = csm_c[CSM_C_MATRICES + cascade * 3];
    float4 row_v = csm_c[CSM_C_MATRICES + cascade * 3 + 1];
    float4 row_depth = csm_c[CSM_C_MATRICES + cascade * 3 + 2];
    float offset = csm_c[CSM_C_BIAS].w * texel.x;
    float3 p = float3(mad(normal.x, offset, position.x), mad(normal.y, offset, position.y),
                      mad(normal.z, offset, position.z));
    float2 uv = float2(csm_row(row_u, p), csm_row(row_v, p));
    float depth = mad(-csm_bias(texel, normal), texel.y, csm_row(row_depth, p));
    if (any(uv < 0.0) || any(uv > 1.0))
        return 1.0;
    return csm_filter(uv, (float)cascade, clamp(depth, 0.0, 1.0));
}

#endif
