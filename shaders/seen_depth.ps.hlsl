// Which of 32 slots of depth have surfaces in each tile of 16 x 16 pixels: plan_seen_tile.
cbuffer tiles_block : register(b0)
{
    float4 tiles_c[1]; // width and height in texels, depth where there is no surface, 1 or -1: depth is not reversed
};

Texture2D<float> camera_depth : register(t0);

#define TILE_SIDE 16
#define SLOTS 32

static const float2 nothing = float2(2.0, -2.0); // the least is above the greatest

// Below 0: there is no surface.
float nearness(int2 at)
{
    int2 last = int2(tiles_c[0].xy) - 1; // what lies past it must not be read
    float depth = camera_depth.Load(int3(min(at, last), 0));
    bool there = (float)at.x < tiles_c[0].x && (float)at.y < tiles_c[0].y && depth != tiles_c[0].z;
    return there ? mad(depth, tiles_c[0].w, tiles_c[0].z) : -1.0;
}

float4 main(float4 screen : SV_Position) : SV_Target
{
    int2 first = int2(screen.xy) * TILE_SIDE;
    float2 all = nothing;
    int i;
    for (i = 0; i < TILE_SIDE * TILE_SIDE; ++i)
    {
        float at = nearness(first + int2(i % TILE_SIDE, i / TILE_SIDE));
        all = at >= 0.0 ? float2(min(all.x, at), max(all.y, at)) : all;
    }
    uint begin = asuint(all.x);
    uint range = all.x <= all.y ? asuint(all.y) - begin : 0;
    uint shift = 0;
    for (i = 0; i < 31; ++i)
    {
        shift += (range >> (uint)i) >= SLOTS ? 1 : 0;
    }
    uint slots = 0;
    for (i = 0; i < TILE_SIDE * TILE_SIDE; ++i)
    {
        float at = nearness(first + int2(i % TILE_SIDE, i / TILE_SIDE));
        uint slot = at >= 0.0 ? (asuint(at) - begin) >> shift : 0;
        slots |= at >= 0.0 ? 1u << slot : 0;
    }
    return float4(all, (float)(int)(slots & 0xffffu), (float)(int)(slots >> 16));
}
