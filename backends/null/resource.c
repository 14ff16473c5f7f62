/* resource.c: buffers, images, views and targets. */
#include "null.h"

#include <string.h>

/* ---- ranges ---- */

bool null_spans(uint32_t size, uint32_t first, uint32_t count) {
  return count > 0 && first <= size && count <= size - first;
}

bool null_holds(const gpu_buffer *buffer, uint64_t offset, uint64_t size) {
  return buffer && offset <= buffer->info.size && size <= buffer->info.size - offset;
}

static uint32_t level_count(const gpu_image_info *info) {
  return info->levels ? info->levels : 1;
}

uint32_t null_levels(const gpu_image *image) {
  return level_count(&image->info);
}

gpu_range null_range(const gpu_image *image, const gpu_range *range) {
  gpu_range all = range ? *range : (gpu_range){0};
  if (all.layer_count == 0)
    all.layer_count = image->info.layers - all.first_layer;
  if (all.level_count == 0)
    all.level_count = null_levels(image) - all.first_level;
  return all;
}

static bool contains(const gpu_image *image, const gpu_range *range) {
  return null_spans(image->info.layers, range->first_layer, range->layer_count) &&
         null_spans(null_levels(image), range->first_level, range->level_count);
}

bool null_overlap(const gpu_range *a, const gpu_range *b) {
  return a->first_layer < b->first_layer + b->layer_count && b->first_layer < a->first_layer + a->layer_count &&
         a->first_level < b->first_level + b->level_count && b->first_level < a->first_level + a->level_count;
}

null_piece *null_piece_at(gpu_image *image, uint32_t layer, uint32_t level) {
  return &image->pieces[layer * null_levels(image) + level];
}

/* ---- buffers ---- */

static void check_buffer(gpu_device *device, const gpu_buffer_info *info) {
  null_require(device, info->size > 0, "buffer_create: a size of 0");
  null_require(device, !(info->usage & GPU_BUFFER_WRITE) || info->kind == GPU_BUFFER_DEVICE,
               "buffer_create: shaders write to device buffers alone");
  null_require(device, !info->usage || info->kind != GPU_BUFFER_READBACK,
               "buffer_create: a readback buffer is for nothing else");
  null_require(
      device, !(info->usage & GPU_BUFFER_TEXELS) || (info->usage & GPU_BUFFER_READ && info->size % GPU_TEXEL_SIZE == 0),
      "buffer_create: a texel buffer that is not read, or whose size is not a multiple of 16");
}

csm_result null_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out) {
  *out = NULL;
  check_buffer(device, info);
  gpu_buffer *buffer = null_make(device, sizeof *buffer);
  if (!buffer)
    return CSM_ERROR_OUT_OF_MEMORY;
  null_set_name(buffer->name, info->name);
  buffer->info = *info;
  buffer->memory = null_make(device, info->size);
  if (!buffer->memory) {
    null_release(device, buffer);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  *out = buffer;
  return CSM_SUCCESS;
}

void null_buffer_destroy(gpu_device *device, gpu_buffer *buffer) {
  if (buffer) {
    null_require_unused(device, buffer->used, "buffer_destroy: a recording uses it");
    null_release(device, buffer->memory);
  }
  null_release(device, buffer);
}

void *null_buffer_memory(gpu_buffer *buffer) {
  return buffer->info.kind == GPU_BUFFER_DEVICE ? NULL : buffer->memory;
}

uint64_t null_buffer_native(const gpu_buffer *buffer) {
  return (uintptr_t)buffer;
}

/* ---- images ---- */

static uint32_t most_levels(uint32_t width, uint32_t height) {
  uint32_t levels = 1;
  for (uint32_t size = width > height ? width : height; size > 1; size /= 2)
    levels++;
  return levels;
}

static void check_image(gpu_device *device, const gpu_image_info *info) {
  gpu_device_info about;
  null_describe(device, &about);
  const uint32_t can = info->format < GPU_FORMAT_COUNT ? about.can.formats[info->format] : 0;
  const uint32_t wanted = (info->usage & GPU_IMAGE_TARGET ? GPU_CAN_DRAW : 0) |
                          (info->usage & GPU_IMAGE_SAMPLED ? GPU_CAN_SAMPLE : 0) |
                          (info->usage & GPU_IMAGE_STORED ? GPU_CAN_STORE : 0);
  if (null_require(device, can, "image_create: no format of an image"))
    null_require(device, !(wanted & ~can), "image_create: the format cannot what the usage asks");
  null_require(device, info->width && info->height && info->layers, "image_create: a size or a count of layers of 0");
  null_require(device, level_count(info) <= most_levels(info->width, info->height),
               "image_create: more levels than its size has");
  null_require(device, !gpu_format_is_depth(info->format) || !(info->usage & GPU_IMAGE_COPY_TARGET),
               "image_create: depth is no target of copies");
}

csm_result null_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out) {
  check_image(device, info);
  const size_t pieces = (size_t)info->layers * level_count(info);
  gpu_image *image = *out = null_make(device, sizeof *image + pieces * sizeof *image->pieces);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  null_set_name(image->name, info->name);
  image->info = *info;
  return CSM_SUCCESS;
}

void null_image_destroy(gpu_device *device, gpu_image *image) {
  if (image)
    null_require_unused(device, image->used, "image_destroy: a recording uses it");
  null_release(device, image);
}

uint64_t null_image_bytes(const gpu_image *image) {
  const gpu_image_info *info = &image->info;
  uint64_t texels = 0;
  for (uint32_t level = 0; level < null_levels(image); level++)
    texels += (uint64_t)gpu_level_size(info->width, level) * gpu_level_size(info->height, level);
  return texels * info->layers * gpu_format_bytes(info->format);
}

void null_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out) {
  (void)device;
  *out = (gpu_native_image){.image = (uintptr_t)image};
}

void null_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor) {
  null_record(device, "image_describe %s %llu", image->name, (unsigned long long)descriptor);
}

/* Never reached: there is no engine's device to import from. */
csm_result null_image_import(gpu_device *device, const void *native, gpu_texels texels, gpu_image **out,
                             gpu_imported *about) {
  (void)native;
  (void)texels;
  null_require(device, false, "image_import: not on an engine's device");
  *out = NULL;
  *about = (gpu_imported){0};
  return CSM_ERROR_UNSUPPORTED;
}

csm_result null_geometry_import(gpu_device *device, const void *native, gpu_geometry *out) {
  (void)native;
  null_require(device, false, "geometry_import: not on an engine's device");
  *out = (gpu_geometry){0};
  return CSM_ERROR_UNSUPPORTED;
}

/* ---- views ---- */

csm_result null_view_create(gpu_device *device, const gpu_view_info *info, gpu_view **out) {
  const gpu_range range = null_range(info->image, &info->range);
  null_require(device, contains(info->image, &range), "view_create: no such layers or levels");
  null_require(device, info->image->info.usage & (GPU_IMAGE_SAMPLED | GPU_IMAGE_STORED),
               "view_create: of an image that shaders do not see");
  gpu_view *view = *out = null_make(device, sizeof *view);
  if (!view)
    return CSM_ERROR_OUT_OF_MEMORY;
  *view = (gpu_view){.image = info->image, .range = range};
  return CSM_SUCCESS;
}

void null_view_destroy(gpu_device *device, gpu_view *view) {
  if (view)
    null_require_unused(device, view->used, "view_destroy: a recording uses it");
  null_release(device, view);
}

/* ---- targets ---- */

typedef struct attachment {
  const gpu_image *image;
  uint32_t layer, level;
  bool depth;
} attachment;

static void check_attachment(gpu_device *device, const attachment *on) {
  const gpu_image_info *info = &on->image->info;
  null_require(device, on->layer < info->layers,
               on->depth ? "target_create: no such depth layer" : "target_create: no such colour layer");
  null_require(device, on->level < null_levels(on->image),
               on->depth ? "target_create: no such depth level" : "target_create: no such colour level");
  null_require(device, gpu_format_is_depth(info->format) == on->depth,
               on->depth ? "target_create: depth has no depths" : "target_create: colour has depths");
  null_require(device, info->usage & GPU_IMAGE_TARGET, "target_create: an image that is not made to be one");
}

csm_result null_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out) {
  const attachment on[2] = {{info->depth, info->depth_layer, info->depth_level, true},
                            {info->color, info->color_layer, info->color_level, false}};
  gpu_target *target = *out = null_make(device, sizeof *target);
  if (!target)
    return CSM_ERROR_OUT_OF_MEMORY;
  null_set_name(target->name, info->name);
  target->info = *info;
  null_require(device, info->depth || info->color, "target_create: without an image");
  for (uint32_t i = 0; i < 2; i++) {
    if (!on[i].image)
      continue;
    check_attachment(device, &on[i]);
    const uint32_t width = gpu_level_size(on[i].image->info.width, on[i].level);
    const uint32_t height = gpu_level_size(on[i].image->info.height, on[i].level);
    null_require(device, !target->width || (width == target->width && height == target->height),
                 "target_create: depth and colour differ in size");
    target->width = width;
    target->height = height;
  }
  return CSM_SUCCESS;
}

void null_target_destroy(gpu_device *device, gpu_target *target) {
  if (target)
    null_require_unused(device, target->used, "target_destroy: a recording uses it");
  null_release(device, target);
}

csm_result null_target_native(gpu_device *device, gpu_format depth, gpu_format color, gpu_native_target *out) {
  null_require(device, depth || color, "target_native: without a format");
  null_require(device, !depth || gpu_format_is_depth(depth), "target_native: no depth format");
  null_require(device, !gpu_format_is_depth(color), "target_native: no colour format");
  *out = (gpu_native_target){0};
  return CSM_SUCCESS;
}
