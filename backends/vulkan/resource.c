/* resource.c: buffers, images and views. */
#include "internal.h"

/* ---- buffers ---- */

static VkBufferUsageFlags buffer_usage(const gpu_buffer_info *info) {
  VkBufferUsageFlags usage =
      VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  if (info->kind == GPU_BUFFER_READBACK)
    return VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  if (info->kind == GPU_BUFFER_DEVICE)
    usage |= VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  else
    usage |= VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT;
  if (info->usage & (GPU_BUFFER_READ | GPU_BUFFER_WRITE))
    usage |= VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  if (info->usage & GPU_BUFFER_TEXELS)
    usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  if (info->usage & GPU_BUFFER_INDIRECT)
    usage |= VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT;
  return usage;
}

static csm_result make_texels(gpu_device *device, gpu_buffer *buffer, const gpu_buffer_info *info) {
  if (!(info->usage & GPU_BUFFER_TEXELS))
    return CSM_SUCCESS;
  const VkBufferViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                       .buffer = buffer->handle,
                                       .format = VK_FORMAT_R32G32B32A32_UINT,
                                       .range = VK_WHOLE_SIZE};
  const csm_result result =
      vulkan_made(device, device->vk.CreateBufferView(device->handle, &view, NULL, &buffer->texels), &buffer->texels,
                  "vkCreateBufferView");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_BUFFER_VIEW, (uint64_t)buffer->texels, info->name);
  return result;
}

csm_result vulkan_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out) {
  *out = NULL;
  const vulkan_functions *vk = &device->vk;
  gpu_buffer *buffer = lent_allocate(&device->lent, sizeof *buffer);
  if (!buffer)
    return CSM_ERROR_OUT_OF_MEMORY;
  buffer->kind = info->kind;
  buffer->size = info->size;
  device->buffer_usage |= info->usage;

  const VkBufferCreateInfo create = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = info->size,
                                     .usage = buffer_usage(info),
                                     .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
  csm_result result = vulkan_made(device, vk->CreateBuffer(device->handle, &create, NULL, &buffer->handle),
                                  &buffer->handle, "vkCreateBuffer");
  if (result != CSM_SUCCESS)
    goto failed;
  vulkan_name(device, VK_OBJECT_TYPE_BUFFER, (uint64_t)buffer->handle, info->name);

  vulkan_memory_request request = {.kind = info->kind, .buffer = buffer->handle, .name = info->name};
  vk->GetBufferMemoryRequirements(device->handle, buffer->handle, &request.needs);
  result = vulkan_memory_allocate(device, &request, &buffer->memory);
  if (result != CSM_SUCCESS)
    goto failed;
  result = vulkan_check(
      device, vk->BindBufferMemory(device->handle, buffer->handle, buffer->memory.handle, buffer->memory.offset),
      "vkBindBufferMemory");
  if (result == CSM_SUCCESS)
    result = make_texels(device, buffer, info);
  if (result != CSM_SUCCESS)
    goto failed;
  *out = buffer;
  return CSM_SUCCESS;

failed:
  vulkan_buffer_destroy(device, buffer);
  return result;
}

void vulkan_buffer_destroy(gpu_device *device, gpu_buffer *buffer) {
  if (!buffer)
    return;
  device->vk.DestroyBufferView(device->handle, buffer->texels, NULL);
  if (!buffer->borrowed)
    device->vk.DestroyBuffer(device->handle, buffer->handle, NULL);
  vulkan_memory_release(device, &buffer->memory);
  lent_release(&device->lent, buffer);
}

void *vulkan_buffer_memory(gpu_buffer *buffer) {
  return buffer->memory.mapped;
}

uint64_t vulkan_buffer_native(const gpu_buffer *buffer) {
  return (uint64_t)buffer->handle;
}

/* ---- images ---- */

static VkImageUsageFlags image_usage(const gpu_image_info *info) {
  const bool depth = gpu_format_is_depth(info->format);
  VkImageUsageFlags usage = 0;
  if (info->usage & GPU_IMAGE_TARGET)
    usage |= depth ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT
                   : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  if (info->usage & GPU_IMAGE_SAMPLED)
    usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
  if (info->usage & GPU_IMAGE_STORED)
    usage |= VK_IMAGE_USAGE_STORAGE_BIT;
  if (info->usage & GPU_IMAGE_COPY_SOURCE)
    usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  if (info->usage & GPU_IMAGE_COPY_TARGET)
    usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  return usage;
}

gpu_range vulkan_range(const gpu_image *image, const gpu_range *range) {
  gpu_range all = range ? *range : (gpu_range){0};
  if (all.layer_count == 0)
    all.layer_count = image->layer_count - all.first_layer;
  if (all.level_count == 0)
    all.level_count = image->level_count - all.first_level;
  return all;
}

VkImageSubresourceRange vulkan_subresources(const gpu_image *image, const gpu_range *range) {
  return (VkImageSubresourceRange){.aspectMask = image->aspect,
                                   .baseMipLevel = range->first_level,
                                   .levelCount = range->level_count,
                                   .baseArrayLayer = range->first_layer,
                                   .layerCount = range->layer_count};
}

csm_result vulkan_image_view(gpu_device *device, const gpu_view_info *view, bool array, VkImageView *out) {
  const gpu_range range = vulkan_range(view->image, &view->range);
  const VkImageViewCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                      .image = view->image->handle,
                                      .viewType = array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D,
                                      .format = vulkan_format(view->image->format),
                                      .subresourceRange = vulkan_subresources(view->image, &range)};
  const csm_result result =
      vulkan_made(device, device->vk.CreateImageView(device->handle, &info, NULL, out), out, "vkCreateImageView");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_IMAGE_VIEW, (uint64_t)*out, view->name);
  return result;
}

static csm_result image_handle_create(gpu_device *device, gpu_image *image, const gpu_image_info *info) {
  const vulkan_functions *vk = &device->vk;
  const VkImageCreateInfo create = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = vulkan_format(info->format),
                                    .extent = {info->width, info->height, 1},
                                    .mipLevels = image->level_count,
                                    .arrayLayers = info->layers,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .tiling = VK_IMAGE_TILING_OPTIMAL,
                                    .usage = image_usage(info),
                                    .sharingMode = VK_SHARING_MODE_EXCLUSIVE,
                                    .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
  csm_result result = vulkan_made(device, vk->CreateImage(device->handle, &create, NULL, &image->handle),
                                  &image->handle, "vkCreateImage");
  if (result != CSM_SUCCESS)
    return result;
  vulkan_name(device, VK_OBJECT_TYPE_IMAGE, (uint64_t)image->handle, info->name);

  vulkan_memory_request request = {.kind = GPU_BUFFER_DEVICE, .image = image->handle, .name = info->name};
  vk->GetImageMemoryRequirements(device->handle, image->handle, &request.needs);
  result = vulkan_memory_allocate(device, &request, &image->memory);
  if (result != CSM_SUCCESS)
    return result;
  return vulkan_check(device,
                      vk->BindImageMemory(device->handle, image->handle, image->memory.handle, image->memory.offset),
                      "vkBindImageMemory");
}

csm_result vulkan_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out) {
  *out = NULL;
  const uint32_t levels = info->levels ? info->levels : 1;
  const size_t count = (size_t)info->layers * levels;
  gpu_image *image = lent_allocate(&device->lent, sizeof *image + 2 * count * sizeof *image->states);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->format = info->format;
  image->width = info->width;
  image->height = info->height;
  image->layer_count = info->layers;
  image->sampled_layout = device->read.layout;
  image->level_count = levels;
  image->array = info->array || info->layers > 1;
  image->before = image->states + count;
  image->aspect = gpu_format_is_depth(info->format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;

  csm_result result = image_handle_create(device, image, info);
  if (result == CSM_SUCCESS && (info->usage & GPU_IMAGE_SAMPLED))
    result =
        vulkan_image_view(device, &(gpu_view_info){.name = info->name, .image = image}, image->array, &image->view);
  if (result == CSM_SUCCESS)
    *out = image;
  else
    vulkan_image_destroy(device, image);
  return result;
}

void vulkan_image_destroy(gpu_device *device, gpu_image *image) {
  if (!image)
    return;
  if (!image->borrowed) {
    device->vk.DestroyImageView(device->handle, image->view, NULL);
    device->vk.DestroyImage(device->handle, image->handle, NULL);
  }
  vulkan_memory_release(device, &image->memory);
  lent_release(&device->lent, image);
}

uint64_t vulkan_image_bytes(const gpu_image *image) {
  return image->memory.size;
}

void vulkan_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out) {
  const VkSampler *samplers = device->samplers;
  *out = (gpu_native_image){.image = (uint64_t)image->handle,
                            .view = (uint64_t)image->view,
                            .sampler = (uint64_t)samplers[GPU_SAMPLER_COMPARE_LESS_EQUAL],
                            .sampler_reversed = (uint64_t)samplers[GPU_SAMPLER_COMPARE_GREATER_EQUAL],
                            .sampler_repeat = (uint64_t)samplers[GPU_SAMPLER_COMPARE_LESS_EQUAL_REPEAT],
                            .sampler_repeat_reversed = (uint64_t)samplers[GPU_SAMPLER_COMPARE_GREATER_EQUAL_REPEAT]};
}

void vulkan_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor) {
  (void)device;
  (void)image;
  (void)descriptor;
}

/* ---- views ---- */

csm_result vulkan_view_create(gpu_device *device, const gpu_view_info *info, gpu_view **out) {
  *out = NULL;
  gpu_view *view = lent_allocate(&device->lent, sizeof *view);
  if (!view)
    return CSM_ERROR_OUT_OF_MEMORY;
  view->image = info->image;
  view->range = vulkan_range(info->image, &info->range);
  const csm_result result = vulkan_image_view(device, info, info->image->array, &view->handle);
  if (result == CSM_SUCCESS)
    *out = view;
  else
    lent_release(&device->lent, view);
  return result;
}

void vulkan_view_destroy(gpu_device *device, gpu_view *view) {
  if (!view)
    return;
  device->vk.DestroyImageView(device->handle, view->handle, NULL);
  lent_release(&device->lent, view);
}
