/*
 * tree_pool.h: one buffer for all that rays look up: meshes' trees, triangles and alpha masks. Shaders see it as rows of 16
 * bytes. What lies in it stays at its row: where there is no room, a larger buffer takes everything over.
 */
#ifndef DEVICE_TREE_POOL_H
#define DEVICE_TREE_POOL_H

#include "device/pages.h"

enum { TREE_POOL_ROW = 16 };

/* Bytes to be placed. */
typedef struct tree_bytes {
  const void *memory; /* NULL: none */
  uint64_t size;      /* a multiple of TREE_POOL_ROW */
} tree_bytes;

/* A buffer of rows. */
typedef struct tree_held {
  const gpu_buffer *buffer;
  uint64_t size;
} tree_held;

/* Places bytes, which the next recording uploads. Errors: LIMIT_EXCEEDED (more than shaders see at once), those of
   device_buffer, OUT_OF_MEMORY. */
csm_result tree_pool_add(device *device, const tree_bytes *bytes, page_piece **out);
/* Memory that the next recording takes other bytes from; all of the piece's are to be written. */
csm_result tree_pool_rewrite(device *device, page_piece *piece, void **memory);
/* The GPU is done with it. NULL is allowed. */
void tree_pool_remove(device *device, page_piece *piece);
static inline uint32_t tree_pool_row(const page_piece *piece) {
  return (uint32_t)(piece->offset / TREE_POOL_ROW);
}
/* NULL: nothing was ever placed. */
gpu_buffer *tree_pool_buffer(const device *device);
uint64_t tree_pool_bytes(const device *device);
/* What the last recording has left: a buffer that has grown since holds nothing before the next one. NULL: none. */
tree_held tree_pool_held(const device *device);
/* Records what brings the buffer up to date before uploads. */
void tree_pool_record(device *device);
void tree_pool_destroy(device *device);

#endif
