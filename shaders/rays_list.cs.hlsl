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
    float share = mad(mask.Load(int3(int2(pixel.xy), 0)), 255.0, -RAYS_UNDECIDED) * (1.0 / RAYS_UNDECIDED_STEP);
    bool inside = int(pixel.x) < int(mask_c[CSM_M_SIZE].x) && int(pixel.y) < int(mask_c[CSM_M_SIZE].y);
    if (inside && share > -0.1 && share < RAYS_SHARES + 0.1)
    {
        uint place;
        InterlockedAdd(list[RAYS_COUNT], 1u, place);
        uint k = uint(int(share + 0.5));
        list[RAYS_FIRST + place] = pixel.x | (pixel.y << uint(RAYS_PLACE_BITS)) | (k << uint(RAYS_SHARE_BIT));
    }
}
