/* samples.c: the depths that masks' cameras saw, tile by tile, read back once their frames are done. */
#include "abi/cascades.h"

#include <string.h>

/* The tiles of one mask, on their way back. */
struct sample_read {
  struct sample_read *next;
  gpu_buffer *buffer;
  gpu_bindings *bindings[2]; /* for small tiles, for large ones */
  plan_samples about;
  uint64_t serial; /* of its frame */
  bool pending;    /* not taken over yet */
};

static uint32_t tiles_across(uint32_t pixels, uint32_t tile) {
  return (pixels + tile - 1) / tile;
}

static uint32_t row_bytes(const sample_tiles *tiles) {
  return device_row_bytes(tiles->columns, GPU_FORMAT_RG32_FLOAT);
}

static uint64_t buffer_size(const sample_tiles *tiles) {
  return (uint64_t)row_bytes(tiles) * tiles->rows;
}

static void read_free(device *device, const sample_tiles *tiles, sample_read *read) {
  for (int size = 0; size < 2; ++size)
    device->gpu.api->bindings_destroy(device->gpu.device, read->bindings[size]);
  device_buffer_free(device, read->buffer, buffer_size(tiles));
  context_release(device->context, read);
}

void sample_tiles_free(device *device, retired *self) {
  sample_tiles *tiles = (sample_tiles *)self;
  while (tiles->reads) {
    sample_read *read = tiles->reads;
    tiles->reads = read->next;
    read_free(device, tiles, read);
  }
  for (int size = 0; size < 2; ++size) {
    device->gpu.api->target_destroy(device->gpu.device, tiles->targets[size]);
    device_image_free(device, tiles->images[size]);
  }
  context_release(device->context, tiles);
}

void samples_drop(csm_cascades *cascades, device *device) {
  if (cascades->tiles)
    retire(device, &cascades->tiles->retired, sample_tiles_free);
  cascades->tiles = NULL;
  cascades->samples.columns = 0;
}

/* ---- reserving ---- */

static csm_result make_image(device *device, sample_tiles *tiles, int size, uint32_t width, uint32_t height) {
  return device_drawn_image(device, "depth tiles", GPU_FORMAT_RG32_FLOAT, width, height, &tiles->images[size],
                            &tiles->targets[size]);
}

static csm_result tiles_create(device *device, uint32_t width, uint32_t height, sample_tiles **out) {
  sample_tiles *tiles = context_allocate(device->context, sizeof *tiles);
  if (!tiles)
    return CSM_ERROR_OUT_OF_MEMORY;
  tiles->width = width;
  tiles->height = height;
  tiles->columns = tiles_across(width, DEPTH_TILES_PX);
  tiles->rows = tiles_across(height, DEPTH_TILES_PX);
  csm_result result =
      make_image(device, tiles, 0, tiles_across(width, DEPTH_TILES_FINE_PX), tiles_across(height, DEPTH_TILES_FINE_PX));
  if (!result)
    result = make_image(device, tiles, 1, tiles->columns, tiles->rows);
  if (result) {
    sample_tiles_free(device, &tiles->retired);
    return result;
  }
  *out = tiles;
  return CSM_SUCCESS;
}

/* Each step reads what the one before it wrote. */
static gpu_bindings_info inputs(device *device, const sample_tiles *tiles, int size, gpu_buffer *constants,
                                gpu_image *depth) {
  return depth_tiles_inputs(device->tiles_programs[size], constants, size ? tiles->images[0] : depth);
}

static csm_result read_create(device *device, sample_tiles *tiles, gpu_buffer *constants, gpu_image *depth,
                              sample_read **out) {
  sample_read *read = context_allocate(device->context, sizeof *read);
  if (!read)
    return CSM_ERROR_OUT_OF_MEMORY;
  csm_result result = device_buffer(
      device, &(gpu_buffer_info){.name = "depth tiles", .kind = GPU_BUFFER_READBACK, .size = buffer_size(tiles)},
      &read->buffer);
  for (int size = 0; size < 2 && !result; ++size) {
    const gpu_bindings_info info = inputs(device, tiles, size, constants, depth);
    result = device_check(device, device->gpu.api->bindings_create(device->gpu.device, &info, &read->bindings[size]),
                          "depth tiles");
  }
  if (result) {
    read_free(device, tiles, read);
    return result;
  }
  read->next = tiles->reads;
  tiles->reads = read;
  *out = read;
  return CSM_SUCCESS;
}

/* One that no frame in flight uses. */
static csm_result find_read(device *device, sample_tiles *tiles, gpu_buffer *constants, gpu_image *depth,
                            sample_read **out) {
  for (sample_read *read = tiles->reads; read; read = read->next)
    if (read->serial <= device->done) {
      for (int size = 0; size < 2; ++size) {
        const gpu_bindings_info info = inputs(device, tiles, size, constants, depth);
        device->gpu.api->bindings_write(device->gpu.device, read->bindings[size], &info);
      }
      *out = read;
      return CSM_SUCCESS;
    }
  return read_create(device, tiles, constants, depth, out);
}

/* Takes tiles of another size over, with room for their depths; what was seen in the old size is forgotten. */
static csm_result keep_tiles(csm_cascades *cascades, sample_tiles *tiles) {
  const size_t size = (size_t)tiles->columns * tiles->rows * 2 * sizeof(float);
  const csm_result result = context_grow(cascades->context, &cascades->samples_memory, &cascades->samples_size, size);
  if (result)
    return result;
  samples_drop(cascades, cascades->context->device);
  cascades->tiles = tiles;
  return CSM_SUCCESS;
}

csm_result samples_prepare(csm_cascades *cascades, const plan_camera *camera, uint32_t width, uint32_t height,
                           gpu_buffer *constants, gpu_image *depth, sample_read **out) {
  device *device = cascades->context->device;
  samples_collect(cascades);
  sample_tiles *tiles = cascades->tiles;
  const bool fits = tiles && tiles->width == width && tiles->height == height;
  csm_result result = fits ? CSM_SUCCESS : tiles_create(device, width, height, &tiles);
  if (result)
    return result;
  result = find_read(device, tiles, constants, depth, out);
  if (!result && !fits)
    result = keep_tiles(cascades, tiles);
  if (result) {
    if (!fits)
      sample_tiles_free(device, &tiles->retired);
    return result;
  }
  (*out)->about = (plan_samples){.camera = *camera,
                                 .width = width,
                                 .height = height,
                                 .tile_px = DEPTH_TILES_PX,
                                 .columns = tiles->columns,
                                 .rows = tiles->rows};
  return CSM_SUCCESS;
}

/* ---- recording and reading ---- */

void samples_record(csm_cascades *cascades, sample_read *read, uint32_t constants_offset) {
  device *device = cascades->context->device;
  const sample_tiles *tiles = cascades->tiles;
  depth_tiles_pass pass = {.columns = tiles->columns,
                           .rows = tiles->rows,
                           .out = read->buffer,
                           .row_bytes = row_bytes(tiles),
                           .constants_offset = constants_offset};
  for (int size = 0; size < 2; ++size) {
    pass.programs[size] = device->tiles_programs[size];
    pass.bindings[size] = read->bindings[size];
    pass.targets[size] = tiles->targets[size];
    pass.images[size] = tiles->images[size];
  }
  depth_tiles_record(device->gpu, &pass);
  read->serial = device->serial;
  read->pending = true;
}

static void take(csm_cascades *cascades, const sample_read *read) {
  const device *device = cascades->context->device;
  const sample_tiles *tiles = cascades->tiles;
  const size_t bytes = tiles->columns * 2 * sizeof(float);
  const char *rows = device->gpu.api->buffer_memory(read->buffer);
  for (uint32_t row = 0; row < tiles->rows; ++row)
    memcpy((char *)cascades->samples_memory + row * bytes, rows + (size_t)row * row_bytes(tiles), bytes);
  cascades->samples = read->about;
  cascades->samples.depths = cascades->samples_memory;
}

void samples_collect(csm_cascades *cascades) {
  const device *device = cascades->context->device;
  sample_read *newest = NULL;
  for (sample_read *read = cascades->tiles ? cascades->tiles->reads : NULL; read; read = read->next)
    if (read->pending && read->serial <= device->done) {
      read->pending = false;
      newest = !newest || read->serial > newest->serial ? read : newest;
    }
  if (newest)
    take(cascades, newest);
}
