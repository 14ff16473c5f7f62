/*
 * validation.c: turns the Khronos validation layer on under vkd3d. vkd3d enables no layers, and has no way to ask for
 * them but the process's environment; it does take a vkGetInstanceProcAddr, so it gets one whose vkCreateInstance adds
 * the layer, with synchronization validation, to what vkd3d asks for. Nothing outside this device changes.
 */
#include "d3d12.h"
#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

static const char layer_name[] = "VK_LAYER_KHRONOS_validation";

/* These functions get no pointer of the caller's, so the loader, which the driver keeps open, is looked up by name. */
static PFN_vkVoidFunction loader_proc(VkInstance instance, const char *name) {
  void *library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL | RTLD_NOLOAD);
  if (!library)
    return NULL;
  PFN_vkGetInstanceProcAddr get;
  *(void **)&get = dlsym(library, "vkGetInstanceProcAddr");
  const PFN_vkVoidFunction function = get ? get(instance, name) : NULL;
  dlclose(library);
  return function;
}

static bool lists(const char *const *names, uint32_t count, const char *name) {
  for (uint32_t i = 0; i < count; ++i)
    if (strcmp(names[i], name) == 0)
      return true;
  return false;
}

static VKAPI_ATTR VkResult VKAPI_CALL create_validated_instance(const VkInstanceCreateInfo *asked,
                                                                const VkAllocationCallbacks *allocator,
                                                                VkInstance *out) {
  static const char *const added[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME};
  static const VkValidationFeatureEnableEXT enabled = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  const uint32_t added_count = sizeof added / sizeof *added;
  const PFN_vkCreateInstance create = (PFN_vkCreateInstance)loader_proc(NULL, "vkCreateInstance");
  const char **extensions = malloc((asked->enabledExtensionCount + added_count) * sizeof *extensions);
  if (!create || !extensions) {
    free(extensions);
    return create ? VK_ERROR_OUT_OF_HOST_MEMORY : VK_ERROR_INITIALIZATION_FAILED;
  }
  uint32_t count = 0;
  for (uint32_t i = 0; i < asked->enabledExtensionCount; ++i)
    extensions[count++] = asked->ppEnabledExtensionNames[i];
  for (uint32_t i = 0; i < added_count; ++i)
    if (!lists(extensions, count, added[i]))
      extensions[count++] = added[i];

  const char *const layers[] = {layer_name};
  const VkValidationFeaturesEXT features = {
      .sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
      .pNext = asked->pNext,
      .enabledValidationFeatureCount = 1,
      .pEnabledValidationFeatures = &enabled,
  };
  VkInstanceCreateInfo info = *asked;
  info.pNext = &features;
  info.enabledLayerCount = 1;
  info.ppEnabledLayerNames = layers;
  info.enabledExtensionCount = count;
  info.ppEnabledExtensionNames = extensions;
  const VkResult result = create(&info, allocator, out);
  free(extensions);
  return result;
}

PFN_vkVoidFunction VKAPI_CALL d3d12_validated_proc(VkInstance instance, const char *name) {
  if (strcmp(name, "vkCreateInstance") == 0)
    return (PFN_vkVoidFunction)create_validated_instance;
  return loader_proc(instance, name);
}

bool d3d12_validation_is_installed(const d3d12_driver *driver) {
  const PFN_vkEnumerateInstanceLayerProperties enumerate =
      (PFN_vkEnumerateInstanceLayerProperties)driver->get_instance_proc(NULL, "vkEnumerateInstanceLayerProperties");
  VkLayerProperties layers[64];
  uint32_t count = sizeof layers / sizeof *layers;
  if (!enumerate || enumerate(&count, layers) < 0)
    return false;
  for (uint32_t i = 0; i < count; ++i)
    if (strcmp(layers[i].layerName, layer_name) == 0)
      return true;
  return false;
}

/* vkd3d waits for its fences on a thread of its own, so a message may come from there. */
static VKAPI_ATTR VkBool32 VKAPI_CALL pass_on(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                              VkDebugUtilsMessageTypeFlagsEXT types,
                                              const VkDebugUtilsMessengerCallbackDataEXT *data, void *user) {
  const gpu_host *host = user;
  const bool error = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  char line[2048];
  size_t length = 0;
  (void)types;
  for (const char *c = data->pMessage; *c && length + 1 < sizeof line; ++c)
    line[length++] = *c == '\n' ? ' ' : *c;
  line[length] = 0;
  host->log(host->user, error ? CSM_LOG_ERROR : CSM_LOG_WARNING, line);
  return VK_FALSE;
}

csm_result d3d12_validation_listen(d3d12_driver *driver, const gpu_host *host) {
  const PFN_vkCreateDebugUtilsMessengerEXT create = (PFN_vkCreateDebugUtilsMessengerEXT)driver->get_instance_proc(
      driver->vk_instance, "vkCreateDebugUtilsMessengerEXT");
  const VkDebugUtilsMessengerCreateInfoEXT info = {
      .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
      .messageSeverity =
          VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
      .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
      .pfnUserCallback = pass_on,
      .pUserData = (void *)host,
  };
  if (!create || create(driver->vk_instance, &info, NULL, &driver->messenger) != VK_SUCCESS)
    return CSM_ERROR_DEVICE;
  return CSM_SUCCESS;
}

void d3d12_validation_close(d3d12_driver *driver) {
  if (!driver->messenger)
    return;
  const PFN_vkDestroyDebugUtilsMessengerEXT destroy = (PFN_vkDestroyDebugUtilsMessengerEXT)driver->get_instance_proc(
      driver->vk_instance, "vkDestroyDebugUtilsMessengerEXT");
  destroy(driver->vk_instance, driver->messenger, NULL);
  driver->messenger = VK_NULL_HANDLE;
}
