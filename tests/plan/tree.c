/* Trees of boxes, on items of every kind: what the shaders that walk through them take for granted. */
#include "plan/tree.h"
#include "support.h"

#include <fenv.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { most_depth = 72, grid_end = 65535 };

/* A tree with all that it is made of. */
typedef struct grove {
  uint32_t count, node_count;
  tree_shape shape;
  tree_box *boxes;
  tree_node *nodes;
  uint32_t *order;
  void *scratch;
  tree_grid grid;
  double cost;
} grove;

static grove grove_make(uint32_t count, tree_shape shape) {
  grove g = {.count = count, .shape = shape};
  g.boxes = calloc(count, sizeof *g.boxes);
  g.nodes = calloc(tree_nodes_most(count), sizeof *g.nodes);
  g.order = calloc(count, sizeof *g.order);
  g.scratch = aligned_alloc(16, (tree_scratch_size(count) + 15) / 16 * 16);
  assert_true(g.boxes && g.nodes && g.order && g.scratch);
  return g;
}

static void grove_free(grove *g) {
  free(g->boxes);
  free(g->nodes);
  free(g->order);
  free(g->scratch);
}

static void fit(grove *g) {
  feclearexcept(FE_ALL_EXCEPT);
  g->cost = tree_fit(g->nodes, g->node_count, g->order, g->boxes, &g->grid, g->scratch);
  assert_no_exceptions();
}

static void build(grove *g) {
  feclearexcept(FE_ALL_EXCEPT);
  g->node_count = tree_build(g->nodes, g->order, g->boxes, g->count, g->shape, g->scratch);
  assert_no_exceptions();
  fit(g);
}

/* ---- items ---- */

enum { SCATTERED, EQUAL, POINTS, ONE_POINT, LINE, FLAT, HUGE_NUMBERS, TINY, SPREAD, FAR_AWAY, CLUSTERS, KINDS };

/* Around a place, `wide` from it to each side. */
static tree_box box_at(const double at[3], double wide) {
  tree_box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = (float)(at[axis] - wide);
    box.high[axis] = (float)(at[axis] + wide);
  }
  return box;
}

static tree_box random_box(random_state *random, int kind) {
  const double size = kind == HUGE_NUMBERS ? 1e30 : kind == TINY ? 1e-30 : 100.0;
  double at[3], wide = size * random_scale(random, 1e-4, 0.1);
  for (int axis = 0; axis < 3; ++axis)
    at[axis] = random_between(random, -size, size);
  if (kind == LINE)
    at[0] = at[2] = 3.0;
  for (int axis = 0; axis < 3 && kind == SPREAD; ++axis) /* over all that floats are */
    at[axis] = random_scale(random, 1e-36, 1e36) * (random_below(random, 2) ? 1.0 : -1.0);
  for (int axis = 0; axis < 3 && kind == FAR_AWAY; ++axis)
    at[axis] += 1e6;
  for (int axis = 0; axis < 3 && kind == CLUSTERS; ++axis)
    at[axis] = at[axis] * 1e-4 + 90.0 * (random_below(random, 2) ? 1.0 : -1.0);
  if (kind == POINTS || kind == LINE || kind == SPREAD)
    wide = 0.0;
  tree_box box = box_at(at, wide);
  if (kind == FLAT)
    box.low[1] = box.high[1] = 0.0f;
  return box;
}

static void scatter(grove *g, random_state *random, int kind) {
  const double same[3] = {1.0, -2.0, 3.0};
  for (uint32_t i = 0; i < g->count; ++i)
    g->boxes[i] =
        kind == EQUAL || kind == ONE_POINT ? box_at(same, kind == EQUAL ? 0.5 : 0.0) : random_box(random, kind);
}

/* ---- what must hold ---- */

static uint32_t end_of(const grove *g, uint32_t node) {
  return tree_is_leaf(&g->nodes[node]) ? node + 1 : g->nodes[node].link;
}

/* Less what doubles leave of a place on the grid. */
static double room(const grove *g, int axis) {
  return 1.0 - 0x1p-49 * (fabs(g->grid.offset[axis]) + grid_end);
}

static void check_bounds(const grove *g, const tree_node *node, const tree_box *box) {
  for (int axis = 0; axis < 3; ++axis) {
    const long double scale = g->grid.scale[axis], offset = g->grid.offset[axis];
    const uint32_t low = node->bounds[axis] & 0xffff, high = node->bounds[axis] >> 16;
    const double at_low = (double)(box->low[axis] * scale + offset - low);
    const double at_high = (double)(high - (box->high[axis] * scale + offset));
    if (!(at_low >= room(g, axis) && at_high >= room(g, axis)))
      fail_msg("axis %d: %u to %u has %g and %g steps of room", axis, low, high, at_low, at_high);
  }
}

static void join(tree_box *box, const tree_box *by) {
  for (int axis = 0; axis < 3; ++axis) {
    box->low[axis] = fminf(box->low[axis], by->low[axis]);
    box->high[axis] = fmaxf(box->high[axis], by->high[axis]);
  }
}

/* Checks what a node holds, which ends at `end`, and gives its box. */
static tree_box check_node(const grove *g, uint32_t at, uint32_t end, uint32_t depth, uint32_t *seen) {
  const tree_node *node = &g->nodes[at];
  tree_box box;
  assert_true(at < g->node_count && depth <= most_depth);
  if (tree_is_leaf(node)) {
    const uint32_t first = tree_first_item(node), count = tree_item_count(node);
    assert_true(end == at + 1 && count <= g->shape.most_items && first + count <= g->count);
    box = g->boxes[g->order[first]];
    for (uint32_t i = first; i < first + count; ++i) {
      assert_int_equal(seen[g->order[i]]++, 0);
      join(&box, &g->boxes[g->order[i]]);
    }
  } else {
    assert_int_equal(node->link, end);
    const uint32_t middle = end_of(g, at + 1);
    assert_true(at + 1 < middle && middle < end);
    box = check_node(g, at + 1, middle, depth + 1, seen);
    const tree_box second = check_node(g, middle, end, depth + 1, seen);
    join(&box, &second);
  }
  check_bounds(g, node, &box);
  return box;
}

static void check(const grove *g) {
  uint32_t *seen = calloc(g->count, sizeof *seen);
  assert_non_null(seen);
  assert_in_range(g->node_count, 1, tree_nodes_most(g->count));
  check_node(g, 0, g->node_count, 0, seen);
  for (uint32_t i = 0; i < g->count; ++i)
    assert_int_equal(seen[i], 1);
  free(seen);
}

/* ---- rays ---- */

typedef struct test_ray {
  double at[3], way[3];
} test_ray;

/* Whether a ray meets a box, whose sides belong to it. */
static bool meets(const test_ray *ray, const double low[3], const double high[3]) {
  double enters = 0.0, leaves = INFINITY;
  for (int axis = 0; axis < 3; ++axis) {
    if (ray->way[axis] == 0.0) {
      if (ray->at[axis] < low[axis] || ray->at[axis] > high[axis])
        return false;
      continue;
    }
    const double a = (low[axis] - ray->at[axis]) / ray->way[axis], b = (high[axis] - ray->at[axis]) / ray->way[axis];
    enters = fmax(enters, fmin(a, b));
    leaves = fmin(leaves, fmax(a, b));
  }
  return enters <= leaves;
}

static bool meets_node(const test_ray *on_grid, const tree_node *node) {
  double low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = node->bounds[axis] & 0xffff;
    high[axis] = node->bounds[axis] >> 16;
  }
  return meets(on_grid, low, high);
}

static bool meets_item(const test_ray *ray, const tree_box *box) {
  double low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = box->low[axis];
    high[axis] = box->high[axis];
  }
  return meets(ray, low, high);
}

/* From anywhere in or around the tree; along an axis now and then, and to the middle of an item mostly. */
static test_ray random_ray(random_state *random, const grove *g) {
  const tree_box *to = &g->boxes[random_below(random, g->count)], *from = &g->boxes[random_below(random, g->count)];
  test_ray ray = {{0}, {0}};
  for (int axis = 0; axis < 3; ++axis) {
    ray.at[axis] = from->low[axis] + grid_end / g->grid.scale[axis] * random_between(random, -0.6, 0.6);
    ray.way[axis] = 0.5 * ((double)to->low[axis] + to->high[axis]) - ray.at[axis];
  }
  const uint32_t along = random_below(random, 6);
  for (uint32_t axis = 0; axis < 3 && along < 3; ++axis) {
    ray.at[axis] = axis == along ? ray.at[axis] : to->low[axis];
    ray.way[axis] = axis == along ? ray.way[axis] : 0.0;
  }
  return ray;
}

static test_ray on_grid(const test_ray *ray, const tree_grid *grid) {
  test_ray out;
  for (int axis = 0; axis < 3; ++axis) {
    out.at[axis] = ray->at[axis] * grid->scale[axis] + grid->offset[axis];
    out.way[axis] = ray->way[axis] * grid->scale[axis];
  }
  return out;
}

/* Leaves that the walk comes to are those that the ray meets, and all items that it meets are in them. */
static uint32_t check_ray(const grove *g, const test_ray *ray, bool *visited) {
  const test_ray there = on_grid(ray, &g->grid);
  uint32_t steps = 0, met = 0;
  memset(visited, 0, g->count * sizeof *visited);
  for (uint32_t node = 0; node < g->node_count; ++steps) {
    const bool leaf = tree_is_leaf(&g->nodes[node]), hit = meets_node(&there, &g->nodes[node]);
    const uint32_t first = tree_first_item(&g->nodes[node]);
    for (uint32_t i = 0; leaf && hit && i < tree_item_count(&g->nodes[node]); ++i)
      visited[g->order[first + i]] = true;
    node = leaf || hit ? node + 1 : g->nodes[node].link;
    assert_true(steps < g->node_count);
  }
  for (uint32_t node = 0; node < g->node_count; ++node)
    if (tree_is_leaf(&g->nodes[node]))
      assert_true(visited[g->order[tree_first_item(&g->nodes[node])]] == meets_node(&there, &g->nodes[node]));
  for (uint32_t i = 0; i < g->count; ++i)
    if (meets_item(ray, &g->boxes[i])) {
      assert_true(visited[i]);
      ++met;
    }
  return met;
}

static void check_rays(const grove *g, random_state *random, uint32_t count) {
  bool *visited = calloc(g->count, sizeof *visited);
  uint32_t met = 0;
  assert_non_null(visited);
  for (uint32_t i = 0; i < count; ++i) {
    const test_ray ray = random_ray(random, g);
    met += check_ray(g, &ray, visited) > 0;
  }
  assert_true(met * 3 > count); /* a third of the rays go along an axis through a corner */
  free(visited);
}

/* ---- tests ---- */

static const uint32_t counts[] = {1, 2, 3, 5, 8, 9, 40, 333, 2000};
enum { count_count = sizeof counts / sizeof counts[0] };

static tree_shape shape_of(uint32_t i) {
  static const tree_shape shapes[] = {{1, 4.0f}, {4, 1.5f}, {TREE_MOST_ITEMS, 1.0f}, {2, 0.01f}};
  return shapes[i % 4];
}

static void every_tree_is_sound(void **state) {
  (void)state;
  random_state random = {1};
  for (int kind = 0; kind < KINDS; ++kind)
    for (uint32_t i = 0; i < count_count * 4; ++i) {
      grove g = grove_make(counts[i / 4], shape_of(i));
      scatter(&g, &random, kind);
      build(&g);
      check(&g);
      check_rays(&g, &random, 60);
      grove_free(&g);
    }
}

/* What moved keeps its place in the tree, whose bounds follow: a little, and to somewhere else altogether. */
static void a_tree_follows_what_moves(void **state) {
  (void)state;
  random_state random = {2};
  for (int kind = 0; kind < KINDS; ++kind)
    for (uint32_t i = 0; i < count_count; ++i) {
      grove g = grove_make(counts[i], shape_of(i + (uint32_t)kind));
      scatter(&g, &random, kind);
      build(&g);
      for (int step = 0; step < 4; ++step) {
        for (uint32_t k = 0; k < g.count; k += 1 + random_below(&random, 3))
          g.boxes[k] = random_box(&random, step % 2 ? (int)random_below(&random, KINDS) : kind);
        fit(&g);
        check(&g);
        check_rays(&g, &random, 20);
      }
      grove_free(&g);
    }
}

/* One item far away from the grid's zero, as flat as it may be: the numbers of the grid stay those of floats. */
static void a_grid_fits_into_floats(void **state) {
  (void)state;
  static const float places[] = {0.0f, 1e-38f, 1e-3f, 1.0f, 1e7f, 1e20f, 1e30f, -1e30f, FLT_MAX};
  grove g = grove_make(1, shape_of(0));
  for (size_t i = 0; i < sizeof places / sizeof *places; ++i)
    for (int flat = 0; flat < 8; ++flat) {
      for (int axis = 0; axis < 3; ++axis) {
        g.boxes[0].low[axis] = g.boxes[0].high[axis] = places[i];
        if (flat >> axis & 1)
          g.boxes[0].low[axis] -= 1e-2f;
      }
      build(&g);
      check(&g);
      for (int axis = 0; axis < 3; ++axis)
        assert_true(g.grid.scale[axis] < FLT_MAX && fabs(g.grid.offset[axis]) < FLT_MAX);
    }
  grove_free(&g);
}

static void many_items_make_a_sound_tree(void **state) {
  (void)state;
  static const int kinds[] = {SCATTERED, EQUAL, SPREAD, FLAT};
  random_state random = {3};
  for (uint32_t i = 0; i < 4; ++i) {
    grove g = grove_make(100000, shape_of(i));
    scatter(&g, &random, kinds[i]);
    build(&g);
    check(&g);
    check_rays(&g, &random, 5);
    grove_free(&g);
  }
}

/* Each item is half as far from the first one as the one before: what splits evenly in space is a chain. */
static void a_chain_is_no_deeper_than_it_may_be(void **state) {
  (void)state;
  enum { levels = 250 };
  random_state random = {4};
  for (uint32_t same = 1; same <= 100; same *= 10) {
    grove g = grove_make(levels * same, shape_of(0));
    for (uint32_t i = 0; i < g.count; ++i) {
      const double at = ldexp(1.0, 124 - (int)(i / same));
      g.boxes[i] = box_at((double[]){at, at, at}, 0.0);
    }
    build(&g);
    check(&g);
    check_rays(&g, &random, 20);
    grove_free(&g);
  }
}

/* ---- cost ---- */

/* Halves of a list, whose order says nothing of places. */
static void halve(grove *g, uint32_t first, uint32_t count) {
  tree_node *node = &g->nodes[g->node_count++];
  if (count <= g->shape.most_items) {
    node->link = TREE_LEAF | (count - 1) << TREE_ITEMS_SHIFT | first;
    return;
  }
  halve(g, first, count / 2);
  halve(g, first + count / 2, count - count / 2);
  node->link = g->node_count;
}

/* A ray that meets the first node meets any other one by the share of their areas: what tree_fit says, summed up here. */
static double cost_of(const grove *g) {
  double sum = 0.0, first = 0.0;
  for (uint32_t at = 0; at < g->node_count; ++at) {
    tree_box box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t i = at; i < end_of(g, at); ++i)
      for (uint32_t k = 0; tree_is_leaf(&g->nodes[i]) && k < tree_item_count(&g->nodes[i]); ++k)
        join(&box, &g->boxes[g->order[tree_first_item(&g->nodes[i]) + k]]);
    const double x = (double)box.high[0] - box.low[0], y = (double)box.high[1] - box.low[1];
    const double z = (double)box.high[2] - box.low[2];
    sum += x * y + y * z + z * x;
    first = at ? first : sum;
  }
  return sum / first;
}

static void a_tree_is_worth_its_building(void **state) {
  (void)state;
  static const int kinds[] = {SCATTERED, FLAT, CLUSTERS, FAR_AWAY};
  random_state random = {5};
  for (uint32_t i = 0; i < 4; ++i) {
    grove g = grove_make(4000, (tree_shape){4, 1.5f});
    scatter(&g, &random, kinds[i]);
    build(&g);
    const double built = g.cost;
    assert_near(built / cost_of(&g), 1.0, 1e-9);
    for (uint32_t k = 0; k < g.count; ++k)
      g.order[k] = k;
    g.node_count = 0;
    halve(&g, 0, g.count);
    fit(&g);
    check(&g);
    assert_near(g.cost / cost_of(&g), 1.0, 1e-9);
    assert_true(built < 0.1 * g.cost);
    grove_free(&g);
  }
}

/* Boxes may come in the order of the leaves. */
static void boxes_in_order_need_no_list(void **state) {
  (void)state;
  random_state random = {6};
  grove g = grove_make(500, shape_of(1));
  scatter(&g, &random, SCATTERED);
  build(&g);
  tree_box *sorted = calloc(g.count, sizeof *sorted);
  tree_node *nodes = calloc(g.node_count, sizeof *nodes);
  tree_grid grid;
  assert_true(sorted && nodes);
  for (uint32_t i = 0; i < g.count; ++i)
    sorted[i] = g.boxes[g.order[i]];
  for (uint32_t i = 0; i < g.node_count; ++i)
    nodes[i].link = g.nodes[i].link;
  const double cost = tree_fit(nodes, g.node_count, NULL, sorted, &grid, g.scratch);
  assert_true(cost == g.cost);
  assert_memory_equal(&grid, &g.grid, sizeof grid);
  assert_memory_equal(nodes, g.nodes, g.node_count * sizeof *nodes);
  free(sorted);
  free(nodes);
  grove_free(&g);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(every_tree_is_sound),
      cmocka_unit_test(a_tree_follows_what_moves),
      cmocka_unit_test(a_grid_fits_into_floats),
      cmocka_unit_test(many_items_make_a_sound_tree),
      cmocka_unit_test(a_chain_is_no_deeper_than_it_may_be),
      cmocka_unit_test(a_tree_is_worth_its_building),
      cmocka_unit_test(boxes_in_order_need_no_list),
  };
  return cmocka_run_group_tests_name("plan-tree", tests, NULL, NULL);
}
