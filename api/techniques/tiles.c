#include "techniques/tiles.h"

#include "shader_code.h"
#include "techniques/mask/mask_programs.h"

#include <string.h>

/* ---- programs ---- */

enum { block_bytes = 256 };

static csm_result make_program(gpu gpu, const void *about, gpu_program **out) {
  const tile_step *step = about;
  const gpu_program_info info = {
      .name = step->name,
      .vertex = shader_screen_vs,
      .pixel = *step->pixel,
      .constants_count = 1 + step->masks,
      .constants_sizes = {block_bytes, step->masks ? MASK_CAMERA_BLOCK : 0},
      .texture_count = 1 + step->masks,
      .sampler_count = step->masks,
      .samplers = {GPU_SAMPLER_POINT_CLAMP},
      .color_format = step->format,
      .cull = GPU_CULL_NONE,
  };
  return gpu_program_create(gpu, &info, out);
}

static csm_result find_program(device *device, const tile_step *step, gpu_program **out) {
  const program_key key = {.make = make_program, .name = "a tiles program", .about = step, .size = sizeof *step};
  return programs_find(device, &key, out);
}

/* ---- images ---- */

static uint32_t tiles_across(uint32_t pixels, uint32_t tile) {
  return (pixels + tile - 1) / tile;
}

static const tile_step *last_step(const tile_images *tiles) {
  return &tiles->kind->steps[tiles->kind->count - 1];
}

static uint32_t row_bytes(const tile_images *tiles) {
  return device_row_bytes(tiles->columns, last_step(tiles)->format);
}

static uint64_t buffer_size(const tile_images *tiles) {
  return (uint64_t)row_bytes(tiles) * tiles->rows;
}

static void read_free(device *device, const tile_images *tiles, tile_read *read) {
  for (uint32_t i = 0; i < tiles->kind->count; ++i)
    gpu_bindings_destroy(device->gpu, read->bindings[i]);
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
  for (uint32_t i = 0; i < tiles->kind->count; ++i) {
    gpu_target_destroy(device->gpu, tiles->targets[i]);
    device_image_free(device, tiles->images[i]);
  }
  host_release(device->host, tiles);
}

static csm_result make_image(device *device, tile_images *tiles, uint32_t i) {
  const tile_step *step = &tiles->kind->steps[i];
  const gpu_image_info info = {.name = step->name,
                               .format = step->format,
                               .width = tiles_across(tiles->width, step->px),
                               .height = tiles_across(tiles->height, step->px)};
  const csm_result result = find_program(device, step, &tiles->programs[i]);
  return result ? result : device_drawn_image(device, &info, &tiles->images[i], &tiles->targets[i]);
}

csm_result tile_images_create(device *device, const tile_kind *kind, uint32_t width, uint32_t height,
                              tile_images **out) {
  tile_images *tiles = host_allocate(device->host, sizeof *tiles);
  if (!tiles)
    return CSM_ERROR_OUT_OF_MEMORY;
  tiles->kind = kind;
  tiles->width = width;
  tiles->height = height;
  tiles->columns = tiles_across(width, last_step(tiles)->px);
  tiles->rows = tiles_across(height, last_step(tiles)->px);
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < kind->count && !result; ++i)
    result = make_image(device, tiles, i);
  if (result) {
    tile_images_free(device, &tiles->retired);
    return result;
  }
  *out = tiles;
  return CSM_SUCCESS;
}

uint64_t tile_images_bytes(const tile_images *tiles, const device *device) {
  uint64_t bytes = 0;
  for (uint32_t i = 0; i < tiles->kind->count; ++i)
    bytes += gpu_image_bytes(device->gpu, tiles->images[i]);
  for (const tile_read *read = tiles->reads; read; read = read->next)
    bytes += buffer_size(tiles);
  return bytes;
}

/* ---- the way back ---- */

/* Each step reads what the one before it wrote. */
static gpu_bindings_info reads_of(const tile_images *tiles, uint32_t step, const tile_sources *from) {
  const bool masks = tiles->kind->steps[step].masks;
  return (gpu_bindings_info){.name = tiles->kind->steps[step].name,
                             .program = tiles->programs[step],
                             .constants = {from->constants, masks ? from->constants : NULL},
                             .textures = {step ? tiles->images[step - 1] : from->depth, masks ? from->mask : NULL}};
}

static csm_result read_create(device *device, tile_images *tiles, const tile_sources *from, tile_read **out) {
  tile_read *read = host_allocate(device->host, sizeof *read);
  if (!read)
    return CSM_ERROR_OUT_OF_MEMORY;
  csm_result result = device_buffer(
      device, &(gpu_buffer_info){.name = "tiles", .kind = GPU_BUFFER_READBACK, .size = buffer_size(tiles)},
      &read->buffer);
  for (uint32_t i = 0; i < tiles->kind->count && !result; ++i) {
    const gpu_bindings_info info = reads_of(tiles, i, from);
    result = device_check(device, gpu_bindings_create(device->gpu, &info, &read->bindings[i]), "tiles");
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

csm_result tile_images_find_read(tile_images *tiles, device *device, const tile_sources *from, tile_read **out) {
  tile_read *read = tiles->reads;
  while (read && read->serial > device->done)
    read = read->next;
  if (!read)
    return read_create(device, tiles, from, out);
  for (uint32_t i = 0; i < tiles->kind->count; ++i) {
    const gpu_bindings_info info = reads_of(tiles, i, from);
    gpu_bindings_write(device->gpu, read->bindings[i], &info);
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

static size_t texels_bytes(const tile_images *tiles) {
  return (size_t)tiles->columns * gpu_format_bytes(last_step(tiles)->format);
}

size_t tile_images_size(const tile_images *tiles) {
  return texels_bytes(tiles) * tiles->rows;
}

void tile_images_copy(const tile_images *tiles, const tile_read *read, const device *device, void *out) {
  const size_t bytes = texels_bytes(tiles);
  const char *rows = gpu_buffer_memory(device->gpu, read->buffer);
  for (uint32_t row = 0; row < tiles->rows; ++row)
    memcpy((char *)out + row * bytes, rows + (size_t)row * row_bytes(tiles), bytes);
}

/* ---- recording ---- */

uint64_t tiles_bytes(const tile_kind *kind) {
  return (uint64_t)kind->count * block_bytes;
}

void tiles_write(void *out, const tile_kind *kind, uint32_t width, uint32_t height, float clear) {
  memset(out, 0, tiles_bytes(kind));
  for (uint32_t i = 0; i < kind->count; ++i) {
    const uint32_t px = i ? kind->steps[i - 1].px : 1;
    const float row[] = {(float)tiles_across(width, px), (float)tiles_across(height, px), clear,
                         clear == 0.0f ? 1.0f : -1.0f};
    memcpy((char *)out + i * block_bytes, row, sizeof row);
  }
}

void tiles_record(const tile_images *tiles, tile_read *read, device *device, const uint32_t constants_offsets[2]) {
  const gpu gpu = device->gpu;
  gpu_marker_begin(gpu, last_step(tiles)->name);
  for (uint32_t i = 0; i < tiles->kind->count; ++i) {
    const uint32_t offsets[] = {constants_offsets[0] + i * block_bytes, constants_offsets[1]};
    gpu_pass_begin(gpu, &(gpu_pass_info){.target = tiles->targets[i], .color_load = GPU_LOAD_DISCARD});
    gpu_pass_program(gpu, tiles->programs[i]);
    gpu_pass_bind(gpu, read->bindings[i], offsets);
    gpu_pass_draw(gpu, &(gpu_draw){.count = 3, .instance_count = 1});
    gpu_pass_end(gpu);
    gpu_make_readable(gpu, tiles->images[i], NULL);
  }
  const gpu_region all = {.width = tiles->columns, .height = tiles->rows};
  gpu_copy_image(gpu, read->buffer, 0, row_bytes(tiles), tiles->images[tiles->kind->count - 1], &all);
  gpu_marker_end(gpu);
  read->serial = device->serial;
  read->pending = true;
}
