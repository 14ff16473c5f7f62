#define CSM_FILTER 3
#define MASK_NORMALS
#include "private/mask.hlsl"
