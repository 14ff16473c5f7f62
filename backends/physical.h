/*
 * physical.h: what a Vulkan physical device is in gpu.h's words. The Vulkan backend asks it, and Direct3D 12's run time
 * that stands on Vulkan. Both call Vulkan themselves, and give what it told.
 */
#ifndef PHYSICAL_H
#define PHYSICAL_H

#include "gpu.h"

#include <vulkan/vulkan_core.h>

gpu_device_type physical_type(VkPhysicalDeviceType type);

/* What a device lacks that csm cannot do without; NULL if nothing. `depth` is of D32_SFLOAT. */
const char *physical_lacks(const VkPhysicalDeviceProperties *properties, const VkPhysicalDeviceFeatures *features,
                           const VkFormatProperties *depth);

/* How csm uses depth images. */
extern const VkImageUsageFlags physical_depth_usage;

/* Limits of a device, of its D32_SFLOAT images in that usage, and of its memory. */
typedef struct physical_limits {
  const VkPhysicalDeviceLimits *device;
  const VkImageFormatProperties *depth;
  const VkPhysicalDeviceMemoryProperties *memory;
  uint64_t max_allocation;
} physical_limits;

/* Fills in the largest images, buffers and memory. */
void physical_sizes(const physical_limits *limits, gpu_device_info *out);

/* The heap that images live in: that of the first type of the device's own memory, which allocations try first. */
uint32_t physical_image_heap(const VkPhysicalDeviceMemoryProperties *memory);

/* Passes on what the validation layer says, in one line. */
void physical_log(const gpu_host *host, VkDebugUtilsMessageSeverityFlagBitsEXT severity, const char *message);

#endif
