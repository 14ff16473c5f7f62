// The least and the greatest depth of the surfaces in each tile of 8 x 8 pixels; LARGE: of 4 x 4 such tiles.
cbuffer tiles_block : register(b0)
{
    float4 tiles_c[1]; // width and height in texels, depth where there is no surface
};

static const float2 nothing = float2(2.0, -2.0); // the least is above the greatest

#if LARGE
#define TILE_SIDE 4
Texture2D<float2> tiles : register(t0);

float2 bounds(int2 tile)
{
    return tiles.Load(int3(tile, 0));
}
#else
#define TILE_SIDE 8
Texture2D<float> camera_depth : register(t0);

float2 bounds(int2 pixel)
{
    float depth = camera_depth.Load(int3(pixel, 0));
    return depth != tiles_c[0].z ? float2(depth, depth) : nothing;
}
#endif

float2 main(float4 screen : SV_Position) : SV_Target
{
    int2 first = int2(screen.xy) * TILE_SIDE;
    int2 last = int2(tiles_c[0].xy) - 1; // what lies past it must not be read
    float2 all = nothing;
    for (int y = 0; y < TILE_SIDE; ++y)
    {
        for (int x = 0; x < TILE_SIDE; ++x)
        {
            int2 at = first + int2(x, y);
            float2 more = bounds(min(at, last));
            bool there = (float)at.x < tiles_c[0].x && (float)at.y < tiles_c[0].y;
            all = there ? float2(min(all.x, more.x), max(all.y, more.y)) : all;
        }
    }
    return all;
}
