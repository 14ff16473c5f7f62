/* engine.c: an engine's device, and its images and buffers, each held by a reference of csm's own. */
#include "internal.h"

#include "../structs.h"

/* ---- the device ---- */

static csm_result read_struct(const gpu_device *device, const char *name, void *out, uint32_t size,
                              const void *native) {
  const csm_result result = struct_read(out, size, native);
  if (result == CSM_SUCCESS)
    return result;
  return lent_fail(&device->lent, result, "%s: its struct_size is of no version, or its unknown tail is not zero",
                   name);
}

csm_result d3d12_engine_take(gpu_device *device, const void *native_device) {
  csm_d3d12_device native;
  const csm_result result = read_struct(device, "csm_d3d12_device", &native, sizeof native, native_device);
  if (result != CSM_SUCCESS)
    return result;
  if (native.reserved)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_d3d12_device: reserved is not 0");
  if (!native.device || !native.serialize_root_signature)
    return lent_fail(&device->lent, CSM_ERROR_NULL_POINTER, "csm_d3d12_device: %s is NULL",
                     native.device ? "serialize_root_signature" : "device");
  if (!native.allocate_memory != !native.free_memory)
    return lent_fail(&device->lent, CSM_ERROR_NULL_POINTER, "csm_d3d12_device: %s is NULL",
                     native.free_memory ? "allocate_memory" : "free_memory");
  if (!d3d12_has_feature_level(native.device))
    return lent_fail(&device->lent, CSM_ERROR_UNSUPPORTED, "csm_d3d12_device: the device lacks feature level 11_0");
  device->handle = native.device;
  ID3D12Device_AddRef(device->handle);
  *(void **)&device->serialize = native.serialize_root_signature;
  device->allocate_memory = native.allocate_memory;
  device->free_memory = native.free_memory;
  device->memory_user = native.memory_user;
  d3d12_describe_handle(device);
  return CSM_SUCCESS;
}

/* ---- images ---- */

/* A format that holds texels as csm reads them: the Vulkan backend takes the same. */
typedef struct texel_format {
  DXGI_FORMAT format;
  gpu_texels texels;
  gpu_numbers numbers;
  uint32_t bits;
} texel_format;

static const texel_format texel_formats[] = {
    {DXGI_FORMAT_R32_FLOAT, GPU_TEXELS_DEPTH, GPU_NUMBERS_FLOAT, 24},
    {DXGI_FORMAT_R32_FLOAT_X8X24_TYPELESS, GPU_TEXELS_DEPTH, GPU_NUMBERS_FLOAT, 24},
    {DXGI_FORMAT_R24_UNORM_X8_TYPELESS, GPU_TEXELS_DEPTH, GPU_NUMBERS_UNORM, 24},
    {DXGI_FORMAT_R16_UNORM, GPU_TEXELS_DEPTH, GPU_NUMBERS_UNORM, 16},
    {DXGI_FORMAT_R16_FLOAT, GPU_TEXELS_DEPTH, GPU_NUMBERS_FLOAT, 11},
    {DXGI_FORMAT_R8G8B8A8_UNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 8},
    {DXGI_FORMAT_B8G8R8A8_UNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 8},
    {DXGI_FORMAT_R10G10B10A2_UNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 10},
    {DXGI_FORMAT_R16G16B16A16_UNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_UNORM, 16},
    {DXGI_FORMAT_R8G8B8A8_SNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_SNORM, 8},
    {DXGI_FORMAT_R16G16B16A16_SNORM, GPU_TEXELS_NORMALS, GPU_NUMBERS_SNORM, 16},
    {DXGI_FORMAT_R16G16B16A16_FLOAT, GPU_TEXELS_NORMALS, GPU_NUMBERS_FLOAT, 11},
    {DXGI_FORMAT_R32G32B32_FLOAT, GPU_TEXELS_NORMALS, GPU_NUMBERS_FLOAT, 24},
    {DXGI_FORMAT_R32G32B32A32_FLOAT, GPU_TEXELS_NORMALS, GPU_NUMBERS_FLOAT, 24},
    {DXGI_FORMAT_R16G16_FLOAT, GPU_TEXELS_MOTION, GPU_NUMBERS_FLOAT, 11},
    {DXGI_FORMAT_R32G32_FLOAT, GPU_TEXELS_MOTION, GPU_NUMBERS_FLOAT, 24},
    {DXGI_FORMAT_R16G16B16A16_FLOAT, GPU_TEXELS_MOTION, GPU_NUMBERS_FLOAT, 11},
    {DXGI_FORMAT_R32G32B32A32_FLOAT, GPU_TEXELS_MOTION, GPU_NUMBERS_FLOAT, 24},
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

/* What is wrong with an image, or NULL. */
static const char *image_fault(const csm_d3d12_image *image, const D3D12_RESOURCE_DESC *resource) {
  if (resource->Dimension != D3D12_RESOURCE_DIMENSION_TEXTURE2D || resource->DepthOrArraySize != 1)
    return "resource is not a 2D texture of one layer";
  if (resource->SampleDesc.Count != 1)
    return "resource has several samples";
  if (resource->Flags & D3D12_RESOURCE_FLAG_DENY_SHADER_RESOURCE)
    return "resource denies shaders";
  if (!image->width || !image->height || image->width > resource->Width || image->height > resource->Height)
    return "width or height is not within the resource";
  return NULL;
}

csm_result d3d12_image_import(gpu_device *device, const void *native_image, gpu_texels texels, gpu_image **out,
                              gpu_imported *about) {
  *out = NULL;
  csm_d3d12_image native;
  const csm_result result = read_struct(device, "csm_d3d12_image", &native, sizeof native, native_image);
  if (result != CSM_SUCCESS)
    return result;
  if (!native.resource)
    return lent_fail(&device->lent, CSM_ERROR_NULL_POINTER, "csm_d3d12_image: resource is NULL");
  ID3D12Resource *resource = native.resource;
  const D3D12_RESOURCE_DESC description = ID3D12Resource_GetDesc(resource);
  const char *fault = image_fault(&native, &description);
  if (fault)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_d3d12_image: %s", fault);
  const texel_format *format = find_format(native.format, texels);
  if (!format)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_d3d12_image: format is none that holds %s",
                     texel_names[texels]);
  gpu_image *image = lent_allocate(&device->lent, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->borrowed = true;
  image->view_format = (DXGI_FORMAT)native.format;
  image->width = native.width;
  image->height = native.height;
  image->layer_count = image->level_count = 1;
  image->resource.handle = resource;
  ID3D12Resource_AddRef(resource);
  *about =
      (gpu_imported){.width = native.width, .height = native.height, .numbers = format->numbers, .bits = format->bits};
  *out = image;
  return CSM_SUCCESS;
}

/* ---- buffers ---- */

/* The greatest distance between vertices that an input layout may have. */
enum { LARGEST_STRIDE = 2048 };

static csm_result import_buffer(gpu_device *device, ID3D12Resource *resource, gpu_buffer **out) {
  gpu_buffer *buffer = lent_allocate(&device->lent, sizeof *buffer);
  *out = buffer;
  if (!buffer)
    return CSM_ERROR_OUT_OF_MEMORY;
  buffer->borrowed = true;
  buffer->resource.handle = resource;
  buffer->size = ID3D12Resource_GetDesc(resource).Width;
  buffer->address = ID3D12Resource_GetGPUVirtualAddress(resource);
  ID3D12Resource_AddRef(resource);
  return CSM_SUCCESS;
}

static const char *buffer_fault(ID3D12Resource *resource, uint64_t offset) {
  const D3D12_RESOURCE_DESC description = ID3D12Resource_GetDesc(resource);
  return description.Dimension != D3D12_RESOURCE_DIMENSION_BUFFER ? "a resource is not a buffer"
         : offset >= description.Width                            ? "an offset lies beyond its buffer"
         : offset % 4                                             ? "an offset is no multiple of 4"
                                                                  : NULL;
}

static csm_result check_mesh(const gpu_device *device, const csm_d3d12_mesh *native) {
  if (!native->vertices || !native->indices)
    return lent_fail(&device->lent, CSM_ERROR_NULL_POINTER, "csm_d3d12_mesh: %s is NULL",
                     native->vertices ? "indices" : "vertices");
  if (native->vertex_stride < 12 || native->vertex_stride % 4 || native->vertex_stride > LARGEST_STRIDE)
    return lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE,
                     "csm_d3d12_mesh: vertex_stride is no multiple of 4 from 12 to 2048");
  const char *fault = buffer_fault(native->vertices, native->vertex_offset);
  if (!fault)
    fault = buffer_fault(native->indices, native->index_offset);
  if (!fault && native->index_offset > UINT32_MAX)
    fault = "index_offset lies beyond 4 GiB";
  if (!fault && native->reserved)
    fault = "reserved is not 0";
  return fault ? lent_fail(&device->lent, CSM_ERROR_INVALID_VALUE, "csm_d3d12_mesh: %s", fault) : CSM_SUCCESS;
}

csm_result d3d12_geometry_import(gpu_device *device, const void *native_mesh, gpu_geometry *out) {
  *out = (gpu_geometry){0};
  csm_d3d12_mesh native;
  csm_result result = read_struct(device, "csm_d3d12_mesh", &native, sizeof native, native_mesh);
  if (result != CSM_SUCCESS)
    return result;
  result = check_mesh(device, &native);
  if (result != CSM_SUCCESS)
    return result;
  result = import_buffer(device, native.vertices, &out->vertices);
  if (result == CSM_SUCCESS && native.indices != native.vertices)
    result = import_buffer(device, native.indices, &out->indices);
  if (result != CSM_SUCCESS) {
    d3d12_buffer_destroy(device, out->vertices);
    *out = (gpu_geometry){0};
    return result;
  }
  if (!out->indices)
    out->indices = out->vertices;
  out->vertex_offset = native.vertex_offset;
  out->index_offset = native.index_offset;
  out->vertex_stride = native.vertex_stride;
  out->uv_offset = native.uv_offset;
  out->uv_stride = native.uv_stride;
  out->largest_stride = LARGEST_STRIDE;
  out->vertices_size = ID3D12Resource_GetDesc((ID3D12Resource *)native.vertices).Width;
  return CSM_SUCCESS;
}
