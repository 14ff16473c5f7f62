// Moments of a map's depths, without a blur. A thread makes a square of texels.
#define MOMENTS_FROM_DEPTH
#include "private/moments.hlsl"

[numthreads(MOMENTS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    tile t = tile_of(group, MOMENTS_TILE);
    int layer = t.cascade * int(dispatch_c[MOMENTS_D_TILES].w) + int(group.z);
    begin_depths(t, float(group.z));
    // The last ones of a side that they do not divide make some texels twice
    int x = min(t.begin.x + int(thread & 7u) * MOMENTS_RUN, t.side - MOMENTS_RUN);
    int y = min(t.begin.y + int(thread >> 3u) * MOMENTS_RUN, t.side - MOMENTS_RUN);
    [loop] for (int row = y; row < y + MOMENTS_RUN; ++row)
    {
        to[int3(x, row, layer)] = moments_at(x, row);
        to[int3(x + 1, row, layer)] = moments_at(x + 1, row);
        to[int3(x + 2, row, layer)] = moments_at(x + 2, row);
        to[int3(x + 3, row, layer)] = moments_at(x + 3, row);
        to[int3(x + 4, row, layer)] = moments_at(x + 4, row);
        to[int3(x + 5, row, layer)] = moments_at(x + 5, row);
        to[int3(x + 6, row, layer)] = moments_at(x + 6, row);
        to[int3(x + 7, row, layer)] = moments_at(x + 7, row);
    }
}
