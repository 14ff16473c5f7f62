// Moments of a map's depths, blurred along rows, into a layer that is read by moments_columns.
#define MOMENTS_FROM_DEPTH
#include "private/moments.hlsl"

static int line_at, last;
#define MOMENTS_READ(i) moments_at(clamp(i, 0, last), line_at)
#include "private/moments_run.hlsl"

[numthreads(MOMENTS_THREADS, 1, 1)]
void main(uint3 group : SV_GroupID, uint thread : SV_GroupIndex)
{
    tile t = tile_of(group, MOMENTS_TILE);
    begin_depths(t, dispatch_c[MOMENTS_D_TILES].z);
    last = t.side - 1;
    line_at = min(t.begin.y + int(thread), last);
    int x = min(t.begin.x + int(group.z) * MOMENTS_RUN, t.side - MOMENTS_RUN);
    moments_run run = blurred_run(x, int(dispatch_c[MOMENTS_D_PASS].x));
    to[int3(x, line_at, 0)] = stored(run.a);
    to[int3(x + 1, line_at, 0)] = stored(run.b);
    to[int3(x + 2, line_at, 0)] = stored(run.c);
    to[int3(x + 3, line_at, 0)] = stored(run.d);
    to[int3(x + 4, line_at, 0)] = stored(run.e);
    to[int3(x + 5, line_at, 0)] = stored(run.f);
    to[int3(x + 6, line_at, 0)] = stored(run.g);
    to[int3(x + 7, line_at, 0)] = stored(run.h);
}
