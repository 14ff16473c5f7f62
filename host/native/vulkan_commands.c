#include "native/vulkan_commands.h"

VkResult vulkan_commands_open(vulkan_commands *out, const vulkan_device *vulkan) {
  *out = (vulkan_commands){.vulkan = vulkan};
  const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                        .queueFamilyIndex = vulkan->family};
  VkResult result = vkCreateCommandPool(vulkan->device, &pool, NULL, &out->pool);
  if (result)
    return result;
  const VkCommandBufferAllocateInfo buffer = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = out->pool,
                                              .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                              .commandBufferCount = 1};
  result = vkAllocateCommandBuffers(vulkan->device, &buffer, &out->buffer);
  const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  if (!result)
    result = vkCreateFence(vulkan->device, &fence, NULL, &out->fence);
  return result ? result : vulkan_timestamps(vulkan, 2, &out->queries);
}

void vulkan_commands_close(vulkan_commands *c) {
  if (!c->vulkan)
    return;
  vkDestroyFence(c->vulkan->device, c->fence, NULL);
  vkDestroyQueryPool(c->vulkan->device, c->queries, NULL);
  vkDestroyCommandPool(c->vulkan->device, c->pool, NULL);
}

VkResult vulkan_commands_begin(vulkan_commands *c) {
  const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                         .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  const VkResult result = vkBeginCommandBuffer(c->buffer, &info);
  if (!result && c->queries)
    vkCmdResetQueryPool(c->buffer, c->queries, 0, 2);
  return result;
}

void vulkan_commands_stamp(vulkan_commands *c, uint32_t index) {
  vulkan_write_timestamp(c->buffer, c->queries, index);
}

VkResult vulkan_commands_finish(vulkan_commands *c) {
  const VkSubmitInfo submit = {
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &c->buffer};
  VkResult result = vkEndCommandBuffer(c->buffer);
  if (!result)
    result = vkQueueSubmit(c->vulkan->queue, 1, &submit, c->fence);
  if (!result)
    result = vkWaitForFences(c->vulkan->device, 1, &c->fence, VK_TRUE, UINT64_MAX);
  return result ? result : vkResetFences(c->vulkan->device, 1, &c->fence);
}

double vulkan_commands_ms(const vulkan_commands *c) {
  return vulkan_elapsed_ms(c->vulkan, c->queries);
}

void vulkan_transition(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, vulkan_use from,
                       vulkan_use to) {
  const VkImageMemoryBarrier barrier = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
      .srcAccessMask = from.access,
      .dstAccessMask = to.access,
      .oldLayout = from.layout,
      .newLayout = to.layout,
      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .image = image,
      .subresourceRange = {aspect, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS},
  };
  vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 0, NULL, 0, NULL, 1, &barrier);
}
