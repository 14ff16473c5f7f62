/* ranges.h: the nearest depths around each block of a map's texels, by which a search for blockers knows how far to look. */
#ifndef TECHNIQUES_RANGES_H
#define TECHNIQUES_RANGES_H

#include "techniques/technique.h"

extern const technique technique_ranges;

/* The image of all ranges, a layer for each cascade; NULL with a configuration without them (plan_has_ranges). */
gpu_image *ranges_image(const technique_set *cascades, const csm_config *config);

#endif
