#define CSM_FILTER 6
#define CSM_BIAS_MODE 0
#define CSM_EARLY_OUT 0
#define MASK_NORMALS
#include "private/mask.hlsl"
