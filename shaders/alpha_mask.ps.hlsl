// Casters that an alpha mask cuts out.
#include "private/cut_out.hlsl"

void main(float2 uv : TEXCOORD0)
{
    cut_out(uv);
}
