#define CSM_FILTER 7
#define MASK_NORMALS
#include "private/mask.hlsl"
