/* mask_count.h: how many pixels of a view's mask are neither lit nor dark, read back once their frame is done: a budget's errors
   are told from them. */
#ifndef TECHNIQUES_MASK_COUNT_H
#define TECHNIQUES_MASK_COUNT_H

#include "techniques/technique.h"

extern const technique technique_mask_count;

/* Takes over what has come back: of the pixels that face the light, the share that is unsure. Negative: nothing is known. */
double mask_count_unsure(const technique_set *view, const device *device);

#endif
