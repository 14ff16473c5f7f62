// All that the mask does but reading the maps: position, normal, cascade, bias, and the texel and depth to compare.
#define CSM_FILTER 2
#define CSM_TEXEL_LIT(texel, layer, reference) float(reference + texel.x + texel.y + layer < 1e30)
#include "../../../shaders/private/mask.hlsl"
