/* calls_scenes.h: what frames need of instances. */
#ifndef CALLS_SCENES_H
#define CALLS_SCENES_H

#include "world.h"

/* Fills the world's list with instances, mostly fewer than `most`; returns how many. */
uint32_t world_fill_list(world *w, uint32_t most);

#endif
