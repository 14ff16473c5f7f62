/* ranges.h: what the passes that make ranges and the masks that read them share, for C and HLSL. */
#ifndef CSM_RANGES_PASS_H
#define CSM_RANGES_PASS_H

/* Texels on a side of a block; threads on a side of a group, each of which takes a block. */
#define RANGES_BLOCK 16
#define RANGES_THREADS 8

/* Ranges are four squares around a block: how many blocks each reaches to a side, the last one the farthest. */
#define RANGES_WIDTH_0 1
#define RANGES_WIDTH_1 2
#define RANGES_WIDTH_2 4
#define RANGES_WIDTH_3 9

/* How far from any place in a block, in texels, all lies in a square that reaches `width` blocks: a sample reads a texel more than
   it reaches, and its direction is a rounded one. */
#define RANGES_REACH(width) (RANGES_BLOCK * (width)-1.5)

#endif
