#define CSM_FILTER 8
#define CSM_BIAS_MODE 0
#define MASK_NORMALS
#include "private/mask.hlsl"
