// An engine's own casters: object space to a cascade's clip space by three rows of each instance, in the arithmetic
// that csm uses, so that the maps are the same bit for bit.
float4 main(float3 p : ATTRIBUTE0, float4 x : ATTRIBUTE1, float4 y : ATTRIBUTE2, float4 z : ATTRIBUTE3) : SV_Position
{
    return float4(mad(p.x, x.x, mad(p.y, x.y, mad(p.z, x.z, x.w))),
                  mad(p.x, y.x, mad(p.y, y.y, mad(p.z, y.z, y.w))),
                  mad(p.x, z.x, mad(p.y, z.y, mad(p.z, z.z, z.w))), 1.0);
}
