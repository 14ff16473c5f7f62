/* Depth is the sum of attributes of every narrow format. */
struct Vertex {
  float3 position : ATTRIBUTE0;
  float2 normalised : ATTRIBUTE1;
  float2 pair : ATTRIBUTE2;
  float4 four : ATTRIBUTE3;
  float single : ATTRIBUTE4;
  uint whole : ATTRIBUTE5;
};

float4 main(Vertex v) : SV_Position {
  float z = v.normalised.x + v.normalised.y + v.pair.x + v.pair.y + v.four.x + v.four.y + v.four.z + v.four.w + v.single;
  return float4(v.position.xy, z + float(v.whole) / 256, 1);
}
