#define CSM_FILTER 4
#define CSM_BIAS_MODE 0
#include "private/mask.hlsl"
