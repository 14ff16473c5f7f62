// Moments of a map's depths, without a blur. A thread makes a square of texels.
#define MOMENTS_FROM_DEPTH
#include "private/moments.hlsl"

[numthreads(MOMENTS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    tile t = tile_of(group, MOMENTS_TILE);
    int layer = t.cascade * int(dispatch_c[MOMENTS_D_TILES].w) + int(group.z);
    // By way of an int, for vkd3d's compiler takes an unsigned input's bits for a float's
    begin_depths(t, float(int(group.z)));
    // The last ones of a side that they do not divide make some texels twice
    int x = min(t.begin.x + int(thread & 7u) * MOMENTS_RUN, t.side - MOMENTS_RUN);
    int y = min(t.begin.y + int(thread >> 3u) * MOMENTS_RUN, t.side - MOMENTS_RUN);
    [loop] for (int i = 0; i < MOMENTS_RUN * MOMENTS_RUN; ++i)
    {
        int column = x + (i & (MOMENTS_RUN - 1)), row = y + i / MOMENTS_RUN;
        to[int3(column, row, layer)] = stored(moments_at(column, row));
    }
}
