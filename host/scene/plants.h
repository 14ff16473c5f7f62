/* scene/plants.h: trees and rocks that scenes made by code place. Metres, standing on y = 0. */
#ifndef HOST_PLANTS_H
#define HOST_PLANTS_H

#include "scene/scene.h"

/* Each adds one mesh and returns its index. `seed` makes another of the kind. */
uint32_t plant_conifer(scene *s, const char *name, double height, uint32_t tiers, uint32_t seed);
uint32_t plant_broadleaf(scene *s, const char *name, double height, uint32_t crowns, uint32_t seed);
uint32_t plant_dead_tree(scene *s, const char *name, double height, uint32_t seed);
uint32_t plant_bush(scene *s, const char *name, double height, uint32_t seed);
uint32_t plant_rock(scene *s, const char *name, const double radius[3], uint32_t subdivisions, uint32_t seed);

#endif
