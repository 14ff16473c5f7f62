// Ranges: the nearest depth in four squares around each block, from that of its rows.
#include "private/ranges.hlsl"

Texture2DArray<float4> from : register(t0);
RWTexture2DArray<float4> to : register(u0);

[numthreads(RANGES_THREADS, RANGES_THREADS, 1)]
void main(uint3 group : SV_GroupID, uint3 thread : SV_GroupThreadID)
{
    int cascade = int(group.z), last = last_block(cascade);
    int2 block = block_of(group, thread);
    float4 ranges = float4(2.0, 2.0, 2.0, 2.0);
    [loop] for (int away = -RANGES_WIDTH_3; away <= RANGES_WIDTH_3; ++away)
    {
        float4 depths = from.Load(int4(block.x, clamp(block.y + away, 0, last), cascade, 0));
        ranges.x = abs(away) <= RANGES_WIDTH_0 ? min(ranges.x, depths.x) : ranges.x;
        ranges.y = abs(away) <= RANGES_WIDTH_1 ? min(ranges.y, depths.y) : ranges.y;
        ranges.z = abs(away) <= RANGES_WIDTH_2 ? min(ranges.z, depths.z) : ranges.z;
        ranges.w = min(ranges.w, depths.w);
    }
    to[int3(block, cascade)] = ranges;
}
