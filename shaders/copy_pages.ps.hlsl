// Copies depths from a layer of maps to the same place of another image.
Texture2DArray<float> maps : register(t0);

float main(float from : TEXCOORD0, float4 screen : SV_Position) : SV_Depth
{
    return maps.Load(int4(int2(screen.xy), (int)from, 0)).x;
}
