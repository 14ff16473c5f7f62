/* format.c: formats, and what the device can do with them. */
#include "internal.h"

static const VkFormat formats[GPU_FORMAT_COUNT] = {
    [GPU_FORMAT_NONE] = VK_FORMAT_UNDEFINED,
    [GPU_FORMAT_D32_FLOAT] = VK_FORMAT_D32_SFLOAT,
    [GPU_FORMAT_D16_UNORM] = VK_FORMAT_D16_UNORM,
    [GPU_FORMAT_R8_UNORM] = VK_FORMAT_R8_UNORM,
    [GPU_FORMAT_R16_UNORM] = VK_FORMAT_R16_UNORM,
    [GPU_FORMAT_RG16_UNORM] = VK_FORMAT_R16G16_UNORM,
    [GPU_FORMAT_R16_FLOAT] = VK_FORMAT_R16_SFLOAT,
    [GPU_FORMAT_RG16_FLOAT] = VK_FORMAT_R16G16_SFLOAT,
    [GPU_FORMAT_RGBA16_FLOAT] = VK_FORMAT_R16G16B16A16_SFLOAT,
    [GPU_FORMAT_R32_FLOAT] = VK_FORMAT_R32_SFLOAT,
    [GPU_FORMAT_RG32_FLOAT] = VK_FORMAT_R32G32_SFLOAT,
    [GPU_FORMAT_RGB32_FLOAT] = VK_FORMAT_R32G32B32_SFLOAT,
    [GPU_FORMAT_RGBA32_FLOAT] = VK_FORMAT_R32G32B32A32_SFLOAT,
    [GPU_FORMAT_R32_UINT] = VK_FORMAT_R32_UINT,
};

VkFormat vulkan_format(gpu_format format) {
  return formats[format];
}

/* Shaders store to these without the feature shaderStorageImageExtendedFormats. */
static bool stored_by_all(gpu_format format) {
  return format == GPU_FORMAT_R32_FLOAT || format == GPU_FORMAT_RGBA32_FLOAT || format == GPU_FORMAT_R32_UINT ||
         format == GPU_FORMAT_RGBA16_FLOAT;
}

static uint32_t format_can(const gpu_device *device, gpu_format format) {
  VkFormatProperties properties;
  device->vk.GetPhysicalDeviceFormatProperties(device->physical, formats[format], &properties);
  const VkFormatFeatureFlags has = properties.optimalTilingFeatures;
  const VkFormatFeatureFlags drawn =
      VK_FORMAT_FEATURE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_FORMAT_FEATURE_COLOR_ATTACHMENT_BIT;
  const bool stored = (has & VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT) &&
                      (stored_by_all(format) || device->features.shaderStorageImageExtendedFormats);
  return (has & VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT ? GPU_CAN_SAMPLE : 0) |
         (has & VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT ? GPU_CAN_FILTER : 0) |
         (has & drawn ? GPU_CAN_DRAW : 0) | (stored ? GPU_CAN_STORE | GPU_CAN_LOAD : 0) |
         (stored && (has & VK_FORMAT_FEATURE_STORAGE_IMAGE_ATOMIC_BIT) ? GPU_CAN_ATOMIC : 0);
}

void vulkan_describe_formats(gpu_device *device) {
  for (gpu_format format = GPU_FORMAT_NONE + 1; format < GPU_FORMAT_COUNT; format++)
    device->info.can.formats[format] = format == GPU_FORMAT_RGB32_FLOAT ? 0 : format_can(device, format);
}
