// The bounds of 4 x 4 tiles of depth_tiles.
#define TILE_SIDE 4
#include "private/depth_tiles.hlsl"
Texture2D<float2> tiles : register(t0);

float2 bounds(int2 tile)
{
    return tiles.Load(int3(tile, 0));
}

float2 main(float4 screen : SV_Position) : SV_Target
{
    return tile_bounds(int2(screen.xy) * TILE_SIDE);
}
