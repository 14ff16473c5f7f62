#include "context.h"

#include <string.h>

enum { alignment = 64 };

void *context_allocate(csm_context *context, size_t size) {
  void *memory = context->allocate(context->user, size, alignment);
  if (memory)
    memset(memory, 0, size);
  else
    context_fail(context, CSM_ERROR_OUT_OF_MEMORY, "out of memory: %zu bytes", size);
  return memory;
}

void context_release(csm_context *context, void *memory) {
  if (memory)
    context->release(context->user, memory);
}

csm_result context_grow(csm_context *context, void **memory, size_t *capacity, size_t size) {
  if (size <= *capacity)
    return CSM_SUCCESS;
  const size_t grown = size + size / 2;
  void *fresh = context_allocate(context, grown);
  if (!fresh)
    return CSM_ERROR_OUT_OF_MEMORY;
  context_release(context, *memory);
  *memory = fresh;
  *capacity = grown;
  return CSM_SUCCESS;
}

/* Drivers may accept more than they say that they can hold (lavapipe does), so limits are asked first. */
static csm_result check_device_memory(csm_context *context, const char *name, uint64_t size, uint64_t largest) {
  const uint64_t limit = context->memory_limit ? context->memory_limit : context->info.memory_size;
  if (size > largest)
    return context_fail(context, CSM_ERROR_LIMIT_EXCEEDED, "%s takes %llu bytes, the device allows %llu in one piece",
                        name, (unsigned long long)size, (unsigned long long)largest);
  if (size > limit || context->memory_used > limit - size)
    return context_fail(context, CSM_ERROR_LIMIT_EXCEEDED, "%s takes %llu bytes; %llu of %llu are in use", name,
                        (unsigned long long)size, (unsigned long long)context->memory_used, (unsigned long long)limit);
  return CSM_SUCCESS;
}

csm_result context_buffer(csm_context *context, const gpu_buffer_info *info, gpu_buffer **out) {
  const uint64_t most = context->info.max_buffer_size < context->info.max_allocation_size
                            ? context->info.max_buffer_size
                            : context->info.max_allocation_size;
  *out = NULL;
  csm_result result = check_device_memory(context, info->name, info->size, most);
  if (!result)
    result = context_check(context, context->gpu.api->buffer_create(context->gpu.device, info, out), info->name);
  if (!result)
    context->memory_used += info->size;
  return result;
}

void context_buffer_free(csm_context *context, gpu_buffer *buffer, uint64_t size) {
  if (!buffer)
    return;
  context->gpu.api->buffer_destroy(context->gpu.device, buffer);
  context->memory_used -= size;
}

csm_result context_image(csm_context *context, const gpu_image_info *info, gpu_image **out) {
  const uint64_t texel = info->format == GPU_FORMAT_R8_UNORM ? 1 : 4;
  *out = NULL;
  if (info->width > context->info.max_image_size || info->height > context->info.max_image_size)
    return context_fail(context, CSM_ERROR_LIMIT_EXCEEDED, "%s: %u x %u texels, the device allows %u a side",
                        info->name, info->width, info->height, context->info.max_image_size);
  if (info->layers > context->info.max_image_layers)
    return context_fail(context, CSM_ERROR_LIMIT_EXCEEDED, "%s: %u layers, the device allows %u", info->name,
                        info->layers, context->info.max_image_layers);
  csm_result result = check_device_memory(context, info->name, texel * info->width * info->height * info->layers,
                                          context->info.max_allocation_size);
  if (!result)
    result = context_check(context, context->gpu.api->image_create(context->gpu.device, info, out), info->name);
  if (!result)
    context->memory_used += context->gpu.api->image_bytes(*out);
  return result;
}

void context_image_free(csm_context *context, gpu_image *image) {
  if (!image)
    return;
  context->memory_used -= context->gpu.api->image_bytes(image);
  context->gpu.api->image_destroy(context->gpu.device, image);
}
