// The cheapest that a mask can be: the depth is loaded, the position rebuilt, and that is all.
#define CSM_FILTER 2
#define main csm_main
#include "../../../shaders/private/mask.hlsl"
#undef main

float main(float4 screen : SV_Position) : SV_Target
{
    int2 pixel = int2(screen.xy);
    float3 position = pixel_position(float2(pixel), load_depth(pixel));
    // Always so, but no compiler knows
    return csm_view_depth(position) < 1e30 ? 1.0 : 0.0;
}
