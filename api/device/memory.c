#include "device/pages.h"

enum { row_alignment = 256 };

/* What the engine, or else the driver, says that may still be taken. */
static uint64_t budget(device *device) {
  const host *host = device->host;
  return host->budget ? host->budget(host->user) : gpu_memory_available(device->gpu);
}

/* Whether so much may be taken on top of what is held. */
static bool fits(device *device, uint64_t size, uint64_t limit) {
  return size <= limit && device->memory_used <= limit - size && size <= budget(device);
}

/* Lets go of what nobody has any more. On an own device that may take waiting for the frames that used it last. */
static void make_room(device *device) {
  if (!device->lost)
    (void)recording_finish(device); /* who needs the device will be told of its loss */
  retire_collect(device);
  pages_free_empty(device);
}

/* Drivers may accept more than they say that they can hold (lavapipe does), so limits are asked first. */
static csm_result check_memory(device *device, const char *name, uint64_t size, uint64_t largest) {
  host *host = device->host;
  const uint64_t limit = device->memory_limit ? device->memory_limit : device->info.memory_size;
  if (size > largest)
    return host_fail(host, CSM_ERROR_LIMIT_EXCEEDED, "%s takes %llu bytes, the device allows %llu in one piece", name,
                     (unsigned long long)size, (unsigned long long)largest);
  retire_collect(device); /* who makes and frees without drawing would else hold all that until a frame */
  if (!fits(device, size, limit))
    make_room(device);
  if (fits(device, size, limit))
    return CSM_SUCCESS;
  const uint64_t left = limit > device->memory_used ? limit - device->memory_used : 0;
  if (size > left)
    return host_fail(host, CSM_ERROR_LIMIT_EXCEEDED, "%s takes %llu bytes; %llu of %llu are in use", name,
                     (unsigned long long)size, (unsigned long long)device->memory_used, (unsigned long long)limit);
  return host_fail(host, CSM_ERROR_LIMIT_EXCEEDED, "%s takes %llu bytes; the budget leaves %llu", name,
                   (unsigned long long)size, (unsigned long long)budget(device));
}

csm_result device_buffer(device *device, const gpu_buffer_info *info, gpu_buffer **out) {
  const uint64_t most = device->info.max_buffer_size < device->info.max_allocation_size
                            ? device->info.max_buffer_size
                            : device->info.max_allocation_size;
  *out = NULL;
  csm_result result = check_memory(device, info->name, info->size, most);
  if (!result)
    result = device_check(device, gpu_buffer_create(device->gpu, info, out), info->name);
  if (!result)
    device->memory_used += info->size;
  return result;
}

void device_buffer_free(device *device, gpu_buffer *buffer, uint64_t size) {
  if (!buffer)
    return;
  gpu_buffer_destroy(device->gpu, buffer);
  device->memory_used -= size;
}

csm_result device_image(device *device, const gpu_image_info *info, gpu_image **out) {
  host *host = device->host;
  const uint64_t texel = gpu_format_bytes(info->format);
  *out = NULL;
  if (info->width > device->info.max_image_size || info->height > device->info.max_image_size)
    return host_fail(host, CSM_ERROR_LIMIT_EXCEEDED, "%s: %u x %u texels, the device allows %u a side", info->name,
                     info->width, info->height, device->info.max_image_size);
  if (info->layers > device->info.max_image_layers)
    return host_fail(host, CSM_ERROR_LIMIT_EXCEEDED, "%s: %u layers, the device allows %u", info->name, info->layers,
                     device->info.max_image_layers);
  csm_result result = check_memory(device, info->name, texel * info->width * info->height * info->layers,
                                   device->info.max_allocation_size);
  if (!result)
    result = device_check(device, gpu_image_create(device->gpu, info, out), info->name);
  if (!result)
    device->memory_used += gpu_image_bytes(device->gpu, *out);
  return result;
}

uint32_t device_row_bytes(uint32_t width, gpu_format format) {
  return (width * gpu_format_bytes(format) + row_alignment - 1) / row_alignment * row_alignment;
}

csm_result device_drawn_image(device *device, const gpu_image_info *wanted, gpu_image **image, gpu_target **target) {
  gpu_image_info info = *wanted;
  info.usage |= GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  info.layers = 1;
  csm_result result = device_image(device, &info, image);
  if (result)
    return result;
  const bool depth = gpu_format_is_depth(info.format);
  const gpu_target_info on = {.name = info.name, .depth = depth ? *image : NULL, .color = depth ? NULL : *image};
  result = device_check(device, gpu_target_create(device->gpu, &on, target), info.name);
  if (result) {
    device_image_free(device, *image);
    *image = NULL;
  }
  return result;
}

void device_image_free(device *device, gpu_image *image) {
  if (!image)
    return;
  device->memory_used -= gpu_image_bytes(device->gpu, image);
  gpu_image_destroy(device->gpu, image);
}
