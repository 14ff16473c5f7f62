#include "native/vulkan_memory.h"
#include <stdbool.h>

static uint32_t memory_type(const vulkan_device *vulkan, uint32_t allowed, VkMemoryPropertyFlags wanted) {
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(vulkan->physical, &memory);
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
    if (allowed >> i & 1 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted)
      return i;
  return UINT32_MAX;
}

/* Of a type that has what is wanted, the device's own where there is such. */
static VkResult allocate(const vulkan_device *vulkan, const VkMemoryRequirements *needs, VkMemoryPropertyFlags wanted,
                         VkDeviceMemory *out) {
  uint32_t type = memory_type(vulkan, needs->memoryTypeBits, wanted | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  if (type == UINT32_MAX)
    type = memory_type(vulkan, needs->memoryTypeBits, wanted);
  const VkMemoryAllocateInfo info = {
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size, .memoryTypeIndex = type};
  return vkAllocateMemory(vulkan->device, &info, NULL, out);
}

VkResult vulkan_buffer_open(vulkan_buffer *out, const vulkan_device *vulkan, VkDeviceSize size,
                            VkBufferUsageFlags usage) {
  const VkMemoryPropertyFlags seen = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  const VkBufferCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size ? size : 1, .usage = usage};
  *out = (vulkan_buffer){0};
  VkResult result = vkCreateBuffer(vulkan->device, &info, NULL, &out->buffer);
  if (result)
    return result;
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(vulkan->device, out->buffer, &needs);
  result = allocate(vulkan, &needs, seen, &out->memory);
  if (!result)
    result = vkBindBufferMemory(vulkan->device, out->buffer, out->memory, 0);
  return result ? result : vkMapMemory(vulkan->device, out->memory, 0, VK_WHOLE_SIZE, 0, &out->mapped);
}

void vulkan_buffer_close(const vulkan_buffer *buffer, const vulkan_device *vulkan) {
  vkDestroyBuffer(vulkan->device, buffer->buffer, NULL);
  vkFreeMemory(vulkan->device, buffer->memory, NULL);
}

static VkResult create_view(vulkan_image *out, const vulkan_device *vulkan, const vulkan_image_info *info) {
  const bool is_depth = info->format == VK_FORMAT_D32_SFLOAT;
  const VkImageViewCreateInfo view = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
      .image = out->image,
      .viewType = info->layers ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D,
      .format = info->format,
      .subresourceRange = {is_depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0,
                           VK_REMAINING_ARRAY_LAYERS}};
  return vkCreateImageView(vulkan->device, &view, NULL, &out->view);
}

VkResult vulkan_image_open(vulkan_image *out, const vulkan_device *vulkan, const vulkan_image_info *info) {
  const VkImageCreateInfo create = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                    .imageType = VK_IMAGE_TYPE_2D,
                                    .format = info->format,
                                    .extent = {info->width, info->height, 1},
                                    .mipLevels = 1,
                                    .arrayLayers = info->layers ? info->layers : 1,
                                    .samples = VK_SAMPLE_COUNT_1_BIT,
                                    .usage = info->usage};
  *out = (vulkan_image){0};
  VkResult result = vkCreateImage(vulkan->device, &create, NULL, &out->image);
  if (result)
    return result;
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(vulkan->device, out->image, &needs);
  result = allocate(vulkan, &needs, 0, &out->memory);
  if (!result)
    result = vkBindImageMemory(vulkan->device, out->image, out->memory, 0);
  return result ? result : create_view(out, vulkan, info);
}

void vulkan_image_close(const vulkan_image *image, const vulkan_device *vulkan) {
  vkDestroyImageView(vulkan->device, image->view, NULL);
  vkDestroyImage(vulkan->device, image->image, NULL);
  vkFreeMemory(vulkan->device, image->memory, NULL);
}

VkResult vulkan_shader(const vulkan_device *vulkan, const void *code, size_t size, VkShaderModule *out) {
  const VkShaderModuleCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = size, .pCode = code};
  return vkCreateShaderModule(vulkan->device, &info, NULL, out);
}

VkResult vulkan_timestamps(const vulkan_device *vulkan, uint32_t count, VkQueryPool *out) {
  VkQueueFamilyProperties families[16];
  uint32_t family_count = sizeof families / sizeof families[0];
  vkGetPhysicalDeviceQueueFamilyProperties(vulkan->physical, &family_count, families);
  *out = VK_NULL_HANDLE;
  if (!families[vulkan->family].timestampValidBits)
    return VK_SUCCESS;
  const VkQueryPoolCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO, .queryType = VK_QUERY_TYPE_TIMESTAMP, .queryCount = count};
  return vkCreateQueryPool(vulkan->device, &info, NULL, out);
}

void vulkan_write_timestamp(VkCommandBuffer commands, VkQueryPool pool, uint32_t index) {
  const VkMemoryBarrier all = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  if (!pool)
    return;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &all, 0,
                       NULL, 0, NULL);
  vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, pool, index);
}

double vulkan_elapsed_ms(const vulkan_device *vulkan, VkQueryPool pool) {
  uint64_t ticks[2];
  if (!pool || vkGetQueryPoolResults(vulkan->device, pool, 0, 2, sizeof ticks, ticks, sizeof ticks[0],
                                     VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT))
    return -1.0;
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(vulkan->physical, &properties);
  return (double)(ticks[1] - ticks[0]) * properties.limits.timestampPeriod * 1e-6;
}

const char *vulkan_reason(VkResult result) {
  switch (result) {
  case VK_ERROR_INCOMPATIBLE_DRIVER:
    return "no Vulkan driver is installed";
  case VK_ERROR_INITIALIZATION_FAILED:
    return "there is no Vulkan device that fits";
  case VK_ERROR_OUT_OF_HOST_MEMORY:
  case VK_ERROR_OUT_OF_DEVICE_MEMORY:
    return "out of memory";
  default:
    return "the driver refused";
  }
}
