/* parts.c: which parts of a large mesh a map draws. */
#include "plan/internal.h"

/* A part's box across the light. */
typedef struct part_box {
  double low[2], high[2];
} part_box;

static void place_parts(part_box *out, const plan_parts *parts, const double basis[9], const plan_instance *instance,
                        const plan_bounds *bounds) {
  double to_light[12];
  plan_light_transform(to_light, basis, instance, bounds);
  for (uint32_t i = 0; i < parts->count; ++i) {
    const plan_part *part = &parts->parts[i];
    const double stored[3] = {part->center[0] - bounds->offset[0], part->center[1] - bounds->offset[1],
                              part->center[2] - bounds->offset[2]};
    for (int axis = 0; axis < 2; ++axis) {
      const double *row = &to_light[axis * 4];
      const double middle = plan_dot(row, stored) + row[3];
      const double reach =
          fabs(row[0]) * part->extent[0] + fabs(row[1]) * part->extent[1] + fabs(row[2]) * part->extent[2];
      out[i].low[axis] = middle - reach;
      out[i].high[axis] = middle + reach;
    }
  }
}

/* Parts that can be drawn, a bit each. */
static uint64_t drawable(const plan_parts *parts) {
  uint64_t mask = 0;
  for (uint32_t i = 0; i < parts->count; ++i)
    mask |= (uint64_t)(parts->parts[i].index_count > 0) << i;
  return mask;
}

/* Those of them that lie over a cell that is read. */
static uint64_t find_read(const plan_cells *cells, const part_box *boxes, uint64_t mask) {
  uint64_t read = 0;
  for (; mask; mask &= mask - 1) {
    const uint32_t i = (uint32_t)__builtin_ctzll(mask);
    read |= (uint64_t)plan_cells_meet(cells, boxes[i].low, boxes[i].high) << i;
  }
  return read;
}

/* Writes a draw for each run of parts; false: there is no room for all of them, and nothing has changed. */
static bool add_draws(plan_lists *lists, uint32_t list, const plan_draw *whole, const plan_parts *parts,
                      uint64_t mask) {
  plan_draw *draws = lists->part_draws[list];
  const uint32_t before = lists->part_counts[list];
  const uint32_t runs = (uint32_t)__builtin_popcountll(mask & ~(mask << 1));
  if (runs > PLAN_MOST_PART_DRAWS - before)
    return false;
  plan_draw draw = *whole;
  draw.first = before ? draws[before - 1].first + 1 : 0;
  for (uint32_t i = 0, at = before; i < parts->count; ++i) {
    const bool begins = mask >> i & 1 && !(i && mask >> (i - 1) & 1);
    if (!(mask >> i & 1))
      continue;
    draw.first_index = begins ? parts->parts[i].first_index : draw.first_index;
    draw.index_count = (begins ? 0 : draw.index_count) + parts->parts[i].index_count;
    at += begins;
    draws[at - 1] = draw;
  }
  lists->part_counts[list] += runs;
  return true;
}

void plan_cull_parts(plan_lists *lists, plan_found *found, const plan_cells *cells, const double basis[9],
                     const plan_scene *scene, const plan_span_across *box) {
  const plan_instance *instance = &scene->instances[found->slot];
  const plan_parts parts = plan_parts_of(scene, instance);
  const plan_draw whole = {.mesh = instance->mesh, .count = 1, .mirrored = plan_list_key(lists, instance) & 1};
  const uint64_t all = drawable(&parts);
  part_box boxes[PLAN_MOST_PARTS];
  bool placed = false;
  for (uint64_t rest = found->mask; rest; rest &= rest - 1) {
    const uint32_t list = (uint32_t)__builtin_ctzll(rest);
    if (!plan_cells_meet_some(&cells[list], box->low, box->high))
      continue;
    if (!placed)
      place_parts(boxes, &parts, basis, instance, &scene->meshes[instance->mesh]);
    placed = true;
    const uint64_t read = find_read(&cells[list], boxes, all);
    if (!read)
      found->mask &= ~((uint64_t)1 << list);
    else if (read != all && add_draws(lists, list, &whole, &parts, read))
      found->partly |= (uint64_t)1 << list;
  }
}
