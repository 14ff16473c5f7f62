/* rig_vulkan.h: what a rig on Vulkan is made of, for the tests of what that API alone has. */
#ifndef RIG_VULKAN_H
#define RIG_VULKAN_H

#include "rig.h"

#include <vulkan/vulkan.h>

struct rig {
  VkInstance instance;
  VkPhysicalDevice physical;
  VkDevice device;
  VkQueue queue;
  uint32_t family;
  VkPhysicalDeviceMemoryProperties memory;
  VkPhysicalDeviceFeatures features; /* enabled */
  csm_vulkan_device native;          /* what csm gets */

  VkDebugReportCallbackEXT reporter;
  uint32_t messages; /* errors and warnings of validation, with its synchronization checks */

  /* frames, by number modulo RIG_FRAMES */
  struct {
    VkCommandPool pool;
    VkCommandBuffer commands[RIG_LISTS];
    uint32_t count;
    VkFence fence;
  } frames[RIG_FRAMES];
  uint64_t frame, done;

  rig_lent lent;
  VkPipelineCache cache;
};

/* Opens a device on which depthClamp is off: csm cannot use it. */
rig *rig_vulkan_open_clipping(void);
void rig_vulkan_must(VkResult result, const char *what);
/* Lends the rig's memory and pipeline cache to csm, and says that dynamic rendering is on. */
void rig_vulkan_lend(rig *rig);
/* Pipelines that modern engines' devices made with their cache, and without. */
void rig_vulkan_pipelines(uint32_t *with_cache, uint32_t *without);
/* A memory type that has the flags; UINT32_MAX: none. */
uint32_t rig_vulkan_memory_type(const rig *rig, uint32_t allowed, VkMemoryPropertyFlags flags);
VkDeviceMemory rig_vulkan_allocate(const rig *rig, const VkMemoryRequirements *needs, VkMemoryPropertyFlags flags);

#endif
