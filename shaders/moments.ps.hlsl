// Moments of the depths of one layer of a cascade's map.
#include "csm_constants.h"
#include "csm_enums.h"

cbuffer settings_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
};
cbuffer layer_block : register(b1)
{
    float4 layer_c[1]; // cascade, slice of its depth range
};
Texture2DArray<float> csm_maps : register(t0);

#define CSM_CONSTANT(i) csm_c[i]
#define csm_float2 float2
#define csm_float4 float4
#define csm_mad mad
#define CSM_MOMENTS_WARP_ONLY
#include "csm_moments.inc"

float4 main(float4 position : SV_Position) : SV_Target
{
    float4 rect = csm_c[CSM_C_RECTS + int(layer_c[0].x)];
    float depth = csm_maps.Load(int4(int2(position.xy) + int2(rect.xy), int(rect.w), 0));
    return csm_moments_of(csm_c[CSM_S_OPTIONS].z < 0.0 ? 1.0 - depth : depth, layer_c[0].y);
}
