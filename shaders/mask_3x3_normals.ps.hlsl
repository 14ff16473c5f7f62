#define CSM_FILTER_TAPS 3
#define CSM_BIAS_MODE 1
#define MASK_NORMALS
#include "private/mask.hlsl"
