/* draw_list.h: replays a planned list of casters into the pass that is open. */
#ifndef DRAW_LIST_H
#define DRAW_LIST_H

#include "techniques/passes.h"

typedef struct draw_list_info {
  gpu_program *const *const *programs; /* by gpu_cull, then by pass_mesh.programs */
  gpu_cull cull;                       /* of meshes that are not two-sided; mirrored ones have it turned around */
  bool skip_hidden;                    /* back faces of closed meshes are left out */
  const plan_list *list;
  const pass_mesh *meshes;
  gpu_buffer *matrices; /* `rows` float4 rows each from `offset` on, in the list's order */
  uint64_t offset;
  uint32_t rows;
} draw_list_info;

void draw_list(pass_gpu gpu, const draw_list_info *info);

/* What sets one such program apart. It draws positions into a depth image; there is a pixel
   shader only where an alpha mask cuts out what is not there. */
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

csm_result draw_list_program(pass_gpu gpu, const draw_list_kind *kind, pass_vertices vertices, gpu_program **out);

#endif
