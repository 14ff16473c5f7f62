/*
 * vulkan_base.h: what every Vulkan engine has below its renderer: a device, buffers, images and pipelines. Every
 * failure ends the program.
 */
#ifndef EXAMPLE_VULKAN_BASE_H
#define EXAMPLE_VULKAN_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <vulkan/vulkan.h>

typedef struct vulkan_base {
  VkInstance instance;
  VkDebugUtilsMessengerEXT messenger; /* while validating */
  uint32_t messages;                  /* warnings and errors of the validation layer */
  VkPhysicalDevice physical_device;
  VkPhysicalDeviceProperties properties;
  VkPhysicalDeviceMemoryProperties memory;
  VkPhysicalDeviceFeatures features; /* that are enabled */
  VkDevice device;
  uint32_t queue_family;
  VkQueue queue;
} vulkan_base;

typedef struct vulkan_buffer {
  VkBuffer buffer;
  VkDeviceMemory memory;
  void *mapped;
} vulkan_buffer;

typedef struct vulkan_image {
  VkImage image;
  VkDeviceMemory memory;
  VkImageView view;
} vulkan_image;

typedef struct vulkan_pipeline_info {
  VkPipelineLayout layout;
  VkRenderPass render_pass;
  const uint32_t *vertex_code, *fragment_code; /* fragment_code may be NULL: depth alone */
  size_t vertex_size, fragment_size;           /* bytes */
  VkPipelineVertexInputStateCreateInfo input;
  VkCullModeFlags cull;
  VkCompareOp depth_compare;
  bool depth_clamp;
} vulkan_pipeline_info;

/* Ends the program, naming what failed. */
void vulkan_check(VkResult result, const char *what);

/* Opens a device with one graphics queue; `validate` turns the Khronos layer on, core and synchronization. */
void vulkan_open(vulkan_base *out, bool validate);
void vulkan_close(vulkan_base *base);

/* In memory that the CPU writes: a larger engine would stage what stays. */
vulkan_buffer vulkan_buffer_create(const vulkan_base *base, VkDeviceSize size, VkBufferUsageFlags usage);
void vulkan_buffer_destroy(const vulkan_base *base, vulkan_buffer *buffer);

vulkan_image vulkan_image_create(const vulkan_base *base, VkFormat format, uint32_t width, uint32_t height,
                                 VkImageUsageFlags usage, VkImageAspectFlags aspect);
void vulkan_image_destroy(const vulkan_base *base, vulkan_image *image);

/* Viewport and scissor are dynamic; triangles face the viewer counter-clockwise, seen with clip y up. */
VkPipeline vulkan_pipeline_create(const vulkan_base *base, const vulkan_pipeline_info *info);

#endif
