#define CSM_FILTER 7
#define CSM_BIAS_MODE 1
#include "private/mask.hlsl"
