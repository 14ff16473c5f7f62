/* native/vulkan_device.h: a Vulkan device as an engine has one, for the bare loops, and to lend to csm. */
#ifndef HOST_VULKAN_DEVICE_H
#define HOST_VULKAN_DEVICE_H

#include "csm/csm_vulkan.h"
#include <vulkan/vulkan.h>

typedef struct vulkan_device {
  VkInstance instance;
  VkPhysicalDevice physical;
  VkDevice device;
  VkPhysicalDeviceFeatures features; /* that are enabled */
  uint32_t family;                   /* of graphics */
  VkQueue queue;
  PFN_vkCmdBeginRendering begin_rendering; /* NULL without dynamic rendering */
  PFN_vkCmdEndRendering end_rendering;
} vulkan_device;

/*
 * Opens a device with Vulkan 1.1 and the features that csm makes use of, nothing else: one whose name holds `name`, or,
 * if that is NULL, the first discrete, integrated, virtual, CPU one. vulkan_device_close is allowed after an error, too.
 */
VkResult vulkan_device_open(vulkan_device *out, const char *name);
/* The same with dynamic rendering where the device has it, as csm's own has. */
VkResult vulkan_device_open_rendering(vulkan_device *out, const char *name);
void vulkan_device_close(vulkan_device *device);

/* The device as csm_create takes an engine's. It refers to `device`, which must stay as long as it is used. */
csm_vulkan_device vulkan_device_lend(const vulkan_device *device);

#endif
