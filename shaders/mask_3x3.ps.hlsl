#define CSM_FILTER_TAPS 3
#include "private/mask.hlsl"
