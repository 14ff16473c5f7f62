/* own.c: the handles of an own device: the Vulkan library, an instance, a physical device, a device. */
#include "internal.h"

#include "../choose.h"
#include "../physical.h"

#include <dlfcn.h>
#include <string.h>

#define VALIDATION_LAYER "VK_LAYER_KHRONOS_validation"

static csm_result open_library(gpu_device *device) {
  device->library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!device->library)
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "no Vulkan: %s", dlerror());
  void *symbol = dlsym(device->library, "vkGetInstanceProcAddr");
  memcpy(&device->vk.GetInstanceProcAddr, &symbol, sizeof symbol);
  uint32_t version = 0;
  if (!symbol || !vulkan_load_loader(&device->vk) || device->vk.EnumerateInstanceVersion(&version) != VK_SUCCESS ||
      version < VK_API_VERSION_1_1)
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "the Vulkan library is older than Vulkan 1.1");
  return CSM_SUCCESS;
}

/* ---- the instance ---- */

static bool has_extension(const VkExtensionProperties *extensions, uint32_t count, const char *name) {
  for (uint32_t i = 0; i < count; i++)
    if (strcmp(extensions[i].extensionName, name) == 0)
      return true;
  return false;
}

static csm_result find_instance_extension(gpu_device *device, const char *layer, const char *name, bool *found) {
  *found = false;
  uint32_t count = 0;
  VkResult result = device->vk.EnumerateInstanceExtensionProperties(layer, &count, NULL);
  if (result != VK_SUCCESS || count == 0)
    return vulkan_check(device, result, "vkEnumerateInstanceExtensionProperties");
  VkExtensionProperties *extensions = lent_allocate(&device->lent, count * sizeof *extensions);
  if (!extensions)
    return CSM_ERROR_OUT_OF_MEMORY;
  result = device->vk.EnumerateInstanceExtensionProperties(layer, &count, extensions);
  if (result >= 0)
    *found = has_extension(extensions, count, name);
  lent_release(&device->lent, extensions);
  return vulkan_check(device, result, "vkEnumerateInstanceExtensionProperties");
}

static csm_result find_validation_layer(gpu_device *device, bool *found) {
  *found = false;
  uint32_t count = 0;
  VkResult result = device->vk.EnumerateInstanceLayerProperties(&count, NULL);
  if (result != VK_SUCCESS || count == 0)
    return vulkan_check(device, result, "vkEnumerateInstanceLayerProperties");
  VkLayerProperties *layers = lent_allocate(&device->lent, count * sizeof *layers);
  if (!layers)
    return CSM_ERROR_OUT_OF_MEMORY;
  result = device->vk.EnumerateInstanceLayerProperties(&count, layers);
  for (uint32_t i = 0; result >= 0 && i < count; i++)
    if (strcmp(layers[i].layerName, VALIDATION_LAYER) == 0)
      *found = true;
  lent_release(&device->lent, layers);
  return vulkan_check(device, result, "vkEnumerateInstanceLayerProperties");
}

static VKAPI_ATTR VkBool32 VKAPI_CALL log_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                  VkDebugUtilsMessageTypeFlagsEXT types,
                                                  const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
  (void)types;
  const gpu_device *device = user;
  physical_log(&device->lent.host, severity, data->pMessage);
  return VK_FALSE;
}

/* What the instance turns on: the layer, its extension that validates synchronization, and VK_EXT_debug_utils. */
typedef struct debugging {
  bool layer, features, utils;
} debugging;

static csm_result find_validation(gpu_device *device, debugging *out) {
  csm_result result = find_validation_layer(device, &out->layer);
  if (result == CSM_SUCCESS && out->layer)
    result =
        find_instance_extension(device, VALIDATION_LAYER, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME, &out->features);
  if (result == CSM_SUCCESS && !out->features)
    device->lent.host.log(device->lent.host.user, CSM_LOG_WARNING,
                          out->layer ? VALIDATION_LAYER " is too old to validate synchronization"
                                     : VALIDATION_LAYER " is not installed: nothing is validated");
  return result;
}

static VkDebugUtilsMessengerCreateInfoEXT messenger_of(gpu_device *device) {
  return (VkDebugUtilsMessengerCreateInfoEXT){.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
                                              .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                                                                 VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
                                              .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
                                              .pfnUserCallback = log_message,
                                              .pUserData = device};
}

static csm_result instance_create(gpu_device *device, const debugging *on) {
  const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  const VkValidationFeaturesEXT features = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                            .enabledValidationFeatureCount = 1,
                                            .pEnabledValidationFeatures = enabled};
  VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_of(device);
  messenger.pNext = on->features ? &features : NULL;
  const char *layers[] = {VALIDATION_LAYER};
  const char *extensions[2];
  uint32_t extension_count = 0;
  if (on->utils)
    extensions[extension_count++] = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  if (on->features)
    extensions[extension_count++] = VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME;
  const VkApplicationInfo application = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO,
                                         .pApplicationName = "csm",
                                         .applicationVersion = CSM_VERSION,
                                         .apiVersion = VK_API_VERSION_1_1};
  const VkInstanceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                     .pNext = on->layer && on->utils ? &messenger : NULL,
                                     .pApplicationInfo = &application,
                                     .enabledLayerCount = on->layer,
                                     .ppEnabledLayerNames = layers,
                                     .enabledExtensionCount = extension_count,
                                     .ppEnabledExtensionNames = extensions};
  const VkResult created = device->vk.CreateInstance(&info, NULL, &device->instance);
  if (created != VK_SUCCESS)
    device->instance = VK_NULL_HANDLE; /* it is undefined then */
  if (created == VK_ERROR_INCOMPATIBLE_DRIVER)
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "no Vulkan driver is installed");
  return vulkan_check(device, created, "vkCreateInstance");
}

static csm_result create_instance(gpu_device *device, const gpu_open_info *info) {
  debugging on = {0};
  csm_result result = CSM_SUCCESS;
  if (info->validate || info->names)
    result = find_instance_extension(device, NULL, VK_EXT_DEBUG_UTILS_EXTENSION_NAME, &on.utils);
  if (result == CSM_SUCCESS && info->validate)
    result = find_validation(device, &on);
  if (result == CSM_SUCCESS)
    result = instance_create(device, &on);
  if (result != CSM_SUCCESS)
    return result;
  if (!vulkan_load_instance(&device->vk, device->instance, true))
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "the Vulkan instance lacks functions of Vulkan 1.1");
  on.utils = on.utils && vulkan_load_debug(&device->vk, device->instance, true);
  /* Without it nothing is named, validated or not: loaders take no lock for it (Vulkan-Loader, issue 200). */
  device->debug = on.utils && info->names;
  if (!on.layer || !on.utils)
    return CSM_SUCCESS;
  const VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_of(device);
  return vulkan_made(device,
                     device->vk.CreateDebugUtilsMessengerEXT(device->instance, &messenger, NULL, &device->messenger),
                     &device->messenger, "vkCreateDebugUtilsMessengerEXT");
}

/* ---- the physical device ---- */

/* One that computes too comes first: where there is a graphics queue, Vulkan promises one. */
static uint32_t find_graphics_queue(const gpu_device *device, VkPhysicalDevice physical) {
  const VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  uint32_t found = UINT32_MAX;
  for (uint32_t family = 0;; family++) {
    const VkQueueFlags flags = vulkan_queue_flags(device, physical, family, NULL);
    if ((flags & both) == both)
      return family;
    if ((flags & VK_QUEUE_GRAPHICS_BIT) && found == UINT32_MAX)
      found = family;
    if (!flags)
      return found;
  }
}

/* What a device lacks that csm cannot do without; NULL if nothing. */
static const char *missing(const gpu_device *device, VkPhysicalDevice physical) {
  VkPhysicalDeviceFeatures features;
  device->vk.GetPhysicalDeviceFeatures(physical, &features);
  const char *lacks = vulkan_lacks(device, physical, &features);
  return !lacks && find_graphics_queue(device, physical) == UINT32_MAX ? "a graphics queue" : lacks;
}

static csm_result select_from(gpu_device *device, const char *name, const VkPhysicalDevice *list, uint32_t count) {
  choose_choice choice = {.part = name};
  char refusal[512];
  for (uint32_t i = 0; i < count; i++) {
    VkPhysicalDeviceProperties properties;
    device->vk.GetPhysicalDeviceProperties(list[i], &properties);
    const choose_candidate candidate = {
        .name = properties.deviceName, .type = physical_type(properties.deviceType), .lacks = missing(device, list[i])};
    if (choose_offer(&choice, &candidate))
      device->physical = list[i];
  }
  if (device->physical)
    return CSM_SUCCESS;
  choose_refusal(&choice, refusal, sizeof refusal);
  return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "%s", refusal);
}

static csm_result select_physical(gpu_device *device, const char *name) {
  uint32_t count = 0;
  csm_result result = vulkan_check(device, device->vk.EnumeratePhysicalDevices(device->instance, &count, NULL),
                                   "vkEnumeratePhysicalDevices");
  if (result != CSM_SUCCESS)
    return result;
  if (count == 0)
    return lent_fail(&device->lent, CSM_ERROR_NO_DEVICE, "no Vulkan device");
  VkPhysicalDevice *list = lent_allocate(&device->lent, count * sizeof *list);
  if (!list)
    return CSM_ERROR_OUT_OF_MEMORY;
  result = vulkan_check(device, device->vk.EnumeratePhysicalDevices(device->instance, &count, list),
                        "vkEnumeratePhysicalDevices");
  if (result == CSM_SUCCESS)
    result = select_from(device, name, list, count);
  lent_release(&device->lent, list);
  return result;
}

/* Dynamic rendering, and what of it Vulkan 1.1 has not. */
static const char *const rendering_extensions[] = {VK_KHR_DYNAMIC_RENDERING_EXTENSION_NAME,
                                                   VK_KHR_DEPTH_STENCIL_RESOLVE_EXTENSION_NAME,
                                                   VK_KHR_CREATE_RENDERPASS_2_EXTENSION_NAME};

/* Which optional extensions there are. */
static csm_result find_device_extensions(gpu_device *device) {
  uint32_t count = 0;
  VkResult result = device->vk.EnumerateDeviceExtensionProperties(device->physical, NULL, &count, NULL);
  if (result != VK_SUCCESS || count == 0)
    return vulkan_check(device, result, "vkEnumerateDeviceExtensionProperties");
  VkExtensionProperties *extensions = lent_allocate(&device->lent, count * sizeof *extensions);
  if (!extensions)
    return CSM_ERROR_OUT_OF_MEMORY;
  result = device->vk.EnumerateDeviceExtensionProperties(device->physical, NULL, &count, extensions);
  if (result >= 0) {
    device->driver_properties = has_extension(extensions, count, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME);
    device->memory_budget = has_extension(extensions, count, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME);
    device->dynamic_rendering = true;
    for (uint32_t i = 0; i < sizeof rendering_extensions / sizeof *rendering_extensions; i++)
      device->dynamic_rendering &= has_extension(extensions, count, rendering_extensions[i]);
  }
  lent_release(&device->lent, extensions);
  return vulkan_check(device, result, "vkEnumerateDeviceExtensionProperties");
}

/* The features that are used where they are there. */
static void find_features(gpu_device *device) {
  VkPhysicalDeviceDynamicRenderingFeatures rendering = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES};
  VkPhysicalDeviceFeatures2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                   .pNext = device->dynamic_rendering ? &rendering : NULL};
  device->vk.GetPhysicalDeviceFeatures2(device->physical, &all);
  device->dynamic_rendering = rendering.dynamicRendering;
  device->features =
      (VkPhysicalDeviceFeatures){.depthClamp = VK_TRUE,
                                 .depthBiasClamp = all.features.depthBiasClamp,
                                 .samplerAnisotropy = all.features.samplerAnisotropy,
                                 .fragmentStoresAndAtomics = all.features.fragmentStoresAndAtomics,
                                 .shaderStorageImageExtendedFormats = all.features.shaderStorageImageExtendedFormats};
}

csm_result vulkan_own_select(gpu_device *device, const gpu_open_info *info) {
  csm_result result = open_library(device);
  if (result == CSM_SUCCESS)
    result = create_instance(device, info);
  if (result == CSM_SUCCESS)
    result = select_physical(device, info->device_name);
  if (result == CSM_SUCCESS)
    result = find_device_extensions(device);
  if (result != CSM_SUCCESS)
    return result;
  device->queue_family = find_graphics_queue(device, device->physical);
  find_features(device);
  return CSM_SUCCESS;
}

/* ---- the device ---- */

csm_result vulkan_own_open(gpu_device *device) {
  enum { RENDERING_COUNT = sizeof rendering_extensions / sizeof *rendering_extensions };
  const float priority = 1;
  const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                         .queueFamilyIndex = device->queue_family,
                                         .queueCount = 1,
                                         .pQueuePriorities = &priority};
  const char *extensions[1 + RENDERING_COUNT];
  uint32_t count = 0;
  if (device->memory_budget)
    extensions[count++] = VK_EXT_MEMORY_BUDGET_EXTENSION_NAME;
  for (uint32_t i = 0; device->dynamic_rendering && i < RENDERING_COUNT; i++)
    extensions[count++] = rendering_extensions[i];
  const VkPhysicalDeviceDynamicRenderingFeatures rendering = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DYNAMIC_RENDERING_FEATURES, .dynamicRendering = VK_TRUE};
  const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                   .pNext = device->dynamic_rendering ? &rendering : NULL,
                                   .queueCreateInfoCount = 1,
                                   .pQueueCreateInfos = &queue,
                                   .enabledExtensionCount = count,
                                   .ppEnabledExtensionNames = extensions,
                                   .pEnabledFeatures = &device->features};
  const VkResult created = device->vk.CreateDevice(device->physical, &info, NULL, &device->handle);
  if (created != VK_SUCCESS)
    device->handle = VK_NULL_HANDLE; /* it is undefined then */
  return vulkan_check(device, created, "vkCreateDevice");
}

void vulkan_own_close(gpu_device *device) {
  if (device->handle && device->vk.DestroyDevice)
    device->vk.DestroyDevice(device->handle, NULL);
  if (device->messenger)
    device->vk.DestroyDebugUtilsMessengerEXT(device->instance, device->messenger, NULL);
  if (device->instance && device->vk.DestroyInstance)
    device->vk.DestroyInstance(device->instance, NULL);
  if (device->library)
    dlclose(device->library);
}
