// The debug view of rays, as csm.h defines it, before they are sent: pixels that need none are 0.
#define MASK_GENERAL 1
#define CSM_BIAS_MODE CSM_BIAS_RECEIVER_PLANE
#define MASK_DECIDED(lit) 0.0
#include "mask.ps.hlsl"
