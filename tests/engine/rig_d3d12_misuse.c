/* rig_d3d12_misuse.c: what may be wrong with the structs of csm_d3d12.h. */
#include "rig_d3d12.h"

#include <string.h>

static int32_t CSM_CALL lend(void *user, const csm_d3d12_memory_request *request, csm_d3d12_memory *out) {
  (void)user, (void)request, (void)out;
  return E_OUTOFMEMORY;
}

static void CSM_CALL take_back(void *user, const csm_d3d12_memory *memory) {
  (void)user, (void)memory;
}

#define DEVICE(field) FIELD(csm_d3d12_device, field)
#define IMAGE(field) FIELD(csm_d3d12_image, field)
#define MESH(field) FIELD(csm_d3d12_mesh, field)

static uint32_t device_rows(const rig *rig, rig_native *good, misuse *out) {
  const misuse rows[] = {
      {"no device", DEVICE(device), {0}, CSM_ERROR_NULL_POINTER, "device"},
      {"no serialiser", DEVICE(serialize_root_signature), {0}, CSM_ERROR_NULL_POINTER, "serialize_root_signature"},
      {"reserved", DEVICE(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"no free_memory", DEVICE(allocate_memory), {(uintptr_t)lend}, CSM_ERROR_NULL_POINTER, "free_memory"},
      {"no allocate_memory", DEVICE(free_memory), {(uintptr_t)take_back}, CSM_ERROR_NULL_POINTER, "allocate_memory"},
      {"no size", DEVICE(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "struct_size"},
      {"an odd size", DEVICE(struct_size), {17}, CSM_ERROR_STRUCT_SIZE, "struct_size"},
      {"an older struct, without a serialiser",
       DEVICE(struct_size),
       {offsetof(csm_d3d12_device, serialize_root_signature)},
       CSM_ERROR_NULL_POINTER,
       "serialize_root_signature"},
  };
  good->d3d12_device = rig->native;
  memcpy(out, rows, sizeof rows);
  return sizeof rows / sizeof rows[0];
}

static uint32_t image_rows(const rig_image *image, const rig_buffer *buffer, rig_native *good, misuse *out) {
  memcpy(&good->d3d12_image, rig_image_native(image), sizeof good->d3d12_image);
  const uint32_t wider = good->d3d12_image.width + 1;
  const misuse rows[] = {
      {"no image", IMAGE(resource), {0}, CSM_ERROR_NULL_POINTER, "resource"},
      {"a buffer", IMAGE(resource), {.pointer = buffer->object}, CSM_ERROR_INVALID_VALUE, "2D texture"},
      {"no format", IMAGE(format), {DXGI_FORMAT_UNKNOWN}, CSM_ERROR_INVALID_VALUE, "format"},
      {"a format of targets alone", IMAGE(format), {DXGI_FORMAT_D32_FLOAT}, CSM_ERROR_INVALID_VALUE, "format"},
      {"a format of colour alone", IMAGE(format), {DXGI_FORMAT_R11G11B10_FLOAT}, CSM_ERROR_INVALID_VALUE, "format"},
      {"a format without a type", IMAGE(format), {DXGI_FORMAT_R32_TYPELESS}, CSM_ERROR_INVALID_VALUE, "format"},
      {"integers", IMAGE(format), {DXGI_FORMAT_R32_UINT}, CSM_ERROR_INVALID_VALUE, "format"},
      {"a width beyond the image", IMAGE(width), {wider}, CSM_ERROR_INVALID_VALUE, "width"},
      {"no width", IMAGE(width), {0}, CSM_ERROR_INVALID_VALUE, "width"},
      {"no height", IMAGE(height), {0}, CSM_ERROR_INVALID_VALUE, "height"},
      {"no size", IMAGE(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "struct_size"},
  };
  memcpy(out, rows, sizeof rows);
  return sizeof rows / sizeof rows[0];
}

static uint32_t mesh_rows(const rig_image *image, const rig_buffer *buffer, rig_native *good, misuse *out) {
  const void *texture = rig_d3d12_resource(image);
  const misuse rows[] = {
      {"no vertices", MESH(vertices), {0}, CSM_ERROR_NULL_POINTER, "vertices"},
      {"no indices", MESH(indices), {0}, CSM_ERROR_NULL_POINTER, "indices"},
      {"an image for vertices", MESH(vertices), {.pointer = texture}, CSM_ERROR_INVALID_VALUE, "buffer"},
      {"an image for indices", MESH(indices), {.pointer = texture}, CSM_ERROR_INVALID_VALUE, "buffer"},
      {"no stride", MESH(vertex_stride), {0}, CSM_ERROR_INVALID_VALUE, "vertex_stride"},
      {"a stride below a position", MESH(vertex_stride), {8}, CSM_ERROR_INVALID_VALUE, "vertex_stride"},
      {"a stride that is not aligned", MESH(vertex_stride), {18}, CSM_ERROR_INVALID_VALUE, "vertex_stride"},
      {"a stride beyond the API's", MESH(vertex_stride), {2052}, CSM_ERROR_INVALID_VALUE, "vertex_stride"},
      {"vertices that are not aligned", MESH(vertex_offset), {2}, CSM_ERROR_INVALID_VALUE, "offset"},
      {"indices that are not aligned", MESH(index_offset), {1026}, CSM_ERROR_INVALID_VALUE, "offset"},
      {"reserved", MESH(reserved), {1}, CSM_ERROR_INVALID_VALUE, "reserved"},
      {"vertices beyond the buffer", MESH(vertex_offset), {4096}, CSM_ERROR_INVALID_VALUE, "buffer"},
      {"indices beyond the buffer", MESH(index_offset), {4096}, CSM_ERROR_INVALID_VALUE, "buffer"},
      {"no size", MESH(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "struct_size"},
      {"an older struct, without indices",
       MESH(struct_size),
       {offsetof(csm_d3d12_mesh, indices)},
       CSM_ERROR_NULL_POINTER,
       "indices"},
      {"an older struct, without an offset",
       MESH(struct_size),
       {offsetof(csm_d3d12_mesh, index_offset)},
       CSM_SUCCESS,
       NULL},
  };
  good->d3d12_mesh = (csm_d3d12_mesh){.struct_size = sizeof good->d3d12_mesh,
                                      .vertex_stride = 16,
                                      .vertices = buffer->object,
                                      .indices = buffer->object,
                                      .index_offset = 1024};
  memcpy(out, rows, sizeof rows);
  return sizeof rows / sizeof rows[0];
}

static uint32_t tested_mesh_rows(const rig_image *image, const rig_buffer *buffer, rig_native *good, misuse *out) {
  static const misuse rows[] = {
      {"no stride", MESH(uv_stride), {0}, CSM_ERROR_INVALID_VALUE, "uv_stride"},
      {"a stride below a pair", MESH(uv_stride), {4}, CSM_ERROR_INVALID_VALUE, "uv_stride"},
      {"a stride that is not aligned", MESH(uv_stride), {10}, CSM_ERROR_INVALID_VALUE, "uv_stride"},
      {"a stride beyond the API's", MESH(uv_stride), {2052}, CSM_ERROR_INVALID_VALUE, "uv_stride"},
      {"uvs that are not aligned", MESH(uv_offset), {6}, CSM_ERROR_INVALID_VALUE, "uv_offset"},
      {"uvs beyond the buffer", MESH(uv_offset), {4096}, CSM_ERROR_INVALID_VALUE, "uv"},
  };
  misuse untold[MISUSE_ROWS];
  mesh_rows(image, buffer, good, untold);
  good->d3d12_mesh.uv_offset = 512;
  good->d3d12_mesh.uv_stride = 8;
  memcpy(out, rows, sizeof rows);
  return sizeof rows / sizeof rows[0];
}

uint32_t rig_misuses(rig *rig, rig_struct which, const rig_image *image, const rig_buffer *buffer, rig_native *good,
                     misuse *rows) {
  *good = (rig_native){0};
  return which == RIG_DEVICE  ? device_rows(rig, good, rows)
         : which == RIG_IMAGE ? image_rows(image, buffer, good, rows)
         : which == RIG_MESH  ? mesh_rows(image, buffer, good, rows)
                              : tested_mesh_rows(image, buffer, good, rows);
}

uint32_t rig_struct_size(rig_struct which) {
  return which == RIG_DEVICE  ? sizeof(csm_d3d12_device)
         : which == RIG_IMAGE ? sizeof(csm_d3d12_image)
                              : sizeof(csm_d3d12_mesh);
}

void rig_give_device(const rig_native *device, csm_create_info *info) {
  info->d3d12 = &device->d3d12_device;
}

void rig_give_mesh(const rig_native *mesh, csm_mesh_info *info) {
  info->d3d12 = &mesh->d3d12_mesh;
}

/* ---- the other API's ---- */

void rig_give_foreign_device(csm_create_info *info) {
  static const csm_vulkan_device device = {.struct_size = sizeof device};
  info->vulkan = &device;
}

void rig_give_foreign_mesh(csm_mesh_info *info) {
  static const csm_vulkan_mesh mesh = {.struct_size = sizeof mesh, .vertex_stride = 12};
  info->vulkan = &mesh;
}
