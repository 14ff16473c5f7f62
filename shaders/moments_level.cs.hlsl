// A level of moments: the mean of four texels of the level before it. A group makes 8 x 8 texels of a tile.
#include "private/moments.hlsl"

Texture2DArray<MOMENTS> from : register(t0); // the level before

[numthreads(MOMENTS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    int level = int(dispatch_c[MOMENTS_D_PASS].y), parts = int(dispatch_c[MOMENTS_D_PASS].z);
    int layers = int(dispatch_c[MOMENTS_D_TILES].w), part = int(group.z) / layers, slice = int(group.z) - part * layers;
    tile t = tile_of(group, parts * 8);
    int last = (t.side >> level) - 1, layer = t.cascade * layers + slice;
    int x = min(t.begin.x + (part % parts) * 8 + int(thread & 7u), last);
    int y = min(t.begin.y + (part / parts) * 8 + int(thread >> 3u), last);
    MOMENTS above = from.Load(int4(2 * x, 2 * y, layer, 0)) + from.Load(int4(2 * x + 1, 2 * y, layer, 0));
    MOMENTS below = from.Load(int4(2 * x, 2 * y + 1, layer, 0)) + from.Load(int4(2 * x + 1, 2 * y + 1, layer, 0));
    to[int3(x, y, layer)] = stored((above + below) * 0.25);
}
