// Draws what the camera sees into its depth image: object space to clip space by the four rows of each instance.
float4 main(float3 p : ATTRIBUTE0, float4 x : ATTRIBUTE1, float4 y : ATTRIBUTE2, float4 z : ATTRIBUTE3,
            float4 w : ATTRIBUTE4) : SV_Position
{
    return float4(mad(p.x, x.x, mad(p.y, x.y, mad(p.z, x.z, x.w))),
                  mad(p.x, y.x, mad(p.y, y.y, mad(p.z, y.z, y.w))),
                  mad(p.x, z.x, mad(p.y, z.y, mad(p.z, z.z, z.w))),
                  mad(p.x, w.x, mad(p.y, w.y, mad(p.z, w.z, w.w))));
}
