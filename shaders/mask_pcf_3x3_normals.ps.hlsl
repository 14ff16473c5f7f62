#define CSM_FILTER 1
#define MASK_NORMALS
#include "private/mask.hlsl"
