#define CSM_FILTER 8
#define MASK_NORMALS
#include "private/mask.hlsl"
