#define CSM_FILTER_TAPS 3
#define MASK_NORMALS
#include "private/mask.hlsl"
