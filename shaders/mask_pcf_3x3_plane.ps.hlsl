#define CSM_FILTER 1
#define CSM_BIAS_MODE 1
#include "private/mask.hlsl"
