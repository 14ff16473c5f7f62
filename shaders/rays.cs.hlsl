// Rays for the pixels in the list: each thread decides one, and writes its visibility into the mask.
#define MASK_GENERAL 1
#define CSM_FILTER CSM_FILTER_NEAREST
#include "csm_enums.h"
#include "private/mask.hlsl"
#include "private/mask_inputs_fill.hlsl"
#include "private/rays.h"

StructuredBuffer<uint4> csm_meshes : register(t8);
StructuredBuffer<uint4> csm_instances : register(t9);
RWStructuredBuffer<uint> list : register(u4);
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
#define CSM_MESHES(row) csm_meshes[row]
#define CSM_INSTANCES(row) csm_instances[row]
#define CSM_ROW_FLOATS(row) asfloat(row)
#define csm_uint4 uint4
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

// From light space to the world, relative to the constants' origin.
float3 from_light(float3 v)
{
    float3 x = csm_c[CSM_C_BASIS].xyz, y = csm_c[CSM_C_BASIS + 1].xyz, z = csm_c[CSM_C_BASIS + 2].xyz;
    return float3(mad(v.x, x.x, mad(v.y, y.x, v.z * z.x)), mad(v.x, x.y, mad(v.y, y.y, v.z * z.y)),
                  mad(v.x, x.z, mad(v.y, y.z, v.z * z.z)));
}

// What rays found out about a pixel. The map's share counts for those that met nothing, but passed what cannot be met.
struct decision
{
    float lit;
    float by_map;
    float nodes;
    float triangles;
};

decision add_ray(decision so_far, csm_traced traced, float share)
{
    decision d = so_far;
    bool by_map = traced.met == 0.0 && traced.unknown > 0.0;
    d.lit += by_map ? share : 1.0 - traced.met;
    d.by_map = by_map ? 1.0 : d.by_map;
    d.nodes += traced.nodes;
    d.triangles += traced.triangles;
    return d;
}

#if RAYS_SOFT
// The share of the light's disc that is seen, by points of a spiral that is turned by where in the world the pixel lies.
decision add_disc(decision so_far, csm_receiver receiver, float3 at, float apart, float share)
{
    decision d = so_far;
    csm_found found = csm_find_first(receiver);
    float turn = mad(csm_c[CSM_S_SOFT_MORE].w, 37.0, csm_noise(found));
    float angle = 6.2831853 * (turn - floor(turn));
    float2 direction = float2(cos(angle), sin(angle)), golden = float2(-0.73736888, 0.67549029);
    float taps = csm_c[CSM_R_HIGH].w, radius = csm_c[CSM_S_SOFT].x;
    float phase = csm_c[CSM_S_SOFT_MORE].w + 0.5;
    phase = phase - floor(phase);
    [loop] for (int i = 0; i < int(taps); ++i)
    {
        float2 beside = direction * (radius * sqrt((float(i) + phase) / taps));
        d = add_ray(d, csm_trace(at, from_light(float3(beside.x, beside.y, -1.0)), apart), share);
        direction = csm_turn(direction, golden);
    }
    d.lit = min(d.lit / taps, 1.0);
    return d;
}
#endif

// What a picture shows of a pixel.
float level_of(decision d, float view_depth)
{
#if RAYS_VIEW
    // Rounded here, as all that is written, so that no format has a say in it
    return clamp(floor(mad(log2(max(d.nodes, 1.0)), 16.0, 1.5)), 1.0, 255.0) * (1.0 / 255.0);
#else
    return floor(mad(csm_faded(d.lit, view_depth), RAYS_LEVELS, 0.5)) * (1.0 / RAYS_LEVELS);
#endif
}

void count(decision d)
{
    if (d.by_map > 0.0)
        InterlockedAdd(list[RAYS_BY_MAP], 1u);
#if RAYS_VIEW
    InterlockedAdd(list[RAYS_NODES], uint(d.nodes * 0.0625));
    InterlockedAdd(list[RAYS_TRIANGLES], uint(d.triangles * 0.0625));
#endif
}

[numthreads(RAYS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    uint index = (group.y * uint(RAYS_MOST_GROUPS) + group.x) * uint(RAYS_THREADS) + thread;
    if (index < list[RAYS_COUNT])
    {
        uint pixel = list[RAYS_FIRST + index], last = (1u << uint(RAYS_PLACE_BITS)) - 1u;
        int2 texel = int2(int(pixel & last), int((pixel >> uint(RAYS_PLACE_BITS)) & last));
        float share = float(pixel >> uint(RAYS_SHARE_BIT)) * (1.0 / RAYS_SHARES);
        float2 place = float2(texel) + 0.5;
        inputs = mask_inputs_of(float4(place, 0.0, 1.0));
        float depth = camera_depth.Load(int3(texel, 0));
        float3 light_at = light_position(place, depth);
        float view_depth = light_view_depth(light_at);
        float3 at = from_light(light_at);
        // The larger the numbers are that it was made of, the more it is off. A depth that changes evenly with the place is
        // rounded where it is interpolated, stored, and taken apart again.
        float large = max(max(abs(at.x), abs(at.y)), max(abs(at.z), view_depth));
        float apart = mad(large, csm_c[CSM_R_OFFSET].w, 4.0 * depth_move(place, depth, light_at));
        decision d;
        d.lit = 0.0;
        d.by_map = 0.0;
        d.nodes = 0.0;
        d.triangles = 0.0;
#if RAYS_SOFT
        csm_receiver receiver = csm_receiver_of(light_at, float3(0.0, 0.0, -1.0), view_depth);
        d = add_disc(d, receiver, at, apart, share);
#else
        d = add_ray(d, csm_trace(at, from_light(float3(0.0, 0.0, -1.0)), apart), share);
#endif
        count(d);
#if RAYS_MIXED
        mask[texel] = float2(level_of(d, view_depth), 0.0);
#else
        mask[texel] = level_of(d, view_depth);
#endif
    }
}
