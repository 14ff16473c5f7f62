/* world.h: a store of instances that change at random, for plans from frame to frame. */
#ifndef TEST_PLAN_WORLD_H
#define TEST_PLAN_WORLD_H

#include "support.h"

#include "scene/instances.h"

enum { WORLD_MESHES = 6, WORLD_MOST = 300 };

typedef struct world {
  random_state random;
  handle_place places[WORLD_MESHES];
  handle_table handles;
  plan_bounds bounds[WORLD_MESHES];
  uint32_t users[WORLD_MESHES];
  instances_meshes meshes;
  csm_mesh names[WORLD_MESHES];
  instances store;
  uint64_t ids[WORLD_MOST];
  uint32_t count;
  double reach;           /* instances lie so far from the origin along each axis, in metres */
  plan_memory *memory[2]; /* for plans */
} world;

void world_begin(world *w, uint64_t seed);
void world_end(world *w);
/* Adds, moves, hides, removes, or gives a mesh new bounds. */
void world_change(world *w);
/* Room for so many slots; one that grows is empty. */
void world_reserve_cache(plan_cache *cache, uint32_t slots);

#endif
