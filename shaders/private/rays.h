/* rays.h: what the programs that send rays share, for C and HLSL. */
#ifndef RAYS_H
#define RAYS_H

/* What a mask holds where a ray is to decide: a number that every format of masks has. */
#define RAYS_UNDECIDED (128.0 / 255.0)

/* The list of pixels, as whole numbers: how many, groups of RAYS_THREADS of them along x, y and z, then each as x + 65536 y. */
#define RAYS_COUNT 0
#define RAYS_GROUPS 1
#define RAYS_FIRST 4

/* Pixels on a side of what a group looks through for them; threads of a group that sends rays. */
#define RAYS_TILE 8
#define RAYS_THREADS 64
#define RAYS_MOST_GROUPS 65535

#endif
