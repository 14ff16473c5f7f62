// The least and the greatest depth of the surfaces in each tile of 8 x 8 pixels.
#define TILE_SIDE 8
#include "private/depth_tiles.hlsl"
Texture2D<float> camera_depth : register(t0);

float2 bounds(int2 pixel)
{
    float depth = camera_depth.Load(int3(pixel, 0));
    return depth != tiles_c[0].z ? float2(depth, depth) : nothing;
}

float2 main(float4 screen : SV_Position) : SV_Target
{
    return tile_bounds(int2(screen.xy) * TILE_SIDE);
}
