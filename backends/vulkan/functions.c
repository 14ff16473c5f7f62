#include "functions.h"

#define LOAD(name)                                                                                                     \
  vk->name = (PFN_vk##name)vk->GetInstanceProcAddr(instance, "vk" #name);                                              \
  complete &= vk->name != NULL;

#define LOAD_DEVICE(name)                                                                                              \
  vk->name = (PFN_vk##name)vk->GetDeviceProcAddr(device, "vk" #name);                                                  \
  complete &= vk->name != NULL;

bool vulkan_load_loader(vulkan_functions *vk) {
  const VkInstance instance = VK_NULL_HANDLE;
  bool complete = true;
  VULKAN_LOADER_FUNCTIONS(LOAD)
  return complete;
}

bool vulkan_load_instance(vulkan_functions *vk, VkInstance instance, bool own) {
  bool complete = true;
  VULKAN_INSTANCE_FUNCTIONS(LOAD)
  if (own) {
    VULKAN_OWN_INSTANCE_FUNCTIONS(LOAD)
  }
  return complete;
}

bool vulkan_load_debug(vulkan_functions *vk, VkInstance instance, bool own) {
  bool complete = true;
  VULKAN_DEBUG_FUNCTIONS(LOAD)
  if (own) {
    VULKAN_MESSENGER_FUNCTIONS(LOAD)
  }
  return complete;
}

bool vulkan_load_rendering(vulkan_functions *vk, VkDevice device) {
  vk->CmdBeginRendering = (PFN_vkCmdBeginRendering)vk->GetDeviceProcAddr(device, "vkCmdBeginRenderingKHR");
  vk->CmdEndRendering = (PFN_vkCmdEndRendering)vk->GetDeviceProcAddr(device, "vkCmdEndRenderingKHR");
  if (!vk->CmdBeginRendering || !vk->CmdEndRendering) {
    vk->CmdBeginRendering = (PFN_vkCmdBeginRendering)vk->GetDeviceProcAddr(device, "vkCmdBeginRendering");
    vk->CmdEndRendering = (PFN_vkCmdEndRendering)vk->GetDeviceProcAddr(device, "vkCmdEndRendering");
  }
  return vk->CmdBeginRendering && vk->CmdEndRendering;
}

bool vulkan_load_device(vulkan_functions *vk, VkDevice device, bool own) {
  bool complete = true;
  VULKAN_DEVICE_FUNCTIONS(LOAD_DEVICE)
  if (own) {
    VULKAN_OWN_DEVICE_FUNCTIONS(LOAD_DEVICE)
  }
  return complete;
}
