#include "bench/vulkan_memory.h"

static uint32_t memory_type(const vulkan_device *vulkan, uint32_t allowed, VkMemoryPropertyFlags wanted) {
  VkPhysicalDeviceMemoryProperties memory;
  vkGetPhysicalDeviceMemoryProperties(vulkan->physical, &memory);
  for (uint32_t i = 0; i < memory.memoryTypeCount; ++i)
    if (allowed >> i & 1 && (memory.memoryTypes[i].propertyFlags & wanted) == wanted)
      return i;
  return UINT32_MAX;
}

VkResult vulkan_allocate(const vulkan_device *vulkan, const VkMemoryRequirements *needs, VkMemoryPropertyFlags wanted,
                         VkDeviceMemory *out) {
  uint32_t type = memory_type(vulkan, needs->memoryTypeBits, wanted | VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  if (type == UINT32_MAX)
    type = memory_type(vulkan, needs->memoryTypeBits, wanted);
  const VkMemoryAllocateInfo info = {
      .sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs->size, .memoryTypeIndex = type};
  return vkAllocateMemory(vulkan->device, &info, NULL, out);
}

VkResult vulkan_buffer(const vulkan_device *vulkan, VkDeviceSize size, VkBufferUsageFlags usage, VkBuffer *buffer,
                       VkDeviceMemory *memory, void **mapped) {
  const VkBufferCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size ? size : 1, .usage = usage};
  VkResult result = vkCreateBuffer(vulkan->device, &info, NULL, buffer);
  if (result)
    return result;
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(vulkan->device, *buffer, &needs);
  result = vulkan_allocate(vulkan, &needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                           memory);
  if (!result)
    result = vkBindBufferMemory(vulkan->device, *buffer, *memory, 0);
  if (!result)
    result = vkMapMemory(vulkan->device, *memory, 0, VK_WHOLE_SIZE, 0, mapped);
  return result;
}

VkResult vulkan_image(const vulkan_device *vulkan, const VkImageCreateInfo *info, VkImage *image,
                      VkDeviceMemory *memory) {
  VkResult result = vkCreateImage(vulkan->device, info, NULL, image);
  if (result)
    return result;
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(vulkan->device, *image, &needs);
  result = vulkan_allocate(vulkan, &needs, 0, memory);
  return result ? result : vkBindImageMemory(vulkan->device, *image, *memory, 0);
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
