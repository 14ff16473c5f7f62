// How many groups of threads the list of pixels takes.
#include "private/rays.h"

RWStructuredBuffer<uint> list : register(u4);

[numthreads(1, 1, 1)]
void main()
{
    uint groups = (list[RAYS_COUNT] + uint(RAYS_THREADS) - 1u) / uint(RAYS_THREADS);
    uint rows = (groups + uint(RAYS_MOST_GROUPS) - 1u) / uint(RAYS_MOST_GROUPS);
    list[RAYS_GROUPS] = min(groups, uint(RAYS_MOST_GROUPS));
    list[RAYS_GROUPS + 1] = rows;
    list[RAYS_GROUPS + 2] = 1u;
}
