#define CSM_FILTER 0
#define MASK_NORMALS
#include "private/mask.hlsl"
