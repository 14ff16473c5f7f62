#define CSM_FILTER_TAPS 1
#include "include/mask.hlsl"
