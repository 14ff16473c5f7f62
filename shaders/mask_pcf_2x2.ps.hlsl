#define CSM_FILTER 0
#define CSM_BIAS_MODE 0
#include "private/mask.hlsl"
