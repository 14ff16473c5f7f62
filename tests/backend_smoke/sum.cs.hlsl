/* The same by a compute shader: 8 by 8 texels a group. */
Texture2DArray<float> from : register(t0);
RWTexture2DArray<float> to : register(u0);

cbuffer Size : register(b0) {
  float4 size; /* width, height of `to` */
};

[numthreads(8, 8, 1)]
void main(uint3 id : SV_DispatchThreadID) {
  int4 at = int4(int2(id.xy) * 2, 0, 0);
  float sum = from.Load(at) + from.Load(at + int4(1, 0, 0, 0)) + from.Load(at + int4(0, 1, 0, 0)) +
              from.Load(at + int4(1, 1, 0, 0));
  if (float(id.x) < size.x && float(id.y) < size.y)
    to[uint3(id.xy, 0)] = sum;
}
