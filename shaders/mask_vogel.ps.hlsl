#define CSM_FILTER 8
#include "private/mask.hlsl"
