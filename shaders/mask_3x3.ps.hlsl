#define CSM_FILTER_TAPS 3
#include "include/mask.hlsl"
