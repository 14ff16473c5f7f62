/* record.c: what a recording holds outside passes: markers, timestamps, copies, clears, dispatches. */
#include "internal.h"

/* ---- markers and timestamps ---- */

void vulkan_marker_begin(gpu_device *device, const char *name) {
  if (!device->debug)
    return;
  const VkDebugUtilsLabelEXT label = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = name};
  device->vk.CmdBeginDebugUtilsLabelEXT(device->commands, &label);
}

void vulkan_marker_end(gpu_device *device) {
  if (device->debug)
    device->vk.CmdEndDebugUtilsLabelEXT(device->commands);
}

/* Outside passes. What follows starts after what went before, so the time between two belongs to what is between. */
void vulkan_timestamp(gpu_device *device, uint32_t index) {
  if (!device->slot->queries)
    return;
  vulkan_memory_barrier(device, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0);
  device->vk.CmdWriteTimestamp(device->commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, device->slot->queries, index);
}

/* ---- copies ---- */

void vulkan_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                        uint64_t size) {
  vulkan_copy_range(device, from, from_offset, size);
  vulkan_copy_range(device, to, to_offset, size);
  if (to->kind == GPU_BUFFER_READBACK)
    device->readback_written = true;
  if (to->kind == GPU_BUFFER_DEVICE || from->kind == GPU_BUFFER_DEVICE)
    vulkan_use_buffers(device, VULKAN_COPIES, to->kind == GPU_BUFFER_DEVICE);
  const VkBufferCopy region = {.srcOffset = from_offset, .dstOffset = to_offset, .size = size};
  device->vk.CmdCopyBuffer(device->commands, from->handle, to->handle, 1, &region);
}

static VkBufferImageCopy image_copy(const gpu_image *image, const gpu_region *region, uint64_t offset,
                                    uint32_t row_bytes) {
  return (VkBufferImageCopy){.bufferOffset = offset,
                             .bufferRowLength = row_bytes / gpu_format_bytes(image->format),
                             .imageSubresource = {.aspectMask = image->aspect,
                                                  .mipLevel = region->level,
                                                  .baseArrayLayer = region->layer,
                                                  .layerCount = 1},
                             .imageOffset = {(int32_t)region->x, (int32_t)region->y, 0},
                             .imageExtent = {region->width, region->height, 1}};
}

void vulkan_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                       const gpu_region *from) {
  const gpu_range range = {from->layer, 1, from->level, 1};
  const VkBufferImageCopy region = image_copy(image, from, offset, row_bytes);
  vulkan_copy_range(device, to, offset, (uint64_t)row_bytes * from->height);
  device->readback_written = true;
  vulkan_image_use(device, image, &range, &vulkan_use_copy, false);
  device->vk.CmdCopyImageToBuffer(device->commands, image->handle, vulkan_use_copy.layout, to->handle, 1, &region);
}

void vulkan_copy_to_image(gpu_device *device, gpu_image *image, const gpu_region *to, gpu_buffer *from, uint64_t offset,
                          uint32_t row_bytes) {
  const gpu_range range = {to->layer, 1, to->level, 1};
  const VkBufferImageCopy region = image_copy(image, to, offset, row_bytes);
  const bool whole =
      to->width == gpu_level_size(image->width, to->level) && to->height == gpu_level_size(image->height, to->level);
  vulkan_copy_range(device, from, offset, (uint64_t)row_bytes * to->height);
  vulkan_image_use(device, image, &range, &vulkan_use_overwrite, whole);
  device->vk.CmdCopyBufferToImage(device->commands, from->handle, image->handle, vulkan_use_overwrite.layout, 1,
                                  &region);
}

/* ---- images ---- */

void vulkan_clear_depth(gpu_device *device, gpu_image *image, float depth) {
  const gpu_range all = vulkan_range(image, NULL);
  vulkan_image_use(device, image, &all, &vulkan_use_overwrite, true);
  const VkClearDepthStencilValue value = {.depth = depth};
  const VkImageSubresourceRange range = vulkan_subresources(image, &all);
  device->vk.CmdClearDepthStencilImage(device->commands, image->handle, vulkan_use_overwrite.layout, &value, 1, &range);
  /* One barrier for all layers; else each layer's pass would begin with one, and wait for the pass before it. */
  vulkan_image_prepare(device, image, &all, &vulkan_use_depth, false);
}

void vulkan_make_readable(gpu_device *device, gpu_image *image, const gpu_range *range) {
  const gpu_range wanted = vulkan_range(image, range);
  if (!image->borrowed)
    vulkan_image_use(device, image, &wanted, &device->read, false);
}

/* ---- dispatches ---- */

static void use_bindings(gpu_device *device, gpu_bindings *bindings) {
  for (uint32_t i = 0; i < bindings->texture_count; i++)
    if (!bindings->textures[i].image->borrowed)
      vulkan_image_use(device, bindings->textures[i].image, &bindings->textures[i].range, &device->read, false);
  for (uint32_t i = 0; i < bindings->store_image_count; i++)
    vulkan_image_use(device, bindings->store_images[i].image, &bindings->store_images[i].range,
                     &vulkan_use_dispatch_store, false);
}

void vulkan_dispatch(gpu_device *device, const gpu_dispatch_info *info) {
  const vulkan_functions *vk = &device->vk;
  gpu_bindings *bindings = info->bindings;
  if (bindings)
    use_bindings(device, bindings);
  if (info->arguments || (bindings && bindings->buffers))
    vulkan_use_buffers(device, VULKAN_DISPATCHES, bindings && bindings->store_buffer_count);
  vk->CmdBindPipeline(device->commands, VK_PIPELINE_BIND_POINT_COMPUTE, info->program->pipeline);
  if (bindings && bindings->set)
    vk->CmdBindDescriptorSets(device->commands, VK_PIPELINE_BIND_POINT_COMPUTE, bindings->layout, 0, 1, &bindings->set,
                              bindings->constants_count, info->offsets);
  if (info->arguments)
    vk->CmdDispatchIndirect(device->commands, info->arguments->handle, info->arguments_offset);
  else
    vk->CmdDispatch(device->commands, info->groups[0], info->groups[1], info->groups[2]);
}
