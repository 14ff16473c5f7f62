// Rays for the pixels in the list: each thread decides one, and writes its visibility into the mask.
#define MASK_GENERAL 1
#define CSM_FILTER CSM_FILTER_NEAREST
#include "csm_enums.h"
#include "private/mask.hlsl"
#include "private/mask_inputs_fill.hlsl"
#include "private/ray_list.hlsl"

Buffer<uint4> csm_meshes : register(t12);
Buffer<uint4> csm_instances : register(t13);
#if RAYS_MIXED
#define RAYS_LEVELS 65535.0
#ifdef VULKAN
[[spv::format_rg16]]
#endif
RWTexture2D<float2> mask : register(u0); // whose second channel is csm_flatness: rays know no kernel
#else
#define RAYS_LEVELS 255.0
#ifdef VULKAN
[[spv::format_r8]]
#endif
RWTexture2D<float> mask : register(u0);
#endif
#include "csm_rays.inc"

// What a depth may be off moves the pixel so far.
float depth_move(float2 place, float depth, float3 at)
{
    float2 rounding = mask_c[CSM_M_DEPTH_OFF].xy;
    float off = mad(depth, rounding.x, rounding.y), scale = 1.0 / light_row(inputs.light_3, place, depth);
    float nearer = off * inputs.light_3.z;
    float3 move = float3(mad(-at.x, nearer, off * inputs.light_0.z), mad(-at.y, nearer, off * inputs.light_1.z),
                         mad(-at.z, nearer, off * inputs.light_2.z)) * scale;
    return sqrt(csm_dot(move, move));
}

// What a picture shows of a pixel.
float level_of(csm_decision d, float view_depth)
{
#if RAYS_VIEW
    // Rounded here, as all that is written, so that no format has a say in it
    return clamp(floor(mad(log2(max(d.nodes, 1.0)), 16.0, 1.5)), 1.0, 255.0) * (1.0 / 255.0);
#else
    return floor(mad(csm_faded(d.lit, view_depth), RAYS_LEVELS, 0.5)) * (1.0 / RAYS_LEVELS);
#endif
}

void count(csm_decision d, int2 texel)
{
    if (d.by_map > 0.0)
        InterlockedAdd(list[RAYS_BY_MAP], 1u);
#if RAYS_VIEW
    // In sixteenths, so that no sum overflows; neighbours round up at different remainders, so that the sum is right on the whole.
    uint rounding = uint(texel.x & 3) + 4u * uint(texel.y & 3);
    InterlockedAdd(list[RAYS_NODES], (uint(d.nodes) + rounding) >> 4u);
    InterlockedAdd(list[RAYS_TRIANGLES], (uint(d.triangles) + rounding) >> 4u);
#endif
}

[numthreads(RAYS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    uint index = list_index(group, thread);
    if (index < list[RAYS_COUNT])
    {
        uint pixel = list[RAYS_FIRST + index];
        int2 texel = list_texel(pixel);
        float share = float(pixel >> uint(RAYS_SHARE_BIT)) * (1.0 / RAYS_SHARES);
        float2 place = float2(texel) + 0.5;
        inputs = mask_inputs_of(float4(place, 0.0, 1.0));
        float depth = camera_depth.Load(int3(texel, 0));
        float3 light_at = light_position(place, depth);
        float view_depth = light_view_depth(light_at);
        float3 at = csm_from_light(light_at);
        // A depth that changes evenly with the place is rounded where it is interpolated, stored, and taken apart again.
        float apart = mad(4.0, depth_move(place, depth, light_at), csm_apart(at, view_depth));
#if RAYS_SOFT
        csm_receiver receiver = csm_receiver_of(light_at, float3(0.0, 0.0, -1.0), view_depth);
        csm_decision d = csm_decide_disc(receiver, at, apart, share);
#else
        csm_decision d = csm_decide(at, apart, share);
#endif
        count(d, texel);
#if RAYS_MIXED
        mask[texel] = float2(level_of(d, view_depth), 0.0);
#else
        mask[texel] = level_of(d, view_depth);
#endif
    }
}
