#define CSM_FILTER 9
#define CSM_BIAS_MODE 1
#include "private/mask.hlsl"
