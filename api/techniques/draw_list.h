/* draw_list.h: replays a planned list of instances into the pass that is open, for every technique that draws meshes.
 */
#ifndef TECHNIQUES_DRAW_LIST_H
#define TECHNIQUES_DRAW_LIST_H

#include "device/device.h"
#include "plan/plan.h"

typedef struct draw_list_info {
  gpu_program *const *programs[3]; /* by gpu_cull, then by shape */
  gpu_cull cull;                   /* of meshes that are not two-sided; mirrored ones have it turned around */
  bool skip_hidden;                /* back faces of watertight meshes are left out */
  const plan_list *list;
  const mesh_place *meshes;
  gpu_buffer *matrices; /* `rows` float4 rows each from `offset` on, in the list's order */
  uint64_t offset;
  uint32_t rows;
} draw_list_info;

void draw_list(gpu gpu, const draw_list_info *info);

/* Bytes of the matrices of a list. */
uint64_t draw_list_bytes(const plan_list *list, uint32_t rows);

/* Indices of a draw's mesh that each of its instances is drawn with. */
uint32_t draw_list_indices(const plan_draw *draw, const mesh_place *mesh);

/* What sets one program that draws meshes apart. It draws positions into a depth image; there is a pixel shader only
   where an alpha mask cuts out what is not there. */
typedef struct draw_list_kind {
  const char *name;
  gpu_code vertex;
  gpu_code cut_out_vertex; /* with an alpha mask */
  uint32_t rows;
  gpu_format format;
  gpu_compare compare;
  bool clip;
  gpu_cull cull;
  gpu_raster_bias bias;
} draw_list_kind;

csm_result draw_list_program(gpu gpu, const draw_list_kind *kind, mesh_vertices vertices, gpu_program **out);

#endif
