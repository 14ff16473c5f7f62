/* moments.h: moments of the maps' depths, which are mixed before they are read: one image of layers. */
#ifndef TECHNIQUES_MOMENTS_H
#define TECHNIQUES_MOMENTS_H

#include "techniques/technique.h"

extern const technique technique_moments;

/* The image of all moments; NULL with a configuration whose filter reads none. */
gpu_image *moments_image(const technique_set *cascades, const csm_config *config);

#endif
