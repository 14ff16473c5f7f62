// forward.ps.hlsl, which gathers four texels at once.
#define CSM_POINT csm_point
#include "forward.ps.hlsl"
