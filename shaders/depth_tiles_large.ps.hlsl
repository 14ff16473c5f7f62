// The bounds of 4 x 4 tiles of depth_tiles.
cbuffer tiles_block : register(b0)
{
    float4 tiles_c[1]; // tiles across and down
};
Texture2D<float2> tiles : register(t0);

float2 main(float4 screen : SV_Position) : SV_Target
{
    int2 first = int2(screen.xy) * 4;
    float2 bounds = float2(2.0, -2.0);
    for (int y = 0; y < 4; ++y)
    {
        for (int x = 0; x < 4; ++x)
        {
            int2 tile = first + int2(x, y);
            float2 more = tiles.Load(int3(tile, 0));
            bool there = (float)tile.x < tiles_c[0].x && (float)tile.y < tiles_c[0].y;
            bounds = there ? float2(min(bounds.x, more.x), max(bounds.y, more.y)) : bounds;
        }
    }
    return bounds;
}
