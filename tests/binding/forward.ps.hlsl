// An engine's forward shader in small: the light's visibility on a plane, whose point at each pixel the test says.
// FORWARD_WAY: 0 loads texels, 1 gathers them, 2 is fixed to a configuration, 3 has two lights, 4 asks for points; 5 to 7
// are fixed to filters vsm, evsm2 and pcss, have moments, and tell how the position changes; 8 and 9 to exact and exact_soft,
// and send rays, as 10 does, which follows the configuration; 11 is fixed to exact, and sends none; 12 is, too, and traces by
// itself.
#include "csm_constants.h"
#include "csm_enums.h"
#include "forward_boxes.h"

cbuffer shadows_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
};
cbuffer plane_block : register(b1)
{
    float4 plane[4]; // homogeneous position at (0, 0), its change for each pixel right and down; normal
#if FORWARD_WAY == 12
    float4 boxes[2 * FORWARD_BOXES]; // least and largest corners
#endif
};
Texture2DArray<float> csm_maps : register(t0);

#if FORWARD_WAY == 3
// The first light has its constants by a function, the second its own names and a sampler.
float4 sun_constant(int i)
{
    return csm_c[i];
}
SamplerState moon_sampler : register(s0);
#define CSM_PREFIX sun_
#define CSM_CONSTANT(i) sun_constant(i)
#define CSM_BLENDING CSM_BLEND_OFF
#define CSM_SELECTION CSM_SELECT_MAP
#define CSM_CASCADES 4
#include "csm_sample.hlsl"
#define CSM_PREFIX moon_
#define CSM_MAPS csm_maps
#define CSM_POINT moon_sampler
#define CSM_BLENDING CSM_BLEND_OFF
#define CSM_SELECTION CSM_SELECT_MAP
#define CSM_CASCADES 4
#include "csm_sample.hlsl"

float visibility(float3 position)
{
    float3 normal = plane[3].xyz;
    float sun = sun_visibility(position, normal, sun_view_depth(position));
    return 0.5 * (sun + moon_visibility(position, normal, moon_view_depth(position)));
}
#else
#if FORWARD_WAY == 1
SamplerState csm_point : register(s0);
#define CSM_POINT csm_point
#elif FORWARD_WAY == 2
#include "forward_defines.h"
#elif FORWARD_WAY >= 5
SamplerState csm_point : register(s0);
SamplerState csm_linear : register(s1);
Texture2DArray<float4> csm_moments : register(t1);
#define CSM_POINT csm_point
#if FORWARD_WAY == 5
#define CSM_FILTER CSM_FILTER_VSM
#elif FORWARD_WAY == 6
#define CSM_FILTER CSM_FILTER_EVSM2
#elif FORWARD_WAY == 7
#define CSM_FILTER CSM_FILTER_PCSS
#elif FORWARD_WAY == 9
#define CSM_FILTER CSM_FILTER_EXACT_SOFT
#elif FORWARD_WAY == 10
#define CSM_SOFT 1
#else
#define CSM_FILTER CSM_FILTER_EXACT
#endif
#if FORWARD_WAY >= 8 && FORWARD_WAY <= 10
StructuredBuffer<uint4> csm_meshes : register(t8);
StructuredBuffer<uint4> csm_instances : register(t9);
#define CSM_RAYS 1
#elif FORWARD_WAY == 12
bool is_hidden(float3 position, float3 direction, float apart)
{
    bool hidden = false;
    for (int i = 0; i < FORWARD_BOXES; ++i)
    {
        float3 a = (boxes[2 * i].xyz - position) / direction, b = (boxes[2 * i + 1].xyz - position) / direction;
        float3 enters = min(a, b), leaves = max(a, b);
        float last = min(min(leaves.x, leaves.y), leaves.z);
        hidden = hidden || (last > apart && max(max(enters.x, enters.y), enters.z) <= last);
    }
    return hidden;
}
#define CSM_RAYS 1
#define CSM_TRACE is_hidden
#endif
#include "forward_plain.h"
#endif
#include "csm_sample.hlsl"

float visibility(float3 position)
{
#if FORWARD_WAY == 4
    return csm_visibility_point(position, csm_view_depth(position));
#else
    return csm_visibility(position, plane[3].xyz, csm_view_depth(position));
#endif
}
#endif

#if FORWARD_WAY >= 5
float3 position_at(float2 screen)
{
    float4 p = plane[0] + screen.x * plane[1] + screen.y * plane[2];
    return p.xyz / p.w;
}

float main(float4 screen : SV_Position) : SV_Target
{
    float3 position = position_at(screen.xy);
    float3 across = position_at(screen.xy + float2(1.0, 0.0)) - position;
    float3 down = position_at(screen.xy + float2(0.0, 1.0)) - position;
    return csm_visibility_grad(position, plane[3].xyz, csm_view_depth(position), across, down);
}
#else
float main(float4 screen : SV_Position) : SV_Target
{
    float4 p = plane[0] + screen.x * plane[1] + screen.y * plane[2];
    return visibility(p.xyz / p.w);
}
#endif
