/* draw_list.h: replays a planned list of casters into the pass that is open. */
#ifndef DRAW_LIST_H
#define DRAW_LIST_H

#include "passes.h"

/*
 * Matrices of `rows` float4 rows each begin at `offset` of `matrices`, in the list's order. `programs` is by
 * pass_mesh.programs.
 */
void draw_list(pass_gpu gpu, gpu_program *const *programs, const plan_list *list, const pass_mesh *meshes,
               gpu_buffer *matrices, uint64_t offset, uint32_t rows);

/* What sets one such program apart. It draws positions into a depth image; there is a pixel
   shader only where an opacity cuts out what is not there. */
typedef struct draw_list_kind {
  const char *name;
  gpu_code vertex;
  gpu_code cut_out_vertex; /* with an opacity */
  uint32_t rows;
  gpu_compare compare;
  bool clip;
} draw_list_kind;

csm_result draw_list_program(pass_gpu gpu, const draw_list_kind *kind, pass_vertices vertices, gpu_program **out);

#endif
