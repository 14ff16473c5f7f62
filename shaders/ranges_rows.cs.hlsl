// The nearest depth of the blocks beside each one, in ranges' four widths.
#include "private/ranges.hlsl"

Texture2DArray<float> from : register(t0);
RWTexture2DArray<float4> to : register(u0);

[numthreads(RANGES_THREADS, RANGES_THREADS, 1)]
void main(uint3 group : SV_GroupID, uint3 thread : SV_GroupThreadID)
{
    int cascade = int(group.z), last = last_block(cascade);
    int2 block = block_of(group, thread);
    float4 ranges = float4(2.0, 2.0, 2.0, 2.0);
    [loop] for (int away = -RANGES_WIDTH_3; away <= RANGES_WIDTH_3; ++away)
    {
        float depth = from.Load(int4(clamp(block.x + away, 0, last), block.y, cascade, 0));
        ranges.x = abs(away) <= RANGES_WIDTH_0 ? min(ranges.x, depth) : ranges.x;
        ranges.y = abs(away) <= RANGES_WIDTH_1 ? min(ranges.y, depth) : ranges.y;
        ranges.z = abs(away) <= RANGES_WIDTH_2 ? min(ranges.z, depth) : ranges.z;
        ranges.w = min(ranges.w, depth);
    }
    to[int3(block, cascade)] = ranges;
}
