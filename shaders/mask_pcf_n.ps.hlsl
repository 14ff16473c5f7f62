#define CSM_FILTER 6
#define CSM_BIAS_MODE 0
#include "private/mask.hlsl"
