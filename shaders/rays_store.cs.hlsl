// Writes the means that rays_share has made into the mask.
#include "private/ray_list.hlsl"

#ifdef VULKAN
[[spv::format_r8]]
#endif
RWTexture2D<float> mask : register(u0);

[numthreads(RAYS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    uint index = list_index(group, thread), count = list[RAYS_COUNT];
    if (index < count)
    {
        int2 texel = list_texel(list[RAYS_FIRST + index]);
        mask[texel] = float(list[RAYS_FIRST + count + index]) * (1.0 / 255.0);
    }
}
