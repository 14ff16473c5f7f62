/* rig_vulkan_misuse.c: what may be wrong with the structs of csm_vulkan.h. */
#include "rig_vulkan.h"

#include <string.h>

static PFN_vkVoidFunction VKAPI_CALL knows_nothing(VkInstance instance, const char *name) {
  (void)instance, (void)name;
  return NULL;
}

static VkResult CSM_CALL lend(void *user, const csm_vulkan_memory_request *request, csm_vulkan_memory *out) {
  (void)user, (void)request, (void)out;
  return VK_ERROR_OUT_OF_DEVICE_MEMORY;
}

static void CSM_CALL take_back(void *user, const csm_vulkan_memory *memory) {
  (void)user, (void)memory;
}

#define DEVICE(field) FIELD(csm_vulkan_device, field)
#define IMAGE(field) FIELD(csm_vulkan_image, field)
#define MESH(field) FIELD(csm_vulkan_mesh, field)

static uint32_t device_rows(const rig *rig, rig_native *good, misuse *out) {
  static const VkPhysicalDeviceFeatures no_features = {0};
  const misuse rows[] = {
      {"no instance", DEVICE(instance), {0}, CSM_ERROR_NULL_POINTER, "instance"},
      {"no physical device", DEVICE(physical_device), {0}, CSM_ERROR_NULL_POINTER, "physical_device"},
      {"no device", DEVICE(device), {0}, CSM_ERROR_NULL_POINTER, "device"},
      {"no functions", DEVICE(get_instance_proc_addr), {0}, CSM_ERROR_NULL_POINTER, "get_instance_proc_addr"},
      {"functions of nothing",
       DEVICE(get_instance_proc_addr),
       {(uintptr_t)knows_nothing},
       CSM_ERROR_UNSUPPORTED,
       "functions"},
      {"no extensions", DEVICE(extensions), {0}, CSM_ERROR_NULL_POINTER, "extensions is NULL"},
      {"an extension without a name", DEVICE(extension_count), {2}, CSM_ERROR_NULL_POINTER, "an element of extensions"},
      {"reserved", DEVICE(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"reserved2", DEVICE(reserved2), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"reserved3", DEVICE(reserved3), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"dynamic rendering of 2", DEVICE(dynamic_rendering), {2}, CSM_ERROR_INVALID_VALUE, "dynamic_rendering"},
      {"dynamic rendering on Vulkan 1.2", DEVICE(dynamic_rendering), {1}, CSM_ERROR_UNSUPPORTED, "dynamic"},
      {"no free_memory", DEVICE(allocate_memory), {(uintptr_t)lend}, CSM_ERROR_NULL_POINTER, "free_memory"},
      {"no allocate_memory", DEVICE(free_memory), {(uintptr_t)take_back}, CSM_ERROR_NULL_POINTER, "allocate_memory"},
      {"Vulkan 1.0", DEVICE(api_version), {VK_API_VERSION_1_0}, CSM_ERROR_UNSUPPORTED, "1.1"},
      {"no such queue family", DEVICE(queue_family), {9}, CSM_ERROR_UNSUPPORTED, "queue_family"},
      {"no features", DEVICE(features), {0}, CSM_ERROR_UNSUPPORTED, "depthClamp"},
      {"no depthClamp", DEVICE(features), {.pointer = &no_features}, CSM_ERROR_UNSUPPORTED, "depthClamp"},
      {"no size", DEVICE(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "struct_size"},
      {"an older struct, without features",
       DEVICE(struct_size),
       {offsetof(csm_vulkan_device, features)},
       CSM_ERROR_UNSUPPORTED,
       "depthClamp"},
  };
  static const char *const extensions[] = {"VK_KHR_maintenance9", NULL}; /* of a later driver; and an end */
  good->vulkan_device = rig->native;
  good->vulkan_device.extensions = extensions;
  good->vulkan_device.extension_count = 1;
  memcpy(out, rows, sizeof rows);
  return sizeof rows / sizeof rows[0];
}

static uint32_t image_rows(const rig_image *image, rig_native *good, misuse *out) {
  const misuse rows[] = {
      {"no view", IMAGE(view), {0}, CSM_ERROR_NULL_POINTER, "view"},
      {"no size", IMAGE(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "struct_size"},
      {"an attachment",
       IMAGE(layout),
       {VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL},
       CSM_ERROR_INVALID_VALUE,
       "layout 3"},
      {"no layout", IMAGE(layout), {VK_IMAGE_LAYOUT_UNDEFINED}, CSM_ERROR_INVALID_VALUE, "layout 0"},
      {"no format", IMAGE(format), {VK_FORMAT_UNDEFINED}, CSM_ERROR_INVALID_VALUE, "format 0"},
      {"a pair", IMAGE(format), {VK_FORMAT_R8G8_UNORM}, CSM_ERROR_INVALID_VALUE, "format 16"},
      {"integers", IMAGE(format), {VK_FORMAT_R8G8B8A8_UINT}, CSM_ERROR_INVALID_VALUE, "format 41"},
      {"no width", IMAGE(width), {0}, CSM_ERROR_INVALID_VALUE, "size of 0"},
      {"no height", IMAGE(height), {0}, CSM_ERROR_INVALID_VALUE, "size of 0"},
      {"a width of another size", IMAGE(width), {3}, CSM_ERROR_INVALID_VALUE, "3"},
      {"reserved", IMAGE(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
  };
  memcpy(&good->vulkan_image, rig_image_native(image), sizeof good->vulkan_image);
  memcpy(out, rows, sizeof rows);
  return sizeof rows / sizeof rows[0];
}

static uint32_t mesh_rows(const rig_buffer *buffer, rig_native *good, misuse *out) {
  const misuse rows[] = {
      {"no vertices", MESH(vertices), {0}, CSM_ERROR_NULL_POINTER, "vertices"},
      {"no indices", MESH(indices), {0}, CSM_ERROR_NULL_POINTER, "indices"},
      {"no size", MESH(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "struct_size"},
      {"no stride", MESH(vertex_stride), {0}, CSM_ERROR_INVALID_VALUE, "vertex_stride"},
      {"a stride below a position", MESH(vertex_stride), {8}, CSM_ERROR_INVALID_VALUE, "vertex_stride"},
      {"a stride that is not aligned", MESH(vertex_stride), {14}, CSM_ERROR_INVALID_VALUE, "vertex_stride"},
      {"a stride beyond the device's", MESH(vertex_stride), {1u << 30}, CSM_ERROR_INVALID_VALUE, "vertex_stride"},
      {"vertices that are not aligned", MESH(vertex_offset), {2}, CSM_ERROR_INVALID_VALUE, "offset"},
      {"indices that are not aligned", MESH(index_offset), {1026}, CSM_ERROR_INVALID_VALUE, "offset"},
      {"reserved", MESH(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"an older struct, without indices",
       MESH(struct_size),
       {offsetof(csm_vulkan_mesh, indices)},
       CSM_ERROR_NULL_POINTER,
       "indices"},
      {"an older struct, without an offset",
       MESH(struct_size),
       {offsetof(csm_vulkan_mesh, index_offset)},
       CSM_SUCCESS,
       NULL},
  };
  good->vulkan_mesh = (csm_vulkan_mesh){.struct_size = sizeof good->vulkan_mesh,
                                        .vertex_stride = 16,
                                        .vertices = buffer->object,
                                        .vertex_offset = 4,
                                        .indices = buffer->object,
                                        .index_offset = 1024};
  memcpy(out, rows, sizeof rows);
  return sizeof rows / sizeof rows[0];
}

static uint32_t tested_mesh_rows(const rig_buffer *buffer, rig_native *good, misuse *out) {
  static const misuse rows[] = {
      {"no stride", MESH(uv_stride), {0}, CSM_ERROR_INVALID_VALUE, "uv_stride"},
      {"a stride below a pair", MESH(uv_stride), {4}, CSM_ERROR_INVALID_VALUE, "uv_stride"},
      {"a stride that is not aligned", MESH(uv_stride), {10}, CSM_ERROR_INVALID_VALUE, "uv_stride"},
      {"a stride beyond the device's", MESH(uv_stride), {1u << 30}, CSM_ERROR_INVALID_VALUE, "uv_stride"},
      {"uvs that are not aligned", MESH(uv_offset), {6}, CSM_ERROR_INVALID_VALUE, "uv_offset"},
  };
  misuse untold[MISUSE_ROWS];
  mesh_rows(buffer, good, untold);
  good->vulkan_mesh.uv_offset = 512;
  good->vulkan_mesh.uv_stride = 8;
  memcpy(out, rows, sizeof rows);
  return sizeof rows / sizeof rows[0];
}

uint32_t rig_misuses(rig *rig, rig_struct which, const rig_image *image, const rig_buffer *buffer, rig_native *good,
                     misuse *rows) {
  *good = (rig_native){0};
  return which == RIG_DEVICE  ? device_rows(rig, good, rows)
         : which == RIG_IMAGE ? image_rows(image, good, rows)
         : which == RIG_MESH  ? mesh_rows(buffer, good, rows)
                              : tested_mesh_rows(buffer, good, rows);
}

uint32_t rig_struct_size(rig_struct which) {
  return which == RIG_DEVICE  ? sizeof(csm_vulkan_device)
         : which == RIG_IMAGE ? sizeof(csm_vulkan_image)
                              : sizeof(csm_vulkan_mesh);
}

void rig_give_device(const rig_native *device, csm_create_info *info) {
  info->vulkan = &device->vulkan_device;
}

void rig_give_mesh(const rig_native *mesh, csm_mesh_info *info) {
  info->vulkan = &mesh->vulkan_mesh;
}

/* ---- the other API's ---- */

static int not_an_object;

void rig_give_foreign_device(csm_create_info *info) {
  static const csm_d3d12_device device = {.struct_size = sizeof device, .device = &not_an_object};
  info->d3d12 = &device;
}

void rig_give_foreign_mesh(csm_mesh_info *info) {
  static const csm_d3d12_mesh mesh = {
      .struct_size = sizeof mesh, .vertex_stride = 12, .vertices = &not_an_object, .indices = &not_an_object};
  info->d3d12 = &mesh;
}
