// Draws what the camera sees into its depth image: object space to clip space by the four rows of each instance. ALPHA_MASK:
// surfaces that an alpha mask cuts out.
#include "private/vertex.hlsl"

vertex_outputs main(float3 p : ATTRIBUTE0, float4 x : ATTRIBUTE1, float4 y : ATTRIBUTE2, float4 z : ATTRIBUTE3,
                    float4 w : ATTRIBUTE4
#if ALPHA_MASK
                    , float2 uv : ATTRIBUTE5
#endif
)
{
    vertex_outputs o;
#if ALPHA_MASK
    o.uv = uv;
#endif
    o.position = float4(vertex_row(p, x), vertex_row(p, y), vertex_row(p, z), vertex_row(p, w));
    return o;
}
