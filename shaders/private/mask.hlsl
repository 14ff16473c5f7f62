// What the mask's pixel shaders share: a pixel's place in light space, and how its surface lies there.
#if MASK_GENERAL == 0
#define CSM_MAPS_ALIKE 1
#endif
#if MASK_GENERAL == 2
#define CSM_MAPS_ALIKE 2
#endif
#if MASK_GENERAL == 0 || MASK_GENERAL == 2
#define CSM_CASCADES 4
#define CSM_MAPS_REVERSED 0
#define CSM_SELECTION CSM_SELECT_MAP
#define CSM_BLENDING CSM_BLEND_OFF
#define CSM_NORMAL_OFFSET_ON 0
#define CSM_BIAS_UNITS 0
#endif
#include "csm_constants.h"
#include "csm_enums.h"
#include "private/mask_inputs.hlsl"

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
#if (CSM_FILTER >= CSM_FILTER_VSM && CSM_FILTER <= CSM_FILTER_MSM4) || CSM_FILTER == CSM_FILTER_VSSM
#define MASK_MOMENTS 1
Texture2DArray<float4> csm_moments : register(t2);
SamplerState csm_linear : register(s2);
#endif
#if MASK_RANGES
#include "private/reach.hlsl"
#define CSM_REACH(spot, reach)                                                                                         \
    reach_of(float4(spot.depth, abs(spot.plane.x) + abs(spot.plane.y), spot.last, spot.soft), reach, spot.place,       \
             spot.rect.z, spot.cascade)
#endif
#if MASK_NORMALS && (MASK_MOMENTS || MASK_RANGES)
Texture2D<float4> normals : register(t3);
#elif MASK_NORMALS
Texture2D<float4> normals : register(t2);
#endif
SamplerState csm_point : register(s0);
SamplerState maps_point : register(s1); // repeats where maps do
#define CSM_POINT maps_point

// What every pixel needs comes with the inputs.
static mask_inputs inputs;
#define CSM_BIAS_ROW float4(inputs.scale_0.w, inputs.scale_1.w, inputs.scale_2.w, csm_c[CSM_S_BIAS].w)
#define CSM_BIAS_RANGE inputs.scale_3.w
#define CSM_END inputs.offset_3.w
#define CSM_SCALE_0 inputs.scale_0
#define CSM_SCALE_1 inputs.scale_1
#define CSM_SCALE_2 inputs.scale_2
#define CSM_SCALE_3 inputs.scale_3
#define CSM_OFFSET_0 inputs.offset_0
#define CSM_OFFSET_1 inputs.offset_1
#define CSM_OFFSET_2 inputs.offset_2
#define CSM_OFFSET_3 inputs.offset_3
#include "csm_sample.hlsl"

float light_row(float4 row, float2 place, float depth)
{
    return mad(place.x, row.x, mad(place.y, row.y, mad(depth, row.z, row.w)));
}

// A point of the screen in light space.
float3 light_position(float2 place, float depth)
{
    float scale = 1.0 / light_row(inputs.light_3, place, depth);
    return float3(light_row(inputs.light_0, place, depth) * scale, light_row(inputs.light_1, place, depth) * scale,
                  light_row(inputs.light_2, place, depth) * scale);
}

#if MASK_MOMENTS
float light_change(float4 row, float3 change)
{
    return mad(change.x, row.x, mad(change.y, row.y, change.z * row.z));
}

// How a point of the screen, which lies at `at` in light space, moves there right and up, by how its place and depth change.
float3 light_step(float2 place, float depth, float3 at, float3 change)
{
    float scale = 1.0 / light_row(inputs.light_3, place, depth);
    float nearer = light_change(inputs.light_3, change);
    return float3(mad(-at.x, nearer, light_change(inputs.light_0, change)) * scale,
                  mad(-at.y, nearer, light_change(inputs.light_1, change)) * scale, 0.0);
}
#endif

#include "private/depth_steps.hlsl"
// View depth of a point of light space.
float light_view_depth(float3 at)
{
    return csm_row(float4(inputs.offset_0.w, inputs.offset_1.w, inputs.offset_2.w, mask_c[CSM_M_DEPTH].w), at);
}

// A unit vector; towards the light where there is no direction.
float3 unit(float3 v)
{
    float square = csm_dot(v, v);
    return square > 0.0 ? v * rsqrt(square) : float3(0.0, 0.0, -1.0);
}

float normal_row(float4 row, float2 steps, float origin)
{
    return mad(steps.x, row.x, mad(steps.y, row.y, mad(origin, row.w, -row.z)));
}

// The normal of the plane on screen that has these steps, in light space.
float3 plane_normal(float2 place, float depth, float2 steps)
{
    float origin = mad(-steps.x, place.x, mad(-steps.y, place.y, depth));
    return float3(normal_row(inputs.normal_0, steps, origin), normal_row(inputs.normal_1, steps, origin),
                  normal_row(inputs.normal_2, steps, origin));
}
