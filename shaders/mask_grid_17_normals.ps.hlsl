#define CSM_FILTER 9
#define MASK_NORMALS
#include "private/mask.hlsl"
