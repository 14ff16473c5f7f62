/*
 * smoke.h: what the tests of one backend alone share: objects on its device, quads to draw into them, and readback.
 * Results are held against what is known by analysis.
 */
#ifndef SMOKE_H
#define SMOKE_H

#include "gpu_calls.h"
#include "smoke_code.h"

#include <stdio.h>

enum {
  SIZE = 256,
  LAYERS = 4,
  SLOTS = 3,
  FRAMES = 9,
  BLOCK = 256,
  ROW_BYTES = SIZE * 4,
  LAYER_BYTES = SIZE * ROW_BYTES
};

/* Where things lie in a slot's upload buffer */
enum {
  AT_ROWS = 0,
  AT_WHICH = 1024,
  AT_SIZE = AT_WHICH + LAYERS * BLOCK,
  CONSTANTS_AT = AT_SIZE + BLOCK,
  UPLOAD_SIZE = CONSTANTS_AT + 16 * BLOCK
};
/* and in its readback buffer: depth layers, then a mask for each layer */
enum { AT_MASKS = LAYERS * LAYER_BYTES, MASK_BYTES = SIZE * SIZE, READBACK_SIZE = AT_MASKS + LAYERS * MASK_BYTES };

typedef struct smoke_slot {
  gpu_buffer *upload, *readback;
  gpu_bindings *bindings;
} smoke_slot;

/* An image of one layer, and what draws go into. */
typedef struct smoke_surface {
  gpu_format format;
  gpu_image *image;
  gpu_target *target;
} smoke_surface;

/* What a test makes for itself, to be freed at its end in this order. */
typedef enum smoke_kind {
  SCRAP_BINDINGS,
  SCRAP_PROGRAMS,
  SCRAP_TARGETS,
  SCRAP_VIEWS,
  SCRAP_IMAGES,
  SCRAP_BUFFERS,
  SCRAP_KINDS
} smoke_kind;

enum { SCRAP_MOST = 32 };
typedef struct smoke_scrap {
  uint32_t count;
  void *items[SCRAP_MOST];
} smoke_scrap;

typedef struct smoke {
  const gpu_backend *gpu;
  gpu_device *device;
  gpu g; /* the two above */
  gpu_capabilities can;
  smoke_scrap scrap[SCRAP_KINDS];
  gpu_host host;
  uint32_t failures, messages;
  int64_t live_allocations;
  gpu_buffer *staging, *geometry;
  gpu_image *map, *mask;
  gpu_target *map_targets[LAYERS], *mask_target;
  smoke_surface plain, plain16; /* D32 and D16, which shaders cannot read */
  gpu_program *depth, *depth_back, *depth_front, *depth_greater, *depth_always, *depth_clipped, *depth16;
  gpu_program *compare, *compare_reversed;
  smoke_slot slots[SLOTS];
} smoke;

#define CHECK(s, condition, ...)                                                                                       \
  do {                                                                                                                 \
    if (!(condition)) {                                                                                                \
      (s)->failures++;                                                                                                 \
      fprintf(stderr, "%s:%d: %s: ", __FILE__, __LINE__, #condition);                                                  \
      fprintf(stderr, __VA_ARGS__);                                                                                    \
      fputc('\n', stderr);                                                                                             \
    }                                                                                                                  \
  } while (0)

/* A scaled and moved quad whose depth is slope * x + z, x being the quad's own. */
typedef struct quad {
  float scale_x, scale_y, x, y, slope, z;
} quad;

/* Where things lie in the geometry: a quad of two triangles that face +z, with indices of either size. */
enum { AT_VERTICES = 256, AT_U32 = 512, AT_U16 = 768, GEOMETRY_SIZE = 1024 };

/* ---- support.c ---- */
gpu_buffer *make_buffer(smoke *s, const char *name, gpu_buffer_kind kind, uint64_t size);
gpu_image *make_image(smoke *s, gpu_image_info info);
gpu_target *make_target(smoke *s, gpu_target_info info);
gpu_program *make_program(smoke *s, gpu_program_info info);
/* Draws quads, one for each instance, into depth of a format; nearer ones win. */
gpu_program_info depth_program(gpu_format format);
/* Draws one triangle over the whole target with a pixel shader that reads one texture, constants b0 and b1. */
gpu_program_info screen_program(const char *name, gpu_code pixel, gpu_format color);
void make_objects(smoke *s);
void free_objects(smoke *s);

void write_rows(float *rows, quad q);
void draw_quads(smoke *s, gpu_buffer *rows, uint32_t first, uint32_t count, uint32_t index_size);
void draw_pass(smoke *s, gpu_target *target, gpu_program *program, gpu_buffer *rows, uint32_t first, uint32_t count,
               uint32_t index_size);
void copy_layer(smoke *s, gpu_buffer *to, uint64_t offset, gpu_image *image, gpu_format format, uint32_t layer);
void begin(smoke *s, uint32_t slot);
void end(smoke *s);
void end_and_wait(smoke *s, uint32_t slot);

/* A recording of its own: clears a surface, draws quads into an area of it (NULL: all), and reads it back. */
const void *draw_surface(smoke *s, const smoke_surface *surface, gpu_program *program, float clear, const quad *quads,
                         uint32_t count, const gpu_rect *area);
/* The same into s->plain. */
const float *draw_plain(smoke *s, gpu_program *program, float clear, const quad *quads, uint32_t count);
uint32_t count_texels(const float *depth, float value);

/* ---- own.c, or vulkan.c where it is an engine's: the device ---- */
/* Before the backend opens it, by the name in `info` or a kind of engine: fills in info->native. */
void smoke_open(smoke *s, gpu_open_info *info);
void *smoke_begin(smoke *s); /* the command buffer to record into; NULL on an own device */
void smoke_end(smoke *s);
csm_result smoke_wait(smoke *s, uint32_t slot);
void smoke_close(smoke *s); /* after the backend has closed it */

/* ---- scrap.c ---- */
gpu_buffer *scrap_buffer(smoke *s, gpu_buffer_info info);
gpu_image *scrap_image(smoke *s, gpu_image_info info);
gpu_view *scrap_view(smoke *s, gpu_view_info info);
gpu_target *scrap_target(smoke *s, gpu_target_info info);
gpu_program *scrap_program(smoke *s, gpu_program_info info);
gpu_bindings *scrap_bindings(smoke *s, gpu_bindings_info info);
void scrap_free(smoke *s);

/* Four floats in slot 0's upload buffer, for constants; what they lie at. `index` below 16. */
uint32_t put_constants(smoke *s, uint32_t index, const float values[4]);
/* A pass over its area: one triangle of a program. `offset` is of its constants. */
void draw_screen(smoke *s, const gpu_pass_info *pass, gpu_program *program, gpu_bindings *bindings, uint32_t offset);
/* In a recording of its own: what a {layer, level} holds, rows from 0 on at multiples of *row_bytes. */
const uint8_t *read_level(smoke *s, gpu_image *image, gpu_format format, gpu_region region, uint32_t *row_bytes);
/* In a recording of its own: the first bytes of a buffer, as whole numbers. */
const uint32_t *read_buffer(smoke *s, gpu_buffer *buffer, uint64_t size);

/* ---- tests ---- */
void test_frames(smoke *s);  /* frames.c */
void test_culling(smoke *s); /* raster.c */
void test_clamping(smoke *s);
void test_slope(smoke *s);
void test_bias(smoke *s);
void test_areas(smoke *s);
void test_d16(smoke *s); /* formats.c */
void test_native(smoke *s);
void test_clears(smoke *s);
void test_compares(smoke *s);
void test_pairs(smoke *s);
void test_memory(smoke *s); /* copies.c */
void test_copies(smoke *s);
void test_regions(smoke *s);
void test_updates(smoke *s);
void test_levels(smoke *s); /* levels.c */
void test_level_copies(smoke *s);
void test_layer_views(smoke *s);
void test_loads(smoke *s); /* loads.c */
void test_depth_loads(smoke *s);
void test_always(smoke *s);
void test_both_targets(smoke *s);
void test_samplers(smoke *s); /* textures.c */
void test_many_bindings(smoke *s);
void test_attributes(smoke *s);
void test_buffers(smoke *s); /* stores.c */
void test_atomics(smoke *s);
void test_stored_images(smoke *s);
void test_pixel_stores(smoke *s);
void test_pixel_images(smoke *s);
void test_fetched_vertices(smoke *s); /* indirect.c */
void test_indirect(smoke *s);

#endif
