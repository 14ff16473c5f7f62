// Draws casters into one cascade's map: object space straight to the light's clip space, by the three rows of each
// instance. ALPHA_MASK: casters that an alpha mask cuts out.
#include "private/vertex.hlsl"

vertex_outputs main(float3 p : ATTRIBUTE0, float4 x : ATTRIBUTE1, float4 y : ATTRIBUTE2, float4 z : ATTRIBUTE3
#if ALPHA_MASK
                    , float2 uv : ATTRIBUTE4
#endif
)
{
    vertex_outputs o;
#if ALPHA_MASK
    o.uv = uv;
#endif
    o.position = float4(vertex_row(p, x), vertex_row(p, y), vertex_row(p, z), 1.0);
    return o;
}
