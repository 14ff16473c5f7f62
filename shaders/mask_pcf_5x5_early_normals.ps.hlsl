#define CSM_FILTER 4
#define MASK_NORMALS
#include "private/mask.hlsl"
