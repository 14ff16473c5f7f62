#define CSM_FILTER 2
#define CSM_BIAS_MODE 0
#include "private/mask.hlsl"
