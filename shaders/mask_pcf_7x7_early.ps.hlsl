#define CSM_FILTER 5
#include "private/mask.hlsl"
