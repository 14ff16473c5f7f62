#define CSM_FILTER 4
#include "private/mask.hlsl"
