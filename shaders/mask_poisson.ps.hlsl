#define CSM_FILTER 7
#include "private/mask.hlsl"
