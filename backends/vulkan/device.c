/* device.c: a device from handles that somebody obtained; errors, names and formats. */
#include "internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- memory and errors ---- */

void *vulkan_allocate(const gpu_device *device, size_t size) {
  void *memory = device->host.allocate(device->host.user, size, _Alignof(max_align_t));
  return memory ? memset(memory, 0, size) : NULL;
}

void vulkan_release(const gpu_device *device, void *memory) {
  if (memory)
    device->host.release(device->host.user, memory);
}

void vulkan_text(char *out, size_t size, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(out, size, format, arguments);
  va_end(arguments);
}

csm_result vulkan_fail(const gpu_device *device, csm_result result, const char *format, ...) {
  char text[512];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  if (device->error)
    vulkan_text(device->error, device->error_size, "%s", text);
  else
    device->host.log(device->host.user, CSM_LOG_ERROR, text);
  return result;
}

csm_result vulkan_check(const gpu_device *device, VkResult result, const char *function) {
  switch (result) {
  case VK_SUCCESS:
  case VK_INCOMPLETE:
    return CSM_SUCCESS;
  case VK_ERROR_OUT_OF_HOST_MEMORY:
    return vulkan_fail(device, CSM_ERROR_OUT_OF_MEMORY, "%s: out of host memory", function);
  case VK_ERROR_OUT_OF_DEVICE_MEMORY:
  case VK_ERROR_OUT_OF_POOL_MEMORY:
  case VK_ERROR_FRAGMENTED_POOL:
  case VK_ERROR_TOO_MANY_OBJECTS:
    return vulkan_fail(device, CSM_ERROR_OUT_OF_DEVICE_MEMORY, "%s: out of device memory", function);
  case VK_ERROR_DEVICE_LOST:
    return vulkan_fail(device, CSM_ERROR_DEVICE_LOST, "%s: the device is lost", function);
  default:
    return vulkan_fail(device, CSM_ERROR_DEVICE, "%s: VkResult %d", function, (int)result);
  }
}

void vulkan_name(const gpu_device *device, VkObjectType type, uint64_t handle, const char *name) {
  if (!device->debug || !name)
    return;
  const VkDebugUtilsObjectNameInfoEXT info = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
                                              .objectType = type,
                                              .objectHandle = handle,
                                              .pObjectName = name};
  device->vk.SetDebugUtilsObjectNameEXT(device->handle, &info);
}

/* ---- formats ---- */

VkFormat vulkan_format(gpu_format format) {
  switch (format) {
  case GPU_FORMAT_D32_FLOAT:
    return VK_FORMAT_D32_SFLOAT;
  case GPU_FORMAT_R8_UNORM:
    return VK_FORMAT_R8_UNORM;
  case GPU_FORMAT_RG32_FLOAT:
    return VK_FORMAT_R32G32_SFLOAT;
  case GPU_FORMAT_RGB32_FLOAT:
    return VK_FORMAT_R32G32B32_SFLOAT;
  case GPU_FORMAT_RGBA32_FLOAT:
    return VK_FORMAT_R32G32B32A32_SFLOAT;
  case GPU_FORMAT_NONE:
    break;
  }
  return VK_FORMAT_UNDEFINED;
}

uint32_t vulkan_texel_bytes(gpu_format format) {
  switch (format) {
  case GPU_FORMAT_R8_UNORM:
    return 1;
  case GPU_FORMAT_D32_FLOAT:
    return 4;
  case GPU_FORMAT_RG32_FLOAT:
    return 8;
  case GPU_FORMAT_RGB32_FLOAT:
    return 12;
  case GPU_FORMAT_RGBA32_FLOAT:
    return 16;
  case GPU_FORMAT_NONE:
    break;
  }
  return 0;
}

/* ---- what the device is ---- */

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

static csm_result has_driver_properties(const gpu_device *device, bool *found) {
  *found = false;
  uint32_t count = 0;
  VkResult result = device->vk.EnumerateDeviceExtensionProperties(device->physical, NULL, &count, NULL);
  if (result != VK_SUCCESS || count == 0)
    return vulkan_check(device, result, "vkEnumerateDeviceExtensionProperties");
  VkExtensionProperties *extensions = vulkan_allocate(device, count * sizeof *extensions);
  if (!extensions)
    return CSM_ERROR_OUT_OF_MEMORY;
  result = device->vk.EnumerateDeviceExtensionProperties(device->physical, NULL, &count, extensions);
  if (result >= 0)
    *found = vulkan_has_extension(extensions, count, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME);
  vulkan_release(device, extensions);
  return vulkan_check(device, result, "vkEnumerateDeviceExtensionProperties");
}

static uint32_t minimum(uint32_t a, uint32_t b) {
  return a < b ? a : b;
}

static uint64_t minimum64(uint64_t a, uint64_t b) {
  return a < b ? a : b;
}

/* The largest images and memory: limits of the device and of its depth format. */
static csm_result describe_sizes(gpu_device *device, const VkPhysicalDeviceLimits *limits, uint64_t max_allocation) {
  VkImageFormatProperties depth;
  const VkImageUsageFlags usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                                  VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  const csm_result result = vulkan_check(
      device,
      device->vk.GetPhysicalDeviceImageFormatProperties(device->physical, VK_FORMAT_D32_SFLOAT, VK_IMAGE_TYPE_2D,
                                                        VK_IMAGE_TILING_OPTIMAL, usage, 0, &depth),
      "vkGetPhysicalDeviceImageFormatProperties");
  if (result != CSM_SUCCESS)
    return result;

  device->vk.GetPhysicalDeviceMemoryProperties(device->physical, &device->memory);
  const uint32_t type = vulkan_memory_type(device, UINT32_MAX, GPU_BUFFER_DEVICE);
  gpu_device_info *info = &device->info;
  info->memory_size = device->memory.memoryHeaps[device->memory.memoryTypes[type].heapIndex].size;
  info->max_allocation_size = minimum64(minimum64(max_allocation, info->memory_size), depth.maxResourceSize);
  info->max_buffer_size = info->max_allocation_size;
  info->max_image_layers = minimum(limits->maxImageArrayLayers, depth.maxArrayLayers);
  uint32_t size = minimum(limits->maxImageDimension2D, minimum(depth.maxExtent.width, depth.maxExtent.height));
  size = minimum(size, minimum(limits->maxFramebufferWidth, limits->maxFramebufferHeight));
  info->max_image_size = minimum(size, minimum(limits->maxViewportDimensions[0], limits->maxViewportDimensions[1]));
  return CSM_SUCCESS;
}

static void describe_timestamps(gpu_device *device, const VkPhysicalDeviceLimits *limits) {
  VkQueueFamilyProperties families[16];
  uint32_t count = sizeof families / sizeof *families;
  device->vk.GetPhysicalDeviceQueueFamilyProperties(device->physical, &count, families);
  const uint32_t bits = device->queue_family < count ? families[device->queue_family].timestampValidBits : 0;
  device->timestamp_mask = bits == 0 ? 0 : UINT64_MAX >> (64 - bits);
  device->timestamp_period_ns = limits->timestampPeriod;
}

static csm_result describe_physical(gpu_device *device) {
  bool driver_known = false;
  const csm_result result = has_driver_properties(device, &driver_known);
  if (result != CSM_SUCCESS)
    return result;
  VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceMaintenance3Properties sizes = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES,
                                                  .pNext = driver_known ? &driver : NULL};
  VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &sizes};
  device->vk.GetPhysicalDeviceProperties2(device->physical, &all);

  const VkPhysicalDeviceProperties *properties = &all.properties;
  gpu_device_info *info = &device->info;
  info->type = device_type(properties->deviceType);
  info->required = "Vulkan 1.1 (instance and device); depthClamp; D32_SFLOAT as a depth target and a texture; a "
                   "graphics queue";
  info->optional = "VK_EXT_debug_utils; VK_KHR_driver_properties";
  vulkan_text(info->name, sizeof info->name, "%s", properties->deviceName);
  if (driver_known)
    vulkan_text(info->driver, sizeof info->driver, "%.120s %.120s", driver.driverName, driver.driverInfo);
  else
    vulkan_text(info->driver, sizeof info->driver, "version 0x%08x", properties->driverVersion);
  describe_timestamps(device, &properties->limits);
  return describe_sizes(device, &properties->limits, sizes.maxMemoryAllocationSize);
}

void vulkan_describe(const gpu_device *device, gpu_device_info *out) {
  *out = device->info;
}

/* ---- opening and closing ---- */

static csm_result device_new(const gpu_open_info *info, gpu_device **out) {
  const gpu_host *host = info->host;
  gpu_device *device = host->allocate(host->user, sizeof *device, _Alignof(gpu_device));
  if (!device)
    return CSM_ERROR_OUT_OF_MEMORY;
  *device = (gpu_device){.host = *host,
                         .error = info->error && info->error_size ? info->error : NULL,
                         .error_size = info->error_size,
                         .slot_count = info->slots};
  if (device->error)
    device->error[0] = 0;
  *out = device;
  return CSM_SUCCESS;
}

/* Makes everything that recordings need, from handles alone. */
static csm_result device_use(gpu_device *device) {
  if (!vulkan_load_device(&device->vk, device->handle))
    return vulkan_fail(device, CSM_ERROR_DEVICE, "the device lacks functions of Vulkan 1.1");
  device->vk.GetDeviceQueue(device->handle, device->queue_family, 0, &device->queue);
  vulkan_name(device, VK_OBJECT_TYPE_DEVICE, (uint64_t)(uintptr_t)device->handle, "csm");
  vulkan_name(device, VK_OBJECT_TYPE_QUEUE, (uint64_t)(uintptr_t)device->queue, "csm");
  csm_result result = vulkan_samplers_create(device);
  for (uint32_t i = 0; result == CSM_SUCCESS && i < device->slot_count; i++)
    result = vulkan_slot_create(device, &device->slots[i]);
  return result;
}

static csm_result select_and_describe(gpu_device *device, const gpu_open_info *info) {
  if (info->native)
    return vulkan_fail(device, CSM_ERROR_UNSUPPORTED, "this version opens no engine's device");
  const csm_result result = vulkan_own_select(device, info);
  return result == CSM_SUCCESS ? describe_physical(device) : result;
}

csm_result vulkan_query(const gpu_open_info *info, gpu_device_info *out) {
  gpu_device *device = NULL;
  csm_result result = device_new(info, &device);
  if (result != CSM_SUCCESS)
    return result;
  result = select_and_describe(device, info);
  if (result == CSM_SUCCESS)
    *out = device->info;
  vulkan_close(device);
  return result;
}

csm_result vulkan_open(const gpu_open_info *info, gpu_device **out) {
  *out = NULL;
  gpu_device *device = NULL;
  csm_result result = device_new(info, &device);
  if (result != CSM_SUCCESS)
    return result;
  result = select_and_describe(device, info);
  if (result == CSM_SUCCESS)
    result = vulkan_own_open(device);
  if (result == CSM_SUCCESS)
    result = device_use(device);
  device->error = NULL;
  if (result == CSM_SUCCESS)
    *out = device;
  else
    vulkan_close(device);
  return result;
}

static void destroy_objects(gpu_device *device) {
  device->vk.DeviceWaitIdle(device->handle);
  for (uint32_t i = 0; i < device->slot_count; i++)
    vulkan_slot_destroy(device, &device->slots[i]);
  for (uint32_t depth = 0; depth < VULKAN_FORMATS; depth++)
    for (uint32_t color = 0; color < VULKAN_FORMATS; color++)
      device->vk.DestroyRenderPass(device->handle, device->passes[depth][color], NULL);
  for (uint32_t i = 0; i < VULKAN_SAMPLERS; i++)
    device->vk.DestroySampler(device->handle, device->samplers[i], NULL);
}

void vulkan_close(gpu_device *device) {
  if (device->queue)
    destroy_objects(device);
  vulkan_own_close(device);
  const gpu_host host = device->host;
  host.release(host.user, device);
}
