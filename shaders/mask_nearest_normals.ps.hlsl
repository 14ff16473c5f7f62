#define CSM_FILTER 2
#define CSM_BIAS_MODE 0
#define MASK_NORMALS
#include "private/mask.hlsl"
