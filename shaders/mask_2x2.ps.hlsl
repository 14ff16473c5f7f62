#define CSM_FILTER_TAPS 1
#define CSM_BIAS_MODE 1
#include "private/mask.hlsl"
