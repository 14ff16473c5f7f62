/* rays.h: rays to the light for the pixels that the mask has left undecided. */
#ifndef TECHNIQUES_RAYS_H
#define TECHNIQUES_RAYS_H

#include "techniques/technique.h"

extern const technique technique_rays;

#endif
