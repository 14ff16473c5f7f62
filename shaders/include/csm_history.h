/*
 * csm_history.h: the constants of the history pass, for csm's own shaders and the plan. All are float4.
 *
 * A pixel's place is as in the mask's block of csm_constants.h. Its span is what changes linearly across the picture of a
 * plane: 1 / view depth of a perspective camera, the view depth of an orthographic one, each times a power of two of its
 * picture's.
 */
#ifndef CSM_HISTORY_H
#define CSM_HISTORY_H

#include "csm_constants.h"

#define CSM_H_PLACE 0  /* four rows: a pixel's place to x, y and span in the earlier picture, each times w, and w */
#define CSM_H_PLANE 4  /* three rows: a plane on screen, as in CSM_M_PLANES, to the earlier picture's: x, y and span */
#define CSM_H_NORMAL 7 /* three rows: such a plane, or a texel of the engine's normals, to its normal in the world */
#define CSM_H_SIZE CSM_M_SIZE /* width, height, 1 / width, 1 / height: where the mask's block has it */
#define CSM_H_OWN 11          /* a pixel's place to its span in this picture */
#define CSM_H_LIMITS 12 /* how far spans may be apart: a share of themselves, and more; cosine of the angle; frames */
/* Depth of a pixel without a surface; 1: the mask shows how many frames a pixel has; 1: the world's shadows rest; phase */
#define CSM_H_CLEAR 13
#define CSM_H_NOISE 14 /* the most that noise may be: its deviation */
#define CSM_H_COUNT 15

#define CSM_H_NO_FRAMES -2047.0 /* what a history has where it has no frames: shaders/private/history_frames.hlsl */

#endif
