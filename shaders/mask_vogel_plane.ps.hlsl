#define CSM_FILTER 8
#define CSM_BIAS_MODE 1
#include "private/mask.hlsl"
