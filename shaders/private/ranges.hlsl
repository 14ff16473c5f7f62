// What the passes that make ranges share: which block a thread takes.
#include "csm_constants.h"
#include "private/ranges.h"

cbuffer cascades_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
};

// Threads beyond a map take its last block again.
int last_block(int cascade)
{
    return (int(csm_c[CSM_C_RECTS + cascade].z) + RANGES_BLOCK - 1) / RANGES_BLOCK - 1;
}

int2 block_of(uint3 group, uint3 thread)
{
    int last = last_block(int(group.z));
    return int2(min(int(group.x) * RANGES_THREADS + int(thread.x), last),
                min(int(group.y) * RANGES_THREADS + int(thread.y), last));
}
