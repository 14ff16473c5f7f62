// Rectangles of a map, one for each instance: its corners in clip space, and the layer that its pages are copied from.
void main(uint vertex : SV_VertexID, float4 corners : ATTRIBUTE0, float layer : ATTRIBUTE1, out float from : TEXCOORD0,
          out float4 position : SV_Position)
{
    bool right = vertex == 1 || vertex >= 4, down = vertex == 2 || vertex == 3 || vertex == 5;
    from = layer;
    position = float4(right ? corners.z : corners.x, down ? corners.w : corners.y, 0.0, 1.0);
}
