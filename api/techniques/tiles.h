/* tiles.h: what is found in each square tile of a camera's depth, or of a mask, in a step, or in two: small tiles first, then large
   ones of them; and the large ones' way back to memory. */
#ifndef TECHNIQUES_TILES_H
#define TECHNIQUES_TILES_H

#include "device/device.h"
#include "plan/plan.h"

enum { TILE_MOST_STEPS = 2 };

/* A pass that draws a texel for each tile, of the depth or of the tiles of the step before. Its block of constants has
   in its row the size of what it reads, the depth where there is no surface, and 1, or -1 where depth is not reversed. */
typedef struct tile_step {
  const char *name;
  const gpu_code *pixel; /* the shader */
  uint32_t px;           /* of a tile's side, in the picture's pixels */
  gpu_format format;
  uint32_t masks; /* 1: it sees the mask, too, and in a second block the mask's constants of the camera */
} tile_step;

typedef struct tile_kind {
  tile_step steps[TILE_MOST_STEPS];
  uint32_t count;
} tile_kind;

/* What tiles are made of. */
typedef struct tile_sources {
  gpu_buffer *constants;
  gpu_image *depth;
  gpu_image *mask; /* NULL: no step sees it */
} tile_sources;

/* The last step's tiles of one picture, on their way back. */
typedef struct tile_read {
  struct tile_read *next;
  gpu_buffer *buffer;
  gpu_bindings *bindings[TILE_MOST_STEPS];
  plan_depth_samples about; /* of depth samples */
  uint64_t serial;          /* of its frame */
  bool pending;             /* not taken over yet */
} tile_read;

/* What the depths of pictures of one size are brought down to. */
typedef struct tile_images {
  retired retired;
  const tile_kind *kind;
  uint32_t width, height; /* of the pictures */
  uint32_t columns, rows; /* of the last step's tiles */
  gpu_image *images[TILE_MOST_STEPS];
  gpu_target *targets[TILE_MOST_STEPS];
  gpu_program *programs[TILE_MOST_STEPS];
  tile_read *reads;
} tile_images;

/* `kind` stays as long as the images. */
csm_result tile_images_create(device *device, const tile_kind *kind, uint32_t width, uint32_t height,
                              tile_images **out);
void tile_images_free(device *device, retired *self);
uint64_t tile_images_bytes(const tile_images *tiles, const device *device);

/* A way back that no frame in flight uses, for the recording that was prepared; made if there is none. */
csm_result tile_images_find_read(tile_images *tiles, device *device, const tile_sources *from, tile_read **out);
/* The newest that has come back; NULL if none has since the last call. */
const tile_read *tile_images_newest(const tile_images *tiles, const device *device);
/* Its texels, without gaps, and their size in bytes. */
size_t tile_images_size(const tile_images *tiles);
void tile_images_copy(const tile_images *tiles, const tile_read *read, const device *device, void *out);

/* What a recording wants of the ring. */
uint64_t tiles_bytes(const tile_kind *kind);
/* Fills it in; `clear` is the depth where there is no surface. */
void tiles_write(void *out, const tile_kind *kind, uint32_t width, uint32_t height, float clear);
/* Offsets of what was filled in, and of the mask's constants of the camera, if a step sees those. */
void tiles_record(const tile_images *tiles, tile_read *read, device *device, const uint32_t constants_offsets[2]);

#endif
