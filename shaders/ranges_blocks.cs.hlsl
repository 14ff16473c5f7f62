// The nearest depth of each block of a map's texels; depths grow away from the light.
#include "private/ranges.hlsl"

Texture2DArray<float> maps : register(t0);
SamplerState point_clamp : register(s0);
RWTexture2DArray<float> to : register(u0);

[numthreads(RANGES_THREADS, RANGES_THREADS, 1)]
void main(uint3 group : SV_GroupID, uint3 thread : SV_GroupThreadID)
{
    int cascade = int(group.z);
    int2 block = block_of(group, thread);
    float4 rect = csm_c[CSM_C_RECTS + cascade];
    float2 scale = csm_c[CSM_C_PARAMS].zw;
    float side = csm_c[CSM_S_OPTIONS].z, last = rect.z - 2.0;
    float4 nearest = float4(2.0, 2.0, 2.0, 2.0);
    [loop] for (int y = 0; y < RANGES_BLOCK; y += 2)
    {
        float down = min(float(block.y * RANGES_BLOCK + y), last) + rect.y + 1.0;
        [unroll] for (int x = 0; x < RANGES_BLOCK; x += 2)
        {
            float right = min(float(block.x * RANGES_BLOCK + x), last) + rect.x + 1.0;
            float4 at = float4(right * scale.x, down * scale.y, rect.w, rect.w);
            nearest = min(nearest, maps.Gather(point_clamp, at.xyz) * side);
        }
    }
    to[int3(block, cascade)] = min(min(nearest.x, nearest.y), min(nearest.z, nearest.w));
}
