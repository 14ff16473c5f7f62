#include "techniques/depth_samples/tiles.h"

#include "shader_code.h"

#include <string.h>

/* ---- programs ---- */

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const bool large = *(const uint32_t *)about;
  const gpu_program_info info = {
      .name = large ? "depth tiles, large" : "depth tiles",
      .vertex = shader_screen_vs,
      .pixel = large ? shader_depth_tiles_large_ps : shader_depth_tiles_ps,
      .constants_count = 1,
      .constants_sizes = {TILES_BLOCK},
      .texture_count = 1,
      .color_format = GPU_FORMAT_RG32_FLOAT,
      .cull = GPU_CULL_NONE,
  };
  return gpu_program_create(gpu, &info, out);
}

static csm_result find_program(device *device, uint32_t large, gpu_program **out) {
  const program_key key = {
      .make = make_program, .name = "a depth tiles program", .about = &large, .size = sizeof large};
  return programs_find(device, &key, out);
}

/* ---- images ---- */

static uint32_t tiles_across(uint32_t pixels, uint32_t tile) {
  return (pixels + tile - 1) / tile;
}

static uint32_t row_bytes(const tile_images *tiles) {
  return device_row_bytes(tiles->columns, GPU_FORMAT_RG32_FLOAT);
}

static uint64_t buffer_size(const tile_images *tiles) {
  return (uint64_t)row_bytes(tiles) * tiles->rows;
}

static void read_free(device *device, const tile_images *tiles, tile_read *read) {
  for (int large = 0; large < 2; ++large)
    gpu_bindings_destroy(device->gpu, read->bindings[large]);
  device_buffer_free(device, read->buffer, buffer_size(tiles));
  host_release(device->host, read);
}

void tile_images_free(device *device, retired *self) {
  tile_images *tiles = (tile_images *)self;
  while (tiles->reads) {
    tile_read *read = tiles->reads;
    tiles->reads = read->next;
    read_free(device, tiles, read);
  }
  for (int large = 0; large < 2; ++large) {
    gpu_target_destroy(device->gpu, tiles->targets[large]);
    device_image_free(device, tiles->images[large]);
  }
  host_release(device->host, tiles);
}

static csm_result make_image(device *device, tile_images *tiles, uint32_t large, uint32_t width, uint32_t height) {
  const gpu_image_info info = {
      .name = "depth tiles", .format = GPU_FORMAT_RG32_FLOAT, .width = width, .height = height};
  const csm_result result = find_program(device, large, &tiles->programs[large]);
  return result ? result : device_drawn_image(device, &info, &tiles->images[large], &tiles->targets[large]);
}

csm_result tile_images_create(device *device, uint32_t width, uint32_t height, tile_images **out) {
  tile_images *tiles = host_allocate(device->host, sizeof *tiles);
  if (!tiles)
    return CSM_ERROR_OUT_OF_MEMORY;
  tiles->width = width;
  tiles->height = height;
  tiles->columns = tiles_across(width, TILE_PX);
  tiles->rows = tiles_across(height, TILE_PX);
  csm_result result =
      make_image(device, tiles, 0, tiles_across(width, TILE_FINE_PX), tiles_across(height, TILE_FINE_PX));
  if (!result)
    result = make_image(device, tiles, 1, tiles->columns, tiles->rows);
  if (result) {
    tile_images_free(device, &tiles->retired);
    return result;
  }
  *out = tiles;
  return CSM_SUCCESS;
}

uint64_t tile_images_bytes(const tile_images *tiles, const device *device) {
  uint64_t bytes = gpu_image_bytes(device->gpu, tiles->images[0]) + gpu_image_bytes(device->gpu, tiles->images[1]);
  for (const tile_read *read = tiles->reads; read; read = read->next)
    bytes += buffer_size(tiles);
  return bytes;
}

/* ---- the way back ---- */

/* Each step reads what the one before it wrote. */
static gpu_bindings_info reads_of(const tile_images *tiles, int large, gpu_buffer *constants, gpu_image *depth) {
  return (gpu_bindings_info){.name = "depth tiles",
                             .program = tiles->programs[large],
                             .constants = {constants},
                             .textures = {large ? tiles->images[0] : depth}};
}

static csm_result read_create(device *device, tile_images *tiles, gpu_buffer *constants, gpu_image *depth,
                              tile_read **out) {
  tile_read *read = host_allocate(device->host, sizeof *read);
  if (!read)
    return CSM_ERROR_OUT_OF_MEMORY;
  csm_result result = device_buffer(
      device, &(gpu_buffer_info){.name = "depth tiles", .kind = GPU_BUFFER_READBACK, .size = buffer_size(tiles)},
      &read->buffer);
  for (int large = 0; large < 2 && !result; ++large) {
    const gpu_bindings_info info = reads_of(tiles, large, constants, depth);
    result = device_check(device, gpu_bindings_create(device->gpu, &info, &read->bindings[large]), "depth tiles");
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

csm_result tile_images_find_read(tile_images *tiles, device *device, gpu_buffer *constants, gpu_image *depth,
                                 tile_read **out) {
  tile_read *read = tiles->reads;
  while (read && read->serial > device->done)
    read = read->next;
  if (!read)
    return read_create(device, tiles, constants, depth, out);
  for (int large = 0; large < 2; ++large) {
    const gpu_bindings_info info = reads_of(tiles, large, constants, depth);
    gpu_bindings_write(device->gpu, read->bindings[large], &info);
  }
  *out = read;
  return CSM_SUCCESS;
}

const tile_read *tile_images_newest(const tile_images *tiles, const device *device) {
  const tile_read *newest = NULL;
  for (tile_read *read = tiles->reads; read; read = read->next)
    if (read->pending && read->serial <= device->done) {
      read->pending = false;
      newest = !newest || read->serial > newest->serial ? read : newest;
    }
  return newest;
}

void tile_images_copy(const tile_images *tiles, const tile_read *read, const device *device, void *out) {
  const size_t bytes = tiles->columns * 2 * sizeof(float);
  const char *rows = gpu_buffer_memory(device->gpu, read->buffer);
  for (uint32_t row = 0; row < tiles->rows; ++row)
    memcpy((char *)out + row * bytes, rows + (size_t)row * row_bytes(tiles), bytes);
}

/* ---- recording ---- */

void tiles_write(void *out, uint32_t width, uint32_t height, float clear) {
  float blocks[TILES_BLOCKS / sizeof(float)] = {0};
  float *large = &blocks[TILES_BLOCK / sizeof(float)];
  blocks[0] = (float)width;
  blocks[1] = (float)height;
  blocks[2] = clear;
  large[0] = (float)tiles_across(width, TILE_FINE_PX);
  large[1] = (float)tiles_across(height, TILE_FINE_PX);
  memcpy(out, blocks, sizeof blocks);
}

void tiles_record(const tile_images *tiles, tile_read *read, device *device, uint32_t constants_offset) {
  const gpu gpu = device->gpu;
  gpu_marker_begin(gpu, "depth tiles");
  for (uint32_t large = 0; large < 2; ++large) {
    const uint32_t offset = constants_offset + large * TILES_BLOCK;
    gpu_pass_begin(gpu, &(gpu_pass_info){.target = tiles->targets[large], .color_load = GPU_LOAD_DISCARD});
    gpu_pass_program(gpu, tiles->programs[large]);
    gpu_pass_bind(gpu, read->bindings[large], &offset);
    gpu_pass_draw(gpu, &(gpu_draw){.count = 3, .instance_count = 1});
    gpu_pass_end(gpu);
    gpu_make_readable(gpu, tiles->images[large], NULL);
  }
  const gpu_region all = {.width = tiles->columns, .height = tiles->rows};
  gpu_copy_image(gpu, read->buffer, 0, row_bytes(tiles), tiles->images[1], &all);
  gpu_marker_end(gpu);
  read->serial = device->serial;
  read->pending = true;
}
