// The least and the greatest depth in a square of TILE_SIDE texels a side, which its includer defines before, and after it
// the bounds of one texel.
cbuffer tiles_block : register(b0)
{
    float4 tiles_c[1]; // width and height in texels, depth where there is no surface
};

static const float2 nothing = float2(2.0, -2.0); // the least is above the greatest

float2 bounds(int2 at);

float2 tile_bounds(int2 first)
{
    float2 all = nothing;
    for (int y = 0; y < TILE_SIDE; ++y)
    {
        for (int x = 0; x < TILE_SIDE; ++x)
        {
            int2 at = first + int2(x, y);
            float2 more = bounds(at);
            bool there = (float)at.x < tiles_c[0].x && (float)at.y < tiles_c[0].y;
            all = there ? float2(min(all.x, more.x), max(all.y, more.y)) : all;
        }
    }
    return all;
}
