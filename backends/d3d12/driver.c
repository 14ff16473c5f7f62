/* driver.c: opens vkd3d and the Vulkan loader beneath it, makes vkd3d's instance, chooses a physical device. */
#include "d3d12.h"
#include <ctype.h>
#include <dlfcn.h>
#include <stdio.h>
#include <string.h>

enum { MAX_PHYSICAL_DEVICES = 32 };

static csm_result open_library(const gpu_open_info *info, const char *name, const char *package, void **out) {
  *out = dlopen(name, RTLD_NOW | RTLD_LOCAL);
  if (*out)
    return CSM_SUCCESS;
  const char *reason = dlerror();
  return d3d12_refuse(info, CSM_ERROR_NO_DEVICE, "%s (Debian's package %s) cannot be opened: %s", name, package,
                      reason ? reason : "no reason given");
}

static csm_result open_libraries(d3d12_driver *driver, const gpu_open_info *info) {
  csm_result result = open_library(info, "libvulkan.so.1", "libvulkan1", &driver->vulkan_library);
  if (result == CSM_SUCCESS)
    result = open_library(info, "libvkd3d.so.1", "libvkd3d1", &driver->vkd3d_library);
  if (result != CSM_SUCCESS)
    return result;

  const struct {
    void *library;
    const char *name;
    void **out;
  } entries[] = {
      {driver->vulkan_library, "vkGetInstanceProcAddr", (void **)&driver->get_instance_proc},
      {driver->vkd3d_library, "vkd3d_create_instance", (void **)&driver->create_instance},
      {driver->vkd3d_library, "vkd3d_instance_decref", (void **)&driver->release_instance},
      {driver->vkd3d_library, "vkd3d_instance_get_vk_instance", (void **)&driver->get_vk_instance},
      {driver->vkd3d_library, "vkd3d_create_device", (void **)&driver->create_device},
      {driver->vkd3d_library, "vkd3d_serialize_root_signature", (void **)&driver->serialize_root_signature},
  };
  for (size_t i = 0; i < sizeof entries / sizeof *entries; ++i) {
    *entries[i].out = dlsym(entries[i].library, entries[i].name);
    if (!*entries[i].out)
      return d3d12_refuse(info, CSM_ERROR_NO_DEVICE, "%s has no %s", i ? "libvkd3d.so.1" : "libvulkan.so.1",
                          entries[i].name);
  }
  return CSM_SUCCESS;
}

static HRESULT signal_event(HANDLE handle) {
  d3d12_event *event = handle;
  pthread_mutex_lock(&event->mutex);
  event->signaled = true;
  pthread_cond_broadcast(&event->signaled_changed);
  pthread_mutex_unlock(&event->mutex);
  return S_OK;
}

static csm_result create_instance(d3d12_driver *driver, const gpu_open_info *info) {
  const bool validate = info->validate && d3d12_validation_is_installed(driver);
  if (info->validate && !validate)
    d3d12_log(info->host, CSM_LOG_WARNING, "VK_LAYER_KHRONOS_validation is not installed: nothing is validated");

  const struct vkd3d_application_info application = {
      .type = VKD3D_STRUCTURE_TYPE_APPLICATION_INFO,
      .application_name = "csm",
      .application_version = CSM_VERSION,
      .api_version = VKD3D_API_VERSION_1_2,
  };
  const struct vkd3d_instance_create_info create = {
      .type = VKD3D_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
      .next = &application,
      .pfn_signal_event = signal_event,
      .wchar_size = sizeof(WCHAR),
      .pfn_vkGetInstanceProcAddr = validate ? d3d12_validated_proc : driver->get_instance_proc,
  };
  const HRESULT hr = driver->create_instance(&create, &driver->instance);
  if (FAILED(hr)) {
    driver->instance = NULL;
    return d3d12_refuse(info, CSM_ERROR_NO_DEVICE, "vkd3d found no usable Vulkan driver (HRESULT 0x%08x)",
                        (uint32_t)hr);
  }
  driver->vk_instance = driver->get_vk_instance(driver->instance);
  if (validate && d3d12_validation_listen(driver, info->host) != CSM_SUCCESS)
    return d3d12_refuse(info, CSM_ERROR_DEVICE, "the validation layer's messages cannot be received");
  return CSM_SUCCESS;
}

static uint32_t device_type(VkPhysicalDeviceType type) {
  switch (type) {
  case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
    return CSM_DEVICE_INTEGRATED;
  case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
    return CSM_DEVICE_DISCRETE;
  case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
    return CSM_DEVICE_VIRTUAL;
  case VK_PHYSICAL_DEVICE_TYPE_CPU:
    return CSM_DEVICE_CPU;
  default:
    return CSM_DEVICE_OTHER;
  }
}

/* Higher is better. */
static uint32_t rank(VkPhysicalDeviceType type) {
  switch (type) {
  case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
    return 4;
  case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
    return 3;
  case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
    return 2;
  case VK_PHYSICAL_DEVICE_TYPE_CPU:
    return 1;
  default:
    return 0;
  }
}

static bool contains(const char *text, const char *part) {
  for (; *text || !*part; ++text) {
    size_t i = 0;
    while (part[i] && tolower((unsigned char)text[i]) == tolower((unsigned char)part[i]))
      ++i;
    if (!part[i])
      return true;
  }
  return false;
}

/* Takes the first of the best type among those whose name contains the one asked for. */
static csm_result choose_device(d3d12_driver *driver, const gpu_open_info *info) {
  const PFN_vkEnumeratePhysicalDevices enumerate =
      (PFN_vkEnumeratePhysicalDevices)driver->get_instance_proc(driver->vk_instance, "vkEnumeratePhysicalDevices");
  const PFN_vkGetPhysicalDeviceProperties get_properties = (PFN_vkGetPhysicalDeviceProperties)driver->get_instance_proc(
      driver->vk_instance, "vkGetPhysicalDeviceProperties");
  VkPhysicalDevice devices[MAX_PHYSICAL_DEVICES];
  uint32_t count = MAX_PHYSICAL_DEVICES;
  if (enumerate(driver->vk_instance, &count, devices) < 0 || count == 0)
    return d3d12_refuse(info, CSM_ERROR_NO_DEVICE, "no Vulkan device for vkd3d was found");

  uint32_t best = 0;
  for (uint32_t i = 0; i < count; ++i) {
    VkPhysicalDeviceProperties properties;
    get_properties(devices[i], &properties);
    if (info->device_name && !contains(properties.deviceName, info->device_name))
      continue;
    if (driver->physical_device && rank(properties.deviceType) <= best)
      continue;
    best = rank(properties.deviceType);
    driver->physical_device = devices[i];
  }
  if (!driver->physical_device)
    return d3d12_refuse(info, CSM_ERROR_NO_DEVICE, "no device's name contains \"%s\"", info->device_name);
  return CSM_SUCCESS;
}

/* vkd3d tells its version through the shader library that it depends on, which is of the same release. */
static const char *vkd3d_version(const d3d12_driver *driver) {
  const char *(*get_version)(unsigned int *major, unsigned int *minor);
  *(void **)&get_version = dlsym(driver->vkd3d_library, "vkd3d_shader_get_version");
  return get_version ? get_version(NULL, NULL) : "vkd3d";
}

/* Index of the largest heap of device memory, which images live in. */
static uint32_t image_heap(const VkPhysicalDeviceMemoryProperties *memory) {
  uint32_t best = 0;
  uint64_t largest = 0;
  for (uint32_t i = 0; i < memory->memoryHeapCount; ++i)
    if ((memory->memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) && memory->memoryHeaps[i].size > largest) {
      best = i;
      largest = memory->memoryHeaps[i].size;
    }
  return best;
}

static uint64_t memory_size(const d3d12_driver *driver) {
  const PFN_vkGetPhysicalDeviceMemoryProperties get =
      (PFN_vkGetPhysicalDeviceMemoryProperties)driver->get_instance_proc(driver->vk_instance,
                                                                         "vkGetPhysicalDeviceMemoryProperties");
  VkPhysicalDeviceMemoryProperties memory;
  get(driver->physical_device, &memory);
  return memory.memoryHeaps[image_heap(&memory)].size;
}

/* Whether the physical device has VK_EXT_memory_budget, which needs no enabling. */
static csm_result find_budget(d3d12_driver *driver, const gpu_open_info *info) {
  const PFN_vkEnumerateDeviceExtensionProperties enumerate =
      (PFN_vkEnumerateDeviceExtensionProperties)driver->get_instance_proc(driver->vk_instance,
                                                                          "vkEnumerateDeviceExtensionProperties");
  uint32_t count = 0;
  if (enumerate(driver->physical_device, NULL, &count, NULL) != VK_SUCCESS || !count)
    return CSM_SUCCESS;
  VkExtensionProperties *extensions = d3d12_new(info->host, count * sizeof *extensions);
  if (!extensions)
    return d3d12_refuse(info, CSM_ERROR_OUT_OF_MEMORY, "out of memory");
  if (enumerate(driver->physical_device, NULL, &count, extensions) >= 0)
    for (uint32_t i = 0; i < count; ++i)
      driver->tells_budget |= strcmp(extensions[i].extensionName, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME) == 0;
  info->host->release(info->host->user, extensions);
  return CSM_SUCCESS;
}

uint64_t d3d12_driver_memory_available(const d3d12_driver *driver) {
  if (!driver->tells_budget)
    return UINT64_MAX;
  const PFN_vkGetPhysicalDeviceMemoryProperties2 get =
      (PFN_vkGetPhysicalDeviceMemoryProperties2)driver->get_instance_proc(driver->vk_instance,
                                                                          "vkGetPhysicalDeviceMemoryProperties2KHR");
  VkPhysicalDeviceMemoryBudgetPropertiesEXT budget = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT};
  VkPhysicalDeviceMemoryProperties2 memory = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2,
                                              .pNext = &budget};
  if (!get)
    return UINT64_MAX;
  get(driver->physical_device, &memory);
  const uint32_t heap = image_heap(&memory.memoryProperties);
  return budget.heapBudget[heap] > budget.heapUsage[heap] ? budget.heapBudget[heap] - budget.heapUsage[heap] : 0;
}

static uint32_t minimum(uint32_t a, uint32_t b) {
  return a < b ? a : b;
}

static uint64_t minimum64(uint64_t a, uint64_t b) {
  return a < b ? a : b;
}

/* The largest images and memory: limits of the device, of its depth format, and of D3D12. */
static csm_result describe_sizes(const d3d12_driver *driver, const gpu_open_info *info,
                                 const VkPhysicalDeviceLimits *limits, uint64_t max_allocation, gpu_device_info *out) {
  const PFN_vkGetPhysicalDeviceImageFormatProperties get =
      (PFN_vkGetPhysicalDeviceImageFormatProperties)driver->get_instance_proc(
          driver->vk_instance, "vkGetPhysicalDeviceImageFormatProperties");
  const VkImageUsageFlags usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                                  VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  VkImageFormatProperties depth;
  if (get(driver->physical_device, VK_FORMAT_D32_SFLOAT, VK_IMAGE_TYPE_2D, VK_IMAGE_TILING_OPTIMAL, usage, 0, &depth) !=
      VK_SUCCESS)
    return d3d12_refuse(info, CSM_ERROR_NO_DEVICE, "%s has no D32_FLOAT images", out->name);
  uint32_t size = minimum(limits->maxImageDimension2D, minimum(depth.maxExtent.width, depth.maxExtent.height));
  size = minimum(size, minimum(limits->maxFramebufferWidth, limits->maxFramebufferHeight));
  size = minimum(size, minimum(limits->maxViewportDimensions[0], limits->maxViewportDimensions[1]));
  out->max_image_size = minimum(size, D3D12_REQ_TEXTURE2D_U_OR_V_DIMENSION);
  out->max_image_layers =
      minimum(minimum(limits->maxImageArrayLayers, depth.maxArrayLayers), D3D12_REQ_TEXTURE2D_ARRAY_AXIS_DIMENSION);
  out->memory_size = memory_size(driver);
  out->max_buffer_size = minimum64(max_allocation, out->memory_size);
  out->max_allocation_size = minimum64(out->max_buffer_size, depth.maxResourceSize);
  return CSM_SUCCESS;
}

static csm_result describe_device(const d3d12_driver *driver, const gpu_open_info *info, gpu_device_info *out) {
  const PFN_vkGetPhysicalDeviceProperties2 get = (PFN_vkGetPhysicalDeviceProperties2)driver->get_instance_proc(
      driver->vk_instance, "vkGetPhysicalDeviceProperties2KHR");
  if (!get)
    return d3d12_refuse(info, CSM_ERROR_NO_DEVICE, "the Vulkan driver has no vkGetPhysicalDeviceProperties2KHR");
  /* A driver that does not know the driver's properties leaves them empty. */
  VkPhysicalDeviceDriverProperties name = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceMaintenance3Properties sizes = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES,
                                                  .pNext = &name};
  VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &sizes};
  get(driver->physical_device, &all);

  out->type = device_type(all.properties.deviceType);
  d3d12_requirements(out);
  snprintf(out->name, sizeof out->name, "%s", all.properties.deviceName);
  snprintf(out->driver, sizeof out->driver, "%s on %.96s %.96s", vkd3d_version(driver), name.driverName,
           name.driverInfo);
  return describe_sizes(driver, info, &all.properties.limits, sizes.maxMemoryAllocationSize, out);
}

csm_result d3d12_driver_open(d3d12_driver *driver, const gpu_open_info *info, gpu_device_info *out) {
  *driver = (d3d12_driver){0};
  csm_result result = open_libraries(driver, info);
  if (result == CSM_SUCCESS)
    result = create_instance(driver, info);
  if (result == CSM_SUCCESS)
    result = choose_device(driver, info);
  if (result == CSM_SUCCESS)
    result = describe_device(driver, info, out);
  if (result == CSM_SUCCESS)
    result = find_budget(driver, info);
  if (result != CSM_SUCCESS)
    d3d12_driver_close(driver);
  return result;
}

void d3d12_driver_close(d3d12_driver *driver) {
  d3d12_validation_close(driver);
  if (driver->instance)
    driver->release_instance(driver->instance);
  if (driver->vkd3d_library)
    dlclose(driver->vkd3d_library);
  if (driver->vulkan_library)
    dlclose(driver->vulkan_library);
  *driver = (d3d12_driver){0};
}
