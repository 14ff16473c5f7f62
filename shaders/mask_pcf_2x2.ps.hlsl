#define CSM_FILTER 0
#include "private/mask.hlsl"
