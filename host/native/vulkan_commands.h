/* native/vulkan_commands.h: commands that are recorded, submitted and waited for, and timed on the GPU. */
#ifndef HOST_VULKAN_COMMANDS_H
#define HOST_VULKAN_COMMANDS_H

#include "native/vulkan_memory.h"

typedef struct vulkan_commands {
  const vulkan_device *vulkan;
  VkCommandPool pool;
  VkCommandBuffer buffer;
  VkFence fence;
  VkQueryPool queries; /* the stamps */
} vulkan_commands;

/* `vulkan` must outlive it. vulkan_commands_close is allowed after an error, too. */
VkResult vulkan_commands_open(vulkan_commands *out, const vulkan_device *vulkan);
void vulkan_commands_close(vulkan_commands *c);

VkResult vulkan_commands_begin(vulkan_commands *c);
/* Where what is timed begins (0), and ends (1). Outside passes. */
void vulkan_commands_stamp(vulkan_commands *c, uint32_t index);
/* Submits, and waits. */
VkResult vulkan_commands_finish(vulkan_commands *c);
/* Milliseconds on the GPU from stamp to stamp; negative where the queue has no timestamps. */
double vulkan_commands_ms(const vulkan_commands *c);

/* How an image was used, or will be. */
typedef struct vulkan_use {
  VkImageLayout layout;
  VkPipelineStageFlags stages;
  VkAccessFlags access;
} vulkan_use;

/* Of all layers. */
void vulkan_transition(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, vulkan_use from,
                       vulkan_use to);

#endif
