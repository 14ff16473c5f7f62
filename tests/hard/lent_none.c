/* lent_none.c: a program without an engine: every device is csm's own. */
#include "lent.h"

lent *lent_open(void) {
  return NULL;
}

void lent_close(lent *lent) {
  (void)lent;
}

void lent_rest(lent *lent) {
  (void)lent;
}

void lent_give(const lent *lent, csm_create_info *info) {
  (void)lent, (void)info;
}

void lent_frame(lent *lent, dice *dice, csm_frame *frame) {
  (void)lent, (void)dice, (void)frame;
}

void lent_step(lent *lent, dice *dice) {
  (void)lent, (void)dice;
}

uint64_t lent_done(const lent *lent, dice *dice) {
  (void)lent, (void)dice;
  return 0;
}

void lent_mesh(lent *lent, dice *dice, csm_mesh_info *info) {
  (void)lent, (void)dice, (void)info;
}

void lent_images(lent *lent, dice *dice, csm_mask_info *info) {
  (void)lent, (void)dice, (void)info;
}
