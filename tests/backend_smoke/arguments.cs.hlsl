/* Writes arguments: an indexed draw at 0, a draw at 32 bytes, a dispatch at 64. */
RWStructuredBuffer<uint> out_ : register(u4);

cbuffer Numbers : register(b0) {
  float4 numbers; /* instances of the indexed draw, vertices of the other, groups, first index */
};

[numthreads(1, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
  out_[0] = 6;
  out_[1] = uint(numbers.x);
  out_[2] = uint(numbers.w);
  out_[3] = 0;
  out_[4] = 0;
  out_[8] = uint(numbers.y);
  out_[9] = 1;
  out_[10] = 0;
  out_[11] = 0;
  out_[16] = uint(numbers.z);
  out_[17] = 1;
  out_[18] = 1;
}
