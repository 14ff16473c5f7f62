/* The sum of two by two texels of the first layer: a level of a chain. */
Texture2DArray<float> from : register(t0);

float4 main(float4 position : SV_Position) : SV_Target {
  int4 at = int4(int2(position.xy) * 2, 0, 0);
  float sum = from.Load(at) + from.Load(at + int4(1, 0, 0, 0)) + from.Load(at + int4(0, 1, 0, 0)) +
              from.Load(at + int4(1, 1, 0, 0));
  return float4(sum, 0, 0, 0);
}
