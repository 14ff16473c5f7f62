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
  gpu_buffer *vertices, *indices;
  uint64_t vertex_offset, index_offset;
  uint32_t index_count, index_size;
  uint32_t programs;      /* index of the programs for its shape */
  bool two_sided, closed; /* no face of it is culled; its back faces need not be drawn */
  uint64_t uv_offset;     /* in the vertices' buffer; read only with an alpha mask */
  gpu_bindings *alpha_mask;  /* of an alpha-tested mesh, else NULL */
} pass_mesh;

/* What programs that draw a mesh depend on. */
typedef struct pass_vertices {
  uint32_t stride;
  uint32_t uv_stride; /* 0: opaque */
} pass_vertices;

/* Called inside a cascade's pass, when its list is drawn. */
typedef void (*pass_callback)(void *user, uint32_t cascade);

/* ---- the cascades' maps ---- */

/* How casters are drawn, but for their shape. */
typedef struct pass_casters {
  gpu_format format;
  bool reversed, clip;
  gpu_cull cull;
  gpu_raster_bias bias;
} pass_casters;

pass_casters cascade_depth_casters(const csm_config *config);

enum { PASS_CASCADE_ROWS = 3, PASS_CAMERA_ROWS = 4 }; /* float4 rows for each instance's matrix */

/* The program for vertices, for those of the casters of which `cull` faces are left out. */
csm_result cascade_depth_program(pass_gpu gpu, const pass_casters *casters, gpu_cull cull, pass_vertices vertices,
                                 gpu_program **out);

typedef struct cascade_depth_pass {
  const pass_casters *casters;
  gpu_program *const *programs[3]; /* by gpu_cull, then by pass_mesh.programs */
  gpu_image *maps;
  gpu_target *const *targets; /* one for each layer */
  const plan_layout *layout;
  const plan_frame *plan;
  const pass_mesh *meshes;
  gpu_buffer *matrices; /* as plan_write_cascade_matrices writes them */
  uint64_t matrices_offsets[CSM_MAX_CASCADES];
  pass_callback draw; /* or NULL */
  void *draw_user;
  bool timestamps; /* from first_timestamp on: begin, cleared, each cascade drawn */
  uint32_t first_timestamp;
} cascade_depth_pass;

void cascade_depth_record(pass_gpu gpu, const cascade_depth_pass *pass);

/* ---- alpha mask ---- */

enum { ALPHA_MASK_BLOCK = 256 };

/* Writes the constants of an alpha-tested mesh: ALPHA_MASK_BLOCK bytes. */
void alpha_mask_write(void *out, const csm_alpha_mask_info *info, float cutoff);
/* What such a mesh reads: its constants from the buffer's beginning, and the texture. */
gpu_bindings_info alpha_mask_inputs(const gpu_program *program, gpu_buffer *constants, gpu_image *texture);

/* ---- the camera's depth ---- */

csm_result camera_depth_program(pass_gpu gpu, bool reversed, pass_vertices vertices, gpu_program **out);

typedef struct camera_depth_pass {
  gpu_program *const *programs; /* by pass_mesh.programs */
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

/* Of the program of the debug views; no other has it. */
#define MASK_VIEW_KEY UINT64_C(1)

/* What a checked configuration asks for: a key of the table of variants. Views do without the engine's normals. */
uint64_t mask_key(const csm_config *config, bool normals, uint32_t view);
/* `normals` is what the key was made with. */
csm_result mask_program(pass_gpu gpu, uint64_t key, bool normals, gpu_program **out);

/* What the mask reads: maps, depth, normals (or NULL), and from `constants` the MASK_BLOCKS bytes of a recording. */
gpu_bindings_info mask_inputs(const gpu_program *program, gpu_buffer *constants, gpu_image *maps, gpu_image *depth,
                              gpu_image *normals);

typedef struct mask_pass {
  gpu_program *program;
  gpu_bindings *bindings;
  gpu_target *target;
  uint32_t constants_offset; /* of this recording's MASK_BLOCKS bytes */
} mask_pass;

void mask_record(pass_gpu gpu, const mask_pass *pass);

/* ---- depth tiles: the least and the greatest depth in each tile of a camera's depth ---- */

enum {
  DEPTH_TILES_FINE_PX = 8,
  DEPTH_TILES_PX = 32,
  DEPTH_TILES_BLOCK = 256,
  DEPTH_TILES_BLOCKS = 2 * DEPTH_TILES_BLOCK
};

/* First of small tiles, then of those in each large one. */
csm_result depth_tiles_program(pass_gpu gpu, bool coarse, gpu_program **out);
/* Writes the DEPTH_TILES_BLOCKS bytes of a recording; `clear` is the depth where there is no surface. */
void depth_tiles_write(void *out, uint32_t width, uint32_t height, float clear);
gpu_bindings_info depth_tiles_inputs(const gpu_program *program, gpu_buffer *constants, gpu_image *from);

typedef struct depth_tiles_pass {
  gpu_program *programs[2]; /* small, large */
  gpu_bindings *bindings[2];
  gpu_target *targets[2];
  gpu_image *images[2];
  uint32_t columns, rows; /* of large tiles */
  gpu_buffer *out;        /* a readback buffer that gets the large ones, row by row */
  uint32_t row_bytes;
  uint32_t constants_offset; /* of this recording's DEPTH_TILES_BLOCKS bytes */
} depth_tiles_pass;

void depth_tiles_record(pass_gpu gpu, const depth_tiles_pass *pass);

#endif
