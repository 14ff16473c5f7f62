/* moments.h: how the passes that make moments get their numbers, for C and for HLSL. */
#ifndef CSM_MOMENTS_PASS_H
#define CSM_MOMENTS_PASS_H

/* A tile is so many texels of the moments wide, and a group of threads takes one; a thread makes so many texels a side. */
#define MOMENTS_TILE 64
#define MOMENTS_THREADS 64
#define MOMENTS_RUN 8

/* A blur that reaches no farther has no loop. */
#define MOMENTS_SMALL_RADIUS 3
#define MOMENTS_RADIUS_MOST 32

/* Behind the constants of all cascades: eight rows, each with a cascade's side in texels of the moments; then the blur's
   weights from one end to the other in x, followed by zeros. */
#define MOMENTS_SIDES 0
#define MOMENTS_WEIGHTS 8
#define MOMENTS_COUNT (MOMENTS_WEIGHTS + 2 * MOMENTS_RADIUS_MOST + MOMENTS_RUN)

/* Of a dispatch: the first tile, groups in a row of them, slice of the depth range, slices in all; then the blur's radius,
   and the level that is made. */
#define MOMENTS_D_TILES 0
#define MOMENTS_D_PASS 1
#define MOMENTS_D_COUNT 2

/* How a tile is packed: x, y and cascade. */
#define MOMENTS_TILE_BITS 9

#endif
