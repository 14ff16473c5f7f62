/* mask.h: the screen-space mask: what of a picture is lit. */
#ifndef TECHNIQUES_MASK_H
#define TECHNIQUES_MASK_H

#include "techniques/technique.h"

extern const technique technique_mask;

#endif
