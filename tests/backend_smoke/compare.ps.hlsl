/* The compare sampler on one layer of a depth array; two constant blocks. */
Texture2DArray<float> map : register(t0);
SamplerComparisonState compare : register(s0);

cbuffer Which : register(b0) {
  float4 which; /* layer, reference */
};
cbuffer Size : register(b1) {
  float4 size; /* 1 / width, 1 / height */
};

float4 main(float4 position : SV_Position) : SV_Target {
  return map.SampleCmpLevelZero(compare, float3(position.xy * size.xy, which.x), which.y);
}
