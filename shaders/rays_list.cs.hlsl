// Lists the pixels of a mask that rays are to decide. A group looks through a square of pixels, so that what follows each other
// in the list lies together on screen. Each thread takes four pixels: on a CPU threads cost more than what they look at.
#include "csm_constants.h"
#include "private/rays.h"

cbuffer mask_block : register(b1)
{
    float4 mask_c[CSM_M_COUNT];
};
Texture2D<float> mask : register(t0);
SamplerState csm_point : register(s0);
RWStructuredBuffer<uint> list : register(u4);

// 1: a ray is to decide the pixel whose mask stands for that share, and which lies in the picture; else 0.
uint asks(float share, bool inside)
{
    return inside && share > -0.1 && share < RAYS_SHARES + 0.1 ? 1u : 0u;
}

uint entry(uint x, uint y, float share)
{
    return x | (y << uint(RAYS_PLACE_BITS)) | (uint(int(share + 0.5)) << uint(RAYS_SHARE_BIT));
}

[numthreads(RAYS_LOOK, RAYS_LOOK, 1)]
void main(uint3 thread : SV_DispatchThreadID)
{
    float4 size = mask_c[CSM_M_SIZE];
    uint x = thread.x * 2u, y = thread.y * 2u;
    float2 middle = float2(float(int(x)) + 1.0, float(int(y)) + 1.0) * size.zw;
    float4 gathered = mask.GatherRed(csm_point, middle);
    float4 shares = mad(gathered, 255.0, -RAYS_UNDECIDED) * (1.0 / RAYS_UNDECIDED_STEP);
    bool in_x = int(x) < int(size.x), in_y = int(y) < int(size.y);
    bool right = int(x) + 1 < int(size.x), below = int(y) + 1 < int(size.y);
    uint a = asks(shares.w, in_x && in_y), b = asks(shares.z, right && in_y);
    uint c = asks(shares.x, in_x && below), d = asks(shares.y, right && below);
    uint count = a + b + c + d;
    if (count > 0u)
    {
        uint place;
        InterlockedAdd(list[RAYS_COUNT], count, place);
        place += uint(RAYS_FIRST);
        if (a > 0u)
            list[place] = entry(x, y, shares.w);
        if (b > 0u)
            list[place + a] = entry(x + 1u, y, shares.z);
        if (c > 0u)
            list[place + a + b] = entry(x, y + 1u, shares.x);
        if (d > 0u)
            list[place + a + b + c] = entry(x + 1u, y + 1u, shares.y);
    }
}
