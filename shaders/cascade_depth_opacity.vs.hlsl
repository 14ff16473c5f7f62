// As cascade_depth, for casters that an opacity texture cuts out.
struct Vertex
{
    float2 uv : TEXCOORD0;
    float4 position : SV_Position;
};

Vertex main(float3 p : ATTRIBUTE0, float4 x : ATTRIBUTE1, float4 y : ATTRIBUTE2, float4 z : ATTRIBUTE3,
            float2 uv : ATTRIBUTE4)
{
    Vertex v;
    v.uv = uv;
    v.position = float4(mad(p.x, x.x, mad(p.y, x.y, mad(p.z, x.z, x.w))),
                        mad(p.x, y.x, mad(p.y, y.y, mad(p.z, y.z, y.w))),
                        mad(p.x, z.x, mad(p.y, z.y, mad(p.z, z.z, z.w))), 1.0);
    return v;
}
