/* csm_vulkan.h: an engine's own Vulkan device. The next version takes it; this one answers CSM_ERROR_UNSUPPORTED. */
#ifndef CSM_VULKAN_H
#define CSM_VULKAN_H

#include "csm_base.h"
#include <vulkan/vulkan_core.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct csm_vulkan_device {
  uint32_t struct_size;
  uint32_t api_version; /* what the instance and the device were made for: VK_API_VERSION_1_1 or later */
  VkInstance instance;
  VkPhysicalDevice physical_device;
  VkDevice device;
  uint32_t queue_family; /* of the command buffers that csm records into: graphics */
  uint32_t reserved;     /* 0 */
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  const char *const *extensions; /* device extensions that are enabled */
  uint32_t extension_count;
  uint32_t reserved2;                       /* 0 */
  const VkPhysicalDeviceFeatures *features; /* features that are enabled; NULL means none */
} csm_vulkan_device;

#ifdef __cplusplus
}
#endif
#endif
