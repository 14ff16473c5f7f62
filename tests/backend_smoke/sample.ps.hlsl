/* A texture sampled in three ways, each on 8 columns: at a level, with gradients, and with the quad's own. */
Texture2D<float2> from : register(t0);
SamplerState filter : register(s0);

cbuffer Where : register(b0) {
  float4 where;     /* u, v, level */
  float4 gradients; /* ddx, ddy */
};

float4 main(float4 position : SV_Position) : SV_Target {
  float2 by_level = from.SampleLevel(filter, where.xy, where.z);
  float2 by_gradients = from.SampleGrad(filter, where.xy, gradients.xy, gradients.zw);
  float2 by_quad = from.Sample(filter, position.xy * gradients.xw);
  return float4(position.x < 8 ? by_level : position.x < 16 ? by_gradients : by_quad, 0, 0);
}
