#define CSM_FILTER 8
#define CSM_BIAS_MODE 1
#define MASK_NORMALS
#include "private/mask.hlsl"
