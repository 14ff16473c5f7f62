#define CSM_FILTER 3
#define CSM_BIAS_MODE 0
#include "private/mask.hlsl"
