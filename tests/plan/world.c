#include "world.h"

#include <stdlib.h>
#include <string.h>

void world_begin(world *w, uint64_t seed) {
  memset(w, 0, sizeof *w);
  w->random.value = seed;
  w->reach = 60.0;
  w->handles = (handle_table){.places = w->places, .key = handles_key(w, seed), .capacity = WORLD_MESHES};
  w->meshes = (instances_meshes){.handles = &w->handles, .bounds = w->bounds, .users = w->users};
  for (int i = 0; i < WORLD_MESHES; ++i) {
    w->names[i] = handles_take(&w->handles);
    plan_bounds_make(&w->bounds[i], (float[]){-1, 0, -1}, (float[]){1, (float)i, 1});
  }
  instances_begin(&w->store, &(instances_memory){.allocate = support_allocate, .release = support_release},
                  handles_key(&w->store, seed));
  for (int i = 0; i < 2; ++i)
    w->memory[i] = memory_make(2 * WORLD_MOST, WORLD_MESHES, PLAN_WINDOWS_MOST);
}

void world_end(world *w) {
  instances_end(&w->store, &w->meshes);
  memory_free(w->memory[0]);
  memory_free(w->memory[1]);
}

static void some_transforms(world *w, float (*rows)[12], uint32_t count) {
  for (uint32_t i = 0; i < count; ++i)
    for (int k = 0; k < 12; ++k)
      rows[i][k] =
          (float)(k % 4 == 3 ? random_between(&w->random, -w->reach, w->reach) : random_between(&w->random, -2.0, 2.0));
}

void world_change(world *w) {
  float rows[WORLD_MOST][12];
  csm_mesh meshes[WORLD_MOST];
  uint32_t flags[WORLD_MOST];
  instances_error error;
  const uint32_t kind = random_below(&w->random, 6), some = random_below(&w->random, 120);
  instances_batch batch = {.count = some < w->count ? some : w->count, .ids = w->ids};
  some_transforms(w, rows, WORLD_MOST);
  for (int i = 0; i < WORLD_MOST; ++i) {
    meshes[i] = w->names[random_below(&w->random, WORLD_MESHES)];
    flags[i] = (uint32_t[]){0, 0, PLAN_CASTS_ONLY, PLAN_RECEIVES_ONLY, PLAN_HIDDEN}[random_below(&w->random, 5)];
  }
  const instances_transforms transforms = {.first = rows, .stride = sizeof *rows, .floats = true};
  if (kind < 2 && w->count + some <= WORLD_MOST) {
    batch.count = some;
    batch.transforms = transforms;
    batch.meshes = (instances_column){.first = meshes, .stride = sizeof *meshes};
    assert_int_equal(instances_add(&w->store, &w->meshes, &batch, &w->ids[w->count], &error), CSM_SUCCESS);
    w->count += some;
  } else if (kind < 4) {
    batch.transforms = transforms;
    if (kind == 3)
      batch.flags = (instances_column){.first = flags, .stride = sizeof *flags};
    assert_int_equal(instances_change(&w->store, &w->meshes, &batch, &error), CSM_SUCCESS);
  } else if (kind == 4) {
    assert_int_equal(instances_remove(&w->store, &w->meshes, &batch, &error), CSM_SUCCESS);
    w->count -= batch.count;
    memmove(w->ids, w->ids + batch.count, w->count * sizeof *w->ids);
  } else {
    const uint32_t mesh = random_below(&w->random, WORLD_MESHES);
    plan_bounds_make(&w->bounds[mesh], (float[]){-3, -1, -2}, (float[]){1, (float)some / 10.0f, 2});
    instances_mesh_changed(&w->store, &w->meshes, mesh);
  }
}

void world_reserve_cache(plan_cache *cache, uint32_t slots) {
  if (cache->slots >= slots)
    return;
  free(cache->memory);
  *cache = (plan_cache){.memory = support_allocate(NULL, plan_cache_size(slots), 64), .slots = slots};
}
