/* Draws white, and counts pixels in a buffer: all of them, and those of the left half. */
RWStructuredBuffer<uint> counts : register(u4);

float4 main(float4 position : SV_Position) : SV_Target {
  uint before;
  InterlockedAdd(counts[0], 1, before);
  if (position.x < 128)
    InterlockedAdd(counts[1], 1, before);
  return float4(1, 1, 1, 1);
}
