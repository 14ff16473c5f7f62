// The mask: visibility of every pixel of a camera's depth image. Where MASK_VIEW is defined, only what a view of it needs.
#include "csm_constants.h"

cbuffer cascades_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
};
cbuffer mask_block : register(b1)
{
    float4 mask_c[CSM_M_COUNT];
};
Texture2DArray<float> csm_maps : register(t0);
Texture2D<float> camera_depth : register(t1);
#ifdef MASK_NORMALS
Texture2D<float4> normals : register(t2);
#endif
SamplerState csm_point : register(s0);
#define CSM_POINT csm_point

#include "csm_sample.hlsl"

float load_depth(int2 pixel)
{
    int2 last = int2((int)mask_c[CSM_M_SIZE].x - 1, (int)mask_c[CSM_M_SIZE].y - 1);
    return camera_depth.Load(int3(clamp(pixel, int2(0, 0), last), 0));
}

float row_value(uint row, float2 ndc, float depth)
{
    float4 c = mask_c[CSM_M_INVERSE + row];
    return mad(ndc.x, c.x, mad(ndc.y, c.y, mad(depth, c.z, c.w)));
}

// World position of a pixel's centre, relative to the constants' origin.
float3 pixel_position(float2 pixel, float depth)
{
    float2 ndc = float2(mad(pixel.x + 0.5, mask_c[CSM_M_SIZE].z * 2.0, -1.0),
                        mad(pixel.y + 0.5, mask_c[CSM_M_SIZE].w * -2.0, 1.0));
    float w = row_value(3, ndc, depth);
    return float3(row_value(0, ndc, depth) / w, row_value(1, ndc, depth) / w, row_value(2, ndc, depth) / w);
}

bool inside(int2 pixel)
{
    return pixel.x >= 0 && pixel.y >= 0 && (float)pixel.x < mask_c[CSM_M_SIZE].x && (float)pixel.y < mask_c[CSM_M_SIZE].y;
}

// How far the depth at a pixel is from where the two pixels beside it say that it is. Depth in clip space is linear across
// a plane on screen, so this is 0 where the three lie on one plane. Pixels beyond the border say nothing.
float bend(int2 pixel, int2 axis, float beside, float depth)
{
    float error = abs(mad(2.0, beside, -load_depth(pixel + axis + axis)) - depth);
    return inside(pixel + axis + axis) ? error : inside(pixel + axis) ? 1e20 : 1e30;
}

// How the position changes across one pixel along an axis, taken on the side that goes on straight.
float3 tangent(int2 pixel, int2 axis, float3 position, float depth)
{
    float before = load_depth(pixel - axis);
    float after = load_depth(pixel + axis);
    bool back = bend(pixel, -axis, before, depth) < bend(pixel, axis, after, depth);
    // One of the two sides is all that is worked out
    float3 beside = pixel_position(float2(back ? pixel - axis : pixel + axis), back ? before : after);
    return back ? position - beside : beside - position;
}

// A unit vector; towards the light where there is no direction.
float3 unit(float3 v)
{
    float square = csm_dot(v, v);
    return square > 0.0 ? v * rsqrt(square) : -csm_c[CSM_C_BASIS + 2].xyz;
}

float3 unit_cross(float3 a, float3 b)
{
    return unit(float3(mad(a.y, b.z, -(a.z * b.y)), mad(a.z, b.x, -(a.x * b.z)), mad(a.x, b.y, -(a.y * b.x))));
}

#ifndef MASK_VIEW
#ifdef MASK_NORMALS
float3 surface_normal(int2 pixel, float3 position, float depth)
{
    float3 n = normals.Load(int3(pixel, 0)).xyz;
    float2 decode = mask_c[CSM_M_CLEAR].zw;
    return unit(float3(mad(n.x, decode.x, decode.y), mad(n.y, decode.x, decode.y), mad(n.z, decode.x, decode.y)));
}
#else
float3 surface_normal(int2 pixel, float3 position, float depth)
{
    float3 right = tangent(pixel, int2(1, 0), position, depth);
    float3 down = tangent(pixel, int2(0, 1), position, depth);
    return unit_cross(down, right) * mask_c[CSM_M_CLEAR].y;
}
#endif

float main(float4 screen : SV_Position) : SV_Target
{
    int2 pixel = int2(screen.xy);
    float depth = load_depth(pixel);
    if (depth == mask_c[CSM_M_CLEAR].x)
        return 1.0;
    float3 position = pixel_position(float2(pixel), depth);
    float3 normal = surface_normal(pixel, position, depth);
    return csm_visibility(position, normal, csm_view_depth(position));
}
#endif
