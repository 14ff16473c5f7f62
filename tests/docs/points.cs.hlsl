// points.cs.hlsl: points.comp in HLSL
#include "csm_constants.h"
cbuffer shadows : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
    float4 points[2]; // relative to csm_binding.origin
};
Texture2DArray<float> csm_maps : register(t0);
SamplerState csm_point : register(s0);
#define CSM_POINT csm_point
RWStructuredBuffer<float> visibility : register(u0);
#include "csm_sample.hlsl"

[numthreads(2, 1, 1)] void main(uint3 id : SV_DispatchThreadID)
{
    float3 position = points[id.x].xyz, normal = float3(0.0, 1.0, 0.0);
    visibility[id.x] = csm_visibility(position, normal, csm_view_depth(position));
}
