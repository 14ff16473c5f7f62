/* Vertices that the shader fetches itself, from a structured buffer. */
struct Corner {
  float4 position;
};
StructuredBuffer<Corner> corners : register(t8);

float4 main(uint id : SV_VertexID) : SV_Position {
  return corners[id].position;
}
