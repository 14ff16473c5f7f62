// The forward pass: sun and sky on a plain colour, the sun's share by csm.
#include "csm_constants.h"
#include "include/bones.hlsl"
#include "include/frame.hlsl"

// What csm_sample.hlsl reads: its constants, its maps, and a sampler, point and clamped.
cbuffer shadow_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
};
Texture2DArray<float> csm_maps : register(t0);
SamplerState csm_point : register(s0);
#define CSM_POINT csm_point
#include "csm_sample.hlsl"

float4 main(float4 clip : SV_Position, float3 position : POSITION, float3 normal : NORMAL) : SV_Target
{
    float3 n = normal * rsqrt(dot(normal, normal));
    float visibility = csm_visibility(position, n, csm_view_depth(position));
    float3 light = sky_light.xyz * (0.75 + 0.25 * n.y) + sun_light.xyz * (visibility * max(dot(n, to_sun.xyz), 0.0));
    return float4(surface.xyz * light, 1.0);
}
