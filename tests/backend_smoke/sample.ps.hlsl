/* A texture sampled at one place: at a level on the left of x = 8, with gradients to its right. */
Texture2D<float2> from : register(t0);
SamplerState filter : register(s0);

cbuffer Where : register(b0) {
  float4 where; /* u, v, level */
  float4 gradients; /* ddx, ddy */
};

float4 main(float4 position : SV_Position) : SV_Target {
  float2 by_level = from.SampleLevel(filter, where.xy, where.z);
  float2 by_gradients = from.SampleGrad(filter, where.xy, gradients.xy, gradients.zw);
  return float4(position.x < 8 ? by_level : by_gradients, 0, 0);
}
