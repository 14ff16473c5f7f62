/* The sum of two by two texels: a level of a chain. */
Texture2D<float> from : register(t0);

float4 main(float4 position : SV_Position) : SV_Target {
  int3 at = int3(int2(position.xy) * 2, 0);
  float sum = from.Load(at) + from.Load(at + int3(1, 0, 0)) + from.Load(at + int3(0, 1, 0)) +
              from.Load(at + int3(1, 1, 0));
  return float4(sum, 0, 0, 0);
}
