/* native/vulkan_memory.h: memory, buffers and shader modules on the host's own Vulkan device. */
#ifndef HOST_VULKAN_MEMORY_H
#define HOST_VULKAN_MEMORY_H

#include "native/vulkan_device.h"
#include <stddef.h>

/* In memory that the host sees. */
typedef struct vulkan_buffer {
  VkBuffer buffer;
  VkDeviceMemory memory;
  void *mapped;
} vulkan_buffer;

/* vulkan_buffer_close is allowed after an error, too, and of a buffer that is all zeros. */
VkResult vulkan_buffer_open(vulkan_buffer *out, const vulkan_device *vulkan, VkDeviceSize size,
                            VkBufferUsageFlags usage);
void vulkan_buffer_close(const vulkan_buffer *buffer, const vulkan_device *vulkan);

/* On the device. */
typedef struct vulkan_image {
  VkImage image;
  VkDeviceMemory memory;
  VkImageView view; /* of all of it */
} vulkan_image;

typedef struct vulkan_image_info {
  VkFormat format; /* D32, or a colour */
  uint32_t width, height;
  uint32_t layers; /* 0: it is no array */
  VkImageUsageFlags usage;
} vulkan_image_info;

/* As for buffers. */
VkResult vulkan_image_open(vulkan_image *out, const vulkan_device *vulkan, const vulkan_image_info *info);
void vulkan_image_close(const vulkan_image *image, const vulkan_device *vulkan);

VkResult vulkan_shader(const vulkan_device *vulkan, const void *code, size_t size, VkShaderModule *out);

/* A pool of timestamps, or VK_NULL_HANDLE where the queue has none. */
VkResult vulkan_timestamps(const vulkan_device *vulkan, uint32_t count, VkQueryPool *out);
/* Writes one when all before it is done, and before anything after it begins. Outside passes. */
void vulkan_write_timestamp(VkCommandBuffer commands, VkQueryPool pool, uint32_t index);
/* Milliseconds from timestamp 0 to 1, of work that was waited for; negative where there are none. */
double vulkan_elapsed_ms(const vulkan_device *vulkan, VkQueryPool pool);

/* What a VkResult means to who opened a device. */
const char *vulkan_reason(VkResult result);

#endif
