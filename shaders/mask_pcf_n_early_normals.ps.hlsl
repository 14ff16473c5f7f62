#define CSM_FILTER 6
#define MASK_NORMALS
#include "private/mask.hlsl"
