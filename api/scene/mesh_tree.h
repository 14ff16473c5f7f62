/*
 * mesh_tree.h: what rays look up of a mesh: a tree over its triangles, the triangles in the order of its leaves, and the
 * uvs of an alpha-tested one. Rows of 16 bytes, as csm_rays.inc reads them.
 */
#ifndef SCENE_MESH_TREE_H
#define SCENE_MESH_TREE_H

#include "device/geometry.h"

typedef struct mesh_tree {
  mesh_rays rays; /* with rows from the first of `bytes` on, and without the alpha mask */
  tree_bytes bytes;
  uint32_t *corners; /* vertices of the triangles, in the order of the leaves */
  double build_ms;
} mesh_tree;

/* Of a checked mesh with positions, which are stored less `offset`. Errors: LIMIT_EXCEEDED, OUT_OF_MEMORY. */
csm_result mesh_tree_make(host *host, const csm_mesh_info *info, const double *offset, mesh_tree **out);
/* Memory that fitting it to other positions needs for a while; the caller releases it. NULL: there is none. */
void *mesh_tree_room(const mesh_tree *tree, host *host);
/* Fits it to other positions. */
void mesh_tree_refit(mesh_tree *tree, void *room, const csm_mesh_update_info *info, const double *offset);
/* NULL is allowed. */
void mesh_tree_free(mesh_tree *tree, host *host);

#endif
