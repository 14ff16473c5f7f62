// Lists the pixels of a mask that rays are to decide. A group looks through a square of pixels, so that what follows each other
// in the list lies together on screen.
#include "csm_constants.h"
#include "private/rays.h"

cbuffer mask_block : register(b1)
{
    float4 mask_c[CSM_M_COUNT];
};
Texture2D<float> mask : register(t0);
RWStructuredBuffer<uint> list : register(u4);

[numthreads(RAYS_TILE, RAYS_TILE, 1)]
void main(uint3 pixel : SV_DispatchThreadID)
{
    float lit = mask.Load(int3(int2(pixel.xy), 0));
    bool inside = int(pixel.x) < int(mask_c[CSM_M_SIZE].x) && int(pixel.y) < int(mask_c[CSM_M_SIZE].y);
    if (inside && abs(lit - RAYS_UNDECIDED) < 0.001)
    {
        uint place;
        InterlockedAdd(list[RAYS_COUNT], 1u, place);
        list[RAYS_FIRST + place] = pixel.x | (pixel.y << 16u);
    }
}
