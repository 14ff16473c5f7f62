/* Writes each pixel's place to an image, and no colour. */
RWTexture2D<uint> to : register(u0);

void main(float4 position : SV_Position) {
  to[uint2(position.xy)] = uint(position.x) + 1000 * uint(position.y);
}
