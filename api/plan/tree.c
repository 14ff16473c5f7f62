#include "plan/tree.h"

#include <math.h>
#include <string.h>

enum {
  bin_count = 16,
  balanced_depth = 40, /* below it, halves: so that no tree is deeper than this and 32 more */
};

static const float grid_last = 65535.0f;

/* ---- boxes ---- */

static const tree_box no_box = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void widen(tree_box *box, const tree_box *by) {
  for (int axis = 0; axis < 3; ++axis) {
    box->low[axis] = by->low[axis] < box->low[axis] ? by->low[axis] : box->low[axis];
    box->high[axis] = by->high[axis] > box->high[axis] ? by->high[axis] : box->high[axis];
  }
}

/* Half of a box's surface; in doubles, which hold the product of any two floats. */
static double area(const tree_box *box) {
  double side[3];
  for (int axis = 0; axis < 3; ++axis) {
    side[axis] = (double)box->high[axis] - box->low[axis];
    if (!(side[axis] > 0.0))
      side[axis] = 0.0;
  }
  return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
}

static double middle(const tree_box *box, int axis) {
  return 0.5 * ((double)box->low[axis] + box->high[axis]);
}

/* ---- building ---- */

typedef struct bin {
  tree_box box;
  uint32_t count;
} bin;

typedef struct builder {
  tree_node *nodes;
  uint32_t node_count;
  uint32_t *order;
  const tree_box *boxes;
  tree_shape shape;
  bin bins[3][bin_count];
  double right_costs[bin_count];
} builder;

/* Items from `first` on. */
typedef struct span {
  uint32_t first, count;
} span;

typedef struct split {
  int axis;
  int bin; /* items of this bin and of those after it are apart from those before it */
  double cost;
  bool turned; /* those come first: they take up more */
} split;

/* Where middles lie, and the factor that takes them to bins: 0 where they do not differ. */
typedef struct spread {
  double low[3], scale[3];
} spread;

static spread spread_of(const builder *b, span all) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  spread out;
  for (uint32_t i = 0; i < all.count; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const double at = middle(&b->boxes[b->order[all.first + i]], axis);
      low[axis] = at < low[axis] ? at : low[axis];
      high[axis] = at > high[axis] ? at : high[axis];
    }
  for (int axis = 0; axis < 3; ++axis) {
    const double wide = high[axis] - low[axis];
    out.low[axis] = low[axis];
    out.scale[axis] = wide > 0x1p-500 ? bin_count / wide : 0.0;
  }
  return out;
}

static int bin_of(const spread *s, const tree_box *box, int axis) {
  const int at = (int)((middle(box, axis) - s->low[axis]) * s->scale[axis]);
  return at < bin_count ? at : bin_count - 1;
}

static void fill_bins(builder *b, span all, const spread *s) {
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < bin_count; ++i)
      b->bins[axis][i] = (bin){.box = no_box};
  for (uint32_t i = 0; i < all.count; ++i) {
    const tree_box *box = &b->boxes[b->order[all.first + i]];
    for (int axis = 0; axis < 3; ++axis) {
      bin *into = &b->bins[axis][bin_of(s, box, axis)];
      widen(&into->box, box);
      ++into->count;
    }
  }
}

/* The cheapest split between two bins of an axis: the halves' areas, each times its items. The half that takes up more comes
   first, for a ray is likelier to end there: Nah and Manocha, "SATO: Surface Area Traversal Order for Shadow Ray Tracing". */
static void try_axis(builder *b, int axis, split *best) {
  const bin *bins = b->bins[axis];
  tree_box box = no_box;
  uint32_t count = 0;
  for (int i = bin_count - 1; i > 0; --i) {
    widen(&box, &bins[i].box);
    count += bins[i].count;
    b->right_costs[i] = count ? area(&box) * count : 0.0;
  }
  box = no_box;
  uint32_t left = 0;
  for (int i = 1; i < bin_count; ++i) {
    widen(&box, &bins[i - 1].box);
    left += bins[i - 1].count;
    const uint32_t right = count + bins[0].count - left;
    const double wide = left ? area(&box) : 0.0, cost = wide * left + b->right_costs[i];
    if (left && right && cost < best->cost)
      *best = (split){.axis = axis, .bin = i, .cost = cost, .turned = b->right_costs[i] > wide * right};
  }
}

/* Items of the first half to the front; gives their number. */
static uint32_t part(builder *b, span all, const spread *s, const split *by) {
  uint32_t *order = &b->order[all.first];
  uint32_t front = 0;
  for (uint32_t i = 0; i < all.count; ++i)
    if ((bin_of(s, &b->boxes[order[i]], by->axis) < by->bin) != by->turned) {
      const uint32_t item = order[i];
      order[i] = order[front];
      order[front++] = item;
    }
  return front;
}

/* How many items the first half has; 0: they are best left together. */
static uint32_t divide(builder *b, span all, uint32_t depth) {
  if (all.count == 1)
    return 0;
  const bool fits = all.count <= b->shape.most_items;
  if (depth >= balanced_depth)
    return fits ? 0 : all.count / 2;
  const spread s = spread_of(b, all);
  split best = {.cost = INFINITY};
  tree_box whole = no_box;
  fill_bins(b, all, &s);
  for (int i = 0; i < bin_count; ++i)
    widen(&whole, &b->bins[0][i].box);
  for (int axis = 0; axis < 3; ++axis)
    if (s.scale[axis] > 0.0)
      try_axis(b, axis, &best);
  const double together = area(&whole) * b->shape.item_cost * all.count;
  if (fits && (best.cost == INFINITY || together <= area(&whole) + best.cost * b->shape.item_cost))
    return 0;
  return best.cost < INFINITY ? part(b, all, &s, &best) : all.count / 2;
}

static void build(builder *b, span all, uint32_t depth) {
  const uint32_t index = b->node_count++, first = divide(b, all, depth);
  if (!first) {
    b->nodes[index].link = TREE_LEAF | (all.count - 1) << TREE_ITEMS_SHIFT | all.first;
    return;
  }
  build(b, (span){all.first, first}, depth + 1);
  build(b, (span){all.first + first, all.count - first}, depth + 1);
  b->nodes[index].link = b->node_count;
}

size_t tree_nodes_most(uint32_t count) {
  return 2 * (size_t)count - 1;
}

size_t tree_scratch_size(uint32_t count) {
  const size_t boxes = tree_nodes_most(count) * sizeof(tree_box);
  return boxes > sizeof(builder) ? boxes : sizeof(builder);
}

uint32_t tree_build(tree_node *nodes, uint32_t *order, const tree_box *boxes, uint32_t count, tree_shape shape,
                    void *scratch) {
  builder *b = scratch;
  *b = (builder){.nodes = nodes, .order = order, .boxes = boxes, .shape = shape};
  for (uint32_t i = 0; i < count; ++i)
    order[i] = i;
  build(b, (span){0, count}, 0);
  return b->node_count;
}

/* ---- fitting ---- */

/* The grid reaches from 1 to 65534 over the box, and is no finer along an axis than a box that is flat there needs, nor than
   floats are where the box lies: else its numbers would be too large for them. */
static void make_grid(tree_grid *grid, const tree_box *box) {
  double widest = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    widest = fmax(widest, (double)box->high[axis] - box->low[axis]);
  for (int axis = 0; axis < 3; ++axis) {
    const double low = box->low[axis], high = box->high[axis], reach = fmax(fabs(low), fabs(high));
    const double least = fmax(fmax(widest * 0x1p-16, reach * 0x1p-24), 0x1p-100);
    grid->scale[axis] = (grid_last - 2.0) / fmax(high - low, least);
    grid->offset[axis] = 1.0 - low * grid->scale[axis];
  }
}

static void quantise(tree_node *node, const tree_box *box, const tree_grid *grid) {
  for (int axis = 0; axis < 3; ++axis) {
    const double low = floor(box->low[axis] * grid->scale[axis] + grid->offset[axis]) - 1.0;
    const double high = ceil(box->high[axis] * grid->scale[axis] + grid->offset[axis]) + 1.0;
    node->bounds[axis] = (uint32_t)fmax(low, 0.0) | (uint32_t)fmin(high, grid_last) << 16;
  }
}

static tree_box leaf_box(const tree_node *leaf, const uint32_t *order, const tree_box *boxes) {
  tree_box box = no_box;
  for (uint32_t i = 0; i < tree_item_count(leaf); ++i) {
    const uint32_t item = tree_first_item(leaf) + i;
    widen(&box, &boxes[order ? order[item] : item]);
  }
  return box;
}

double tree_fit(tree_node *nodes, uint32_t node_count, const uint32_t *order, const tree_box *boxes, tree_grid *grid,
                tree_box *scratch) {
  double sum = 0.0;
  for (uint32_t i = node_count; i-- > 0;) { /* what a node holds comes after it */
    if (tree_is_leaf(&nodes[i])) {
      scratch[i] = leaf_box(&nodes[i], order, boxes);
    } else {
      const uint32_t second = tree_is_leaf(&nodes[i + 1]) ? i + 2 : nodes[i + 1].link;
      scratch[i] = scratch[i + 1];
      widen(&scratch[i], &scratch[second]);
    }
    sum += area(&scratch[i]);
  }
  make_grid(grid, &scratch[0]);
  for (uint32_t i = 0; i < node_count; ++i)
    quantise(&nodes[i], &scratch[i], grid);
  return sum / fmax(area(&scratch[0]), 0x1p-500);
}
