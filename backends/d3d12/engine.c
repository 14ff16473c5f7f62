/* engine.c: what an engine gives: its device, its images, its buffers. Each is held by a reference of csm's own. */
#include "csm/csm_d3d12.h"
#include "../structs.h"
#include "d3d12.h"
#include <string.h>

/* ---- the device ---- */

void d3d12_requirements(gpu_device_info *out) {
  static const char *const run_time[] = {"an ID3D12Device of the process's libvkd3d.so.1",
                                         "its D3D12SerializeRootSignature", NULL};
  out->required = (gpu_needs){.others = run_time, .feature_level = D3D_FEATURE_LEVEL_11_0};
}

static bool has_feature_level(ID3D12Device *device) {
  const D3D_FEATURE_LEVEL levels[] = {D3D_FEATURE_LEVEL_11_0};
  D3D12_FEATURE_DATA_FEATURE_LEVELS data = {.NumFeatureLevels = 1, .pFeatureLevelsRequested = levels};
  return SUCCEEDED(ID3D12Device_CheckFeatureSupport(device, D3D12_FEATURE_FEATURE_LEVELS, &data, sizeof data)) &&
         data.MaxSupportedFeatureLevel == D3D_FEATURE_LEVEL_11_0;
}

/* What Direct3D 12 tells, which is neither a name nor how much memory there is. */
static void describe(ID3D12Device *device, gpu_device_info *out) {
  D3D12_FEATURE_DATA_ARCHITECTURE architecture = {0};
  D3D12_FEATURE_DATA_GPU_VIRTUAL_ADDRESS_SUPPORT addresses = {0};
  HRESULT hr = ID3D12Device_CheckFeatureSupport(device, D3D12_FEATURE_ARCHITECTURE, &architecture, sizeof architecture);
  *out = (gpu_device_info){
      .type = FAILED(hr)         ? CSM_DEVICE_OTHER
              : architecture.UMA ? CSM_DEVICE_INTEGRATED
                                 : CSM_DEVICE_DISCRETE,
      .max_image_size = D3D12_REQ_TEXTURE2D_U_OR_V_DIMENSION,
      .max_image_layers = D3D12_REQ_TEXTURE2D_ARRAY_AXIS_DIMENSION,
      .max_allocation_size = UINT64_MAX,
      .memory_size = UINT64_MAX,
      .name = "the engine's device",
      .driver = "Direct3D 12",
  };
  hr =
      ID3D12Device_CheckFeatureSupport(device, D3D12_FEATURE_GPU_VIRTUAL_ADDRESS_SUPPORT, &addresses, sizeof addresses);
  const UINT bits = addresses.MaxGPUVirtualAddressBitsPerResource;
  if (SUCCEEDED(hr) && bits && bits < 64)
    out->max_allocation_size = (uint64_t)1 << bits;
  out->max_buffer_size = out->max_allocation_size;
  d3d12_requirements(out);
}

csm_result d3d12_engine_open(const gpu_open_info *info, ID3D12Device **device, d3d12_serializer *serialize,
                             gpu_device_info *out) {
  csm_d3d12_device given;
  const csm_result result = struct_read(&given, sizeof given, info->native);
  if (result != CSM_SUCCESS)
    return d3d12_refuse(info, result, "csm_d3d12_device: struct_size is wrong");
  if (given.reserved)
    return d3d12_refuse(info, CSM_ERROR_INVALID_VALUE, "csm_d3d12_device: reserved is not 0");
  if (!given.device || !given.serialize_root_signature)
    return d3d12_refuse(info, CSM_ERROR_NULL_POINTER, "csm_d3d12_device: %s is NULL",
                        given.device ? "serialize_root_signature" : "device");
  if (!has_feature_level(given.device))
    return d3d12_refuse(info, CSM_ERROR_UNSUPPORTED, "csm_d3d12_device: the device has no feature level 11_0");
  *device = given.device;
  ID3D12Device_AddRef(*device);
  *(void **)serialize = given.serialize_root_signature;
  describe(*device, out);
  return CSM_SUCCESS;
}

HRESULT d3d12_engine_tick_rate(ID3D12Device *device, uint64_t *ticks_per_second) {
  const D3D12_COMMAND_QUEUE_DESC description = {.Type = D3D12_COMMAND_LIST_TYPE_DIRECT};
  ID3D12CommandQueue *queue;
  HRESULT hr = ID3D12Device_CreateCommandQueue(device, &description, &IID_ID3D12CommandQueue, (void **)&queue);
  if (FAILED(hr))
    return hr;
  hr = ID3D12CommandQueue_GetTimestampFrequency(queue, ticks_per_second);
  ID3D12CommandQueue_Release(queue);
  return hr;
}

/* ---- images ---- */

typedef enum texels { TEXELS_REFUSED, TEXELS_FLOAT, TEXELS_UNORM } texels;

/* What a shader reads from an image that holds a depth or a normal, seen in a format. */
static texels texels_of(uint32_t format) {
  switch (format) {
  case DXGI_FORMAT_R32_FLOAT:
  case DXGI_FORMAT_R32_FLOAT_X8X24_TYPELESS:
  case DXGI_FORMAT_R16_FLOAT:
  case DXGI_FORMAT_R32G32B32A32_FLOAT:
  case DXGI_FORMAT_R32G32B32_FLOAT:
  case DXGI_FORMAT_R16G16B16A16_FLOAT:
  case DXGI_FORMAT_R16G16B16A16_SNORM:
  case DXGI_FORMAT_R8G8B8A8_SNORM:
    return TEXELS_FLOAT;
  case DXGI_FORMAT_R24_UNORM_X8_TYPELESS:
  case DXGI_FORMAT_R16_UNORM:
  case DXGI_FORMAT_R16G16B16A16_UNORM:
  case DXGI_FORMAT_R10G10B10A2_UNORM:
  case DXGI_FORMAT_R8G8B8A8_UNORM:
  case DXGI_FORMAT_B8G8R8A8_UNORM:
  case DXGI_FORMAT_B8G8R8X8_UNORM:
    return TEXELS_UNORM;
  default:
    return TEXELS_REFUSED;
  }
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
  if (texels_of(image->format) == TEXELS_REFUSED)
    return "format is not one that depth or normals are read in";
  return NULL;
}

static csm_result refuse(const gpu_device *device, csm_result result, const char *name, const char *fault) {
  d3d12_log(&device->host, CSM_LOG_ERROR, "d3d12: %s: %s", name, fault);
  return result;
}

csm_result d3d12_image_import(gpu_device *device, const void *native, gpu_image **out, gpu_imported *about) {
  static const char name[] = "csm_d3d12_image";
  csm_d3d12_image given;
  *out = NULL;
  const csm_result result = struct_read(&given, sizeof given, native);
  if (result != CSM_SUCCESS)
    return refuse(device, result, name, "struct_size is wrong");
  if (!given.resource)
    return refuse(device, CSM_ERROR_NULL_POINTER, name, "resource is NULL");
  ID3D12Resource *resource = given.resource;
  const D3D12_RESOURCE_DESC description = ID3D12Resource_GetDesc(resource);
  const char *fault = image_fault(&given, &description);
  if (fault)
    return refuse(device, CSM_ERROR_INVALID_VALUE, name, fault);
  gpu_image *image = d3d12_new(&device->host, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->info = (gpu_image_info){.usage = GPU_IMAGE_SAMPLED, .width = given.width, .height = given.height, .layers = 1};
  image->view_format = (DXGI_FORMAT)given.format;
  image->resource = (d3d12_resource){.handle = resource, .state = D3D12_STATE_READABLE, .rest = D3D12_STATE_READABLE};
  ID3D12Resource_AddRef(resource);
  *about =
      (gpu_imported){.width = given.width, .height = given.height, .unorm = texels_of(given.format) == TEXELS_UNORM};
  *out = image;
  return CSM_SUCCESS;
}

/* ---- buffers ---- */

/* The greatest distance between vertices that an input layout may have. */
enum { LARGEST_STRIDE = 2048 };

static csm_result import_buffer(gpu_device *device, ID3D12Resource *resource, gpu_buffer **out) {
  gpu_buffer *buffer = d3d12_new(&device->host, sizeof *buffer);
  *out = buffer;
  if (!buffer)
    return CSM_ERROR_OUT_OF_MEMORY;
  buffer->imported = true;
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

csm_result d3d12_geometry_import(gpu_device *device, const void *native, gpu_geometry *out) {
  static const char name[] = "csm_d3d12_mesh";
  csm_d3d12_mesh given;
  csm_result result = struct_read(&given, sizeof given, native);
  *out = (gpu_geometry){0};
  if (result != CSM_SUCCESS)
    return refuse(device, result, name, "struct_size is wrong");
  if (!given.vertices || !given.indices)
    return refuse(device, CSM_ERROR_NULL_POINTER, name, given.vertices ? "indices is NULL" : "vertices is NULL");
  if (given.vertex_stride < 12 || given.vertex_stride % 4 || given.vertex_stride > LARGEST_STRIDE)
    return refuse(device, CSM_ERROR_INVALID_VALUE, name, "vertex_stride is no multiple of 4 from 12 to 2048");
  const char *fault = buffer_fault(given.vertices, given.vertex_offset);
  if (!fault)
    fault = buffer_fault(given.indices, given.index_offset);
  if (fault)
    return refuse(device, CSM_ERROR_INVALID_VALUE, name, fault);
  result = import_buffer(device, given.vertices, &out->vertices);
  if (result == CSM_SUCCESS && given.indices != given.vertices)
    result = import_buffer(device, given.indices, &out->indices);
  if (result != CSM_SUCCESS) {
    d3d12_buffer_destroy(device, out->vertices);
    *out = (gpu_geometry){0};
    return result;
  }
  if (!out->indices)
    out->indices = out->vertices;
  out->vertex_offset = given.vertex_offset;
  out->index_offset = given.index_offset;
  out->vertex_stride = given.vertex_stride;
  out->uv_offset = given.uv_offset;
  out->uv_stride = given.uv_stride;
  return CSM_SUCCESS;
}
