/* device.c: a device from handles that own.c or engine.c obtained; errors and names. */
#include "internal.h"

#include <string.h>

/* ---- errors and names ---- */

csm_result vulkan_check(const gpu_device *device, VkResult result, const char *function) {
  switch (result) {
  case VK_SUCCESS:
  case VK_INCOMPLETE:
    return CSM_SUCCESS;
  case VK_ERROR_OUT_OF_HOST_MEMORY:
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_MEMORY, "%s: out of host memory", function);
  case VK_ERROR_OUT_OF_DEVICE_MEMORY:
  case VK_ERROR_OUT_OF_POOL_MEMORY:
  case VK_ERROR_FRAGMENTED_POOL:
  case VK_ERROR_TOO_MANY_OBJECTS:
    return lent_fail(&device->lent, CSM_ERROR_OUT_OF_DEVICE_MEMORY, "%s: out of device memory", function);
  case VK_ERROR_DEVICE_LOST:
    return lent_fail(&device->lent, CSM_ERROR_DEVICE_LOST, "%s: the device is lost", function);
  default:
    return lent_fail(&device->lent, CSM_ERROR_DEVICE, "%s: VkResult %d", function, (int)result);
  }
}

csm_result vulkan_made(const gpu_device *device, VkResult result, void *handle, const char *function) {
  if (result != VK_SUCCESS)
    memset(handle, 0, sizeof(uint64_t));
  return vulkan_check(device, result, function);
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

/* ---- opening and closing ---- */

static csm_result device_new(const gpu_open_info *info, gpu_device **out) {
  const gpu_lent lent = lent_begin(info);
  gpu_device *device = lent_allocate(&lent, sizeof *device);
  if (!device)
    return CSM_ERROR_OUT_OF_MEMORY;
  *device = (gpu_device){.lent = lent, .slot_count = info->slots, .own = !info->native};
  *out = device;
  return CSM_SUCCESS;
}

/* Makes everything that recordings need, from handles alone. */
static csm_result device_use(gpu_device *device) {
  if (!vulkan_load_device(&device->vk, device->handle, device->own))
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED, "the device lacks functions of Vulkan 1.1");
  if (device->dynamic_rendering && !vulkan_load_rendering(&device->vk, device->handle))
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED, "the device lacks the functions of dynamic rendering");
  device->usable = true;
  if (device->own) {
    device->vk.GetDeviceQueue(device->handle, device->queue_family, 0, &device->queue);
    vulkan_name(device, VK_OBJECT_TYPE_DEVICE, (uint64_t)(uintptr_t)device->handle, "csm");
    vulkan_name(device, VK_OBJECT_TYPE_QUEUE, (uint64_t)(uintptr_t)device->queue, "csm");
  }
  csm_result result = vulkan_samplers_create(device);
  for (uint32_t i = 0; result == CSM_SUCCESS && i < device->slot_count; i++)
    result = vulkan_slot_create(device, &device->slots[i]);
  return result;
}

static csm_result select_and_describe(gpu_device *device, const gpu_open_info *info) {
  const csm_result result = device->own ? vulkan_own_select(device, info) : vulkan_engine_take(device, info->native);
  return result == CSM_SUCCESS ? vulkan_describe_physical(device) : result;
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
  if (result == CSM_SUCCESS && device->own)
    result = vulkan_own_open(device);
  if (result == CSM_SUCCESS)
    result = device_use(device);
  device->lent.error = NULL;
  if (result == CSM_SUCCESS)
    *out = device;
  else
    vulkan_close(device);
  return result;
}

static void destroy_objects(gpu_device *device) {
  if (device->own)
    device->vk.DeviceWaitIdle(device->handle);
  for (uint32_t i = 0; i < device->slot_count; i++)
    vulkan_slot_destroy(device, &device->slots[i]);
  const VkRenderPass *passes = &device->passes[0][0][0][0];
  for (size_t i = 0; i < sizeof device->passes / sizeof *passes; i++)
    device->vk.DestroyRenderPass(device->handle, passes[i], NULL);
  for (uint32_t i = 0; i < GPU_SAMPLER_COUNT; i++)
    device->vk.DestroySampler(device->handle, device->samplers[i], NULL);
}

void vulkan_close(gpu_device *device) {
  if (device->usable)
    destroy_objects(device);
  if (device->own)
    vulkan_own_close(device);
  const gpu_lent lent = device->lent;
  lent_release(&lent, device);
}
