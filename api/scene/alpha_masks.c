#include "abi/context.h"

#include <string.h>

enum { largest_side = 16384 };

/* ---- on a device ---- */

/* Texels on their way to a texture. */
typedef struct staged_texels {
  retired retired;
  gpu_buffer *buffer;
  uint64_t size;
  uint32_t row_bytes;
} staged_texels;

struct alpha_mask_image {
  retired retired;
  gpu_image *texture;
  staged_texels *staged; /* NULL once they are on their way */
};

static void staged_free(device *device, retired *self) {
  staged_texels *staged = (staged_texels *)self;
  device_buffer_free(device, staged->buffer, staged->size);
  context_release(device->context, staged);
}

static void image_free(device *device, retired *self) {
  alpha_mask_image *image = (alpha_mask_image *)self;
  if (image->staged)
    staged_free(device, &image->staged->retired);
  device_image_free(device, image->texture);
  context_release(device->context, image);
}

static csm_result stage_texels(device *device, const csm_alpha_mask_info *info, staged_texels **out) {
  staged_texels *staged = context_allocate(device->context, sizeof *staged);
  if (!staged)
    return CSM_ERROR_OUT_OF_MEMORY;
  staged->row_bytes = device_row_bytes(info->width, GPU_FORMAT_R8_UNORM);
  staged->size = (uint64_t)staged->row_bytes * info->height;
  const csm_result result = device_buffer(
      device, &(gpu_buffer_info){.name = "alpha_mask staging", .kind = GPU_BUFFER_UPLOAD, .size = staged->size},
      &staged->buffer);
  if (result) {
    context_release(device->context, staged);
    return result;
  }
  char *rows = device->gpu.api->buffer_memory(staged->buffer);
  for (uint32_t y = 0; y < info->height; ++y)
    memcpy(rows + (size_t)y * staged->row_bytes, info->texels + (size_t)y * info->row_stride, info->width);
  *out = staged;
  return CSM_SUCCESS;
}

csm_result alpha_mask_reserve(device *device, uint32_t capacity) {
  alpha_mask_images *alpha_masks = &device->alpha_masks;
  if (capacity <= alpha_masks->capacity)
    return CSM_SUCCESS;
  alpha_mask_image **images = context_allocate(device->context, capacity * sizeof *images);
  if (!images)
    return CSM_ERROR_OUT_OF_MEMORY;
  if (alpha_masks->capacity)
    memcpy(images, alpha_masks->images, alpha_masks->capacity * sizeof *images);
  context_release(device->context, alpha_masks->images);
  alpha_masks->images = images;
  alpha_masks->capacity = capacity;
  return CSM_SUCCESS;
}

csm_result alpha_mask_add(device *device, uint32_t slot, const csm_alpha_mask_info *info) {
  alpha_mask_image *image = context_allocate(device->context, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  const gpu_image_info texture = {.name = "alpha_mask",
                                  .format = GPU_FORMAT_R8_UNORM,
                                  .usage = GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_TARGET,
                                  .width = info->width,
                                  .height = info->height,
                                  .layers = 1};
  csm_result result = device_image(device, &texture, &image->texture);
  if (!result)
    result = stage_texels(device, info, &image->staged);
  if (result) {
    image_free(device, &image->retired);
    return result;
  }
  device->alpha_masks.images[slot] = image;
  ++device->alpha_masks.due;
  return CSM_SUCCESS;
}

gpu_image *alpha_mask_texture(const device *device, uint32_t slot) {
  return device->alpha_masks.images[slot]->texture;
}

void alpha_mask_remove(device *device, uint32_t slot) {
  alpha_mask_image *image = device->alpha_masks.images[slot];
  device->alpha_masks.images[slot] = NULL;
  device->alpha_masks.due -= image->staged != NULL;
  retire(device, &image->retired, image_free);
}

void alpha_mask_record(device *device) {
  alpha_mask_images *alpha_masks = &device->alpha_masks;
  for (uint32_t i = 0; i < alpha_masks->capacity && alpha_masks->due; ++i) {
    alpha_mask_image *image = alpha_masks->images[i];
    if (!image || !image->staged)
      continue;
    device->gpu.api->copy_to_image(device->gpu.device, image->texture, image->staged->buffer, 0,
                                   image->staged->row_bytes);
    device->gpu.api->make_readable(device->gpu.device, image->texture);
    retire(device, &image->staged->retired, staged_free);
    image->staged = NULL;
    --alpha_masks->due;
  }
}

void alpha_mask_destroy(device *device) {
  alpha_mask_images *alpha_masks = &device->alpha_masks;
  for (uint32_t i = 0; i < alpha_masks->capacity; ++i)
    if (alpha_masks->images[i])
      image_free(device, &alpha_masks->images[i]->retired);
  context_release(device->context, alpha_masks->images);
}

/* ---- in a context ---- */

static csm_result check_info(csm_context *context, csm_alpha_mask_info *info) {
  if (!info->texels)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "csm_alpha_mask_info: texels is NULL");
  if (!info->row_stride)
    info->row_stride = info->width;
  const char *wrong = info->flags || info->reserved                  ? "flags"
                      : !info->width || info->width > largest_side   ? "width"
                      : !info->height || info->height > largest_side ? "height"
                      : info->wrap_u > CSM_WRAP_MIRROR               ? "wrap_u"
                      : info->wrap_v > CSM_WRAP_MIRROR               ? "wrap_v"
                      : info->row_stride < info->width               ? "row_stride"
                                                                     : NULL;
  return wrong ? context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_alpha_mask_info: %s is not allowed", wrong)
               : CSM_SUCCESS;
}

static csm_result grow(csm_context *context) {
  alpha_mask_table *alpha_masks = &context->alpha_masks;
  const uint32_t count = alpha_masks->handles.count, capacity = handles_grown(&alpha_masks->handles, 16);
  const csm_result result = alpha_mask_reserve(context->device, capacity);
  if (result)
    return result;
  handle_place *places = context_allocate(context, capacity * sizeof *places);
  csm_alpha_mask_info *infos = context_allocate(context, capacity * sizeof *infos);
  uint32_t *users = context_allocate(context, capacity * sizeof *users);
  if (!places || !infos || !users) {
    context_release(context, places);
    context_release(context, infos);
    context_release(context, users);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  if (count) {
    memcpy(infos, alpha_masks->infos, count * sizeof *infos);
    memcpy(users, alpha_masks->users, count * sizeof *users);
  }
  context_release(context, handles_grow(&alpha_masks->handles, places, capacity));
  context_release(context, alpha_masks->infos);
  context_release(context, alpha_masks->users);
  alpha_masks->infos = infos;
  alpha_masks->users = users;
  return CSM_SUCCESS;
}

/* Names a free place without taking it. */
static csm_result find_place(csm_context *context, uint32_t *index) {
  *index = handles_next(&context->alpha_masks.handles);
  return *index < context->alpha_masks.handles.capacity ? CSM_SUCCESS : grow(context);
}

static csm_result keep(csm_context *context, const csm_alpha_mask_info *info, csm_alpha_mask_info *kept) {
  unsigned char *texels = context_allocate(context, (size_t)info->width * info->height);
  if (!texels)
    return CSM_ERROR_OUT_OF_MEMORY;
  for (uint32_t y = 0; y < info->height; ++y)
    memcpy(texels + (size_t)y * info->width, info->texels + (size_t)y * info->row_stride, info->width);
  *kept = *info;
  kept->texels = texels;
  kept->row_stride = info->width;
  kept->name = NULL;
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_alpha_mask_create(csm_context *context, const csm_alpha_mask_info *info, csm_alpha_mask *alpha_mask) {
  if (alpha_mask)
    *alpha_mask = 0;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_alpha_mask_info own, kept;
  uint32_t index;
  csm_result result = context_usable(context);
  if (!result)
    result = context_check_struct(context, struct_read(&own, sizeof own, info), "csm_alpha_mask_info");
  if (!result && !alpha_mask)
    result = context_fail(context, CSM_ERROR_NULL_POINTER, "alpha_mask is NULL");
  if (!result)
    result = check_info(context, &own);
  if (!result)
    result = find_place(context, &index);
  if (!result)
    result = keep(context, &own, &kept);
  if (result)
    return result;
  result = alpha_mask_add(context->device, index, &kept);
  if (result) {
    context_release(context, (void *)kept.texels);
    return result;
  }
  alpha_mask_table *alpha_masks = &context->alpha_masks;
  alpha_masks->infos[index] = kept;
  alpha_masks->users[index] = 0;
  *alpha_mask = handles_take(&alpha_masks->handles);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_alpha_mask_destroy(csm_context *context, csm_alpha_mask alpha_mask) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  const csm_result result = context_usable(context);
  if (result)
    return result;
  alpha_mask_table *alpha_masks = &context->alpha_masks;
  const uint32_t index = handles_find(&alpha_masks->handles, alpha_mask);
  if (index == UINT32_MAX)
    return context_fail(context, CSM_ERROR_INVALID_HANDLE, "alpha_mask %llx does not exist", (unsigned long long)alpha_mask);
  if (alpha_masks->users[index])
    return context_fail(context, CSM_ERROR_INVALID_STATE, "%u meshes use alpha_mask %llx still", alpha_masks->users[index],
                        (unsigned long long)alpha_mask);
  alpha_mask_remove(context->device, index);
  context_release(context, (void *)alpha_masks->infos[index].texels);
  alpha_masks->infos[index].texels = NULL;
  handles_free(&alpha_masks->handles, index);
  return CSM_SUCCESS;
}

csm_result alpha_masks_move(csm_context *context, device *to) {
  const alpha_mask_table *alpha_masks = &context->alpha_masks;
  csm_result result = alpha_mask_reserve(to, alpha_masks->handles.capacity);
  for (uint32_t i = 0; i < alpha_masks->handles.count && !result; ++i)
    if (handles_live(&alpha_masks->handles, i))
      result = alpha_mask_add(to, i, &alpha_masks->infos[i]);
  return result;
}

void alpha_masks_destroy(csm_context *context) {
  alpha_mask_table *alpha_masks = &context->alpha_masks;
  for (uint32_t i = 0; i < alpha_masks->handles.count; ++i)
    context_release(context, (void *)alpha_masks->infos[i].texels);
  context_release(context, alpha_masks->handles.places);
  context_release(context, alpha_masks->infos);
  context_release(context, alpha_masks->users);
}
