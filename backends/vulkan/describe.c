/* describe.c: what a device is, and what it must be. */
#include "internal.h"

#include "../physical.h"

/* ---- requirements ---- */

const char *vulkan_lacks(const gpu_device *device, VkPhysicalDevice physical,
                         const VkPhysicalDeviceFeatures *features) {
  VkPhysicalDeviceProperties properties;
  VkFormatProperties depth;
  device->vk.GetPhysicalDeviceProperties(physical, &properties);
  device->vk.GetPhysicalDeviceFormatProperties(physical, VK_FORMAT_D32_SFLOAT, &depth);
  return physical_lacks(&properties, features, &depth);
}

VkQueueFlags vulkan_queue_flags(const gpu_device *device, VkPhysicalDevice physical, uint32_t family,
                                uint32_t *timestamp_bits) {
  VkQueueFamilyProperties families[16];
  uint32_t count = sizeof families / sizeof *families;
  device->vk.GetPhysicalDeviceQueueFamilyProperties(physical, &count, families);
  if (family >= count)
    return 0;
  if (timestamp_bits)
    *timestamp_bits = families[family].timestampValidBits;
  return families[family].queueFlags;
}

/* ---- description ---- */

static uint32_t minimum(uint32_t a, uint32_t b) {
  return a < b ? a : b;
}

static csm_result describe_sizes(gpu_device *device, const VkPhysicalDeviceLimits *limits, uint64_t max_allocation) {
  VkImageFormatProperties depth;
  const csm_result result = vulkan_check(
      device,
      device->vk.GetPhysicalDeviceImageFormatProperties(device->physical, VK_FORMAT_D32_SFLOAT, VK_IMAGE_TYPE_2D,
                                                        VK_IMAGE_TILING_OPTIMAL, physical_depth_usage, 0, &depth),
      "vkGetPhysicalDeviceImageFormatProperties");
  if (result != CSM_SUCCESS)
    return result;
  device->vk.GetPhysicalDeviceMemoryProperties(device->physical, &device->memory);
  device->max_stride = limits->maxVertexInputBindingStride;
  const physical_limits all = {
      .device = limits, .depth = &depth, .memory = &device->memory, .max_allocation = max_allocation};
  physical_sizes(&all, &device->info);
  return CSM_SUCCESS;
}

/* Images rest visible to the shaders of every stage that the queue has: an engine may sample them in any. */
static void describe_queue(gpu_device *device, const VkPhysicalDeviceLimits *limits) {
  uint32_t bits = 0;
  const VkQueueFlags flags = vulkan_queue_flags(device, device->physical, device->queue_family, &bits);
  device->timestamp_mask = bits == 0 ? 0 : UINT64_MAX >> (64 - bits);
  device->timestamp_period_ns = limits->timestampPeriod;
  device->read = (vulkan_use){.layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                              .stages = VK_PIPELINE_STAGE_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                              .access = VK_ACCESS_SHADER_READ_BIT};
  device->info.can.compute = flags & VK_QUEUE_COMPUTE_BIT;
  device->info.can.timestamps = bits;
  if (flags & VK_QUEUE_COMPUTE_BIT)
    device->read.stages |= VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
}

static void describe_abilities(gpu_device *device, const VkPhysicalDeviceLimits *limits) {
  gpu_capabilities *can = &device->info.can;
  const uint32_t anisotropy = (uint32_t)limits->maxSamplerAnisotropy;
  can->max_anisotropy = device->features.samplerAnisotropy ? minimum(anisotropy, GPU_MAX_ANISOTROPY) : 1;
  can->max_texels_size = (uint64_t)limits->maxTexelBufferElements * GPU_TEXEL_SIZE;
  can->max_buffers = minimum(limits->maxPerStageDescriptorStorageBuffers, GPU_MAX_BUFFERS + GPU_MAX_STORES);
  can->indirect = true;
  can->pixel_stores = device->features.fragmentStoresAndAtomics;
  can->bias_clamp = device->features.depthBiasClamp;
  can->dynamic_rendering = device->dynamic_rendering;
  vulkan_describe_formats(device);
}

csm_result vulkan_describe_physical(gpu_device *device) {
  VkPhysicalDeviceDriverProperties driver = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
  VkPhysicalDeviceMaintenance3Properties sizes = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES,
                                                  .pNext = device->driver_properties ? &driver : NULL};
  VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, .pNext = &sizes};
  device->vk.GetPhysicalDeviceProperties2(device->physical, &all);

  const VkPhysicalDeviceProperties *properties = &all.properties;
  gpu_device_info *info = &device->info;
  info->type = physical_type(properties->deviceType);
  info->required = vulkan_required;
  info->optional = vulkan_optional;
  lent_text(info->name, sizeof info->name, "%s", properties->deviceName);
  if (device->driver_properties)
    lent_text(info->driver, sizeof info->driver, "%.120s %.120s", driver.driverName, driver.driverInfo);
  else
    lent_text(info->driver, sizeof info->driver, "version 0x%08x", properties->driverVersion);
  describe_queue(device, &properties->limits);
  describe_abilities(device, &properties->limits);
  return describe_sizes(device, &properties->limits, sizes.maxMemoryAllocationSize);
}

void vulkan_describe(const gpu_device *device, gpu_device_info *out) {
  *out = device->info;
}

/* ---- the budget ---- */

uint64_t vulkan_memory_available(gpu_device *device) {
  if (!device->memory_budget)
    return UINT64_MAX;
  VkPhysicalDeviceMemoryBudgetPropertiesEXT budget = {
      .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_BUDGET_PROPERTIES_EXT};
  VkPhysicalDeviceMemoryProperties2 memory = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MEMORY_PROPERTIES_2,
                                              .pNext = &budget};
  device->vk.GetPhysicalDeviceMemoryProperties2(device->physical, &memory);
  const uint32_t heap = physical_image_heap(&device->memory);
  const uint64_t most = budget.heapBudget[heap], used = budget.heapUsage[heap];
  return most > used ? most - used : 0;
}
