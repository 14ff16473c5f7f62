#define CSM_FILTER 6
#define CSM_BIAS_MODE 1
#define CSM_EARLY_OUT 0
#include "private/mask.hlsl"
