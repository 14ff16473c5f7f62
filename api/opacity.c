#include "context.h"

#include <string.h>

enum { largest_side = 16384 };

/* ---- on a device ---- */

/* Texels on their way to a texture. */
typedef struct staged_texels {
  retired retired;
  gpu_buffer *buffer;
  uint64_t size;
  uint32_t width, height, row_bytes;
} staged_texels;

struct opacity_image {
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
  opacity_image *image = (opacity_image *)self;
  if (image->staged)
    staged_free(device, &image->staged->retired);
  device_image_free(device, image->texture);
  context_release(device->context, image);
}

static csm_result stage_texels(device *device, const csm_opacity_info *info, staged_texels **out) {
  staged_texels *staged = context_allocate(device->context, sizeof *staged);
  if (!staged)
    return CSM_ERROR_OUT_OF_MEMORY;
  staged->width = info->width;
  staged->height = info->height;
  staged->row_bytes = device_row_bytes(info->width, GPU_FORMAT_R8_UNORM);
  staged->size = (uint64_t)staged->row_bytes * info->height;
  const csm_result result = device_buffer(
      device, &(gpu_buffer_info){.name = "opacity staging", .kind = GPU_BUFFER_UPLOAD, .size = staged->size},
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

csm_result opacity_reserve(device *device, uint32_t capacity) {
  opacity_images *opacities = &device->opacities;
  if (capacity <= opacities->capacity)
    return CSM_SUCCESS;
  opacity_image **images = context_allocate(device->context, capacity * sizeof *images);
  if (!images)
    return CSM_ERROR_OUT_OF_MEMORY;
  if (opacities->capacity)
    memcpy(images, opacities->images, opacities->capacity * sizeof *images);
  context_release(device->context, opacities->images);
  opacities->images = images;
  opacities->capacity = capacity;
  return CSM_SUCCESS;
}

csm_result opacity_add(device *device, uint32_t slot, const csm_opacity_info *info) {
  opacity_image *image = context_allocate(device->context, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  const gpu_image_info texture = {.name = "opacity",
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
  device->opacities.images[slot] = image;
  ++device->opacities.due;
  return CSM_SUCCESS;
}

gpu_image *opacity_texture(const device *device, uint32_t slot) {
  return device->opacities.images[slot]->texture;
}

void opacity_remove(device *device, uint32_t slot) {
  opacity_image *image = device->opacities.images[slot];
  device->opacities.images[slot] = NULL;
  device->opacities.due -= image->staged != NULL;
  retire(device, &image->retired, image_free);
}

void opacity_record(device *device) {
  opacity_images *opacities = &device->opacities;
  for (uint32_t i = 0; i < opacities->capacity && opacities->due; ++i) {
    opacity_image *image = opacities->images[i];
    if (!image || !image->staged)
      continue;
    const gpu_region all = {.width = image->staged->width, .height = image->staged->height};
    device->gpu.api->copy_to_image(device->gpu.device, image->texture, &all, image->staged->buffer, 0,
                                   image->staged->row_bytes);
    device->gpu.api->make_readable(device->gpu.device, image->texture, NULL);
    retire(device, &image->staged->retired, staged_free);
    image->staged = NULL;
    --opacities->due;
  }
}

void opacity_destroy(device *device) {
  opacity_images *opacities = &device->opacities;
  for (uint32_t i = 0; i < opacities->capacity; ++i)
    if (opacities->images[i])
      image_free(device, &opacities->images[i]->retired);
  context_release(device->context, opacities->images);
}

/* ---- in a context ---- */

static csm_result check_info(csm_context *context, csm_opacity_info *info) {
  if (!info->texels)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "csm_opacity_info: texels is NULL");
  if (!info->row_stride)
    info->row_stride = info->width;
  const char *wrong = info->flags || info->reserved                  ? "flags"
                      : !info->width || info->width > largest_side   ? "width"
                      : !info->height || info->height > largest_side ? "height"
                      : info->wrap_u > CSM_WRAP_MIRROR               ? "wrap_u"
                      : info->wrap_v > CSM_WRAP_MIRROR               ? "wrap_v"
                      : info->row_stride < info->width               ? "row_stride"
                                                                     : NULL;
  return wrong ? context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_opacity_info: %s is not allowed", wrong)
               : CSM_SUCCESS;
}

static csm_result grow(csm_context *context) {
  opacity_table *opacities = &context->opacities;
  const uint32_t count = opacities->handles.count, capacity = handles_grown(&opacities->handles, 16);
  const csm_result result = opacity_reserve(context->device, capacity);
  if (result)
    return result;
  handle_place *places = context_allocate(context, capacity * sizeof *places);
  csm_opacity_info *infos = context_allocate(context, capacity * sizeof *infos);
  uint32_t *users = context_allocate(context, capacity * sizeof *users);
  if (!places || !infos || !users) {
    context_release(context, places);
    context_release(context, infos);
    context_release(context, users);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  if (count) {
    memcpy(infos, opacities->infos, count * sizeof *infos);
    memcpy(users, opacities->users, count * sizeof *users);
  }
  context_release(context, handles_grow(&opacities->handles, places, capacity));
  context_release(context, opacities->infos);
  context_release(context, opacities->users);
  opacities->infos = infos;
  opacities->users = users;
  return CSM_SUCCESS;
}

/* Names a free place without taking it. */
static csm_result find_place(csm_context *context, uint32_t *index) {
  *index = handles_next(&context->opacities.handles);
  return *index < context->opacities.handles.capacity ? CSM_SUCCESS : grow(context);
}

static csm_result keep(csm_context *context, const csm_opacity_info *info, csm_opacity_info *kept) {
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

csm_result CSM_CALL csm_opacity_create(csm_context *context, const csm_opacity_info *info, csm_opacity *opacity) {
  if (opacity)
    *opacity = 0;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_opacity_info own, kept;
  uint32_t index;
  csm_result result = context_usable(context);
  if (!result)
    result = context_check_struct(context, struct_read(&own, sizeof own, info), "csm_opacity_info");
  if (!result && !opacity)
    result = context_fail(context, CSM_ERROR_NULL_POINTER, "opacity is NULL");
  if (!result)
    result = check_info(context, &own);
  if (!result)
    result = find_place(context, &index);
  if (!result)
    result = keep(context, &own, &kept);
  if (result)
    return result;
  result = opacity_add(context->device, index, &kept);
  if (result) {
    context_release(context, (void *)kept.texels);
    return result;
  }
  opacity_table *opacities = &context->opacities;
  opacities->infos[index] = kept;
  opacities->users[index] = 0;
  *opacity = handles_take(&opacities->handles);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_opacity_destroy(csm_context *context, csm_opacity opacity) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  const csm_result result = context_usable(context);
  if (result)
    return result;
  opacity_table *opacities = &context->opacities;
  const uint32_t index = handles_find(&opacities->handles, opacity);
  if (index == UINT32_MAX)
    return context_fail(context, CSM_ERROR_INVALID_HANDLE, "opacity %llx does not exist", (unsigned long long)opacity);
  if (opacities->users[index])
    return context_fail(context, CSM_ERROR_INVALID_STATE, "%u meshes use opacity %llx still", opacities->users[index],
                        (unsigned long long)opacity);
  opacity_remove(context->device, index);
  context_release(context, (void *)opacities->infos[index].texels);
  opacities->infos[index].texels = NULL;
  handles_free(&opacities->handles, index);
  return CSM_SUCCESS;
}

csm_result opacities_move(csm_context *context, device *to) {
  const opacity_table *opacities = &context->opacities;
  csm_result result = opacity_reserve(to, opacities->handles.capacity);
  for (uint32_t i = 0; i < opacities->handles.count && !result; ++i)
    if (handles_live(&opacities->handles, i))
      result = opacity_add(to, i, &opacities->infos[i]);
  return result;
}

void opacities_destroy(csm_context *context) {
  opacity_table *opacities = &context->opacities;
  for (uint32_t i = 0; i < opacities->handles.count; ++i)
    context_release(context, (void *)opacities->infos[i].texels);
  context_release(context, opacities->handles.places);
  context_release(context, opacities->infos);
  context_release(context, opacities->users);
}
