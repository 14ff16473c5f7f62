#include "scene/mesh_tree.h"

#include "device/clock.h"
#include "plan/tree.h"

#include <math.h>
#include <string.h>

enum { triangle_rows = 3, uv_rows = 2, row_floats = 4 };

/* Three corners; a row each, whose last number is unused. */
typedef float triangle[triangle_rows][row_floats];

static tree_node *nodes_of(const mesh_tree *tree) {
  return (tree_node *)tree->bytes.memory;
}

static triangle *triangles_of(const mesh_tree *tree) {
  return (triangle *)((char *)tree->bytes.memory + (size_t)tree->rays.triangle_row * TREE_POOL_ROW);
}

static void read_triangle(triangle out, const void *positions, uint32_t stride, const uint32_t *corners,
                          const double *offset) {
  for (int i = 0; i < 3; ++i) {
    geometry_positions(out[i], (const char *)positions + (size_t)corners[i] * stride, stride, 1, offset);
    out[i][3] = 0.0f;
  }
}

static tree_box box_of(const triangle t) {
  tree_box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = fminf(fminf(t[0][axis], t[1][axis]), t[2][axis]);
    box.high[axis] = fmaxf(fmaxf(t[0][axis], t[1][axis]), t[2][axis]);
  }
  return box;
}

/* ---- building ---- */

/* What is needed for a while; one block of memory. */
typedef struct room {
  tree_node *nodes;
  tree_box *boxes;
  uint32_t *corners, *order;
  void *scratch;
} room;

static void *make_room(room *out, host *host, uint32_t count) {
  const size_t nodes = tree_nodes_most(count) * sizeof(tree_node), boxes = count * sizeof(tree_box);
  const size_t corners = 3 * (size_t)count * sizeof(uint32_t), order = count * sizeof(uint32_t);
  const size_t scratch = tree_scratch_size(count);
  char *block = host_allocate(host, nodes + boxes + corners + order + scratch + 5 * HOST_CARVED), *at = block;
  if (!block)
    return NULL;
  out->nodes = host_carve(&at, nodes);
  out->boxes = host_carve(&at, boxes);
  out->corners = host_carve(&at, corners);
  out->order = host_carve(&at, order);
  out->scratch = host_carve(&at, scratch);
  return block;
}

/* Boxes and corners of all triangles, as they come. */
static void read_mesh(room *room, const csm_mesh_info *info, const double *offset) {
  for (uint32_t i = 0; i < info->index_count / 3; ++i) {
    triangle t;
    for (uint32_t k = 0; k < 3; ++k)
      room->corners[3 * i + k] = geometry_index(info, 3 * i + k);
    read_triangle(t, info->positions, info->position_stride, &room->corners[3 * i], offset);
    room->boxes[i] = box_of(t);
  }
}

static void write_uvs(mesh_tree *tree, const csm_mesh_info *info) {
  float *to = (float *)((char *)tree->bytes.memory + (size_t)tree->rays.uv_row * TREE_POOL_ROW);
  for (uint32_t i = 0; i < tree->rays.triangle_count; ++i, to += uv_rows * row_floats)
    for (uint32_t k = 0; k < 3; ++k)
      memcpy(&to[2 * k], (const char *)info->uvs + (size_t)tree->corners[3 * i + k] * info->uv_stride, 2 * sizeof *to);
}

/* Fits the nodes to boxes in the order of the leaves. */
static void fit(mesh_tree *tree, const tree_box *boxes, tree_box *scratch) {
  tree_grid grid;
  mesh_rays *rays = &tree->rays;
  rays->cost = tree_fit(nodes_of(tree), rays->node_count, NULL, boxes, &grid, scratch);
  rays->reach = 0.0;
  for (uint32_t i = 0; i < rays->triangle_count; ++i)
    for (int axis = 0; axis < 3; ++axis)
      rays->reach = fmax(rays->reach, fmax(fabs(boxes[i].low[axis]), fabs(boxes[i].high[axis])));
  memcpy(rays->grid_scale, grid.scale, sizeof grid.scale);
  memcpy(rays->grid_offset, grid.offset, sizeof grid.offset);
}

/* Rows of the tree's parts, one after the other. */
static void lay_out(mesh_tree *tree, uint32_t node_count, const csm_mesh_info *info) {
  const uint32_t count = info->index_count / 3;
  mesh_rays *rays = &tree->rays;
  rays->node_count = node_count;
  rays->triangle_count = count;
  rays->triangle_row = node_count;
  rays->uv_row = info->alpha_mask ? node_count + triangle_rows * count : MESH_RAYS_NONE;
  tree->bytes.size =
      ((uint64_t)node_count + (triangle_rows + (info->alpha_mask ? uv_rows : 0)) * (uint64_t)count) * TREE_POOL_ROW;
}

/* The tree in memory of its own, from what was built in the room. */
static csm_result assemble(host *host, const room *room, uint32_t node_count, const csm_mesh_info *info,
                           const double *offset, mesh_tree **out) {
  const uint32_t count = info->index_count / 3;
  mesh_tree *tree = host_allocate(host, sizeof *tree);
  if (!tree)
    return CSM_ERROR_OUT_OF_MEMORY;
  lay_out(tree, node_count, info);
  tree->bytes.memory = host_allocate(host, tree->bytes.size);
  tree->corners = host_allocate(host, 3 * (size_t)count * sizeof *tree->corners);
  if (!tree->bytes.memory || !tree->corners) {
    mesh_tree_free(tree, host);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  memcpy(nodes_of(tree), room->nodes, node_count * sizeof(tree_node));
  tree_box *boxes = room->scratch; /* of the triangles, and after them of the nodes */
  for (uint32_t i = 0; i < count; ++i) {
    memcpy(&tree->corners[3 * i], &room->corners[3 * room->order[i]], 3 * sizeof *tree->corners);
    read_triangle(triangles_of(tree)[i], info->positions, info->position_stride, &tree->corners[3 * i], offset);
  }
  for (uint32_t i = 0; i < count; ++i)
    room->boxes[i] = box_of(triangles_of(tree)[i]);
  fit(tree, room->boxes, boxes);
  if (info->alpha_mask)
    write_uvs(tree, info);
  *out = tree;
  return CSM_SUCCESS;
}

csm_result mesh_tree_make(host *host, const csm_mesh_info *info, const double *offset, mesh_tree **out) {
  const uint32_t count = info->index_count / 3;
  const double begin_ms = clock_ms();
  room room;
  *out = NULL;
  if (count > TREE_MOST)
    return host_fail(host, CSM_ERROR_LIMIT_EXCEEDED, "the mesh has more than %u triangles, the most of a tree",
                     TREE_MOST);
  void *block = make_room(&room, host, count);
  if (!block)
    return CSM_ERROR_OUT_OF_MEMORY;
  read_mesh(&room, info, offset);
  const tree_shape shape = {.most_items = 4, .item_cost = 0.8f};
  const uint32_t nodes = tree_build(room.nodes, room.order, room.boxes, count, shape, room.scratch);
  const csm_result result = assemble(host, &room, nodes, info, offset, out);
  host_release(host, block);
  if (!result)
    (*out)->build_ms = clock_ms() - begin_ms;
  return result;
}

void *mesh_tree_room(const mesh_tree *tree, host *host) {
  return host_allocate(host, (tree->rays.triangle_count + (size_t)tree->rays.node_count) * sizeof(tree_box));
}

void mesh_tree_refit(mesh_tree *tree, void *room, const csm_mesh_update_info *info, const double *offset) {
  const uint32_t count = tree->rays.triangle_count;
  tree_box *boxes = room;
  for (uint32_t i = 0; i < count; ++i) {
    read_triangle(triangles_of(tree)[i], info->positions, info->position_stride, &tree->corners[3 * i], offset);
    boxes[i] = box_of(triangles_of(tree)[i]);
  }
  fit(tree, boxes, boxes + count);
}

void mesh_tree_free(mesh_tree *tree, host *host) {
  if (!tree)
    return;
  host_release(host, (void *)tree->bytes.memory);
  host_release(host, tree->corners);
  host_release(host, tree);
}
