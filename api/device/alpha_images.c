#include "device/alpha_images.h"

#include "device/tree_pool.h"

#include "private/alpha_mask.h"
#include "shader_code.h"
#include <string.h>

/* Texels on their way to an image. */
typedef struct staged_texels {
  retired retired;
  gpu_buffer *buffer;
  uint64_t size;
  uint32_t row_bytes;
} staged_texels;

struct alpha_image {
  retired retired;
  gpu_image *image;
  uint32_t width, height;
  staged_texels *staged; /* NULL once they are on their way */
  page_piece *traced;    /* the texels once more, for rays; NULL: no mesh is traced */
};

static void staged_free(device *device, retired *self) {
  staged_texels *staged = (staged_texels *)self;
  device_buffer_free(device, staged->buffer, staged->size);
  host_release(device->host, staged);
}

static void alpha_image_free(device *device, retired *self) {
  alpha_image *alpha = (alpha_image *)self;
  if (alpha->staged)
    staged_free(device, &alpha->staged->retired);
  device_image_free(device, alpha->image);
  tree_pool_remove(device, alpha->traced);
  host_release(device->host, alpha);
}

static csm_result stage_texels(device *device, const csm_alpha_mask_info *info, staged_texels **out) {
  staged_texels *staged = host_allocate(device->host, sizeof *staged);
  if (!staged)
    return CSM_ERROR_OUT_OF_MEMORY;
  staged->row_bytes = device_row_bytes(info->width, GPU_FORMAT_R8_UNORM);
  staged->size = (uint64_t)staged->row_bytes * info->height;
  const csm_result result = device_buffer(
      device, &(gpu_buffer_info){.name = "alpha mask staging", .kind = GPU_BUFFER_UPLOAD, .size = staged->size},
      &staged->buffer);
  if (result) {
    host_release(device->host, staged);
    return result;
  }
  char *rows = gpu_buffer_memory(device->gpu, staged->buffer);
  for (uint32_t y = 0; y < info->height; ++y)
    memcpy(rows + (size_t)y * staged->row_bytes, info->texels + (size_t)y * info->row_stride, info->width);
  *out = staged;
  return CSM_SUCCESS;
}

/* Row by row, without gaps. */
static csm_result add_traced(device *device, const csm_alpha_mask_info *info, page_piece **out) {
  const uint64_t texels = (uint64_t)info->width * info->height;
  const uint64_t size = (texels + TREE_POOL_ROW - 1) / TREE_POOL_ROW * TREE_POOL_ROW;
  char *rows = host_allocate(device->host, size);
  if (!rows)
    return CSM_ERROR_OUT_OF_MEMORY;
  for (uint32_t y = 0; y < info->height; ++y)
    memcpy(rows + (size_t)y * info->width, info->texels + (size_t)y * info->row_stride, info->width);
  const csm_result result = tree_pool_add(device, &(tree_bytes){.memory = rows, .size = size}, out);
  host_release(device->host, rows);
  return result;
}

csm_result alpha_images_reserve(device *device, uint32_t capacity) {
  alpha_images *all = &device->alpha_images;
  if (capacity <= all->capacity)
    return CSM_SUCCESS;
  alpha_image **images = host_grown_copy(device->host, all->images, all->capacity, capacity, sizeof(alpha_image *));
  if (!images)
    return CSM_ERROR_OUT_OF_MEMORY;
  host_release(device->host, all->images);
  all->images = images;
  all->capacity = capacity;
  return CSM_SUCCESS;
}

csm_result alpha_images_add(device *device, uint32_t index, const csm_alpha_mask_info *info) {
  alpha_image *alpha = host_allocate(device->host, sizeof *alpha);
  if (!alpha)
    return CSM_ERROR_OUT_OF_MEMORY;
  alpha->width = info->width;
  alpha->height = info->height;
  const gpu_image_info image = {.name = "alpha mask",
                                .format = GPU_FORMAT_R8_UNORM,
                                .usage = GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_TARGET,
                                .width = info->width,
                                .height = info->height,
                                .layers = 1};
  csm_result result = device_image(device, &image, &alpha->image);
  if (!result)
    result = stage_texels(device, info, &alpha->staged);
  if (!result && device->trees.wanted)
    result = add_traced(device, info, &alpha->traced);
  if (result) {
    alpha_image_free(device, &alpha->retired);
    return result;
  }
  device->alpha_images.images[index] = alpha;
  ++device->alpha_images.due;
  return CSM_SUCCESS;
}

void alpha_images_remove(device *device, uint32_t index) {
  alpha_image *alpha = device->alpha_images.images[index];
  device->alpha_images.images[index] = NULL;
  device->alpha_images.due -= alpha->staged != NULL;
  retire(device, &alpha->retired, alpha_image_free);
}

gpu_image *alpha_images_texture(const device *device, uint32_t index) {
  return device->alpha_images.images[index]->image;
}

uint32_t alpha_images_row(const device *device, uint32_t index) {
  return tree_pool_row(device->alpha_images.images[index]->traced);
}

void alpha_images_record(device *device) {
  alpha_images *all = &device->alpha_images;
  for (uint32_t i = 0; i < all->capacity && all->due; ++i) {
    alpha_image *alpha = all->images[i];
    if (!alpha || !alpha->staged)
      continue;
    const gpu_region whole = {.width = alpha->width, .height = alpha->height};
    gpu_copy_to_image(device->gpu, alpha->image, &whole, alpha->staged->buffer, 0, alpha->staged->row_bytes);
    gpu_make_readable(device->gpu, alpha->image, &(gpu_range){0});
    retire(device, &alpha->staged->retired, staged_free);
    alpha->staged = NULL;
    --all->due;
  }
}

void alpha_images_destroy(device *device) {
  alpha_images *all = &device->alpha_images;
  for (uint32_t i = 0; i < all->capacity; ++i)
    if (all->images[i])
      alpha_image_free(device, &all->images[i]->retired);
  host_release(device->host, all->images);
}

/* ---- what a mesh reads ---- */

void alpha_mask_write(void *out, const csm_alpha_mask_info *info, float cutoff) {
  float block[ALPHA_MASK_BLOCK / sizeof(float)] = {0};
  float *size = &block[ALPHA_MASK_SIZE * 4], *wrap = &block[ALPHA_MASK_WRAP * 4];
  size[0] = (float)info->width;
  size[1] = (float)info->height;
  size[2] = cutoff;
  wrap[0] = (float)info->wrap_u;
  wrap[1] = (float)info->wrap_v;
  memcpy(out, block, sizeof block);
}

/* A program of the shape that all programs with an alpha mask have; it draws nothing. */
static csm_result make_shape(gpu gpu, const void *about, gpu_program **out) {
  (void)about;
  const gpu_program_info info = {
      .name = "alpha mask bindings",
      .vertex = shader_cascade_depth_alpha_mask_vs,
      .pixel = shader_alpha_mask_ps,
      .stream_count = 3,
      .streams = {{.stride = 12}, {.stride = 48, .per_instance = true}, {.stride = 8}},
      .attribute_count = 5,
      .attributes = {{.format = GPU_FORMAT_RGB32_FLOAT},
                     {.format = GPU_FORMAT_RGBA32_FLOAT, .stream = 1},
                     {.format = GPU_FORMAT_RGBA32_FLOAT, .stream = 1, .offset = 16},
                     {.format = GPU_FORMAT_RGBA32_FLOAT, .stream = 1, .offset = 32},
                     {.format = GPU_FORMAT_RG32_FLOAT, .stream = 2}},
      .constants_count = 1,
      .constants_sizes = {ALPHA_MASK_BLOCK},
      .texture_count = 1,
      .depth_format = GPU_FORMAT_D32_FLOAT,
      .depth_compare = GPU_COMPARE_LESS,
  };
  return gpu_program_create(gpu, &info, out);
}

csm_result alpha_mask_bindings(device *device, gpu_buffer *constants, gpu_image *texture, gpu_bindings **out) {
  gpu_bindings_info info = {.name = "alpha mask", .constants = {constants}, .textures = {texture}};
  gpu_program *shape;
  const program_key key = {.make = make_shape, .name = "the program of alpha masks' bindings"};
  const csm_result result = programs_find(device, &key, &shape);
  if (result)
    return result;
  info.program = shape;
  return device_check(device, gpu_bindings_create(device->gpu, &info, out), "an alpha-tested mesh's bindings");
}
