/* Writes an array's layers of pairs, two at a time. */
RWTexture2DArray<float2> to : register(u0);

[numthreads(8, 8, 2)]
void main(uint3 id : SV_DispatchThreadID) {
  to[id] = float2(float(id.x) + 1000 * float(id.y), id.z);
}
