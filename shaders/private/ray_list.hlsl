// The list of pixels that rays are to decide, for the passes that take one a thread.
#include "private/rays.h"

RWStructuredBuffer<uint> list : register(u4);

// A thread's place in the list; RAYS_COUNT of it tells whether there is such a one.
uint list_index(uint3 group, uint thread)
{
    return (group.y * uint(RAYS_MOST_GROUPS) + group.x) * uint(RAYS_THREADS) + thread;
}

int2 list_texel(uint pixel)
{
    uint last = (1u << uint(RAYS_PLACE_BITS)) - 1u;
    return int2(int(pixel & last), int((pixel >> uint(RAYS_PLACE_BITS)) & last));
}
