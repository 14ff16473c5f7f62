// The mask: visibility of every pixel of a camera's depth image.
#define CSM_RAYS 2 // later, by rays.cs.hlsl
#include "private/mask.hlsl"

// What a pixel is that no ray is to decide: a view of rays makes it something else.
#ifndef MASK_DECIDED
#define MASK_DECIDED(lit) (lit)
#endif

#if CSM_FILTER == CSM_FILTER_EXACT || CSM_FILTER == CSM_FILTER_EXACT_SOFT
#define MASK_RAYS 1
#include "private/rays.h"
static bool bends = false; // the depth leaves the pixel's plane unsure: see depth_steps.hlsl
#endif

// In light space.
float3 surface_normal(float2 place, float depth)
{
#if MASK_NORMALS
    float3 n = normals.Load(int3(int2(place), 0)).xyz;
    return float3(csm_row(inputs.normal_0, n), csm_row(inputs.normal_1, n), csm_row(inputs.normal_2, n));
#elif MASK_RAYS
    float3 plane = depth_plane(place, depth);
    bends = plane.z > 0.0;
    return plane_normal(place, depth, plane.xy);
#else
    return plane_normal(place, depth, depth_steps(place, depth));
#endif
}

#if MASK_RAYS
// Whether a map cannot be asked: it compares with a plane that may not be the pixel's.
bool is_unsure(float3 normal)
{
    float4 squares = csm_c[CSM_R_UNSURE];
    return (bends && (normal.z > 0.0 || csm_grazes(normal, squares.x))) || csm_grazes(normal, squares.y);
}
#endif

// How much its last component may be off, as what it was made of is rounded.
float normal_doubt(float2 place, float depth)
{
    float2 rounding = mask_c[CSM_M_CLEAR].zw;
#if MASK_NORMALS
    float3 n = abs(normals.Load(int3(int2(place), 0)).xyz * inputs.normal_2.xyz);
    return mad(n.x + n.y + n.z, rounding.x, rounding.y);
#else
    float across = mad(-place.x, inputs.normal_2.w, inputs.normal_2.x);
    float down = mad(-place.y, inputs.normal_2.w, inputs.normal_2.y);
    return mad(depth, rounding.x, rounding.y) * (abs(across) + abs(down));
#endif
}

// Visibility, and, for a history, csm_flatness.
float2 main(mask_inputs pixel) : SV_Target
{
    inputs = pixel;
    float2 place = pixel.position.xy;
    float depth = camera_depth.Load(int3(int2(place), 0));
    float3 at = light_position(place, depth), normal = surface_normal(place, depth);
#if CSM_NORMAL_OFFSET_ON != 0
    normal = unit(normal);
#endif
    csm_receiver receiver = csm_receiver_of(at, normal, light_view_depth(at));
    receiver.doubt = normal_doubt(place, depth);
#if MASK_MOMENTS
    float2 steps = depth_steps(place, depth);
    receiver.across = light_step(place, depth, at, float3(1.0, 0.0, steps.x));
    receiver.down = light_step(place, depth, at, float3(0.0, 1.0, steps.y));
#endif
    float lit = csm_visibility_of(receiver);
    float flatness = 0.0;
#if MASK_RAYS
    bool undecided = csm_undecided > 0.0 || (csm_undecided == 0.0 && is_unsure(normal));
    float level = mad(floor(mad(lit, RAYS_SHARES, 0.5)), RAYS_UNDECIDED_STEP, RAYS_UNDECIDED) * (1.0 / 255.0);
    lit = undecided ? level : MASK_DECIDED(lit);
#elif CSM_KNOWS_LIGHT == 1
    flatness = csm_flatness;
#endif
    return float2(depth == mask_c[CSM_M_CLEAR].x ? MASK_DECIDED(1.0) : lit, flatness);
}
