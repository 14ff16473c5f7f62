/* Large meshes are drawn in parts: every part over a cell that is read, and no other one where there is room to tell. */
#include "plan/internal.h"
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { instances = 60, meshes = 7, lists_count = CSM_MAX_CASCADES };

/* ---- a scene ---- */

typedef struct parts_scene {
  test_scene scene;
  plan_parts tables[64];
  plan_part parts[64][PLAN_MOST_PARTS];
} parts_scene;

/* Boxes anywhere within a mesh's; some hold nothing that is drawn. */
static void divide(parts_scene *s, random_state *random, uint32_t mesh, uint32_t count) {
  const plan_bounds *bounds = &s->scene.meshes[mesh];
  uint32_t index = 0;
  for (uint32_t i = 0; i < count; ++i) {
    plan_part *part = &s->parts[mesh][i];
    for (int axis = 0; axis < 3; ++axis) {
      part->extent[axis] = bounds->extent[axis] * random_between(random, 0.0, 0.2);
      part->center[axis] = bounds->center[axis] + random_between(random, -0.8, 0.8) * bounds->extent[axis];
    }
    part->first_index = index;
    part->index_count = random_below(random, 10) ? 3 * (1 + random_below(random, 128)) : 0;
    index += part->index_count;
  }
  s->tables[mesh] = (plan_parts){.parts = s->parts[mesh], .count = count};
}

static void make_scene(parts_scene *s, random_state *random, uint32_t count, uint32_t mesh_count) {
  *s = (parts_scene){.scene = scene_make(count, mesh_count)};
  s->scene.scene.parts = s->tables;
  scene_scatter(&s->scene, random, (const double[3]){0, 0, 0}, 40.0);
  for (uint32_t i = 0; i < mesh_count; ++i)
    if (i % 7 != 3) /* which stays whole */
      divide(s, random, i, 1 + random_below(random, PLAN_MOST_PARTS));
}

/* ---- lists, by brute force ---- */

static void make_cells(plan_cells *cells, random_state *random) {
  const uint32_t kind = random_below(random, 4);
  for (int axis = 0; axis < 2; ++axis) {
    cells->begin[axis] = random_between(random, -80.0, 20.0);
    cells->size[axis] = random_scale(random, 0.05, 4.0);
  }
  for (uint32_t y = 0; y < PLAN_CELLS; ++y) {
    const uint64_t few = random_bits(random) & random_bits(random) & random_bits(random) & random_bits(random);
    const uint64_t rare = few & random_bits(random) & random_bits(random);
    cells->read[y] = kind == 0 ? UINT64_MAX : kind == 1 ? few : kind == 2 ? rare : (uint64_t)(y < 20) << 20;
  }
}

/* Whether an instance's box, made larger or smaller about its middle, lies over a cell that is read. */
static bool over_read(const plan_cells *cells, const double basis[9], const plan_instance *instance,
                      const double center[3], const double extent[3], double scale) {
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (uint32_t corner = 0; corner < 8; ++corner) {
    double object[3], world[3];
    for (int i = 0; i < 3; ++i)
      object[i] = center[i] + (corner >> i & 1 ? scale : -scale) * extent[i];
    for (int i = 0; i < 3; ++i)
      world[i] = plan_dot(&instance->transform[i * 4], object) + instance->transform[i * 4 + 3];
    for (int axis = 0; axis < 2; ++axis) {
      low[axis] = fmin(low[axis], plan_dot(&basis[axis * 3], world));
      high[axis] = fmax(high[axis], plan_dot(&basis[axis * 3], world));
    }
  }
  bool over = false;
  for (uint32_t y = 0; y < PLAN_CELLS; ++y)
    for (uint32_t x = 0; x < PLAN_CELLS; ++x) {
      const double at[2] = {cells->begin[0] + x * cells->size[0], cells->begin[1] + y * cells->size[1]};
      over |= cells->read[y] >> x & 1 && low[0] <= at[0] + cells->size[0] && high[0] >= at[0] &&
              low[1] <= at[1] + cells->size[1] && high[1] >= at[1];
    }
  return over;
}

/* By part of one instance in a list: how often it is drawn; `whole`: all of it. */
typedef struct drawn_parts {
  uint32_t times[PLAN_MOST_PARTS], draws;
  bool listed, whole;
} drawn_parts;

/* Draws of parts come after the others, by slot and by index; each is a run of whole parts. */
static void check_order(const plan_list *list, const plan_scene *scene) {
  uint32_t next = 0;
  const plan_draw *before = NULL;
  for (uint32_t d = 0; d < list->draw_count; ++d) {
    const plan_draw *draw = &list->draws[d];
    const bool same = before && before->index_count && draw->first == before->first;
    assert_true(same || draw->first == next);
    assert_true(!before || !before->index_count || draw->index_count);
    assert_true(!draw->index_count || draw->count == 1);
    if (same)
      assert_true(draw->first_index >= before->first_index + before->index_count);
    else if (before && before->index_count)
      assert_true(list->instances[draw->first] > list->instances[before->first]);
    next += same ? 0 : draw->count;
    for (uint32_t i = 0; i < draw->count; ++i) {
      const plan_instance *instance = &scene->instances[list->instances[draw->first + i]];
      assert_true(instance->mesh == draw->mesh && instance->mirrored == draw->mirrored);
    }
    before = draw;
  }
  assert_int_equal(next, list->instance_count);
}

static void find_drawn(drawn_parts *out, const plan_list *list, const plan_scene *scene, uint32_t slot) {
  const plan_parts parts = plan_parts_of(scene, &scene->instances[slot]);
  *out = (drawn_parts){0};
  for (uint32_t d = 0; d < list->draw_count; ++d) {
    const plan_draw *draw = &list->draws[d];
    for (uint32_t i = 0; i < draw->count; ++i) {
      if (list->instances[draw->first + i] != slot)
        continue;
      assert_true(!out->whole && (!out->listed || draw->index_count));
      out->listed = true;
      out->whole = !draw->index_count;
      ++out->draws;
      uint32_t held = 0;
      for (uint32_t k = 0; k < parts.count && draw->index_count; ++k) {
        const plan_part *part = &parts.parts[k];
        const bool inside = part->index_count && part->first_index >= draw->first_index &&
                            part->first_index + part->index_count <= draw->first_index + draw->index_count;
        out->times[k] += inside;
        held += inside ? part->index_count : 0;
      }
      assert_int_equal(held, draw->index_count);
    }
  }
}

/* Whether a slot is drawn in parts. */
static bool check_slot(const plan_list *list, const plan_cells *cells, const double basis[9], const plan_scene *scene,
                       uint32_t slot) {
  const plan_instance *instance = &scene->instances[slot];
  const plan_parts parts = plan_parts_of(scene, instance);
  const plan_bounds *bounds = &scene->meshes[instance->mesh];
  drawn_parts drawn;
  find_drawn(&drawn, list, scene, slot);
  if (!parts.count)
    assert_true(drawn.listed || !over_read(cells, basis, instance, bounds->center, bounds->extent, 1.0 - 1e-9));
  for (uint32_t k = 0; k < parts.count; ++k) {
    const plan_part *part = &parts.parts[k];
    if (!part->index_count)
      continue;
    if (over_read(cells, basis, instance, part->center, part->extent, 1.0 - 1e-9))
      assert_true(drawn.whole || drawn.times[k] == 1);
    else if (!over_read(cells, basis, instance, part->center, part->extent, 1.0 + 1e-9) && !drawn.whole)
      assert_int_equal(drawn.times[k], 0);
    assert_true(drawn.times[k] <= 1);
  }
  return drawn.listed && !drawn.whole;
}

/* More lists than a frame has cascades: each has cells of its own. */
static void fill_lists(plan_list *out, plan_lists *lists, const plan_cells *cells, const double basis[9],
                       const plan_scene *scene, plan_memory *memory) {
  const plan_hull hull = {0};
  const plan_kept kept = {0};
  const plan_light_cull cull = {.basis = basis, .hull = &hull, .kept = &kept};
  *lists = (plan_lists){.count = lists_count, .sides = true, .among = scene->slot_count};
  for (uint32_t i = 0; i < lists_count; ++i) {
    out[i] = (plan_list){0};
    lists->lists[i] = &out[i];
  }
  plan_lists_begin(lists, memory);
  plan_lists_room(lists, scene);
  for (uint32_t slot = 0; slot < scene->slot_count; ++slot)
    plan_lists_add(lists, &(plan_found){.mask = (1u << lists_count) - 1, .slot = slot, .place = slot, .drawn = 1});
  plan_cull_unread(lists, cells, &cull, scene);
  plan_cull_unread_parts(lists, cells, &cull, scene);
  plan_lists_end(lists, scene);
}

static void every_part_that_is_read_is_drawn_once(void **state) {
  (void)state;
  random_state random = {1};
  uint32_t partly = 0;
  uint64_t left = 0;
  for (int i = 0; i < 60; ++i) {
    static parts_scene s;
    plan_list made[lists_count];
    plan_lists lists;
    plan_cells cells[lists_count];
    double light[3], basis[9];
    make_scene(&s, &random, instances, meshes);
    random_unit(&random, light);
    assert_int_equal(plan_light_basis(basis, light, NULL), CSM_SUCCESS);
    for (uint32_t k = 0; k < lists_count; ++k)
      make_cells(&cells[k], &random);
    fill_lists(made, &lists, cells, basis, &s.scene.scene, s.scene.memory);
    for (uint32_t k = 0; k < lists_count; ++k) {
      check_order(&made[k], &s.scene.scene);
      assert_int_equal(made[k].culled, instances - made[k].instance_count);
      left += made[k].culled;
      for (uint32_t slot = 0; slot < instances; ++slot) {
        const bool in = lists.found[slot].mask >> k & 1;
        drawn_parts drawn;
        find_drawn(&drawn, &made[k], &s.scene.scene, slot);
        assert_true(drawn.listed == in);
        partly += check_slot(&made[k], &cells[k], basis, &s.scene.scene, slot);
      }
    }
    scene_free(&s.scene);
  }
  assert_true(partly > 500 && left > 5000);
}

/* Where a list would have too many draws, what comes last is drawn whole. */
static void there_are_not_too_many_draws(void **state) {
  (void)state;
  enum { many = 200 };
  static parts_scene s;
  random_state random = {2};
  plan_list made[lists_count];
  plan_lists lists;
  plan_cells cells[lists_count];
  uint32_t whole = 0, apart = 0;
  s = (parts_scene){.scene = scene_make(many, 1)};
  s.scene.scene.parts = s.tables;
  s.scene.meshes[0] = (plan_bounds){.extent = {32.0, 0.0, 32.0}};
  s.tables[0] = (plan_parts){.parts = s.parts[0], .count = PLAN_MOST_PARTS};
  for (uint32_t k = 0; k < PLAN_MOST_PARTS; ++k) /* a strip each */
    s.parts[0][k] =
        (plan_part){.center = {k - 31.5, 0.0, 0.0}, .extent = {0.4, 0.0, 32.0}, .first_index = 3 * k, .index_count = 3};
  for (uint32_t i = 0; i < many; ++i)
    for (int k = 0; k < 3; ++k)
      s.scene.instances[i].transform[k * 5] = 1.0;
  scene_place(&s.scene);
  const double basis[9] = {1, 0, 0, 0, 0, 1, 0, 1, 0};
  for (uint32_t i = 0; i < lists_count; ++i) {
    cells[i] = (plan_cells){.begin = {-32.0, -32.0}, .size = {1.0, 1.0}};
    for (uint32_t y = 0; y < PLAN_CELLS; ++y)
      cells[i].read[y] = i ? 0x5555555555555555u : random_bits(&random) & random_bits(&random);
  }
  fill_lists(made, &lists, cells, basis, &s.scene.scene, s.scene.memory);
  for (uint32_t slot = 0; slot < many; ++slot) {
    drawn_parts drawn;
    find_drawn(&drawn, &made[1], &s.scene.scene, slot);
    assert_true(drawn.listed);
    whole += drawn.whole;
    apart += drawn.whole ? 0 : drawn.draws;
    assert_true(drawn.whole || drawn.draws == 32);
  }
  check_order(&made[1], &s.scene.scene);
  assert_int_equal(apart, PLAN_MOST_PART_DRAWS);
  assert_int_equal(whole, many - PLAN_MOST_PART_DRAWS / 32);
  scene_free(&s.scene);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_part_that_is_read_is_drawn_once),
      cmocka_unit_test(there_are_not_too_many_draws),
  };
  return cmocka_run_group_tests_name("plan-parts", tests, NULL, NULL);
}
