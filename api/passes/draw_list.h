/* draw_list.h: replays a planned list of casters into the pass that is open. */
#ifndef DRAW_LIST_H
#define DRAW_LIST_H

#include "passes.h"

/* Matrices of `rows` float4 rows each begin at `offset` of `matrices`, in the list's order. */
void draw_list(pass_gpu gpu, const plan_list *list, const pass_mesh *meshes, gpu_buffer *matrices, uint64_t offset,
               uint32_t rows);

/* A program that draws positions with matrices of `rows` rows into a depth image, and has no pixel shader. */
csm_result draw_list_program(pass_gpu gpu, const char *name, gpu_code vertex, uint32_t rows, gpu_compare compare,
                             bool clip, gpu_program **out);

#endif
