/*
 * tree.h: hierarchies of boxes, which rays are led through: over the triangles of a mesh, and over the instances of a
 * scene. As the plan: no GPU, no allocation, no globals.
 *
 * A tree is a list of nodes, each before what it holds. A ray that misses a node goes on after all that it holds: every
 * inner node says where that is, and no stack is needed. After a leaf comes the next node.
 */
#ifndef TREE_H
#define TREE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
  TREE_LEAF = 1u << 31,
  TREE_ITEMS_SHIFT = 28,      /* of a leaf's link: how many items, less 1 */
  TREE_MOST_ITEMS = 8,        /* in a leaf */
  TREE_MOST = (1u << 28) - 1, /* items in all */
};

/* Bounds are whole numbers on a grid: along each axis the lower one, and 65536 times the upper one. `link` of an inner node
   is the index of the node after all that it holds; of a leaf TREE_LEAF, its items' number less 1, and its first item. */
typedef struct tree_node {
  uint32_t bounds[3], link;
} tree_node;

typedef struct tree_box {
  float low[3], high[3];
} tree_box;

/* Takes a position to the grid: position * scale + offset, axis by axis. */
typedef struct tree_grid {
  double scale[3], offset[3];
} tree_grid;

typedef struct tree_shape {
  uint32_t most_items; /* in a leaf: 1 to TREE_MOST_ITEMS */
  float item_cost;     /* of an item, in those of a node */
} tree_shape;

/* Nodes that a tree of so many items may take; bytes that building one needs besides. */
size_t tree_nodes_most(uint32_t count);
size_t tree_scratch_size(uint32_t count);

/*
 * Builds a tree over the items' boxes, which are finite and ordered: by the surface area heuristic, in bins (Wald, "On
 * fast construction of SAH-based bounding volume hierarchies", 2007). `order` gets the items as the leaves have them. Gives the number of nodes, whose bounds are to
 * be fitted. Preconditions: 1 to TREE_MOST items; tree_nodes_most nodes; scratch is aligned to 16.
 */
uint32_t tree_build(tree_node *nodes, uint32_t *order, const tree_box *boxes, uint32_t count, tree_shape shape,
                    void *scratch);

/*
 * `order` may be NULL: boxes are in the leaves' order.
 * Fits a tree's bounds, and its grid, to its items' boxes, which may have moved since it was built. Bounds hold their boxes with
 * room of one step of the grid. `scratch`: node_count boxes. Gives the sum of all nodes' areas as a share of the first one's: what a ray has to do.
 */
double tree_fit(tree_node *nodes, uint32_t node_count, const uint32_t *order, const tree_box *boxes, tree_grid *grid,
                tree_box *scratch);

static inline bool tree_is_leaf(const tree_node *node) {
  return node->link & TREE_LEAF;
}

static inline uint32_t tree_first_item(const tree_node *leaf) {
  return leaf->link & TREE_MOST;
}

static inline uint32_t tree_item_count(const tree_node *leaf) {
  return (leaf->link >> TREE_ITEMS_SHIFT & (TREE_MOST_ITEMS - 1)) + 1;
}

#endif
