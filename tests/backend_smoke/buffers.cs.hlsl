/* out = in * factor + raw + index, from a structured and a raw buffer, through groups of 64. */
StructuredBuffer<uint> in_ : register(t8);
ByteAddressBuffer raw : register(t9);
RWStructuredBuffer<uint> out_ : register(u4);

cbuffer Numbers : register(b0) {
  float4 numbers; /* factor */
};

[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
  out_[id.x] = in_[id.x] * uint(numbers.x) + raw.Load(4 * id.x) + id.x;
}
