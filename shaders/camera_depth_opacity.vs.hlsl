// As camera_depth, for surfaces that an opacity texture cuts out.
struct Vertex
{
    float2 uv : TEXCOORD0;
    float4 position : SV_Position;
};

Vertex main(float3 p : ATTRIBUTE0, float4 x : ATTRIBUTE1, float4 y : ATTRIBUTE2, float4 z : ATTRIBUTE3,
            float4 w : ATTRIBUTE4, float2 uv : ATTRIBUTE5)
{
    Vertex v;
    v.uv = uv;
    v.position = float4(mad(p.x, x.x, mad(p.y, x.y, mad(p.z, x.z, x.w))),
                        mad(p.x, y.x, mad(p.y, y.y, mad(p.z, y.z, y.w))),
                        mad(p.x, z.x, mad(p.y, z.y, mad(p.z, z.z, z.w))),
                        mad(p.x, w.x, mad(p.y, w.y, mad(p.z, w.z, w.w))));
    return v;
}
