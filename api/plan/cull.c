/* cull.c: which casters a map draws. */
#include "plan/internal.h"

#include <string.h>

/* ---- the scene's bounds ---- */

/* Around all that casts or receives; low above high: nothing does. */
static plan_box box_of_all(const plan_scene *scene) {
  plan_box all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot) {
    const plan_instance *instance = &scene->instances[slot];
    if (!plan_casts(instance) && !plan_receives(instance))
      continue;
    const plan_box *box = &scene->boxes[slot];
    for (int axis = 0; axis < 3; ++axis) {
      all.low[axis] = box->low[axis] < all.low[axis] ? box->low[axis] : all.low[axis];
      all.high[axis] = box->high[axis] > all.high[axis] ? box->high[axis] : all.high[axis];
    }
  }
  return all;
}

void plan_scene_bounds(plan_scene_box *out, const double basis[9], const plan_scene *scene, const plan_order *order) {
  const plan_box all = order->slots ? plan_order_bounds(order) : box_of_all(scene);
  double low[3], high[3];
  out->corner_count = all.low[0] <= all.high[0] ? 8 : 0;
  for (int axis = 0; axis < 3; ++axis) { /* no range is so long that a float does not hold it */
    low[axis] = fmin(fmax(all.low[axis], -PLAN_LARGEST), PLAN_LARGEST);
    high[axis] = fmin(fmax(all.high[axis], -PLAN_LARGEST), PLAN_LARGEST);
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

/* ---- blocks ---- */

/* What walks look for: what casts into some area, or what lies in a hull and beyond a span. */
typedef struct light_search {
  const plan_light_cull *cull;
  uint32_t area_count;
  double least; /* a caster's size from which on it has to be looked at whether floats put it off its place */
  const plan_span *span;
} light_search;

/* Boxes in light space around boxes in the world, with room for rounding: what lies in those lies in these. */
static void enclose(plan_light_block *out, const plan_bounds_block *bounds, const double basis[9]) {
  const double rounding = 1e-12;
  for (int axis = 0; axis < 3; ++axis) {
    const double *way = &basis[axis * 3];
    for (uint32_t i = 0; i < PLAN_BLOCK; ++i) {
      double middle = 0.0, reach = 0.0;
      for (int k = 0; k < 3; ++k) {
        const double at = 0.5 * (bounds->low[k][i] + bounds->high[k][i]);
        const double half = 0.5 * (bounds->high[k][i] - bounds->low[k][i]);
        middle += way[k] * at;
        reach += fabs(way[k]) * (half + rounding * (fabs(at) + fabs(half)));
      }
      out->low[axis][i] = middle - reach;
      out->high[axis][i] = middle + reach;
    }
  }
}

/* Whether nothing in a box can say where the maps that it meets begin, or by how much floats put casters off. */
static bool tells_nothing(const light_search *search, const plan_light_block *block, uint32_t at, uint64_t areas) {
  double square = 0.0, first = -INFINITY;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = block->high[axis][at] - block->low[axis][at];
    square += size * size;
  }
  for (; areas; areas &= areas - 1)
    first = fmax(first, search->cull->areas[__builtin_ctzll(areas)].first_caster);
  return block->low[2][at] >= first && square <= search->least * search->least;
}

/* What casts into the maps, but on nothing in the hull, is not drawn, and yet maps lie where they lie with it. */
static uint64_t meet_areas(const void *with, const plan_bounds_block *bounds) {
  const light_search *search = with;
  plan_light_block block;
  slot_pair pairs[PLAN_BLOCK / 2] = {0};
  int64_t meets[PLAN_BLOCK];
  uint64_t mask = 0;
  enclose(&block, bounds, search->cull->basis);
  for (uint32_t i = 0; i < search->area_count; ++i)
    meet_area(pairs, &block, &search->cull->areas[i], i);
  memcpy(meets, pairs, sizeof meets);
  for (uint32_t i = 0; i < PLAN_BLOCK; ++i) {
    const bool spared =
        meets[i] && outside_hull(search->cull->hull, &block, i) && tells_nothing(search, &block, i, (uint64_t)meets[i]);
    mask |= (uint64_t)(meets[i] && !spared) << i;
  }
  return mask;
}

static bool within_span(const plan_span *span, const plan_light_block *block, uint32_t at) {
  bool within = true;
  for (int axis = 0; axis < 3; ++axis)
    within &= span->low[axis] <= block->low[axis][at] && block->high[axis][at] <= span->high[axis];
  return within;
}

static uint64_t meet_beyond_span(const void *with, const plan_bounds_block *bounds) {
  const light_search *search = with;
  plan_light_block block;
  uint64_t mask = 0;
  enclose(&block, bounds, search->cull->basis);
  for (uint32_t i = 0; i < PLAN_BLOCK; ++i)
    mask |= (uint64_t)(block.low[0][i] <= block.high[0][i] && !within_span(search->span, &block, i) &&
                       !outside_hull(search->cull->hull, &block, i))
            << i;
  return mask;
}

/* ---- casters ---- */

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
    const uint32_t slot = plan_slot_at(&cull->kept->order, first + i);
    const plan_instance *instance = &scene->instances[slot];
    if (other_layers(instance, cull->layers))
      continue;
    if (!outside_hull(cull->hull, block, i))
      plan_lists_add(lists, &(plan_found){.mask = (uint64_t)meets[i], .slot = slot, .place = first + i});
    note(cull, (uint32_t)meets[i], block->low[2][i]);
    if (may_be_off)
      note_rounding(cull, scene, instance, (uint32_t)meets[i], block->high[2][i]);
  }
}

void plan_cull_light(plan_lists *lists, const plan_light_cull *cull, const plan_scene *scene) {
  const double least = any_far(scene) ? 0.0 : least_width(cull->areas, lists->count);
  const light_search search = {.cull = cull, .area_count = lists->count, .least = least};
  plan_walk walk = plan_walk_begin(&cull->kept->order, scene->slot_count, meet_areas, &search);
  lists->among = scene->caster_count;
  for (uint32_t at; plan_walk_next(&walk, &at);) {
    plan_light_block made;
    const plan_light_block *block = plan_light_block_at(&made, cull->kept, cull->basis, scene, at);
    cull_block(lists, cull, scene, block, at * PLAN_BLOCK, block->largest > least * least);
  }
}

/* Boxes across the light, a block after the other. */
typedef struct box_reader {
  const plan_light_cull *cull;
  const plan_scene *scene;
  plan_light_block made;
  const plan_light_block *block;
  uint32_t at;
} box_reader;

static plan_span_across read_box(box_reader *reader, uint32_t place) {
  const uint32_t i = place % PLAN_BLOCK;
  if (!reader->block || reader->at != place / PLAN_BLOCK) {
    reader->at = place / PLAN_BLOCK;
    reader->block =
        plan_light_block_at(&reader->made, reader->cull->kept, reader->cull->basis, reader->scene, reader->at);
  }
  const plan_light_block *block = reader->block;
  return (plan_span_across){.low = {block->low[0][i], block->low[1][i]},
                            .high = {block->high[0][i], block->high[1][i]}};
}

/* Of the lists that hold a caster, those in whose maps it lies over no cell that is read. */
static uint64_t unread(const plan_cells *cells, const plan_span_across *box, uint64_t mask) {
  uint64_t unread = 0;
  for (uint64_t rest = mask; rest; rest &= rest - 1) {
    const uint32_t list = (uint32_t)__builtin_ctzll(rest);
    unread |= (uint64_t)!plan_cells_meet(&cells[list], box->low, box->high) << list;
  }
  return unread;
}

void plan_cull_unread(plan_lists *lists, const plan_cells *cells, const plan_light_cull *cull,
                      const plan_scene *scene) {
  box_reader reader = {.cull = cull, .scene = scene};
  uint32_t left = 0;
  for (uint32_t i = 0; i < lists->found_count; ++i) {
    plan_found found = lists->found[i];
    if (found.mask) {
      const plan_span_across box = read_box(&reader, found.place);
      found.mask &= ~unread(cells, &box, found.mask);
    }
    if (found.mask || found.drawn)
      lists->found[left++] = found;
  }
  lists->found_count = left;
}

void plan_cull_unread_parts(plan_lists *lists, const plan_cells *cells, const plan_light_cull *cull,
                            const plan_scene *scene) {
  box_reader reader = {.cull = cull, .scene = scene};
  for (uint32_t i = 0; i < lists->found_count && scene->parts; ++i) {
    plan_found *found = &lists->found[i];
    if (!found->mask || !plan_parts_of(scene, &scene->instances[found->slot]).count)
      continue;
    const plan_span_across box = read_box(&reader, found->place);
    plan_cull_parts(lists, found, cells, cull->basis, scene, &box);
  }
}

bool plan_casters_span(plan_span *out, const plan_light_cull *cull, const plan_scene *scene) {
  *out = (plan_span){.low = {INFINITY, INFINITY, INFINITY}, .high = {-INFINITY, -INFINITY, -INFINITY}};
  const light_search search = {.cull = cull, .span = out};
  plan_walk walk = plan_walk_begin(&cull->kept->order, scene->slot_count, meet_beyond_span, &search);
  for (uint32_t at; plan_walk_next(&walk, &at);) {
    plan_light_block made;
    const plan_light_block *block = plan_light_block_at(&made, cull->kept, cull->basis, scene, at);
    for (uint32_t i = 0; i < PLAN_BLOCK; ++i) {
      if (!(block->low[0][i] <= block->high[0][i]) || within_span(out, block, i))
        continue;
      const plan_instance *instance = &scene->instances[plan_slot_at(&cull->kept->order, at * PLAN_BLOCK + i)];
      if (other_layers(instance, cull->layers) || outside_hull(cull->hull, block, i))
        continue;
      for (int axis = 0; axis < 3; ++axis) {
        out->low[axis] = fmin(out->low[axis], block->low[axis][i]);
        out->high[axis] = fmax(out->high[axis], block->high[axis][i]);
      }
    }
  }
  return out->low[0] <= out->high[0];
}
