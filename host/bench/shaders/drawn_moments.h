/* drawn_moments.h: the exponents of moments that are written while casters are drawn, for C and for HLSL. */
#ifndef HOST_DRAWN_MOMENTS_H
#define HOST_DRAWN_MOMENTS_H

#define DRAWN_EXPONENT 40.0
#define DRAWN_EXPONENT_NEGATIVE 5.0

#endif
