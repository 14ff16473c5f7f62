/* order.c: instances in blocks that lie together, and the bounds of these, so that no plan looks at every instance. */
#include "plan/internal.h"

#include <string.h>

static uint32_t units_of(uint32_t count) {
  return count / PLAN_BLOCK + (count % PLAN_BLOCK != 0);
}

/* ---- memory ---- */

size_t plan_order_size(uint32_t slot_count) {
  const size_t blocks = units_of(slot_count), groups = units_of((uint32_t)blocks), tops = units_of((uint32_t)groups);
  return (tops + groups) * sizeof(plan_bounds_block) + 2 * groups * sizeof(uint64_t) +
         blocks * (sizeof(double) + sizeof(uint64_t) + 3 * PLAN_BLOCK * sizeof(uint32_t));
}

void plan_order_find(plan_order *out, void *memory, uint32_t slot_count) {
  out->block_count = units_of(slot_count);
  out->group_count = units_of(out->block_count);
  out->top_count = units_of(out->group_count);
  out->tops = memory;
  out->groups = out->tops + out->top_count;
  out->widths = (double *)(void *)(out->groups + out->group_count);
  out->changed = (uint64_t *)(void *)(out->widths + out->block_count);
  out->marked = out->changed + out->group_count;
  out->marks = out->marked + out->group_count;
  out->slots = (uint32_t *)(void *)(out->marks + out->block_count);
  out->places = out->slots + (size_t)out->block_count * PLAN_BLOCK;
  out->indices = out->places + (size_t)out->block_count * PLAN_BLOCK;
}

/* ---- order ---- */

/* An instance's middle. */
typedef struct item {
  float at[3];
  uint32_t slot;
} item;

/* The axis along which middles lie farthest apart. */
static int widest_axis(const item *items, uint32_t count) {
  float low[3], high[3];
  memcpy(low, items[0].at, sizeof low);
  memcpy(high, items[0].at, sizeof high);
  for (uint32_t i = 1; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = items[i].at[axis] < low[axis] ? items[i].at[axis] : low[axis];
      high[axis] = items[i].at[axis] > high[axis] ? items[i].at[axis] : high[axis];
    }
  int widest = 0;
  for (int axis = 1; axis < 3; ++axis)
    widest = high[axis] - low[axis] > high[widest] - low[widest] ? axis : widest;
  return widest;
}

/* A guess at which value has so many others below it, from a few that lie anywhere: rows and rings, which scenes have, are no
 * trap for it. */
static float guess(const item *items, uint32_t count, uint32_t first, int axis) {
  enum { samples = 9 };
  float values[samples];
  for (uint32_t i = 0; i < samples; ++i) {
    const uint64_t mixed = (count + i) * 0x9e3779b97f4a7c15u;
    const float value = items[(mixed >> 32) * count >> 32].at[axis];
    uint32_t at = i;
    for (; at && values[at - 1] > value; --at)
      values[at] = values[at - 1];
    values[at] = value;
  }
  return values[(uint64_t)first * samples / count];
}

/* Puts those below a pivot before the others, or those no higher than it; returns where the others begin. Which way items go is
 * as good as random, so nothing branches on it. */
static uint32_t part(item *items, uint32_t low, uint32_t high, int axis, float pivot, bool equal) {
  uint32_t next = low;
  for (uint32_t i = low; i < high; ++i) {
    const item moved = items[i];
    items[i] = items[next];
    items[next] = moved;
    next += equal ? moved.at[axis] <= pivot : moved.at[axis] < pivot;
  }
  return next;
}

/* Puts so many of the least along an axis before the others: Hoare, "Algorithm 65: FIND" (1961). */
static void put_least_first(item *items, uint32_t count, uint32_t first, int axis) {
  uint32_t low = 0, high = count;
  while (high - low > 1) {
    const float pivot = guess(items + low, high - low, first - low, axis);
    const uint32_t below = part(items, low, high, axis, pivot, false);
    if (first < below) {
      high = below;
      continue;
    }
    low = part(items, below, high, axis, pivot, true);
    if (first < low)
      return;
  }
}

/* Halves what lies farthest apart, at a whole number of blocks, or of groups, until all blocks are apart. */
static void divide(item *items, uint32_t count) {
  uint32_t unit = PLAN_BLOCK;
  while (unit <= (count - 1) / PLAN_BLOCK)
    unit *= PLAN_BLOCK;
  const uint32_t first = ((count - 1) / unit + 1) / 2 * unit;
  if (first == 0)
    return;
  put_least_first(items, count, first, widest_axis(items, count));
  divide(items, first);
  divide(items + first, count - first);
}

static void take_items(item *items, const plan_scene *scene) {
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot) {
    const plan_box *box = &scene->boxes[slot];
    items[slot] = (item){.slot = slot};
    for (int axis = 0; axis < 3 && !(scene->instances[slot].flags & PLAN_FREE); ++axis)
      items[slot].at[axis] = plan_float(0.5 * (box->low[axis] + box->high[axis]));
  }
}

/* ---- bounds ---- */

static const plan_box no_box = {{1e200, 1e200, 1e200}, {-1e200, -1e200, -1e200}};

static void widen(plan_box *box, const double low[3], const double high[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    box->low[axis] = low[axis] < box->low[axis] ? low[axis] : box->low[axis];
    box->high[axis] = high[axis] > box->high[axis] ? high[axis] : box->high[axis];
  }
}

static void put(plan_bounds_block *bounds, uint32_t at, const plan_box *box) {
  for (int axis = 0; axis < 3; ++axis) {
    bounds->low[axis][at] = box->low[axis];
    bounds->high[axis][at] = box->high[axis];
  }
}

/* Around all 64. */
static plan_box bounds_of(const plan_bounds_block *bounds) {
  plan_box box = no_box;
  for (uint32_t i = 0; i < PLAN_BLOCK; ++i)
    widen(&box, (double[]){bounds->low[0][i], bounds->low[1][i], bounds->low[2][i]},
          (double[]){bounds->high[0][i], bounds->high[1][i], bounds->high[2][i]});
  return box;
}

static void fit_block(const plan_order *order, const plan_scene *scene, uint32_t block) {
  plan_box box = no_box;
  for (uint32_t i = 0; i < PLAN_BLOCK; ++i) {
    const uint32_t slot = order->slots[block * PLAN_BLOCK + i];
    if (slot < scene->slot_count && (plan_casts(&scene->instances[slot]) || plan_receives(&scene->instances[slot])))
      widen(&box, scene->boxes[slot].low, scene->boxes[slot].high);
  }
  put(&order->groups[block / PLAN_BLOCK], block % PLAN_BLOCK, &box);
}

static void fit_group(const plan_order *order, uint32_t group) {
  const plan_box box = bounds_of(&order->groups[group]);
  put(&order->tops[group / PLAN_BLOCK], group % PLAN_BLOCK, &box);
}

/* The sum of a block's sides; 0 where nothing is in it. */
static double width_of(const plan_order *order, uint32_t block) {
  const plan_bounds_block *group = &order->groups[block / PLAN_BLOCK];
  const uint32_t at = block % PLAN_BLOCK;
  double width = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    width += fmax(group->high[axis][at] - group->low[axis][at], 0.0);
  return width;
}

static bool is_loose(const plan_order *order, uint32_t block) {
  return width_of(order, block) > 2.0 * order->widths[block];
}

/* ---- what the plan asks for ---- */

static void clear(const plan_order *order) {
  memset(order->changed, 0, order->group_count * sizeof *order->changed);
  memset(order->marked, 0, order->group_count * sizeof *order->marked);
  memset(order->marks, 0, order->block_count * sizeof *order->marks);
  for (uint32_t i = 0; i < order->group_count * PLAN_BLOCK; ++i)
    put(&order->groups[i / PLAN_BLOCK], i % PLAN_BLOCK, &no_box);
  for (uint32_t i = 0; i < order->top_count * PLAN_BLOCK; ++i)
    put(&order->tops[i / PLAN_BLOCK], i % PLAN_BLOCK, &no_box);
}

/* What few instances there are, a group, is looked at about as fast in the order of slots, and found in it. */
void plan_order_make(const plan_order *order, const plan_scene *scene, void *scratch) {
  item *items = scratch;
  clear(order);
  take_items(items, scene);
  if (scene->slot_count > PLAN_BLOCK * PLAN_BLOCK)
    divide(items, scene->slot_count);
  for (uint32_t place = 0; place < order->block_count * PLAN_BLOCK; ++place) {
    order->slots[place] = place < scene->slot_count ? items[place].slot : place;
    order->places[order->slots[place]] = place;
  }
  for (uint32_t i = 0; i < order->block_count; ++i) {
    fit_block(order, scene, i);
    order->widths[i] = width_of(order, i);
  }
  for (uint32_t i = 0; i < order->group_count; ++i)
    fit_group(order, i);
}

void plan_order_note(const plan_order *order, uint32_t slot) {
  const uint32_t block = order->places[slot] / PLAN_BLOCK;
  order->changed[block / PLAN_BLOCK] |= (uint64_t)1 << block % PLAN_BLOCK;
}

int64_t plan_order_fit(const plan_order *order, const plan_scene *scene) {
  int64_t loosened = 0;
  for (uint32_t group = 0; group < order->group_count; ++group) {
    if (!order->changed[group])
      continue;
    for (uint64_t rest = order->changed[group]; rest; rest &= rest - 1) {
      const uint32_t block = group * PLAN_BLOCK + (uint32_t)__builtin_ctzll(rest);
      loosened -= is_loose(order, block);
      fit_block(order, scene, block);
      loosened += is_loose(order, block);
    }
    fit_group(order, group);
    order->changed[group] = 0;
  }
  return loosened;
}

plan_box plan_order_bounds(const plan_order *order) {
  plan_box box = no_box;
  for (uint32_t i = 0; i < order->top_count; ++i) {
    const plan_box top = bounds_of(&order->tops[i]);
    widen(&box, top.low, top.high);
  }
  return box;
}

/* ---- by slot again ---- */

void plan_order_sort(const plan_order *order, plan_found *out, const plan_found *found, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t slot = found[i].slot, word = slot / PLAN_BLOCK;
    order->indices[slot] = i;
    order->marks[word] |= (uint64_t)1 << slot % PLAN_BLOCK;
    order->marked[word / PLAN_BLOCK] |= (uint64_t)1 << word % PLAN_BLOCK;
  }
  for (uint32_t i = 0; i < order->group_count; ++i) {
    for (; order->marked[i]; order->marked[i] &= order->marked[i] - 1) {
      const uint32_t word = i * PLAN_BLOCK + (uint32_t)__builtin_ctzll(order->marked[i]);
      for (; order->marks[word]; order->marks[word] &= order->marks[word] - 1)
        *out++ = found[order->indices[word * PLAN_BLOCK + (uint32_t)__builtin_ctzll(order->marks[word])]];
    }
  }
}

/* ---- walks ---- */

plan_walk plan_walk_begin(const plan_order *order, uint32_t slot_count, plan_meets *meets, const void *with) {
  return (plan_walk){.order = order, .block_count = units_of(slot_count), .meets = meets, .with = with};
}

bool plan_walk_next(plan_walk *walk, uint32_t *block) {
  const plan_order *order = walk->order;
  if (!order->slots || walk->block_count <= PLAN_BLOCK) { /* a group is looked at as fast as its bounds */
    *block = walk->next;
    return walk->next++ < walk->block_count;
  }
  while (!walk->blocks) {
    while (!walk->groups) {
      if (walk->next == order->top_count)
        return false;
      walk->groups = walk->meets(walk->with, &order->tops[walk->next++]);
    }
    walk->group = (walk->next - 1) * PLAN_BLOCK + (uint32_t)__builtin_ctzll(walk->groups);
    walk->groups &= walk->groups - 1;
    walk->blocks = walk->meets(walk->with, &order->groups[walk->group]);
  }
  *block = walk->group * PLAN_BLOCK + (uint32_t)__builtin_ctzll(walk->blocks);
  walk->blocks &= walk->blocks - 1;
  return true;
}
