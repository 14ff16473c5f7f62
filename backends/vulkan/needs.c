/* needs.c: what the backend asks of a device, by name. vulkan_lacks checks the first, vulkan_engine_take the second. */
#include "internal.h"

static const char *const depth_clamp[] = {"depthClamp", NULL};
static const char *const formats_and_queues[] = {"D32_SFLOAT as a depth target and a texture", "a graphics queue",
                                                 NULL};

const gpu_needs vulkan_required = {
    .features = depth_clamp,
    .others = formats_and_queues,
    .api_version = VK_API_VERSION_1_1,
};

static const char *const instance_extensions[] = {VK_EXT_DEBUG_UTILS_EXTENSION_NAME, NULL};
static const char *const device_extensions[] = {VK_EXT_MEMORY_BUDGET_EXTENSION_NAME,
                                                VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME,
                                                VK_KHR_DYNAMIC_RENDERING_EXTENSION_NAME, NULL};
static const char *const features[] = {"depthBiasClamp", "samplerAnisotropy", "fragmentStoresAndAtomics",
                                       "shaderStorageImageExtendedFormats", NULL};
static const char *const others[] = {"dynamicRendering, as csm_vulkan_device says", "compute on the queue",
                                     "timestamps on the queue", NULL};

const gpu_needs vulkan_optional = {
    .instance_extensions = instance_extensions,
    .device_extensions = device_extensions,
    .features = features,
    .others = others,
};
