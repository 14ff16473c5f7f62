// An engine's forward shader in small: the light's visibility on a plane, whose point at each pixel the test says.
#include "csm_constants.h"

cbuffer shadows_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
};
cbuffer plane_block : register(b1)
{
    float4 plane[4]; // homogeneous position at (0, 0), its change for each pixel right and down; normal
};
Texture2DArray<float> csm_maps : register(t0);
#ifdef CSM_POINT
SamplerState CSM_POINT : register(s0);
#endif

#include "csm_sample.hlsl"

float main(float4 screen : SV_Position) : SV_Target
{
    float4 p = plane[0] + screen.x * plane[1] + screen.y * plane[2];
    float3 position = p.xyz / p.w;
    return csm_visibility(position, plane[3].xyz, csm_view_depth(position));
}
