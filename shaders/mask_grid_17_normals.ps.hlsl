#define CSM_FILTER 9
#define CSM_BIAS_MODE 0
#define MASK_NORMALS
#include "private/mask.hlsl"
