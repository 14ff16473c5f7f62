#define CSM_FILTER 2
#define MASK_NORMALS
#include "private/mask.hlsl"
