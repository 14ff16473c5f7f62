// One triangle over the whole mask, with what is the same for all of its pixels.
#include "csm_constants.h"
#include "private/mask_inputs.hlsl"

cbuffer cascades_block : register(b0)
{
    float4 csm_c[CSM_C_COUNT];
};
cbuffer mask_block : register(b1)
{
    float4 mask_c[CSM_M_COUNT];
};

#include "private/mask_inputs_fill.hlsl"

mask_inputs main(uint vertex : SV_VertexID)
{
    return mask_inputs_of(float4(vertex == 1 ? 3.0 : -1.0, vertex == 2 ? 3.0 : -1.0, 0.0, 1.0));
}
