#define CSM_FILTER 1
#include "private/mask.hlsl"
