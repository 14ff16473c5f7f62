/* out = in * factor + raw + texel + index, from a structured, a raw and a texel buffer, through groups of 64. */
StructuredBuffer<uint> in_ : register(t8);
ByteAddressBuffer raw : register(t9);
Buffer<uint4> texels : register(t12);
RWStructuredBuffer<uint> out_ : register(u4);

cbuffer Numbers : register(b0) {
  float4 numbers; /* factor */
};

[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
  uint4 row = texels[id.x >> 2];
  uint texel = (id.x & 2) != 0 ? ((id.x & 1) != 0 ? row.w : row.z) : ((id.x & 1) != 0 ? row.y : row.x);
  out_[id.x] = in_[id.x] * uint(numbers.x) + raw.Load(4 * id.x) + texel + id.x;
}
