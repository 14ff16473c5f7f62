/* engine.c: an engine's device, and its images and buffers. They are used, never owned. */
#include "internal.h"

#include "../structs.h"

#include <string.h>

/* ---- the device ---- */

static csm_result read_struct(gpu_device *device, const char *name, void *out, uint32_t size, const void *native) {
  const csm_result result = struct_read(out, size, native);
  if (result == CSM_SUCCESS)
    return result;
  return lent_fail(&device->lent, result, "%s: its struct_size is of no version, or its unknown tail is not zero",
                   name);
}

static bool has_extension(const csm_vulkan_device *native, const char *name) {
  for (uint32_t i = 0; i < native->extension_count; i++)
    if (strcmp(native->extensions[i], name) == 0)
      return true;
  return false;
}

/* What can be said without calling Vulkan. */
static csm_result check_native(const gpu_device *device, const csm_vulkan_device *native) {
  const char *missing = !native->instance                                ? "instance"
                        : !native->physical_device                       ? "physical_device"
                        : !native->device                                ? "device"
                        : !native->get_instance_proc_addr                ? "get_instance_proc_addr"
                        : native->extension_count && !native->extensions ? "extensions"
                                                                         : NULL;
  for (uint32_t i = 0; !missing && i < native->extension_count; i++)
    if (!native->extensions[i])
      missing = "an element of extensions";
  if (missing)
    return lent_fail(&device->lent, CSM_ERROR_NULL_POINTER, "csm_vulkan_device: %s is NULL", missing);
  if (native->reserved || native->reserved2 || native->reserved3)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_vulkan_device: reserved is not 0");
  if (native->dynamic_rendering > 1)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_vulkan_device: dynamic_rendering is neither 0 nor 1");
  if (!native->allocate_memory != !native->free_memory)
    return lent_fail(&device->lent, CSM_ERROR_NULL_POINTER, "csm_vulkan_device: %s is NULL, and %s is not",
                     native->free_memory ? "allocate_memory" : "free_memory",
                     native->free_memory ? "free_memory" : "allocate_memory");
  if (native->api_version < VK_API_VERSION_1_1)
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED, "csm_vulkan_device: api_version is below Vulkan 1.1");
  if (native->dynamic_rendering && native->api_version < VK_API_VERSION_1_3 &&
      !has_extension(native, VK_KHR_DYNAMIC_RENDERING_EXTENSION_NAME))
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED,
                     "csm_vulkan_device: dynamic_rendering, without its extension and below Vulkan 1.3");
  return CSM_SUCCESS;
}

static csm_result check_capable(const gpu_device *device, const csm_vulkan_device *native) {
  const VkPhysicalDeviceFeatures none = {0};
  const char *lacks = vulkan_lacks(device, native->physical_device, native->features ? native->features : &none);
  const VkQueueFlags queue = vulkan_queue_flags(device, native->physical_device, native->queue_family, NULL);
  if (!lacks && !(queue & VK_QUEUE_GRAPHICS_BIT))
    lacks = "graphics in queue_family";
  return lacks ? lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED, "csm_vulkan_device: the device lacks %s", lacks)
               : CSM_SUCCESS;
}

csm_result vulkan_engine_take(gpu_device *device, const void *native_device) {
  csm_vulkan_device native;
  csm_result result = read_struct(device, "csm_vulkan_device", &native, sizeof native, native_device);
  if (result == CSM_SUCCESS)
    result = check_native(device, &native);
  if (result != CSM_SUCCESS)
    return result;
  device->vk.GetInstanceProcAddr = native.get_instance_proc_addr;
  if (!vulkan_load_instance(&device->vk, native.instance, false))
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED,
                     "csm_vulkan_device: the instance lacks functions of Vulkan 1.1");
  result = check_capable(device, &native);
  if (result != CSM_SUCCESS)
    return result;
  device->instance = native.instance;
  device->physical = native.physical_device;
  device->handle = native.device;
  device->queue_family = native.queue_family;
  device->debug = vulkan_load_debug(&device->vk, native.instance, false); /* nothing where it is not enabled */
  device->driver_properties = has_extension(&native, VK_KHR_DRIVER_PROPERTIES_EXTENSION_NAME);
  if (native.features)
    device->features = *native.features;
  device->dynamic_rendering = native.dynamic_rendering;
  device->pipeline_cache = native.pipeline_cache;
  device->allocate_memory = native.allocate_memory;
  device->free_memory = native.free_memory;
  device->memory_user = native.memory_user;
  device->memory_budget = has_extension(&native, VK_EXT_MEMORY_BUDGET_EXTENSION_NAME);
  return CSM_SUCCESS;
}

/* ---- images ---- */

/* A format that holds texels as csm reads them: the Direct3D 12 backend takes the same. */
typedef struct texel_format {
  VkFormat format;
  gpu_texels texels;
  gpu_numbers numbers;
  uint32_t bits;
} texel_format;

static const texel_format texel_formats[] = {
    {VK_FORMAT_D16_UNORM, GPU_TEXELS_DEPTH, GPU_NUMBERS_UNORM, 16},
    {VK_FORMAT_D16_UNORM_S8_UINT, GPU_TEXELS_DEPTH, GPU_NUMBERS_UNORM, 16},
    {VK_FORMAT_X8_D24_UNORM_PACK32, GPU_TEXELS_DEPTH, GPU_NUMBERS_UNORM, 24},
    {VK_FORMAT_D24_UNORM_S8_UINT, GPU_TEXELS_DEPTH, GPU_NUMBERS_UNORM, 24},
    {VK_FORMAT_D32_SFLOAT, GPU_TEXELS_DEPTH, GPU_NUMBERS_FLOAT, 24},
    {VK_FORMAT_D32_SFLOAT_S8_UINT, GPU_TEXELS_DEPTH, GPU_NUMBERS_FLOAT, 24},
    {VK_FORMAT_R16_UNORM, GPU_TEXELS_DEPTH, GPU_NUMBERS_UNORM, 16},
    {VK_FORMAT_R16_SFLOAT, GPU_TEXELS_DEPTH, GPU_NUMBERS_FLOAT, 11},
    {VK_FORMAT_R32_SFLOAT, GPU_TEXELS_DEPTH, GPU_NUMBERS_FLOAT, 24},
    {VK_FORMAT_R8G8B8A8_UNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 8},
    {VK_FORMAT_A8B8G8R8_UNORM_PACK32, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 8},
    {VK_FORMAT_B8G8R8A8_UNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 8},
    {VK_FORMAT_A2B10G10R10_UNORM_PACK32, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 10},
    {VK_FORMAT_R16G16B16A16_UNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 16},
    {VK_FORMAT_R8G8B8A8_SNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_SNORM, 8},
    {VK_FORMAT_A8B8G8R8_SNORM_PACK32, GPU_TEXELS_NORMALS, GPU_NUMBERS_SNORM, 8},
    {VK_FORMAT_R16G16B16A16_SNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_SNORM, 16},
    {VK_FORMAT_R16G16B16A16_SFLOAT, GPU_TEXELS_NORMALS, GPU_NUMBERS_FLOAT, 11},
    {VK_FORMAT_R32G32B32_SFLOAT, GPU_TEXELS_NORMALS, GPU_NUMBERS_FLOAT, 24},
    {VK_FORMAT_R32G32B32A32_SFLOAT, GPU_TEXELS_NORMALS, GPU_NUMBERS_FLOAT, 24},
    {VK_FORMAT_R16G16_SFLOAT, GPU_TEXELS_MOTION, GPU_NUMBERS_FLOAT, 11},
    {VK_FORMAT_R32G32_SFLOAT, GPU_TEXELS_MOTION, GPU_NUMBERS_FLOAT, 24},
    {VK_FORMAT_R16G16B16A16_SFLOAT, GPU_TEXELS_MOTION, GPU_NUMBERS_FLOAT, 11},
    {VK_FORMAT_R32G32B32A32_SFLOAT, GPU_TEXELS_MOTION, GPU_NUMBERS_FLOAT, 24},
};

/* In words, by gpu_texels. */
static const char *const texel_names[] = {"depth", "normals", "motion"};

/* NULL if it holds no such texels. */
static const texel_format *find_format(uint32_t format, gpu_texels texels) {
  for (size_t i = 0; i < sizeof texel_formats / sizeof *texel_formats; i++)
    if ((uint32_t)texel_formats[i].format == format && texel_formats[i].texels == texels)
      return &texel_formats[i];
  return NULL;
}

static csm_result check_image(const gpu_device *device, const csm_vulkan_image *native, gpu_texels texels) {
  if (!native->view)
    return lent_fail(&device->lent, CSM_ERROR_NULL_POINTER, "csm_vulkan_image: view is NULL");
  if (native->layout != VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL &&
      native->layout != VK_IMAGE_LAYOUT_DEPTH_STENCIL_READ_ONLY_OPTIMAL && native->layout != VK_IMAGE_LAYOUT_GENERAL)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_vulkan_image: layout %u is none that shaders read in",
                     native->layout);
  if (!find_format(native->format, texels))
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_vulkan_image: format %u is none that holds %s",
                     native->format, texel_names[texels]);
  if (!native->width || !native->height || native->reserved)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_vulkan_image: %s",
                     native->reserved ? "reserved is not 0" : "a size of 0");
  return CSM_SUCCESS;
}

csm_result vulkan_image_import(gpu_device *device, const void *native_image, gpu_texels texels, gpu_image **out,
                               gpu_imported *about) {
  *out = NULL;
  csm_vulkan_image native;
  csm_result result = read_struct(device, "csm_vulkan_image", &native, sizeof native, native_image);
  if (result == CSM_SUCCESS)
    result = check_image(device, &native, texels);
  if (result != CSM_SUCCESS)
    return result;
  gpu_image *image = lent_allocate(&device->lent, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->borrowed = true;
  image->layer_count = 1;
  image->level_count = 1;
  image->view = native.view;
  image->sampled_layout = (VkImageLayout)native.layout;
  image->width = native.width;
  image->height = native.height;
  const texel_format *format = find_format(native.format, texels);
  *about =
      (gpu_imported){.width = native.width, .height = native.height, .numbers = format->numbers, .bits = format->bits};
  *out = image;
  return CSM_SUCCESS;
}

/* ---- buffers ---- */

static gpu_buffer *borrow_buffer(gpu_device *device, VkBuffer handle) {
  gpu_buffer *buffer = lent_allocate(&device->lent, sizeof *buffer);
  if (!buffer)
    return NULL;
  buffer->borrowed = true;
  buffer->handle = handle;
  return buffer;
}

static csm_result check_mesh(const gpu_device *device, const csm_vulkan_mesh *native) {
  if (!native->vertices || !native->indices)
    return lent_fail(&device->lent, CSM_ERROR_NULL_POINTER, "csm_vulkan_mesh: %s is NULL",
                     native->vertices ? "indices" : "vertices");
  if (native->vertex_stride % 4 || native->vertex_stride < 12 || native->vertex_stride > device->max_stride)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE,
                     "csm_vulkan_mesh: a vertex_stride of %u, which is no multiple of 4 from 12 to %u",
                     native->vertex_stride, device->max_stride);
  if (native->vertex_offset % 4 || native->index_offset % 4)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_vulkan_mesh: an offset is no multiple of 4");
  if (native->reserved)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_vulkan_mesh: reserved is not 0");
  return CSM_SUCCESS;
}

csm_result vulkan_geometry_import(gpu_device *device, const void *native_mesh, gpu_geometry *out) {
  *out = (gpu_geometry){0};
  csm_vulkan_mesh native;
  csm_result result = read_struct(device, "csm_vulkan_mesh", &native, sizeof native, native_mesh);
  if (result == CSM_SUCCESS)
    result = check_mesh(device, &native);
  if (result != CSM_SUCCESS)
    return result;
  gpu_buffer *vertices = borrow_buffer(device, native.vertices);
  gpu_buffer *indices = native.indices == native.vertices ? vertices : borrow_buffer(device, native.indices);
  if (!vertices || !indices) {
    if (indices != vertices)
      vulkan_buffer_destroy(device, indices);
    vulkan_buffer_destroy(device, vertices);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  *out = (gpu_geometry){.vertices = vertices,
                        .indices = indices,
                        .vertex_offset = native.vertex_offset,
                        .index_offset = native.index_offset,
                        .uv_offset = native.uv_offset,
                        .vertex_stride = native.vertex_stride,
                        .uv_stride = native.uv_stride,
                        .largest_stride = device->max_stride};
  return CSM_SUCCESS;
}
