/* One whole number everywhere. */
cbuffer Color : register(b0) {
  float4 color;
};

uint main(float4 position : SV_Position) : SV_Target {
  return uint(color.x);
}
