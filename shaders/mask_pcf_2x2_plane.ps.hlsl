#define CSM_FILTER 0
#define CSM_BIAS_MODE 1
#include "private/mask.hlsl"
