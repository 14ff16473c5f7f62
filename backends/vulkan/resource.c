/* resource.c: buffers, images, and the targets that draws go into. */
#include "internal.h"

/* ---- buffers ---- */

static VkBufferUsageFlags buffer_usage(gpu_buffer_kind kind) {
  const VkBufferUsageFlags geometry = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT;
  switch (kind) {
  case GPU_BUFFER_DEVICE:
    return geometry | VK_BUFFER_USAGE_TRANSFER_DST_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  case GPU_BUFFER_UPLOAD:
    return geometry | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  case GPU_BUFFER_READBACK:
    break;
  }
  return VK_BUFFER_USAGE_TRANSFER_DST_BIT;
}

csm_result vulkan_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out) {
  *out = NULL;
  const vulkan_functions *vk = &device->vk;
  gpu_buffer *buffer = vulkan_allocate(device, sizeof *buffer);
  if (!buffer)
    return CSM_ERROR_OUT_OF_MEMORY;
  buffer->kind = info->kind;

  const VkBufferCreateInfo create = {.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                                     .size = info->size,
                                     .usage = buffer_usage(info->kind),
                                     .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
  csm_result result = vulkan_made(device, vk->CreateBuffer(device->handle, &create, NULL, &buffer->handle),
                                  &buffer->handle, "vkCreateBuffer");
  if (result != CSM_SUCCESS)
    goto failed;
  vulkan_name(device, VK_OBJECT_TYPE_BUFFER, (uint64_t)buffer->handle, info->name);

  VkMemoryRequirements needs;
  vk->GetBufferMemoryRequirements(device->handle, buffer->handle, &needs);
  result = vulkan_memory_allocate(device, &needs, info->kind, false, info->name, &buffer->memory);
  if (result != CSM_SUCCESS)
    goto failed;
  result = vulkan_check(
      device, vk->BindBufferMemory(device->handle, buffer->handle, buffer->memory.handle, buffer->memory.offset),
      "vkBindBufferMemory");
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
  if (!buffer->borrowed)
    device->vk.DestroyBuffer(device->handle, buffer->handle, NULL);
  vulkan_memory_release(device, &buffer->memory);
  vulkan_release(device, buffer);
}

void *vulkan_buffer_memory(gpu_buffer *buffer) {
  return buffer->memory.mapped;
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
  if (info->usage & GPU_IMAGE_COPY_SOURCE)
    usage |= VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  if (info->usage & GPU_IMAGE_COPY_TARGET)
    usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  return usage;
}

static csm_result view_create(gpu_device *device, const gpu_image *image, VkImageViewType type, uint32_t layer,
                              uint32_t layer_count, const char *name, VkImageView *out) {
  const VkImageViewCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
      .image = image->handle,
      .viewType = type,
      .format = vulkan_format(image->format),
      .subresourceRange = {
          .aspectMask = image->aspect, .levelCount = 1, .baseArrayLayer = layer, .layerCount = layer_count}};
  const csm_result result =
      vulkan_made(device, device->vk.CreateImageView(device->handle, &info, NULL, out), out, "vkCreateImageView");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_IMAGE_VIEW, (uint64_t)*out, name);
  return result;
}

static csm_result image_handle_create(gpu_device *device, gpu_image *image, const gpu_image_info *info) {
  const vulkan_functions *vk = &device->vk;
  const VkImageCreateInfo create = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = vulkan_format(info->format),
                                    .extent = {info->width, info->height, 1},
                                    .mipLevels = 1,
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

  VkMemoryRequirements needs;
  vk->GetImageMemoryRequirements(device->handle, image->handle, &needs);
  result = vulkan_memory_allocate(device, &needs, GPU_BUFFER_DEVICE, true, info->name, &image->memory);
  if (result != CSM_SUCCESS)
    return result;
  return vulkan_check(device,
                      vk->BindImageMemory(device->handle, image->handle, image->memory.handle, image->memory.offset),
                      "vkBindImageMemory");
}

csm_result vulkan_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out) {
  *out = NULL;
  gpu_image *image = vulkan_allocate(device, sizeof *image + 2 * info->layers * sizeof *image->layers);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->format = info->format;
  image->width = info->width;
  image->height = info->height;
  image->layer_count = info->layers;
  image->sampled_layout = device->read.layout;
  image->before = image->layers + info->layers;
  image->aspect = gpu_format_is_depth(info->format) ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;

  csm_result result = image_handle_create(device, image, info);
  if (result == CSM_SUCCESS && (info->usage & GPU_IMAGE_SAMPLED))
    result = view_create(device, image, info->array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D, 0,
                         info->layers, info->name, &image->view);
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
  vulkan_release(device, image);
}

uint64_t vulkan_image_bytes(const gpu_image *image) {
  return image->memory.size;
}

void vulkan_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out) {
  *out = (gpu_native_image){.image = (uint64_t)image->handle,
                            .view = (uint64_t)image->view,
                            .sampler = (uint64_t)device->samplers[GPU_SAMPLER_COMPARE_LESS_EQUAL],
                            .sampler_reversed = (uint64_t)device->samplers[GPU_SAMPLER_COMPARE_GREATER_EQUAL]};
}

void vulkan_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor) {
  (void)device;
  (void)image;
  (void)descriptor;
}

/* ---- targets ---- */

static csm_result framebuffer_create(gpu_device *device, gpu_target *target, const char *name) {
  VkImageView views[2];
  uint32_t count = 0;
  if (target->depth)
    views[count++] = target->depth_view;
  if (target->color)
    views[count++] = target->color_view;
  const VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                        .renderPass = target->pass,
                                        .attachmentCount = count,
                                        .pAttachments = views,
                                        .width = target->width,
                                        .height = target->height,
                                        .layers = 1};
  const csm_result result =
      vulkan_made(device, device->vk.CreateFramebuffer(device->handle, &info, NULL, &target->framebuffer),
                  &target->framebuffer, "vkCreateFramebuffer");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_FRAMEBUFFER, (uint64_t)target->framebuffer, name);
  return result;
}

csm_result vulkan_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out) {
  *out = NULL;
  gpu_target *target = vulkan_allocate(device, sizeof *target);
  if (!target)
    return CSM_ERROR_OUT_OF_MEMORY;
  target->depth = info->depth;
  target->depth_layer = info->depth_layer;
  target->color = info->color;
  target->color_layer = info->color_layer;
  const gpu_image *image = info->depth ? info->depth : info->color;
  target->width = image->width;
  target->height = image->height;

  csm_result result = vulkan_pass_get(device, info->depth ? info->depth->format : GPU_FORMAT_NONE,
                                      info->color ? info->color->format : GPU_FORMAT_NONE, &target->pass);
  if (result == CSM_SUCCESS && info->depth)
    result =
        view_create(device, info->depth, VK_IMAGE_VIEW_TYPE_2D, info->depth_layer, 1, info->name, &target->depth_view);
  if (result == CSM_SUCCESS && info->color)
    result =
        view_create(device, info->color, VK_IMAGE_VIEW_TYPE_2D, info->color_layer, 1, info->name, &target->color_view);
  if (result == CSM_SUCCESS)
    result = framebuffer_create(device, target, info->name);
  if (result == CSM_SUCCESS)
    *out = target;
  else
    vulkan_target_destroy(device, target);
  return result;
}

void vulkan_target_destroy(gpu_device *device, gpu_target *target) {
  if (!target)
    return;
  device->vk.DestroyFramebuffer(device->handle, target->framebuffer, NULL);
  device->vk.DestroyImageView(device->handle, target->color_view, NULL);
  device->vk.DestroyImageView(device->handle, target->depth_view, NULL);
  vulkan_release(device, target);
}
