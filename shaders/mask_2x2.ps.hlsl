#define CSM_FILTER_TAPS 1
#include "private/mask.hlsl"
