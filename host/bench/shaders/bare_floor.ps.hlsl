// The cheapest that a mask can be, as it is written first: the depth is loaded, the position rebuilt, and that is all.
#include "csm_constants.h"

cbuffer mask_block : register(b1)
{
    float4 mask_c[CSM_M_COUNT];
};
Texture2D<float> camera_depth : register(t1);

float row_value(uint row, float2 place, float depth)
{
    float4 c = mask_c[CSM_M_LIGHT + row];
    return mad(place.x, c.x, mad(place.y, c.y, mad(depth, c.z, c.w)));
}

float main(float4 screen : SV_Position) : SV_Target
{
    float2 place = screen.xy;
    int2 last = int2((int)mask_c[CSM_M_SIZE].x - 1, (int)mask_c[CSM_M_SIZE].y - 1);
    float depth = camera_depth.Load(int3(clamp(int2(place), int2(0, 0), last), 0));
    float w = row_value(3, place, depth);
    float3 position = float3(row_value(0, place, depth) / w, row_value(1, place, depth) / w, row_value(2, place, depth) / w);
    float3 forward = mask_c[CSM_M_DEPTH].xyz;
    // Always so, but no compiler knows
    return mad(position.x, forward.x, mad(position.y, forward.y, position.z * forward.z)) < 1e30 ? 1.0 : 0.0;
}
