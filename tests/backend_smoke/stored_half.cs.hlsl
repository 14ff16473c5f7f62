/* Writes the image of 4 halves: glslang takes a format from the type, which is of 32 bits, unless it is told. */
#ifdef VULKAN
[[spv::format_rgba16f]]
#endif
RWTexture2D<float4> to : register(u0);

[numthreads(8, 8, 1)]
void main(uint3 id : SV_DispatchThreadID) {
  to[id.xy] = float4(id.x, id.y, 0.5, -2);
}
