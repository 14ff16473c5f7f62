// The mask: visibility of every pixel of a camera's depth image.
#include "private/mask.hlsl"

// In light space.
float3 surface_normal(float2 place, float depth)
{
#if MASK_NORMALS
    float3 n = normals.Load(int3(int2(place), 0)).xyz;
    return float3(csm_row(inputs.normal_0, n), csm_row(inputs.normal_1, n), csm_row(inputs.normal_2, n));
#else
    return plane_normal(place, depth, depth_steps(place, depth));
#endif
}

float main(mask_inputs pixel) : SV_Target
{
    inputs = pixel;
    float2 place = pixel.position.xy;
    float depth = camera_depth.Load(int3(int2(place), 0));
    float3 at = light_position(place, depth), normal = surface_normal(place, depth);
#if CSM_NORMAL_OFFSET_ON != 0
    normal = unit(normal);
#endif
    float lit = csm_visibility_of(csm_receiver_of(at, normal, light_view_depth(at)));
    return depth == mask_c[CSM_M_CLEAR].x ? 1.0 : lit;
}
