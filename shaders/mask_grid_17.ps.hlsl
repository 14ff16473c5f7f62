#define CSM_FILTER 9
#define CSM_BIAS_MODE 0
#include "private/mask.hlsl"
