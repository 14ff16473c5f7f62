/* mesh_parts.h: the order of a copied mesh's triangles on a device, and the parts that a large one is divided into. */
#ifndef SCENE_MESH_PARTS_H
#define SCENE_MESH_PARTS_H

#include "device/geometry.h"
#include "plan/plan.h"

/* Meshes of more triangles are divided, into parts of at most half as many unless there would be too many parts. */
enum { MESH_WHOLE = 256 };

/*
 * Of a checked mesh with positions; the same each time. The caller releases the order's triangles, and frees the parts.
 * Errors: OUT_OF_MEMORY, and neither is made.
 */
csm_result mesh_parts_make(host *host, const csm_mesh_info *info, geometry_order *order, plan_parts *parts);
/* The mesh is whole from then on. */
void mesh_parts_free(plan_parts *parts, host *host);

#endif
