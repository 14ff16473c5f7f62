/* cache.c: casters' boxes and transforms in light space, kept from plan to plan. */
#include "plan/internal.h"

#include <string.h>

/* A box that meets nothing. */
static void put_none(plan_light_block *block, uint32_t at) {
  const double beyond = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    block->low[axis][at] = beyond;
    block->high[axis][at] = -beyond;
  }
}

static void put_box(plan_light_block *block, const double basis[9], const plan_scene *scene, uint32_t slot) {
  const plan_instance *instance = &scene->instances[slot];
  const uint32_t at = slot % PLAN_BLOCK;
  if (!plan_casts(instance)) {
    put_none(block, at);
    return;
  }
  double square = 0.0;
  plan_placed box;
  plan_place(&box, instance, &scene->meshes[instance->mesh]);
  for (int axis = 0; axis < 3; ++axis) {
    const double center = plan_dot(box.center, &basis[axis * 3]), extent = plan_reach(&box, &basis[axis * 3]);
    block->low[axis][at] = center - extent;
    block->high[axis][at] = center + extent;
    square += 4.0 * extent * extent;
  }
  block->largest = square > block->largest ? square : block->largest;
}

void plan_light_block_make(plan_light_block *out, const double basis[9], const plan_scene *scene, uint32_t first) {
  out->largest = 0.0;
  for (uint32_t i = 0; i < PLAN_BLOCK; ++i)
    if (first + i < scene->slot_count)
      put_box(out, basis, scene, first + i);
    else
      put_none(out, i);
}

static uint32_t blocks_of(uint32_t slots) {
  return slots / PLAN_BLOCK + (slots % PLAN_BLOCK != 0);
}

/* Boxes that there is room for: where each slot was, and is. */
static uint32_t changes_most(uint32_t slots) {
  return 2 * slots;
}

size_t plan_cache_size(uint32_t slot_count) {
  const size_t change = sizeof(plan_span_across) + sizeof(uint8_t);
  const size_t slot = 12 * sizeof(double) + 2 * sizeof(uint32_t) + sizeof(bool);
  return (size_t)blocks_of(slot_count) * sizeof(plan_light_block) + (size_t)slot_count * slot +
         (size_t)changes_most(slot_count) * change;
}

plan_kept plan_cache_kept(const plan_cache *cache) {
  plan_light_block *blocks = cache->memory;
  if (!blocks) /* a scene that has had no instances */
    return (plan_kept){0};
  plan_kept kept = {.blocks = blocks, .transforms = (double(*)[12])(void *)(blocks + blocks_of(cache->slots))};
  kept.changed = (plan_span_across *)(void *)(kept.transforms + cache->slots);
  kept.changed_at = (uint32_t *)(void *)(kept.changed + changes_most(cache->slots));
  kept.movers = kept.changed_at + cache->slots;
  kept.spoils = (uint8_t *)(kept.movers + cache->slots);
  kept.moves = (bool *)(kept.spoils + changes_most(cache->slots));
  return kept;
}

static void put_transform(const plan_kept *kept, const double basis[9], const plan_scene *scene, uint32_t slot) {
  const plan_instance *instance = &scene->instances[slot];
  if (plan_casts(instance))
    plan_light_transform(kept->transforms[slot], basis, instance, &scene->meshes[instance->mesh]);
}

/* ---- what changes, and what keeps changing ---- */

enum {
  CLOSE_PLANS = 4, /* what changes in two of so many plans keeps moving */
  REST_PLANS = 16  /* and is taken for still once it has not for so many */
};

/* Notes a caster's box among those of what changed. */
static void note_changed(const plan_kept *kept, plan_cache *cache, uint32_t slot, uint8_t spoils) {
  const plan_light_block *block = &kept->blocks[slot / PLAN_BLOCK];
  const uint32_t at = slot % PLAN_BLOCK;
  cache->unknown |= cache->changed == changes_most(cache->slots);
  if (cache->unknown || !(block->low[0][at] <= block->high[0][at]))
    return;
  kept->spoils[cache->changed] = spoils;
  kept->changed[cache->changed++] = (plan_span_across){.low = {block->low[0][at], block->low[1][at]},
                                                       .high = {block->high[0][at], block->high[1][at]}};
}

static uint8_t spoiled_by(const plan_kept *kept, uint32_t slot) {
  return kept->moves[slot] ? PLAN_SPOILS_PAGES : PLAN_SPOILS_PAGES | PLAN_SPOILS_STILL;
}

static void note_move(const plan_kept *kept, plan_cache *cache, uint32_t slot) {
  const uint32_t last = kept->changed_at[slot];
  kept->changed_at[slot] = cache->plans;
  if (kept->moves[slot] || last == 0 || last == cache->plans || cache->plans - last > CLOSE_PLANS)
    return;
  kept->moves[slot] = true;
  kept->movers[cache->movers++] = slot;
}

void plan_cache_forget_changes(plan_cache *cache) {
  cache->changed = 0;
  cache->unknown = false;
}

/* What comes to rest has to be drawn where it was left out. */
void plan_cache_rest(plan_cache *cache) {
  const plan_kept kept = plan_cache_kept(cache);
  uint32_t left = 0;
  for (uint32_t i = 0; i < cache->movers; ++i) {
    const uint32_t slot = kept.movers[i];
    kept.moves[slot] = cache->plans - kept.changed_at[slot] <= REST_PLANS;
    if (kept.moves[slot])
      kept.movers[left++] = slot;
    else
      note_changed(&kept, cache, slot, PLAN_SPOILS_STILL);
  }
  cache->movers = left;
}

static void put(const plan_kept *kept, plan_cache *cache, const plan_scene *scene, uint32_t slot) {
  note_changed(kept, cache, slot, spoiled_by(kept, slot));
  put_box(&kept->blocks[slot / PLAN_BLOCK], cache->basis, scene, slot);
  put_transform(kept, cache->basis, scene, slot);
  note_move(kept, cache, slot);
  note_changed(kept, cache, slot, spoiled_by(kept, slot));
}

/* ---- filling it ---- */

static void forget_movers(const plan_kept *kept, plan_cache *cache) {
  cache->movers = 0;
  memset(kept->changed_at, 0, cache->slots * sizeof *kept->changed_at);
  memset(kept->moves, 0, cache->slots * sizeof *kept->moves);
}

static void fill(const plan_kept *kept, const plan_cache *cache, const plan_scene *scene) {
  for (uint32_t i = 0; i < blocks_of(cache->slots); ++i)
    plan_light_block_make(&kept->blocks[i], cache->basis, scene, i * PLAN_BLOCK);
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot)
    put_transform(kept, cache->basis, scene, slot);
}

/* From the journal, or, where that does not reach back so far, from the revision of every slot. */
static void refresh(const plan_kept *kept, plan_cache *cache, const plan_scene *scene) {
  if (cache->revision >= scene->journal_from) {
    for (uint64_t change = cache->revision; change < scene->revision; ++change) {
      const uint32_t slot = scene->journal[change & (scene->journal_size - 1)];
      put(kept, cache, scene, slot);
    }
    return;
  }
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot)
    if (scene->revisions[slot] > cache->revision)
      put(kept, cache, scene, slot);
}

plan_kept plan_cache_fill(plan_cache *cache, const double basis[9], const plan_scene *scene) {
  if (!cache || !scene->identity || cache->slots < scene->slot_count)
    return (plan_kept){0};
  const plan_kept kept = plan_cache_kept(cache);
  const bool same_scene = cache->keeps && cache->identity == scene->identity;
  if (!same_scene && kept.blocks)
    forget_movers(&kept, cache);
  if (same_scene && memcmp(cache->basis, basis, sizeof cache->basis) == 0) {
    refresh(&kept, cache, scene);
  } else {
    memcpy(cache->basis, basis, sizeof cache->basis);
    fill(&kept, cache, scene);
    cache->unknown = true;
  }
  cache->keeps = true;
  cache->identity = scene->identity;
  cache->revision = scene->revision;
  return kept;
}
