/* Positions through three rows per instance; the two streams of a depth pass. */
struct Vertex {
  float3 position : ATTRIBUTE0;
  float4 row0 : ATTRIBUTE1;
  float4 row1 : ATTRIBUTE2;
  float4 row2 : ATTRIBUTE3;
};

float affine(float4 row, float3 p) {
  return mad(row.x, p.x, mad(row.y, p.y, mad(row.z, p.z, row.w)));
}

float4 main(Vertex v) : SV_Position {
  return float4(affine(v.row0, v.position), affine(v.row1, v.position), affine(v.row2, v.position), 1);
}
