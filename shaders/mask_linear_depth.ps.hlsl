#define CSM_FILTER 3
#include "private/mask.hlsl"
