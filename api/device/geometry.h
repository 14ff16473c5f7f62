/* geometry.h: meshes on a device: copied ones in pages, and engines' own buffers. Meshes go by their index in the
   context's table. */
#ifndef DEVICE_GEOMETRY_H
#define DEVICE_GEOMETRY_H

#include "device/alpha_images.h"
#include "device/tree_pool.h"
#include "device/device.h"

/* What an alpha-tested mesh is cut out with. */
typedef struct mesh_cut_out {
  const csm_alpha_mask_info *mask; /* size and wrapping; NULL: the mesh is opaque */
  uint32_t index;                  /* of the mask's image */
} mesh_cut_out;

/* What rays look up of a mesh, to be placed with it: rows of `rays` are from the first one of the bytes on. */
typedef struct mesh_traced {
  const mesh_rays *rays; /* NULL: it cannot be traced */
  tree_bytes bytes;
} mesh_traced;

/* The order in which a copied mesh's triangles are stored. */
typedef struct geometry_order {
  uint32_t *triangles; /* all of them; NULL for an engine's buffers */
  uint32_t drawn;      /* the first ones, which have an area */
} geometry_order;

/* The vertex at a corner of a copied mesh, of any alignment. */
uint32_t geometry_index(const csm_mesh_info *info, uint32_t corner);
/* Positions as they are stored, three floats each, less the offset: the differences are exact, see plan_bounds. */
void geometry_positions(float *to, const void *positions, uint32_t stride, uint32_t count, const double *offset);
/* Makes room for meshes in `capacity` places. */
csm_result geometry_reserve(device *device, uint32_t capacity);
/*
 * Places a checked mesh below the capacity: copies it to staging, or takes in an engine's buffers. Positions are stored
 * less `offset`, of three doubles. Triangles of a copied mesh beyond those that the order names as drawn are not drawn
 * until it is updated.
 */
csm_result geometry_add(device *device, uint32_t index, const csm_mesh_info *info, const double *offset,
                        const geometry_order *order, const mesh_cut_out *cut_out, const mesh_traced *traced);
/*
 * Memory for other bytes of what rays look up of a mesh, which the next recording takes; until they are written it has those
 * that are given. Errors: those of device_buffer, OUT_OF_MEMORY.
 */
csm_result geometry_retrace(device *device, uint32_t index, const mesh_traced *now, void **memory);
/* And what is to be known of it then. */
void geometry_retraced(device *device, uint32_t index, const mesh_rays *rays);
/*
 * Gives a copied mesh of that shape other positions, less another offset. Frames that were recorded before draw what they had: the
 * next recording copies them, in the queue's order. Errors: those of device_buffer, OUT_OF_MEMORY.
 */
csm_result geometry_update(device *device, uint32_t index, const csm_mesh_update_info *info, const csm_mesh_info *shape,
                           const double *offset);
/* Whether a mesh lies in an engine's own buffers. */
bool geometry_is_engines(const device *device, uint32_t index);
/* Frees a place once the GPU is done with it. */
void geometry_remove(device *device, uint32_t index);

#endif
