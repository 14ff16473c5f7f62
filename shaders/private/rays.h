/* rays.h: what the programs that send rays share, for C and HLSL. */
#ifndef RAYS_H
#define RAYS_H

/*
 * What a mask holds where a ray is to decide: level 64 + 8 k of 255, k being 15 times the share that the map calls lit. Every
 * format of masks has these numbers. Fading shadows have them too, and cost a ray that changes nothing.
 */
#define RAYS_UNDECIDED 64.0
#define RAYS_UNDECIDED_STEP 8.0
#define RAYS_SHARES 15.0

/*
 * The list of pixels, as whole numbers: how many; groups of RAYS_THREADS of them along x, y and z; how many of them the map
 * decided after all; of a view, nodes and triangles in 16ths; then each pixel as x + 2^14 y + 2^28 k. Behind the last one, where
 * rays are shared: what each pixel's mask becomes, in 255ths.
 */
#define RAYS_COUNT 0
#define RAYS_GROUPS 1
#define RAYS_BY_MAP 4
#define RAYS_NODES 5
#define RAYS_TRIANGLES 6
#define RAYS_FIRST 8
#define RAYS_PLACE_BITS 14
#define RAYS_SHARE_BIT 28

/* Threads on a side of a group that looks through pixels for them, four pixels a thread; threads of a group that sends rays. */
#define RAYS_LOOK 8
#define RAYS_TILE (2 * RAYS_LOOK)
#define RAYS_THREADS 64
#define RAYS_MOST_GROUPS 65535

#endif
