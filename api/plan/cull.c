/* cull.c: which casters a map draws. */
#include "plan/internal.h"

#include <string.h>

/* ---- the scene's bounds ---- */

void plan_scene_bounds(plan_scene_box *out, const double basis[9], const plan_scene *scene) {
  double low[3] = {PLAN_LARGEST, PLAN_LARGEST, PLAN_LARGEST}, high[3] = {-PLAN_LARGEST, -PLAN_LARGEST, -PLAN_LARGEST};
  bool any = false;
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot) {
    const plan_instance *instance = &scene->instances[slot];
    if (!plan_casts(instance) && !plan_receives(instance))
      continue;
    const plan_box *box = &scene->boxes[slot];
    any = true;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = box->low[axis] < low[axis] ? box->low[axis] : low[axis];
      high[axis] = box->high[axis] > high[axis] ? box->high[axis] : high[axis];
    }
  }
  out->corner_count = any ? 8 : 0;
  for (int axis = 0; axis < 3; ++axis) { /* no range is so long that a float does not hold it */
    low[axis] = fmax(low[axis], -PLAN_LARGEST);
    high[axis] = fmin(high[axis], PLAN_LARGEST);
  }
  for (uint32_t i = 0; i < out->corner_count; ++i) {
    const double corner[3] = {i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]};
    for (int axis = 0; axis < 3; ++axis)
      out->corners[i][axis] = plan_dot(corner, &basis[axis * 3]);
  }
}

/* ---- a light ---- */

/* Whether what casts along the light from a box can shade nothing inside. */
static bool outside_hull(const plan_hull *hull, const plan_light_block *block, uint32_t at) {
  return plan_outside_hull(hull, (double[]){block->low[0][at], block->low[1][at]},
                           (double[]){block->high[0][at], block->high[1][at]});
}

/* Two slots at a time, which is what every processor's vectors hold. */
typedef double double_pair __attribute__((vector_size(16)));
typedef int64_t slot_pair __attribute__((vector_size(16)));

static inline double_pair two_of(const double *values) {
  double_pair pair;
  memcpy(&pair, values, sizeof pair);
  return pair;
}

/*
 * A caster is kept if its bounds, swept towards the light, meet what the map covers: there is no test at the near
 * plane. The rasteriser draws where texels' centres are covered, half a texel inside the area, so the area itself has
 * that much room for rounding.
 */
static void meet_area(slot_pair meets[PLAN_BLOCK / 2], const plan_light_block *block, const plan_area *area,
                      uint32_t list) {
  for (uint32_t i = 0; i < PLAN_BLOCK; i += 2) {
    const slot_pair inside =
        (two_of(&block->low[0][i]) <= area->max[0]) & (two_of(&block->high[0][i]) >= area->min[0]) &
        (two_of(&block->low[1][i]) <= area->max[1]) & (two_of(&block->high[1][i]) >= area->min[1]) &
        (two_of(&block->low[2][i]) <= area->depth[1]);
    meets[i / 2] |= inside & ((int64_t)1 << list);
  }
}

/*
 * A caster's size from which on it has to be looked at whether floats put it off its place. A mesh is stored within two
 * widths of its box from its own origin, or is plan_bounds_far. That origin and the vertices lie no farther from the
 * middle of a slice that the box meets than twice that, and the slice's size, which is small against the least
 * distance.
 */
static double least_width(const plan_area *areas, uint32_t count) {
  double least = INFINITY;
  for (uint32_t i = 0; i < count; ++i)
    least = fmin(least, areas[i].rounding.least);
  return least / 5.0;
}

static bool any_far(const plan_scene *scene) {
  bool far = false;
  for (uint32_t i = 0; i < scene->mesh_count && !far; ++i)
    far = plan_bounds_far(&scene->meshes[i]);
  return far;
}

static bool other_layers(const plan_instance *instance, uint32_t layers) {
  return layers && instance->layers && !(instance->layers & layers);
}

/* Notes where a caster begins in the areas that it meets. */
static void note(const plan_light_cull *cull, uint32_t mask, double begin) {
  for (; mask; mask &= mask - 1) {
    plan_area *area = &cull->areas[__builtin_ctz(mask)];
    area->first_caster = begin < area->first_caster ? begin : area->first_caster;
  }
}

/* What floats put a caster off its place by, in the areas that it casts into. */
static void note_rounding(const plan_light_cull *cull, const plan_scene *scene, const plan_instance *instance,
                          uint32_t mask, double end) {
  for (; mask; mask &= mask - 1)
    plan_rounding_note(&cull->areas[__builtin_ctz(mask)].rounding, cull->basis, instance,
                       &scene->meshes[instance->mesh], end);
}

static void cull_block(plan_lists *lists, const plan_light_cull *cull, const plan_scene *scene,
                       const plan_light_block *block, uint32_t first, bool may_be_off) {
  slot_pair pairs[PLAN_BLOCK / 2] = {0};
  int64_t meets[PLAN_BLOCK];
  for (uint32_t i = 0; i < lists->count; ++i)
    meet_area(pairs, block, &cull->areas[i], i);
  memcpy(meets, pairs, sizeof meets);
  for (uint32_t i = 0; i < PLAN_BLOCK; ++i) {
    if (!meets[i])
      continue;
    const plan_instance *instance = &scene->instances[first + i];
    if (other_layers(instance, cull->layers) || outside_hull(cull->hull, block, i))
      continue;
    lists->masks[first + i] = (uint64_t)meets[i];
    note(cull, (uint32_t)meets[i], block->low[2][i]);
    if (may_be_off)
      note_rounding(cull, scene, instance, (uint32_t)meets[i], block->high[2][i]);
  }
}

/* A block of boxes from a slot on: what is kept, or made. */
static const plan_light_block *find_block(plan_light_block *made, const plan_light_cull *cull, const plan_kept *kept,
                                          const plan_scene *scene, uint32_t first) {
  if (kept->blocks)
    return &kept->blocks[first / PLAN_BLOCK];
  plan_light_block_make(made, cull->basis, scene, first);
  return made;
}

plan_kept plan_cull_light(plan_lists *lists, const plan_light_cull *cull, const plan_scene *scene) {
  const plan_kept kept = plan_cache_fill(cull->cache, cull->basis, scene);
  const double least = any_far(scene) ? 0.0 : least_width(cull->areas, lists->count);
  lists->among = scene->caster_count;
  for (uint32_t first = 0; first < scene->slot_count; first += PLAN_BLOCK) {
    plan_light_block made;
    const plan_light_block *block = find_block(&made, cull, &kept, scene, first);
    cull_block(lists, cull, scene, block, first, block->largest > least * least);
  }
  return kept;
}

/* Of the lists that hold a caster, those in whose maps it lies over no cell that is read. */
static uint64_t unread(const plan_cells *cells, const plan_light_block *block, uint32_t at, uint64_t mask) {
  const double low[2] = {block->low[0][at], block->low[1][at]}, high[2] = {block->high[0][at], block->high[1][at]};
  uint64_t unread = 0;
  for (uint64_t rest = mask; rest; rest &= rest - 1) {
    const uint32_t list = (uint32_t)__builtin_ctzll(rest);
    unread |= (uint64_t)!plan_cells_meet(&cells[list], low, high) << list;
  }
  return unread;
}

void plan_cull_unread(plan_lists *lists, const plan_cells *cells, const plan_light_cull *cull, const plan_kept *kept,
                      const plan_scene *scene) {
  plan_light_block made;
  const plan_light_block *block = NULL;
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot) {
    const uint32_t at = slot % PLAN_BLOCK;
    if (at == 0)
      block = find_block(&made, cull, kept, scene, slot);
    if (lists->masks[slot])
      lists->masks[slot] &= ~unread(cells, block, at, lists->masks[slot]);
    if (lists->room && lists->masks[slot] && plan_parts_of(scene, &scene->instances[slot]).count)
      plan_cull_parts(lists, cells, cull->basis, scene, slot, (double[]){block->low[0][at], block->low[1][at]},
                      (double[]){block->high[0][at], block->high[1][at]});
  }
}

bool plan_casters_span(plan_span *out, const plan_light_cull *cull, const plan_scene *scene) {
  const plan_kept kept = plan_cache_fill(cull->cache, cull->basis, scene);
  *out = (plan_span){.low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}};
  plan_light_block made;
  const plan_light_block *block = NULL;
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot) {
    const uint32_t at = slot % PLAN_BLOCK;
    if (at == 0)
      block = find_block(&made, cull, &kept, scene, slot);
    const plan_instance *instance = &scene->instances[slot];
    if (!plan_casts(instance) || other_layers(instance, cull->layers) || outside_hull(cull->hull, block, at))
      continue;
    for (int axis = 0; axis < 3; ++axis) {
      out->low[axis] = fmin(out->low[axis], block->low[axis][at]);
      out->high[axis] = fmax(out->high[axis], block->high[axis][at]);
    }
  }
  return out->low[0] <= out->high[0];
}
