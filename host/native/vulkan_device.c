#include "native/vulkan_device.h"
#include <stdbool.h>
#include <string.h>

static VkResult open_instance(vulkan_device *out) {
  const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_1};
  const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &application};
  return vkCreateInstance(&info, NULL, &out->instance);
}

/* The same order as csm's own: discrete, integrated, virtual, CPU. */
static int rank_device(const VkPhysicalDeviceProperties *properties, const char *name) {
  if (name)
    return strstr(properties->deviceName, name) ? 4 : -1;
  switch (properties->deviceType) {
  case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
    return 3;
  case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
    return 2;
  case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
    return 1;
  default:
    return 0;
  }
}

static VkResult choose_device(vulkan_device *out, const char *name) {
  VkPhysicalDevice devices[16];
  uint32_t count = sizeof devices / sizeof devices[0];
  int best = -1;
  const VkResult result = vkEnumeratePhysicalDevices(out->instance, &count, devices);
  if (result < 0)
    return result;
  for (uint32_t i = 0; i < count; ++i) {
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(devices[i], &properties);
    const int rank = rank_device(&properties, name);
    if (rank > best) {
      best = rank;
      out->physical = devices[i];
    }
  }
  return best < 0 ? VK_ERROR_INITIALIZATION_FAILED : VK_SUCCESS;
}

static const char *const rendering_extensions[] = {VK_KHR_DYNAMIC_RENDERING_EXTENSION_NAME,
                                                   VK_KHR_DEPTH_STENCIL_RESOLVE_EXTENSION_NAME,
                                                   VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME};
enum { RENDERING_EXTENSIONS = sizeof rendering_extensions / sizeof *rendering_extensions };

/* What has the first of the extensions has the feature, and the extensions that it needs. */
static bool has_rendering(const vulkan_device *out) {
  VkExtensionProperties extensions[512];
  uint32_t count = sizeof extensions / sizeof *extensions;
  if (vkEnumerateDeviceExtensionProperties(out->physical, NULL, &count, extensions) < 0)
    return false;
  for (uint32_t i = 0; i < count; ++i)
    if (strcmp(extensions[i].extensionName, rendering_extensions[0]) == 0)
      return true;
  return false;
}

/* What csm needs, and what it makes use of where a device has it: docs/embedding.md. */
static void choose_features(vulkan_device *out) {
  VkPhysicalDeviceFeatures all;
  vkGetPhysicalDeviceFeatures(out->physical, &all);
  out->features =
      (VkPhysicalDeviceFeatures){.depthClamp = VK_TRUE,
                                 .depthBiasClamp = all.depthBiasClamp,
                                 .samplerAnisotropy = all.samplerAnisotropy,
                                 .fragmentStoresAndAtomics = all.fragmentStoresAndAtomics,
                                 .shaderStorageImageExtendedFormats = all.shaderStorageImageExtendedFormats};
}

static VkResult open_device(vulkan_device *out, bool rendering) {
  VkQueueFamilyProperties families[16];
  uint32_t count = sizeof families / sizeof families[0];
  vkGetPhysicalDeviceQueueFamilyProperties(out->physical, &count, families);
  while (out->family + 1 < count && !(families[out->family].queueFlags & VK_QUEUE_GRAPHICS_BIT))
    ++out->family;
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                         .queueFamilyIndex = out->family,
                                         .queueCount = 1,
                                         .pQueuePriorities = &priority};
  choose_features(out);
  const VkPhysicalDeviceDynamicRenderingFeatures feature = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES, .dynamicRendering = VK_TRUE};
  const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                   .pNext = rendering ? &feature : NULL,
                                   .queueCreateInfoCount = 1,
                                   .pQueueCreateInfos = &queue,
                                   .enabledExtensionCount = rendering ? RENDERING_EXTENSIONS : 0,
                                   .ppEnabledExtensionNames = rendering_extensions,
                                   .pEnabledFeatures = &out->features};
  const VkResult result = vkCreateDevice(out->physical, &info, NULL, &out->device);
  if (result)
    return result;
  vkGetDeviceQueue(out->device, out->family, 0, &out->queue);
  if (rendering) {
    out->begin_rendering = (PFN_vkCmdBeginRendering)vkGetDeviceProcAddr(out->device, "vkCmdBeginRenderingKHR");
    out->end_rendering = (PFN_vkCmdEndRendering)vkGetDeviceProcAddr(out->device, "vkCmdEndRenderingKHR");
  }
  return VK_SUCCESS;
}

static VkResult open_chosen(vulkan_device *out, const char *name) {
  *out = (vulkan_device){0};
  const VkResult result = open_instance(out);
  return result ? result : choose_device(out, name);
}

VkResult vulkan_device_open(vulkan_device *out, const char *name) {
  const VkResult result = open_chosen(out, name);
  return result ? result : open_device(out, false);
}

VkResult vulkan_device_open_rendering(vulkan_device *out, const char *name) {
  const VkResult result = open_chosen(out, name);
  return result ? result : open_device(out, has_rendering(out));
}

void vulkan_device_close(vulkan_device *device) {
  if (device->device)
    vkDestroyDevice(device->device, NULL);
  if (device->instance)
    vkDestroyInstance(device->instance, NULL);
}

csm_vulkan_device vulkan_device_lend(const vulkan_device *device) {
  return (csm_vulkan_device){.struct_size = sizeof(csm_vulkan_device),
                             .api_version = VK_API_VERSION_1_1,
                             .instance = device->instance,
                             .physical_device = device->physical,
                             .device = device->device,
                             .queue_family = device->family,
                             .get_instance_proc_addr = vkGetInstanceProcAddr,
                             .features = &device->features};
}
