#define CSM_FILTER 4
#define CSM_BIAS_MODE 1
#include "private/mask.hlsl"
