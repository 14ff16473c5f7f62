#define CSM_FILTER 9
#include "private/mask.hlsl"
