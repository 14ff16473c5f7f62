#include "device/tree_pool.h"

#include "device/uploads.h"

#include <string.h>

enum { smallest = 1 << 20, alignment = 256 };

/* A buffer that was too small. */
typedef struct outgrown {
  retired retired;
  gpu_buffer *buffer;
  uint64_t size;
} outgrown;

static void outgrown_free(device *device, retired *self) {
  outgrown *old = (outgrown *)self;
  device_buffer_free(device, old->buffer, old->size);
  host_release(device->host, old);
}

static csm_result check_size(const device *device, uint64_t size) {
  const uint64_t most = device->info.can.max_texels_size;
  return size <= most ? CSM_SUCCESS
                      : host_fail(device->host, CSM_ERROR_LIMIT_EXCEEDED,
                                  "the meshes' trees take more than the %llu bytes that shaders see at once",
                                  (unsigned long long)most);
}

static csm_result make_buffer(device *device, uint64_t size, gpu_buffer **out) {
  const gpu_buffer_info info = {
      .name = "trees", .kind = GPU_BUFFER_DEVICE, .size = size, .usage = GPU_BUFFER_READ | GPU_BUFFER_TEXELS};
  return device_buffer(device, &info, out);
}

/* The buffer in use stays readable for frames in flight; the next recording copies it. */
static csm_result grow(device *device, uint64_t size) {
  tree_pool *pool = &device->trees;
  page *page = &pool->page;
  uint64_t wanted = page->size + page->size / 2 + size;
  wanted = wanted > device->info.can.max_texels_size ? page->size + size : wanted;
  wanted = wanted > smallest ? (wanted + alignment - 1) / alignment * alignment : smallest;
  csm_result result = check_size(device, wanted);
  if (result)
    return result;
  outgrown *old = host_allocate(device->host, sizeof *old);
  page_piece *more = host_allocate(device->host, sizeof *more);
  gpu_buffer *made = NULL;
  result = old && more ? make_buffer(device, wanted, &made) : CSM_ERROR_OUT_OF_MEMORY;
  if (result) {
    host_release(device->host, old);
    host_release(device->host, more);
    return result;
  }
  *old = (outgrown){.buffer = page->buffer, .size = page->size};
  *more = (page_piece){.page = page, .offset = page->size, .size = wanted - page->size};
  page->buffer = made;
  page->size = wanted;
  pages_give_back(device, more);
  if (!old->buffer || pool->outgrown) /* one that never held anything */
    outgrown_free(device, &old->retired);
  else
    pool->outgrown = &old->retired;
  return CSM_SUCCESS;
}

csm_result tree_pool_add(device *device, const tree_bytes *bytes, page_piece **out) {
  page *page = &device->trees.page;
  void *memory;
  *out = NULL;
  retire_collect(device);
  csm_result result = page_take(device, page, bytes->size, out);
  if (!result && !*out)
    result = grow(device, bytes->size);
  if (!result && !*out)
    result = page_take(device, page, bytes->size, out);
  if (!result)
    result = uploads_write(device, *out, bytes->size, &memory);
  if (!result) {
    memcpy(memory, bytes->memory, bytes->size);
    device->trees.bytes += bytes->size;
  } else if (*out) {
    pages_give_back(device, *out);
    *out = NULL;
  }
  return result;
}

csm_result tree_pool_rewrite(device *device, page_piece *piece, void **memory) {
  return uploads_write(device, piece, piece->size, memory);
}

void tree_pool_remove(device *device, page_piece *piece) {
  if (!piece)
    return;
  uploads_drop(device, piece);
  device->trees.bytes -= piece->size;
  pages_give_back(device, piece);
}

gpu_buffer *tree_pool_buffer(const device *device) {
  return device->trees.page.buffer;
}

uint64_t tree_pool_bytes(const device *device) {
  return device->trees.page.size;
}

tree_held tree_pool_held(const device *device) {
  const tree_pool *pool = &device->trees;
  const outgrown *old = (const outgrown *)pool->outgrown;
  return old ? (tree_held){.buffer = old->buffer, .size = old->size}
             : (tree_held){.buffer = pool->page.buffer, .size = pool->page.size};
}

void tree_pool_record(device *device) {
  tree_pool *pool = &device->trees;
  if (!pool->outgrown)
    return;
  const outgrown *old = (const outgrown *)pool->outgrown;
  gpu_copy_buffer(device->gpu, pool->page.buffer, 0, old->buffer, 0, old->size);
  retire(device, pool->outgrown, outgrown_free);
  pool->outgrown = NULL;
}

void tree_pool_destroy(device *device) {
  tree_pool *pool = &device->trees;
  if (pool->outgrown)
    outgrown_free(device, pool->outgrown);
  device_buffer_free(device, pool->page.buffer, pool->page.size);
  while (pool->page.free) {
    page_piece *piece = pool->page.free;
    pool->page.free = piece->next;
    host_release(device->host, piece);
  }
}
