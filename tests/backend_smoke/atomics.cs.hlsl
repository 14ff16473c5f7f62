/* A histogram of 256 numbers modulo 8, in a buffer and in an image, and their sum. */
RWTexture2D<uint> histogram : register(u0);
RWStructuredBuffer<uint> counts : register(u4);

[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
  uint before;
  uint value = id.x * id.x;
  InterlockedAdd(counts[value % 8], 1, before);
  InterlockedAdd(counts[8], value, before);
  InterlockedAdd(histogram[uint2(value % 8, 0)], 1, before);
}
