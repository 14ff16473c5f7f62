// Moments that are written while casters are drawn, as most documents do it.
#include "csm_enums.h"
#include "drawn_moments.h"

static const float4 moments_row = float4(DRAWN_EXPONENT, DRAWN_EXPONENT_NEGATIVE, 0.0, 1.0); // one layer
#define CSM_MOMENTS_ROW moments_row
#define CSM_MOMENTS_WARP_ONLY
#define csm_float2 float2
#define csm_float4 float4
#define csm_mad mad
#include "csm_moments.inc"
#if ALPHA_MASK
#include "private/cut_out.hlsl"
#endif

#if CSM_FILTER == CSM_FILTER_VSM
float2 moments_of(float depth)
{
    return csm_moments_of(depth, 0.0).xy;
}
#define MOMENTS float2
#else
float4 moments_of(float depth)
{
    return csm_moments_of(depth, 0.0);
}
#define MOMENTS float4
#endif

MOMENTS main(
#if ALPHA_MASK
    float2 uv : TEXCOORD0,
#endif
    float4 screen : SV_Position) : SV_Target
{
#if ALPHA_MASK
    cut_out(uv);
#endif
    return moments_of(screen.z);
}
