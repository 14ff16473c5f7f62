/* lent.h: an engine's device for random calls. A program has lent.c and a rig, or lent_none.c. */
#ifndef LENT_H
#define LENT_H

#include "csm/csm.h"
#include "dice.h"

typedef struct lent lent;

lent *lent_open(void);
void lent_close(lent *lent);
/* Between worlds: runs what was recorded. */
void lent_rest(lent *lent);

void lent_give(const lent *lent, csm_create_info *info);
/* Takes the frame's number and command buffer: those of the frame that is being recorded, or wrong ones. */
void lent_frame(lent *lent, dice *dice, csm_frame *frame);
/* Goes on: begins, splits, ends or runs a frame. */
void lent_step(lent *lent, dice *dice);
/* A frame's number that is done. */
uint64_t lent_done(const lent *lent, dice *dice);
/* A mesh in the engine's buffers, mostly a good one. */
void lent_mesh(lent *lent, dice *dice, csm_mesh_info *info);
/* Images for a mask of WORLD_WIDTH x WORLD_HEIGHT, mostly good ones. */
void lent_images(lent *lent, dice *dice, csm_mask_info *info);

#endif
