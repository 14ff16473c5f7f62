// Writes the means that rays_share has made into the mask.
#include "private/rays.h"

RWStructuredBuffer<uint> list : register(u4);
#ifdef VULKAN
[[spv::format_r8]]
#endif
RWTexture2D<float> mask : register(u0);

[numthreads(RAYS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    uint index = (group.y * uint(RAYS_MOST_GROUPS) + group.x) * uint(RAYS_THREADS) + thread, count = list[RAYS_COUNT];
    if (index < count)
    {
        uint pixel = list[RAYS_FIRST + index], last = (1u << uint(RAYS_PLACE_BITS)) - 1u;
        int2 texel = int2(int(pixel & last), int((pixel >> uint(RAYS_PLACE_BITS)) & last));
        mask[texel] = float(list[RAYS_FIRST + count + index]) * (1.0 / 255.0);
    }
}
