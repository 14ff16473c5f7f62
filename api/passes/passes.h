/*
 * passes.h: each technique once, for every backend. A pass gives the program it needs, and records itself with objects
 * that its caller made; it decides nothing that the plan has not decided.
 */
#ifndef PASSES_H
#define PASSES_H

#include "gpu.h"
#include "plan/plan.h"

/* A device, and how to speak to it. */
typedef struct pass_gpu {
  const gpu_backend *api;
  gpu_device *device;
} pass_gpu;

/* Where a mesh lies, by its index in the plan's scene. */
typedef struct pass_mesh {
  gpu_buffer *buffer;
  uint64_t vertices, indices; /* offsets into it */
  uint32_t index_count, index_size;
} pass_mesh;

/* ---- the cascades' maps ---- */

enum { PASS_CASCADE_ROWS = 3, PASS_CAMERA_ROWS = 4 }; /* float4 rows for each instance's matrix */

csm_result cascade_depth_program(pass_gpu gpu, gpu_program **out);

typedef struct cascade_depth_pass {
  gpu_program *program;
  gpu_image *maps;
  gpu_target *const *targets; /* one for each cascade */
  const plan_frame *plan;
  const pass_mesh *meshes;
  gpu_buffer *matrices; /* as plan_write_cascade_matrices writes them */
  uint64_t matrices_offsets[CSM_MAX_CASCADES];
  bool timestamps; /* 0: begin, 1: cleared, 2 + k: cascade k drawn */
} cascade_depth_pass;

void cascade_depth_record(pass_gpu gpu, const cascade_depth_pass *pass);

/* ---- the camera's depth ---- */

csm_result camera_depth_program(pass_gpu gpu, bool reversed, gpu_program **out);

typedef struct camera_depth_pass {
  gpu_program *program;
  gpu_image *depth;
  gpu_target *target;
  bool reversed;
  const plan_list *list;
  const pass_mesh *meshes;
  gpu_buffer *matrices; /* as plan_write_view_matrices writes them */
  uint64_t matrices_offset;
} camera_depth_pass;

void camera_depth_record(pass_gpu gpu, const camera_depth_pass *pass);

/* ---- the mask ---- */

enum { MASK_CASCADES_BLOCK = 1024, MASK_CAMERA_BLOCK = 256, MASK_BLOCKS = MASK_CASCADES_BLOCK + MASK_CAMERA_BLOCK };

csm_result mask_program(pass_gpu gpu, uint32_t filter, gpu_program **out);

/* What the mask reads: maps and depth, and constants from `constants`, where each recording has MASK_BLOCKS bytes. */
csm_result mask_bindings(pass_gpu gpu, const gpu_program *program, gpu_buffer *constants, gpu_image *maps,
                         gpu_image *depth, gpu_bindings **out);

typedef struct mask_pass {
  gpu_program *program;
  gpu_bindings *bindings;
  gpu_target *target;
  uint32_t constants_offset; /* of this recording's MASK_BLOCKS bytes */
} mask_pass;

void mask_record(pass_gpu gpu, const mask_pass *pass);

#endif
