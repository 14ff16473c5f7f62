// All that the mask does but reading the maps: position, normal, cascade, bias, and the texel and depth to compare.
#define CSM_FILTER 2
#define CSM_BIAS_MODE 0
#define CSM_EARLY_OUT 0
#define MASK_GENERAL 0
#define MASK_NORMALS 0
#define CSM_TEXEL_LIT(texel, layer, reference) float(reference + texel.x + texel.y + layer < 1e30)
#include "../../../shaders/mask.ps.hlsl"
