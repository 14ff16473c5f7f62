/*
 * history.h: the constants of the history pass, for C and HLSL. All are float4.
 *
 * A pixel's place is (x, y, depth, 1): x and y in pixels, the depth as in the camera's depth buffer. Its span is what
 * changes linearly across the picture of a plane: 1 / view depth of a perspective camera, the view depth of an
 * orthographic one, each times a number of its picture's.
 */
#ifndef HISTORY_H
#define HISTORY_H

#define HISTORY_PLACE 0  /* four rows: a pixel's place to x, y and span in the earlier picture, each times w, and w */
#define HISTORY_PLANE 4  /* three rows: a plane on screen (as in CSM_M_PLANES) to the earlier picture's: x, y, span */
#define HISTORY_NORMAL 7 /* three rows: such a plane, or a texel of the engine's normals, to its normal in the world */
#define HISTORY_OWN 10   /* a pixel's place to its span in this picture, times w: of an orthographic camera w is 1 */
#define HISTORY_SIZE 11  /* width, height, 1 / width, 1 / height */
#define HISTORY_LIMITS 12 /* how far spans may be apart: a share of themselves, and more; cosine of the angle; frames */
#define HISTORY_CLEAR 13  /* depth of a pixel without a surface; 1: the mask shows how many frames a pixel has; unused */
#define HISTORY_COUNT 14

#endif
