// What moments_rows left in its layer, blurred along columns.
#include "private/moments.hlsl"

Texture2DArray<MOMENTS> from : register(t0);

static int line_at, last;
#define MOMENTS_READ(i) from.Load(int4(line_at, clamp(i, 0, last), 0, 0))
#include "private/moments_run.hlsl"

[numthreads(MOMENTS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    tile t = tile_of(group, MOMENTS_TILE);
    float4 list = dispatch_c[MOMENTS_D_TILES];
    int layer = t.cascade * int(list.w) + int(list.z);
    last = t.side - 1;
    line_at = min(t.begin.x + int(thread), last);
    int y = min(t.begin.y + int(group.z) * MOMENTS_RUN, t.side - MOMENTS_RUN);
    moments_run run = blurred_run(y, int(dispatch_c[MOMENTS_D_PASS].x));
    to[int3(line_at, y, layer)] = stored(run.a);
    to[int3(line_at, y + 1, layer)] = stored(run.b);
    to[int3(line_at, y + 2, layer)] = stored(run.c);
    to[int3(line_at, y + 3, layer)] = stored(run.d);
    to[int3(line_at, y + 4, layer)] = stored(run.e);
    to[int3(line_at, y + 5, layer)] = stored(run.f);
    to[int3(line_at, y + 6, layer)] = stored(run.g);
    to[int3(line_at, y + 7, layer)] = stored(run.h);
}
