#define CSM_FILTER 8
#define CSM_BIAS_MODE 0
#include "private/mask.hlsl"
