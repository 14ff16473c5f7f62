/* lists.c: what each cascade draws, ordered by mesh, laid out in one piece of memory. */
#include "plan/internal.h"

#include <string.h>

enum { list_alignment = 16 };

static size_t take(size_t *at, size_t count, size_t size) {
  const size_t begin = *at;
  *at = (begin + count * size + list_alignment - 1) / list_alignment * list_alignment;
  return begin;
}

typedef struct memory_layout {
  size_t masks, partly, drawn, counts, draws, instances, list_stride, size;
  uint32_t whole_draws; /* of a list at most; draws of parts lie after them until all are known */
} memory_layout;

/* One for each slot of whole blocks. */
static size_t mask_count(uint32_t slot_count) {
  return ((size_t)slot_count + PLAN_BLOCK - 1) / PLAN_BLOCK * PLAN_BLOCK;
}

static memory_layout lay_out(uint32_t slot_count, uint32_t mesh_count, uint32_t list_count) {
  const uint32_t keys = mesh_count * 2;
  const uint32_t whole_draws = slot_count < keys ? slot_count : keys;
  const uint32_t part_draws = slot_count ? PLAN_MOST_PART_DRAWS : 0;
  memory_layout layout = {.whole_draws = whole_draws};
  size_t at = 0;
  layout.masks = take(&at, mask_count(slot_count), sizeof(uint64_t));
  layout.partly = take(&at, mask_count(slot_count), sizeof(uint64_t));
  layout.drawn = take(&at, slot_count, sizeof(uint8_t));
  layout.counts = take(&at, (size_t)keys * list_count, sizeof(uint32_t));
  layout.draws = take(&at, (size_t)whole_draws + part_draws, sizeof(plan_draw));
  layout.instances = take(&at, slot_count, sizeof(uint32_t));
  layout.list_stride = at - layout.draws;
  layout.size = layout.draws + layout.list_stride * list_count;
  return layout;
}

size_t plan_memory_size(uint32_t slot_count, uint32_t mesh_count, uint32_t window_count) {
  return lay_out(slot_count, mesh_count, window_count ? window_count : 1).size;
}

void plan_lists_begin(plan_lists *lists, const plan_scene *scene, void *memory) {
  const memory_layout layout = lay_out(scene->slot_count, scene->mesh_count, 0);
  char *const base = memory;
  lists->memory = memory;
  if (scene->slot_count == 0)
    return;
  lists->masks = (uint64_t *)(base + layout.masks);
  lists->partly = (uint64_t *)(base + layout.partly);
  lists->drawn = (uint8_t *)(base + layout.drawn);
  memset(lists->masks, 0, mask_count(scene->slot_count) * sizeof *lists->masks);
  memset(lists->partly, 0, mask_count(scene->slot_count) * sizeof *lists->partly);
}

void plan_lists_room(plan_lists *lists, const plan_scene *scene) {
  const memory_layout layout = lay_out(scene->slot_count, scene->mesh_count, lists->count);
  char *const base = lists->memory;
  lists->room = true;
  if (scene->slot_count == 0)
    return;
  lists->counts = (uint32_t *)(base + layout.counts);
  memset(lists->counts, 0, (size_t)scene->mesh_count * 2 * lists->count * sizeof *lists->counts);
  for (uint32_t i = 0; i < lists->count; ++i) {
    lists->lists[i]->draws = (plan_draw *)(base + layout.draws + i * layout.list_stride);
    lists->part_draws[i] = lists->lists[i]->draws + layout.whole_draws;
    lists->lists[i]->instances = (uint32_t *)(base + layout.instances + i * layout.list_stride);
  }
}

/* A draw for each key that the list holds; counts become the place of the key's next instance. */
static void make_draws(plan_lists *lists, uint32_t index, uint32_t mesh_count) {
  plan_list *list = lists->lists[index];
  for (uint32_t key = 0; key < mesh_count * 2; ++key) {
    uint32_t *count = &lists->counts[(size_t)key * lists->count + index];
    if (*count == 0)
      continue;
    list->draws[list->draw_count++] =
        (plan_draw){.mesh = key / 2, .mirrored = key % 2, .first = list->instance_count, .count = *count};
    list->instance_count += *count;
    *count = list->instance_count - *count;
  }
}

/* The counts that a slot's instance belongs to. */
static uint32_t *counts_of(const plan_lists *lists, const plan_scene *scene, uint32_t slot) {
  return &lists->counts[(size_t)plan_list_key(lists, &scene->instances[slot]) * lists->count];
}

/* The lists that draw all of a slot's mesh. */
static uint64_t whole_in(const plan_lists *lists, uint32_t slot) {
  return lists->masks[slot] & ~lists->partly[slot];
}

static void count_slots(const plan_lists *lists, const plan_scene *scene) {
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot)
    for (uint64_t mask = whole_in(lists, slot); mask; mask &= mask - 1)
      ++counts_of(lists, scene, slot)[__builtin_ctzll(mask)];
}

/* Puts each slot into every list that draws all of it. */
static void place_slots(const plan_lists *lists, const plan_scene *scene) {
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot)
    for (uint64_t mask = whole_in(lists, slot); mask; mask &= mask - 1) {
      const uint32_t list = (uint32_t)__builtin_ctzll(mask);
      lists->lists[list]->instances[counts_of(lists, scene, slot)[list]++] = slot;
    }
}

/* Puts what a list draws in parts after what it draws whole. */
static void add_parts(const plan_lists *lists, uint32_t index, uint32_t slot_count) {
  plan_list *list = lists->lists[index];
  for (uint32_t i = 0; i < lists->part_counts[index]; ++i) {
    plan_draw draw = lists->part_draws[index][i];
    draw.first += list->instance_count;
    list->draws[list->draw_count++] = draw;
  }
  for (uint32_t slot = 0; slot < slot_count && lists->part_counts[index]; ++slot)
    if (lists->partly[slot] >> index & 1)
      list->instances[list->instance_count++] = slot;
}

void plan_lists_end(plan_lists *lists, const plan_scene *scene) {
  if (!lists->room)
    plan_lists_room(lists, scene);
  count_slots(lists, scene);
  for (uint32_t i = 0; i < lists->count; ++i) {
    if (scene->slot_count)
      make_draws(lists, i, scene->mesh_count);
    add_parts(lists, i, scene->slot_count);
    lists->lists[i]->culled = lists->among - lists->lists[i]->instance_count;
  }
  place_slots(lists, scene);
}
