#define CSM_FILTER 2
#define CSM_BIAS_MODE 1
#define MASK_NORMALS
#include "private/mask.hlsl"
