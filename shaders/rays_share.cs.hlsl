// Less noise from as many rays: what a pixel of the list shows becomes the mean of the 3 x 3 pixels around it that lie on its
// plane, where chance alone explains how they differ. Each thread takes one; rays_store writes the means into the mask once all
// of them are known.
#include "csm_constants.h"
#include "private/ray_list.hlsl"

cbuffer cascades_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
};
cbuffer mask_block : register(b1)
{
    float4 mask_c[CSM_M_COUNT];
};
Texture2D<float> mask : register(t0);
Texture2D<float> camera_depth : register(t1);
SamplerState csm_point : register(s0);
#include "private/depth_steps.hlsl"

// In 255ths, of the pixels on one plane.
struct levels
{
    uint count;
    uint sum;
    uint squares;
    uint own; // of the one in the middle
};

levels around(int2 texel)
{
    float4 size = mask_c[CSM_M_SIZE];
    float depth = camera_depth.Load(int3(texel, 0));
    float2 steps = depth_steps(float2(texel) + 0.5, depth), rounding = mask_c[CSM_M_DEPTH_OFF].xy;
    // A quarter of a step beside the plane, and what depths are off by
    float room = mad(abs(steps.x) + abs(steps.y), 0.25, 4.0 * mad(depth, rounding.x, rounding.y));
    levels l;
    l.count = 0u;
    l.sum = 0u;
    l.squares = 0u;
    l.own = 0u;
    [loop] for (int i = 0; i < 9; ++i)
    {
        int down = i < 3 ? -1 : i < 6 ? 0 : 1, across = i - 3 * down - 4;
        int2 at = int2(texel.x + across, texel.y + down);
        bool inside = at.x >= 0 && at.y >= 0 && at.x < int(size.x) && at.y < int(size.y);
        float plane = mad(float(across), steps.x, mad(float(down), steps.y, depth));
        bool on = inside && abs(camera_depth.Load(int3(at, 0)) - plane) <= room;
        uint level = uint(int(mad(mask.Load(int3(at, 0)), 255.0, 0.5)));
        l.count += on ? 1u : 0u;
        l.sum += on ? level : 0u;
        l.squares += on ? level * level : 0u;
        l.own = i == 4 ? level : l.own;
    }
    return l;
}

// A share p that so many rays tell has the variance p (1 - p) / rays. Whole numbers decide: both sides are times the square of
// 255 pixels.
uint mean_of(levels l)
{
    uint rays = uint(int(csm_c[CSM_R_HIGH].w));
    bool chance = rays * (l.count * l.squares - l.sum * l.sum) <= l.sum * (255u * l.count - l.sum);
    uint mean = uint(int(float(2u * l.sum + l.count) / float(2u * l.count)));
    return chance ? mean : l.own;
}

[numthreads(RAYS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    uint index = list_index(group, thread), count = list[RAYS_COUNT];
    if (index < count)
    {
        int2 texel = list_texel(list[RAYS_FIRST + index]);
        list[RAYS_FIRST + count + index] = mean_of(around(texel));
    }
}
