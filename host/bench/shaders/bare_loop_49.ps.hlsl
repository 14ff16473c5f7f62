// The 7 x 7 filter as it is written first: 49 bilinear comparisons by the sampler, a texel apart.
SamplerComparisonState csm_comparison : register(s1);
#define CSM_COMPARE(uv, layer, reference) csm_maps.SampleCmpLevelZero(csm_comparison, float3(uv, layer), reference)
#define CSM_FILTER_BODY(spot)                                                                                          \
    float lit = 0.0, reference = clamp(spot.depth, 0.0, 1.0);                                                          \
    float2 middle = spot.place + spot.rect.xy + 0.5;                                                                   \
    [unroll] for (int y = -3; y <= 3; ++y)                                                                             \
    {                                                                                                                  \
        [unroll] for (int x = -3; x <= 3; ++x)                                                                         \
            lit += CSM_COMPARE((middle + float2(float(x), float(y))) * csm_c[CSM_C_IMAGE].xy, spot.rect.w, reference); \
    }                                                                                                                  \
    return lit * (1.0 / 49.0);
#include "../../../shaders/private/mask.hlsl"
