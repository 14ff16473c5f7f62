/* tiles.h: the least and the greatest depth in each tile of a camera's depth, small tiles first, then large ones of
   them, and the large ones' way back to memory. */
#ifndef TECHNIQUES_TILES_H
#define TECHNIQUES_TILES_H

#include "device/device.h"
#include "plan/plan.h"

enum { TILE_FINE_PX = 8, TILE_PX = 32, TILES_BLOCK = 256, TILES_BLOCKS = 2 * TILES_BLOCK };

/* The large tiles of one picture, on their way back. */
typedef struct tile_read {
  struct tile_read *next;
  gpu_buffer *buffer;
  gpu_bindings *bindings[2]; /* for small tiles, for large ones */
  plan_depth_samples about;
  uint64_t serial; /* of its frame */
  bool pending;    /* not taken over yet */
} tile_read;

/* What the depths of pictures of one size are brought down to. */
typedef struct tile_images {
  retired retired;
  uint32_t width, height; /* of the pictures */
  uint32_t columns, rows; /* of large tiles */
  gpu_image *images[2];   /* small tiles, large ones */
  gpu_target *targets[2];
  gpu_program *programs[2];
  tile_read *reads;
} tile_images;

csm_result tile_images_create(device *device, uint32_t width, uint32_t height, tile_images **out);
void tile_images_free(device *device, retired *self);
uint64_t tile_images_bytes(const tile_images *tiles, const device *device);

/* A way back that no frame in flight uses, for the recording that was prepared; made if there is none. */
csm_result tile_images_find_read(tile_images *tiles, device *device, gpu_buffer *constants, gpu_image *depth,
                                 tile_read **out);
/* The newest that has come back; NULL if none has since the last call. */
const tile_read *tile_images_newest(const tile_images *tiles, const device *device);
/* Its depths, without gaps. */
void tile_images_copy(const tile_images *tiles, const tile_read *read, const device *device, void *out);

/* Writes the TILES_BLOCKS bytes of a recording; `clear` is the depth where there is no surface. */
void tiles_write(void *out, uint32_t width, uint32_t height, float clear);
void tiles_record(const tile_images *tiles, tile_read *read, device *device, uint32_t constants_offset);

#endif
