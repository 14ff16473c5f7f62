/* maps.h: the cascades' depth maps: one image of layers or an atlas, drawn with the plan's lists of casters. */
#ifndef TECHNIQUES_MAPS_H
#define TECHNIQUES_MAPS_H

#include "techniques/technique.h"

extern const technique technique_maps;

/* The image of all maps. */
gpu_image *maps_image(const technique_set *cascades);

/* What an engine's callback draws into, but for struct_size. Errors: those of the device. */
csm_result maps_draw_target(const technique_set *cascades, device *device, csm_draw_target *out);

#endif
