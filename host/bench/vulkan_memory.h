/* bench/vulkan_memory.h: memory, buffers and shader modules on the host's own Vulkan device. */
#ifndef HOST_VULKAN_MEMORY_H
#define HOST_VULKAN_MEMORY_H

#include "bench/vulkan_device.h"
#include <stddef.h>

/* Takes memory of a type that has what is wanted, the device's own where there is such. */
VkResult vulkan_allocate(const vulkan_device *vulkan, const VkMemoryRequirements *needs, VkMemoryPropertyFlags wanted,
                         VkDeviceMemory *out);

/* A buffer in memory that the host sees, mapped. */
VkResult vulkan_buffer(const vulkan_device *vulkan, VkDeviceSize size, VkBufferUsageFlags usage, VkBuffer *buffer,
                       VkDeviceMemory *memory, void **mapped);

/* An image with memory of its own. */
VkResult vulkan_image(const vulkan_device *vulkan, const VkImageCreateInfo *info, VkImage *image,
                      VkDeviceMemory *memory);

VkResult vulkan_shader(const vulkan_device *vulkan, const void *code, size_t size, VkShaderModule *out);

/* A pool of timestamps, or VK_NULL_HANDLE where the queue has none. */
VkResult vulkan_timestamps(const vulkan_device *vulkan, uint32_t count, VkQueryPool *out);
/* Writes one once all before it is done, and before anything after it begins. Outside passes. */
void vulkan_write_timestamp(VkCommandBuffer commands, VkQueryPool pool, uint32_t index);
/* Milliseconds from timestamp 0 to 1, of work that was waited for; negative where there are none. */
double vulkan_elapsed_ms(const vulkan_device *vulkan, VkQueryPool pool);

/* What a VkResult means to who opened a device. */
const char *vulkan_reason(VkResult result);

#endif
