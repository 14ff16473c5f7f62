/* The least and the largest of two by two texels of one layer of a depth array, scaled; no sampler. */
Texture2DArray<float> map : register(t0);

cbuffer Which : register(b0) {
  float4 which; /* layer, scale */
};
cbuffer Size : register(b1) {
  float4 size; /* unused: the shape of the other programs */
};

float4 main(float4 position : SV_Position) : SV_Target {
  int4 at = int4(int2(position.xy) * 2, int(which.x), 0);
  float4 d = float4(map.Load(at), map.Load(at + int4(1, 0, 0, 0)), map.Load(at + int4(0, 1, 0, 0)),
                    map.Load(at + int4(1, 1, 0, 0)));
  float least = min(min(d.x, d.y), min(d.z, d.w));
  float largest = max(max(d.x, d.y), max(d.z, d.w));
  return float4(least * which.y, largest * which.y, 0, 0);
}
