/* alpha_mask.h: the constants of an alpha-tested mesh, for C and HLSL. All are float4. */
#ifndef ALPHA_MASK_H
#define ALPHA_MASK_H

#define ALPHA_MASK_SIZE 0 /* width, height, cutoff, unused */
#define ALPHA_MASK_WRAP 1 /* CSM_WRAP_* of u and v, unused */
#define ALPHA_MASK_COUNT 2

#define ALPHA_MASK_CLAMP 1.0
#define ALPHA_MASK_MIRROR 2.0

#endif
