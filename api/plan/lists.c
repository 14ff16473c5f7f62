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
  size_t found, sorted, drawn, counts, draws, instances, list_stride, size;
  uint32_t whole_draws; /* of a list at most; draws of parts lie after them until all are known */
} memory_layout;

static memory_layout lay_out(uint32_t most, uint32_t mesh_count, uint32_t list_count) {
  const uint32_t keys = mesh_count * 2;
  const uint32_t whole_draws = most < keys ? most : keys;
  const uint32_t part_draws = most ? PLAN_MOST_PART_DRAWS : 0;
  memory_layout layout = {.whole_draws = whole_draws};
  size_t at = 0;
  layout.found = take(&at, most, sizeof(plan_found));
  layout.sorted = take(&at, most, sizeof(plan_found));
  layout.drawn = take(&at, most, sizeof(plan_drawn_slot));
  layout.counts = take(&at, (size_t)keys * list_count, sizeof(uint32_t));
  layout.draws = take(&at, (size_t)whole_draws + part_draws, sizeof(plan_draw));
  layout.instances = take(&at, most, sizeof(uint32_t));
  layout.list_stride = at - layout.draws;
  layout.size = layout.draws + layout.list_stride * list_count;
  return layout;
}

size_t plan_memory_size(uint32_t most, uint32_t mesh_count, uint32_t window_count) {
  return lay_out(most, mesh_count, window_count ? window_count : 1).size;
}

bool plan_memory_short(plan_memory *memory) {
  if (memory->found <= memory->most)
    return false;
  memory->most = memory->found + memory->found / 4;
  return true;
}

/* ---- what was found ---- */

void plan_lists_begin(plan_lists *lists, plan_memory *memory) {
  lists->memory = memory;
  lists->found_count = 0;
  if (memory)
    memory->found = 0;
  if (plan_lists_most(lists))
    lists->found = (plan_found *)(void *)((char *)memory->at + lay_out(memory->most, 0, 0).found);
}

bool plan_lists_fit(const plan_lists *lists) {
  if (lists->memory)
    lists->memory->found = lists->found_count;
  return lists->found_count <= plan_lists_most(lists);
}

static bool is_sorted(const plan_lists *lists) {
  bool sorted = true;
  for (uint32_t i = 1; i < lists->found_count && sorted; ++i)
    sorted = lists->found[i - 1].slot < lists->found[i].slot;
  return sorted;
}

void plan_lists_sort(plan_lists *lists, const plan_order *order) {
  if (is_sorted(lists))
    return;
  plan_found *sorted = (plan_found *)(void *)((char *)lists->memory->at + lay_out(lists->memory->most, 0, 0).sorted);
  plan_order_sort(order, sorted, lists->found, lists->found_count);
  lists->found = sorted;
}

void plan_lists_drawn(const plan_lists *lists, plan_frame *frame) {
  if (lists->found_count == 0)
    return;
  const memory_layout layout = lay_out(lists->memory->most, 0, 0);
  plan_drawn_slot *drawn = (plan_drawn_slot *)(void *)((char *)lists->memory->at + layout.drawn);
  frame->drawn = drawn;
  for (uint32_t i = 0; i < lists->found_count; ++i)
    if (lists->found[i].drawn)
      drawn[frame->drawn_count++] = (plan_drawn_slot){.slot = lists->found[i].slot, .cascades = lists->found[i].drawn};
}

uint32_t plan_drawn_by(const plan_frame *frame, uint32_t slot) {
  uint32_t low = 0, high = frame->drawn_count;
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (frame->drawn[middle].slot < slot)
      low = middle + 1;
    else
      high = middle;
  }
  return low < frame->drawn_count && frame->drawn[low].slot == slot ? frame->drawn[low].cascades : 0;
}

/* ---- lists ---- */

void plan_lists_room(plan_lists *lists, const plan_scene *scene) {
  const memory_layout layout = lay_out(plan_lists_most(lists), scene->mesh_count, lists->count);
  lists->room = true;
  if (plan_lists_most(lists) == 0)
    return;
  char *const base = lists->memory->at;
  lists->counts = (uint32_t *)(void *)(base + layout.counts);
  memset(lists->counts, 0, (size_t)scene->mesh_count * 2 * lists->count * sizeof *lists->counts);
  for (uint32_t i = 0; i < lists->count; ++i) {
    lists->lists[i]->draws = (plan_draw *)(void *)(base + layout.draws + i * layout.list_stride);
    lists->part_draws[i] = lists->lists[i]->draws + layout.whole_draws;
    lists->lists[i]->instances = (uint32_t *)(void *)(base + layout.instances + i * layout.list_stride);
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

/* The counts that an instance belongs to. */
static uint32_t *counts_of(const plan_lists *lists, const plan_scene *scene, const plan_found *found) {
  return &lists->counts[(size_t)plan_list_key(lists, &scene->instances[found->slot]) * lists->count];
}

/* The lists that draw all of a mesh. */
static uint64_t whole_in(const plan_found *found) {
  return found->mask & ~found->partly;
}

static void count_found(const plan_lists *lists, const plan_scene *scene) {
  for (uint32_t i = 0; i < lists->found_count; ++i)
    for (uint64_t mask = whole_in(&lists->found[i]); mask; mask &= mask - 1)
      ++counts_of(lists, scene, &lists->found[i])[__builtin_ctzll(mask)];
}

/* Puts each one into every list that draws all of it. */
static void place_found(const plan_lists *lists, const plan_scene *scene) {
  for (uint32_t i = 0; i < lists->found_count; ++i)
    for (uint64_t mask = whole_in(&lists->found[i]); mask; mask &= mask - 1) {
      const uint32_t list = (uint32_t)__builtin_ctzll(mask);
      lists->lists[list]->instances[counts_of(lists, scene, &lists->found[i])[list]++] = lists->found[i].slot;
    }
}

/* Puts what a list draws in parts after what it draws whole. */
static void add_parts(const plan_lists *lists, uint32_t index) {
  plan_list *list = lists->lists[index];
  for (uint32_t i = 0; i < lists->part_counts[index]; ++i) {
    plan_draw draw = lists->part_draws[index][i];
    draw.first += list->instance_count;
    list->draws[list->draw_count++] = draw;
  }
  for (uint32_t i = 0; i < lists->found_count && lists->part_counts[index]; ++i)
    if (lists->found[i].partly >> index & 1)
      list->instances[list->instance_count++] = lists->found[i].slot;
}

void plan_lists_end(plan_lists *lists, const plan_scene *scene) {
  if (!lists->room)
    plan_lists_room(lists, scene);
  count_found(lists, scene);
  for (uint32_t i = 0; i < lists->count; ++i) {
    if (lists->found_count)
      make_draws(lists, i, scene->mesh_count);
    add_parts(lists, i);
    lists->lists[i]->culled = lists->among - lists->lists[i]->instance_count;
  }
  place_found(lists, scene);
}
