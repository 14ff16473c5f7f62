// The least and the greatest depth of the surfaces in each tile of 8 x 8 pixels; where there is none, the least is above the
// greatest.
cbuffer tiles_block : register(b0)
{
    float4 tiles_c[1]; // width, height, depth of a pixel without a surface
};
Texture2D<float> camera_depth : register(t0);

float2 main(float4 screen : SV_Position) : SV_Target
{
    int2 first = int2(screen.xy) * 8;
    float2 bounds = float2(2.0, -2.0);
    for (int y = 0; y < 8; ++y)
    {
        for (int x = 0; x < 8; ++x)
        {
            int2 pixel = first + int2(x, y);
            float depth = camera_depth.Load(int3(pixel, 0));
            bool seen = (float)pixel.x < tiles_c[0].x && (float)pixel.y < tiles_c[0].y && depth != tiles_c[0].z;
            bounds = seen ? float2(min(bounds.x, depth), max(bounds.y, depth)) : bounds;
        }
    }
    return bounds;
}
