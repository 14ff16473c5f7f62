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

static void put_box(plan_light_block *block, const double basis[9], const plan_scene *scene, uint32_t slot,
                    uint32_t at) {
  const plan_instance *instance = &scene->instances[slot];
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

/* The boxes of the places from `first` on. */
static void make_block(plan_light_block *out, const plan_order *order, const double basis[9], const plan_scene *scene,
                       uint32_t first) {
  out->largest = 0.0;
  for (uint32_t i = 0; i < PLAN_BLOCK; ++i) {
    const uint32_t slot = plan_slot_at(order, first + i);
    if (slot < scene->slot_count)
      put_box(out, basis, scene, slot, i);
    else
      put_none(out, i);
  }
}

static uint32_t blocks_of(uint32_t slots) {
  return slots / PLAN_BLOCK + (slots % PLAN_BLOCK != 0);
}

/* Words of a bit for each block. */
static size_t filled_of(uint32_t slots) {
  return (blocks_of(slots) + PLAN_BLOCK - 1) / PLAN_BLOCK;
}

/* Boxes that there is room for: where each slot was, and is. */
static uint32_t changes_most(uint32_t slots) {
  return 2 * slots;
}

size_t plan_cache_size(uint32_t slot_count) {
  const size_t change = sizeof(plan_span_across) + sizeof(uint8_t);
  const size_t slot = 12 * sizeof(double) + 2 * sizeof(uint32_t) + sizeof(bool);
  return (size_t)blocks_of(slot_count) * sizeof(plan_light_block) + (size_t)slot_count * slot +
         (size_t)changes_most(slot_count) * change + filled_of(slot_count) * sizeof(uint64_t) +
         plan_order_size(slot_count);
}

plan_kept plan_cache_kept(const plan_cache *cache) {
  plan_light_block *blocks = cache->memory;
  if (!blocks) /* a scene that has had no instances */
    return (plan_kept){0};
  plan_kept kept = {.blocks = blocks, .transforms = (double(*)[12])(void *)(blocks + blocks_of(cache->slots))};
  kept.changed = (plan_span_across *)(void *)(kept.transforms + cache->slots);
  kept.filled = (uint64_t *)(void *)(kept.changed + changes_most(cache->slots));
  char *order = (char *)(kept.filled + filled_of(cache->slots));
  plan_order_find(&kept.order, order, cache->slots);
  kept.changed_at = (uint32_t *)(void *)(order + plan_order_size(cache->slots));
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

static bool is_filled(const plan_kept *kept, uint32_t block) {
  return kept->filled[block / PLAN_BLOCK] >> block % PLAN_BLOCK & 1;
}

const plan_light_block *plan_light_block_at(plan_light_block *made, const plan_kept *kept, const double basis[9],
                                            const plan_scene *scene, uint32_t block) {
  if (!kept->blocks) {
    make_block(made, &kept->order, basis, scene, block * PLAN_BLOCK);
    return made;
  }
  if (!is_filled(kept, block)) {
    make_block(&kept->blocks[block], &kept->order, basis, scene, block * PLAN_BLOCK);
    for (uint32_t i = 0; i < PLAN_BLOCK; ++i)
      if (kept->order.slots[block * PLAN_BLOCK + i] < scene->slot_count)
        put_transform(kept, basis, scene, kept->order.slots[block * PLAN_BLOCK + i]);
    kept->filled[block / PLAN_BLOCK] |= (uint64_t)1 << block % PLAN_BLOCK;
  }
  return &kept->blocks[block];
}

bool plan_kept_box(plan_span_across *out, const plan_kept *kept, uint32_t slot) {
  const uint32_t place = kept->order.places[slot], at = place % PLAN_BLOCK;
  const plan_light_block *block = &kept->blocks[place / PLAN_BLOCK];
  *out = (plan_span_across){.low = {block->low[0][at], block->low[1][at]},
                            .high = {block->high[0][at], block->high[1][at]}};
  return is_filled(kept, place / PLAN_BLOCK) && out->low[0] <= out->high[0];
}

/* ---- what changes, and what keeps changing ---- */

enum {
  CLOSE_PLANS = 4, /* what changes in two of so many plans keeps moving */
  REST_PLANS = 16  /* and is taken for still once it has not for so many */
};

/* Notes a caster's box among those of what changed. */
static void note_changed(const plan_kept *kept, plan_cache *cache, uint32_t place, uint8_t spoils) {
  const plan_light_block *block = &kept->blocks[place / PLAN_BLOCK];
  const uint32_t at = place % PLAN_BLOCK;
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

/* What comes to rest has to be drawn where it was left out; what lies in a block that is not filled was in no map. */
void plan_cache_rest(plan_cache *cache) {
  const plan_kept kept = plan_cache_kept(cache);
  uint32_t left = 0;
  for (uint32_t i = 0; i < cache->movers; ++i) {
    const uint32_t slot = kept.movers[i], place = kept.order.places[slot];
    kept.moves[slot] = cache->plans - kept.changed_at[slot] <= REST_PLANS;
    if (kept.moves[slot])
      kept.movers[left++] = slot;
    else if (is_filled(&kept, place / PLAN_BLOCK))
      note_changed(&kept, cache, place, PLAN_SPOILS_STILL);
  }
  cache->movers = left;
}

/* A block that has not been filled for this light met no map, so that no page was drawn of it as it was. */
static void put(const plan_kept *kept, plan_cache *cache, const plan_scene *scene, uint32_t slot) {
  const uint32_t place = kept->order.places[slot], block = place / PLAN_BLOCK;
  if (is_filled(kept, block))
    note_changed(kept, cache, place, spoiled_by(kept, slot));
  put_box(&kept->blocks[block], cache->basis, scene, slot, place % PLAN_BLOCK);
  put_transform(kept, cache->basis, scene, slot);
  note_move(kept, cache, slot);
  note_changed(kept, cache, place, spoiled_by(kept, slot));
  plan_order_note(&kept->order, slot);
  ++cache->strayed;
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

/* ---- filling it ---- */

static void forget_movers(const plan_kept *kept, plan_cache *cache) {
  cache->movers = 0;
  memset(kept->changed_at, 0, cache->slots * sizeof *kept->changed_at);
  memset(kept->moves, 0, cache->slots * sizeof *kept->moves);
}

/* What pages hold is not known from here on: a block that is not filled does not tell where its casters were. */
static void empty(const plan_kept *kept, plan_cache *cache) {
  memset(kept->filled, 0, filled_of(cache->slots) * sizeof *kept->filled);
  cache->unknown = true;
}

/* Putting all in order costs as much as some changes of each. So it waits for a quarter of them, and until it is of use. */
static bool is_disordered(const plan_cache *cache, const plan_order *order) {
  return cache->loose > order->block_count / 4 && cache->strayed > cache->slots / 4;
}

static void put_in_order(const plan_kept *kept, plan_cache *cache, const plan_scene *scene) {
  plan_order_make(&kept->order, scene, kept->blocks);
  empty(kept, cache);
  cache->loose = 0;
  cache->strayed = 0;
}

plan_kept plan_cache_fill(plan_cache *cache, const double basis[9], const plan_scene *scene) {
  if (!cache || !scene->identity || cache->slots < scene->slot_count)
    return (plan_kept){0};
  const plan_kept kept = plan_cache_kept(cache);
  const bool same_scene = cache->keeps && cache->identity == scene->identity;
  const bool same_light = same_scene && memcmp(cache->basis, basis, sizeof cache->basis) == 0;
  memcpy(cache->basis, basis, sizeof cache->basis);
  if (kept.blocks && !same_scene)
    forget_movers(&kept, cache);
  if (kept.blocks && !same_light)
    empty(&kept, cache);
  if (kept.blocks && same_scene) {
    refresh(&kept, cache, scene);
    cache->loose += plan_order_fit(&kept.order, scene);
  }
  if (kept.blocks && (!same_scene || is_disordered(cache, &kept.order)))
    put_in_order(&kept, cache, scene);
  cache->keeps = true;
  cache->identity = scene->identity;
  cache->revision = scene->revision;
  return kept;
}

plan_order plan_cache_order(const plan_cache *cache, const plan_scene *scene) {
  const bool knows = cache && cache->keeps && scene->identity && cache->identity == scene->identity &&
                     cache->revision == scene->revision;
  return knows ? plan_cache_kept(cache).order : (plan_order){0};
}
