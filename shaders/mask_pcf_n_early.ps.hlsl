#define CSM_FILTER 6
#include "private/mask.hlsl"
