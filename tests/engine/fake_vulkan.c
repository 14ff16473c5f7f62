/* fake_vulkan.c: a Vulkan library whose every function is the program's (rig_vulkan_faults.h). */
#include <vulkan/vulkan_core.h>

PFN_vkVoidFunction VKAPI_CALL faults_get_instance_proc_addr(VkInstance instance, const char *name);

__attribute__((visibility("default"))) VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL
vkGetInstanceProcAddr(VkInstance instance, const char *name) {
  return faults_get_instance_proc_addr(instance, name);
}
