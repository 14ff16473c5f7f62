#define CSM_FILTER 2
#include "private/mask.hlsl"
