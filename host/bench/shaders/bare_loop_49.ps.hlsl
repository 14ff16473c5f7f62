// The 7 x 7 filter as it is written first: 49 bilinear comparisons by the sampler, a texel apart.
#define CSM_FILTER 5
#define CSM_BIAS_MODE 0
#define CSM_EARLY_OUT 0
#define MASK_GENERAL 0
#define MASK_NORMALS 0
SamplerComparisonState csm_comparison : register(s2);
#define CSM_COMPARE(uv, layer, reference) csm_maps.SampleCmpLevelZero(csm_comparison, float3(uv, layer), reference)
#define CSM_FILTER_BODY(spot)                                                                                          \
    float lit = 0.0, reference = csm_reference(spot.depth);                                                              \
    float2 middle = spot.place + spot.rect.xy + 0.5;                                                                   \
    [unroll] for (int y = -3; y <= 3; ++y)                                                                             \
    {                                                                                                                  \
        [unroll] for (int x = -3; x <= 3; ++x)                                                                         \
            lit += CSM_COMPARE((middle + float2(float(x), float(y))) * csm_c[CSM_C_PARAMS].zw, spot.rect.w, reference); \
    }                                                                                                                  \
    return lit * (1.0 / 49.0);
#include "../../../shaders/mask.ps.hlsl"
