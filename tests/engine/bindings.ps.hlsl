// An engine's shader that reads what csm_bind described: three maps and the mask, texel by texel.
Texture2DArray<float> maps : register(t0);
Texture2D<float> mask : register(t1);

float4 main(float4 screen : SV_Position) : SV_Target
{
    int2 p = int2(screen.xy);
    return float4(maps.Load(int4(p, 0, 0)), maps.Load(int4(p, 1, 0)), maps.Load(int4(p, 2, 0)), mask.Load(int3(p, 0)));
}
