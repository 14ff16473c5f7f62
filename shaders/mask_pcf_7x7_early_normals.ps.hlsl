#define CSM_FILTER 5
#define MASK_NORMALS
#include "private/mask.hlsl"
