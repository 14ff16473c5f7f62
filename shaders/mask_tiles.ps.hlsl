// Of each tile of 8 x 8 pixels, by four of them: how many are neither lit nor dark, and how many face the light; LARGE: the sums of
// 4 x 4 such tiles.
cbuffer tiles_block : register(b0)
{
    float4 tiles_c[1]; // width and height in texels, depth where there is no surface
};

#if LARGE
#define TILE_SIDE 4
#define TILE_LOOKS 16
Texture2D<float2> tiles : register(t0);

int2 look(int i)
{
    return int2(i - i / 4 * 4, i / 4);
}

float2 count(int2 tile)
{
    return tiles.Load(int3(tile, 0));
}
#else
#define TILE_SIDE 8
#define TILE_LOOKS 4
#include "csm_constants.h"
cbuffer mask_block : register(b1)
{
    float4 mask_c[CSM_M_COUNT];
};
Texture2D<float> camera_depth : register(t0);
Texture2D<float> mask : register(t1);
SamplerState csm_point : register(s0);
#include "private/depth_steps.hlsl"

// One in each quarter of the tile, no two of them in a row or a column: (1, 2), (6, 1), (2, 5) and (5, 6).
int2 look(int i)
{
    return int2(i < 2 ? (i == 0 ? 1 : 6) : (i == 2 ? 2 : 5), i < 2 ? (i == 0 ? 2 : 1) : (i == 2 ? 5 : 6));
}

float2 count(int2 pixel)
{
    float2 place = float2(float(pixel.x) + 0.5, float(pixel.y) + 0.5);
    float depth = camera_depth.Load(int3(pixel, 0)), lit = mask.Load(int3(pixel, 0));
    float2 steps = depth_steps(place, depth);
    float4 row = mask_c[CSM_M_PLANES + 2]; // along the light
    float origin = mad(-steps.x, place.x, mad(-steps.y, place.y, depth));
    float along = mad(steps.x, row.x, mad(steps.y, row.y, mad(origin, row.w, -row.z)));
    bool faces = depth != tiles_c[0].z && along < 0.0;
    return float2(faces && lit > 0.0 && lit < 1.0 ? 1.0 : 0.0, faces ? 1.0 : 0.0);
}
#endif

float2 main(float4 screen : SV_Position) : SV_Target
{
    int2 first = int2(screen.xy) * TILE_SIDE;
    int2 last = int2(tiles_c[0].xy) - 1; // what lies past it must not be read
    float2 all = float2(0.0, 0.0);
    for (int i = 0; i < TILE_LOOKS; ++i)
    {
        int2 at = first + look(i);
        float2 more = count(min(at, last));
        bool there = (float)at.x < tiles_c[0].x && (float)at.y < tiles_c[0].y;
        all = there ? all + more : all;
    }
    return all;
}
