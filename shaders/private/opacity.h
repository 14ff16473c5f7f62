/* opacity.h: the constants of an alpha-tested mesh, for C and HLSL. All are float4. */
#ifndef OPACITY_H
#define OPACITY_H

#define OPACITY_SIZE 0 /* width, height, cutoff, unused */
#define OPACITY_WRAP 1 /* CSM_WRAP_* of u and v, unused */
#define OPACITY_COUNT 2

#define OPACITY_CLAMP 1.0
#define OPACITY_MIRROR 2.0

#endif
