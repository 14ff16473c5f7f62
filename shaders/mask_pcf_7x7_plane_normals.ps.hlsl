#define CSM_FILTER 5
#define CSM_BIAS_MODE 1
#define CSM_EARLY_OUT 0
#define MASK_NORMALS
#include "private/mask.hlsl"
