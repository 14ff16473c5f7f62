#include "physical.h"

gpu_device_type physical_type(VkPhysicalDeviceType type) {
  switch (type) {
  case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
    return GPU_DEVICE_INTEGRATED;
  case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
    return GPU_DEVICE_DISCRETE;
  case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
    return GPU_DEVICE_VIRTUAL;
  case VK_PHYSICAL_DEVICE_TYPE_CPU:
    return GPU_DEVICE_CPU;
  default:
    return GPU_DEVICE_OTHER;
  }
}

const char *physical_lacks(const VkPhysicalDeviceProperties *properties, const VkPhysicalDeviceFeatures *features,
                           const VkFormatProperties *depth) {
  const VkFormatFeatureFlags wanted =
      VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
  if (properties->apiVersion < VK_API_VERSION_1_1)
    return "Vulkan 1.1";
  if (!features->depthClamp)
    return "depthClamp";
  if ((depth->optimalTilingFeatures & wanted) != wanted)
    return "D32_SFLOAT as a depth target and a texture";
  return NULL;
}

/* ---- sizes ---- */

const VkImageUsageFlags physical_depth_usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                                               VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT |
                                               VK_IMAGE_USAGE_TRANSFER_SRC_BIT;

static uint32_t minimum(uint32_t a, uint32_t b) {
  return a < b ? a : b;
}

static uint64_t minimum64(uint64_t a, uint64_t b) {
  return a < b ? a : b;
}

uint32_t physical_image_heap(const VkPhysicalDeviceMemoryProperties *memory) {
  for (uint32_t i = 0; i < memory->memoryTypeCount; i++)
    if (memory->memoryTypes[i].propertyFlags & VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT)
      return memory->memoryTypes[i].heapIndex;
  return memory->memoryTypes[0].heapIndex;
}

void physical_sizes(const physical_limits *limits, gpu_device_info *out) {
  const VkPhysicalDeviceLimits *device = limits->device;
  const VkImageFormatProperties *depth = limits->depth;
  uint32_t size = minimum(device->maxImageDimension2D, minimum(depth->maxExtent.width, depth->maxExtent.height));
  size = minimum(size, minimum(device->maxFramebufferWidth, device->maxFramebufferHeight));
  out->max_image_size = minimum(size, minimum(device->maxViewportDimensions[0], device->maxViewportDimensions[1]));
  out->max_image_layers = minimum(device->maxImageArrayLayers, depth->maxArrayLayers);
  out->memory_size = limits->memory->memoryHeaps[physical_image_heap(limits->memory)].size;
  out->max_buffer_size = minimum64(limits->max_allocation, out->memory_size);
  out->max_allocation_size = minimum64(out->max_buffer_size, depth->maxResourceSize);
}

/* ---- validation ---- */

void physical_log(const gpu_host *host, VkDebugUtilsMessageSeverityFlagBitsEXT severity, const char *message) {
  char text[2048];
  size_t length = 0;
  for (const char *c = message; *c && length + 1 < sizeof text; c++)
    text[length++] = *c == '\n' ? ' ' : *c;
  text[length] = 0;
  const int32_t level = severity >= VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT ? CSM_LOG_ERROR : CSM_LOG_WARNING;
  host->log(host->user, level, text);
}
