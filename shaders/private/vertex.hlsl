// What a vertex of a caster or of a surface hands on: its position, and where it is in the texture that cuts it out.
struct vertex_outputs
{
#if ALPHA_MASK
    float2 uv : TEXCOORD0;
#endif
    float4 position : SV_Position;
};

// One mad chain with the constant innermost, which every compiler keeps, so that all backends rasterise alike.
float vertex_row(float3 p, float4 row)
{
    return mad(p.x, row.x, mad(p.y, row.y, mad(p.z, row.z, row.w)));
}
