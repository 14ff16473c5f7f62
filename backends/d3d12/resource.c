/*
 * resource.c: buffers, images and targets. Every resource is committed, which takes one allocation of the driver's
 * each: the front makes few and large ones (pages of geometry, a ring per slot, arrays of maps).
 */
#include "internal.h"

#include <string.h>

static HRESULT create_view_heap(gpu_device *device, D3D12_DESCRIPTOR_HEAP_TYPE type, ID3D12DescriptorHeap **out) {
  const D3D12_DESCRIPTOR_HEAP_DESC heap = {.Type = type, .NumDescriptors = 1};
  return ID3D12Device_CreateDescriptorHeap(device->handle, &heap, &IID_ID3D12DescriptorHeap, (void **)out);
}

/* A depth view of `layer_count` layers from `layer` on, in a heap of its own. */
static HRESULT create_depth_view(gpu_device *device, gpu_image *image, uint32_t layer, uint32_t layer_count,
                                 ID3D12DescriptorHeap **out) {
  const D3D12_DEPTH_STENCIL_VIEW_DESC view = {
      .Format = d3d12_format(image->info.format),
      .ViewDimension = D3D12_DSV_DIMENSION_TEXTURE2DARRAY,
      .Texture2DArray = {.FirstArraySlice = layer, .ArraySize = layer_count},
  };
  const HRESULT hr = create_view_heap(device, D3D12_DESCRIPTOR_HEAP_TYPE_DSV, out);
  if (SUCCEEDED(hr))
    ID3D12Device_CreateDepthStencilView(device->handle, image->resource.handle, &view,
                                        ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(*out));
  return hr;
}

static HRESULT create_color_view(gpu_device *device, gpu_image *image, uint32_t layer, ID3D12DescriptorHeap **out) {
  const D3D12_RENDER_TARGET_VIEW_DESC view = {
      .Format = d3d12_format(image->info.format),
      .ViewDimension = D3D12_RTV_DIMENSION_TEXTURE2DARRAY,
      .Texture2DArray = {.FirstArraySlice = layer, .ArraySize = 1},
  };
  const HRESULT hr = create_view_heap(device, D3D12_DESCRIPTOR_HEAP_TYPE_RTV, out);
  if (SUCCEEDED(hr))
    ID3D12Device_CreateRenderTargetView(device->handle, image->resource.handle, &view,
                                        ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(*out));
  return hr;
}

/* The state that a buffer of each heap begins in; those of upload and readback heaps stay in it. */
static D3D12_RESOURCE_STATES heap_state(D3D12_HEAP_TYPE heap) {
  switch (heap) {
  case D3D12_HEAP_TYPE_UPLOAD:
    return D3D12_RESOURCE_STATE_GENERIC_READ;
  case D3D12_HEAP_TYPE_READBACK:
    return D3D12_RESOURCE_STATE_COPY_DEST;
  default:
    return D3D12_RESOURCE_STATE_COMMON;
  }
}

HRESULT d3d12_commit_buffer(ID3D12Device *device, D3D12_HEAP_TYPE heap, uint64_t size, ID3D12Resource **out) {
  const D3D12_HEAP_PROPERTIES properties = {.Type = heap};
  const D3D12_RESOURCE_DESC resource = {
      .Dimension = D3D12_RESOURCE_DIMENSION_BUFFER,
      .Width = size,
      .Height = 1,
      .DepthOrArraySize = 1,
      .MipLevels = 1,
      .SampleDesc = {.Count = 1},
      .Layout = D3D12_TEXTURE_LAYOUT_ROW_MAJOR,
  };
  return ID3D12Device_CreateCommittedResource(device, &properties, D3D12_HEAP_FLAG_NONE, &resource, heap_state(heap),
                                              NULL, &IID_ID3D12Resource, (void **)out);
}

static D3D12_HEAP_TYPE heap_type(gpu_buffer_kind kind) {
  switch (kind) {
  case GPU_BUFFER_UPLOAD:
    return D3D12_HEAP_TYPE_UPLOAD;
  case GPU_BUFFER_READBACK:
    return D3D12_HEAP_TYPE_READBACK;
  case GPU_BUFFER_DEVICE:
    break;
  }
  return D3D12_HEAP_TYPE_DEFAULT;
}

csm_result d3d12_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out) {
  *out = NULL;
  gpu_buffer *buffer = d3d12_allocate(device, sizeof *buffer);
  if (!buffer)
    return CSM_ERROR_OUT_OF_MEMORY;
  const D3D12_HEAP_TYPE heap = heap_type(info->kind);
  buffer->kind = info->kind;
  buffer->size = info->size;
  buffer->resource.state = heap_state(heap);
  buffer->resource.rest = heap_state(heap);
  HRESULT hr = d3d12_commit_buffer(device->handle, heap, info->size, &buffer->resource.handle);
  if (SUCCEEDED(hr) && info->kind != GPU_BUFFER_DEVICE)
    hr = ID3D12Resource_Map(buffer->resource.handle, 0, NULL, &buffer->memory);
  if (FAILED(hr)) {
    d3d12_buffer_destroy(device, buffer);
    return d3d12_check(device, hr, "making a buffer");
  }
  buffer->address = ID3D12Resource_GetGPUVirtualAddress(buffer->resource.handle);
  d3d12_name(buffer->resource.handle, info->name);
  *out = buffer;
  return CSM_SUCCESS;
}

void d3d12_buffer_destroy(gpu_device *device, gpu_buffer *buffer) {
  if (!buffer)
    return;
  d3d12_unref(buffer->resource.handle);
  d3d12_release(device, buffer);
}

void *d3d12_buffer_memory(gpu_buffer *buffer) {
  return buffer->memory;
}

static HRESULT commit_image(gpu_device *device, gpu_image *image) {
  const gpu_image_info *info = &image->info;
  const bool depth = gpu_format_is_depth(info->format);
  const D3D12_HEAP_PROPERTIES heap = {.Type = D3D12_HEAP_TYPE_DEFAULT};
  const D3D12_RESOURCE_DESC resource = {
      .Dimension = D3D12_RESOURCE_DIMENSION_TEXTURE2D,
      .Width = info->width,
      .Height = info->height,
      .DepthOrArraySize = (UINT16)info->layers,
      .MipLevels = 1,
      .Format = d3d12_resource_format(info->format),
      .SampleDesc = {.Count = 1},
      .Flags = depth ? D3D12_RESOURCE_FLAG_ALLOW_DEPTH_STENCIL : D3D12_RESOURCE_FLAG_ALLOW_RENDER_TARGET,
  };
  /* The state of the first use, a clear or a pass: vkd3d moves an image out of Vulkan's undefined layout only when it
     is used so, not when a descriptor reads it. */
  image->resource.state = depth ? D3D12_RESOURCE_STATE_DEPTH_WRITE : D3D12_RESOURCE_STATE_RENDER_TARGET;
  image->resource.rest = info->usage & GPU_IMAGE_SAMPLED ? D3D12_STATE_READABLE : image->resource.state;
  image->view_format = d3d12_view_format(info->format);
  const D3D12_RESOURCE_ALLOCATION_INFO allocation =
      ID3D12Device_GetResourceAllocationInfo(device->handle, 0, 1, &resource);
  image->bytes = allocation.SizeInBytes;
  HRESULT hr = ID3D12Device_CreateCommittedResource(device->handle, &heap, D3D12_HEAP_FLAG_NONE, &resource,
                                                    image->resource.state, NULL, &IID_ID3D12Resource,
                                                    (void **)&image->resource.handle);
  if (SUCCEEDED(hr) && depth)
    hr = create_depth_view(device, image, 0, info->layers, &image->clear_heap);
  return hr;
}

csm_result d3d12_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out) {
  *out = NULL;
  gpu_image *image = d3d12_allocate(device, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->info = *info;
  const HRESULT hr = commit_image(device, image);
  if (FAILED(hr)) {
    d3d12_image_destroy(device, image);
    return d3d12_check(device, hr, "making an image");
  }
  d3d12_name(image->resource.handle, info->name);
  *out = image;
  return CSM_SUCCESS;
}

void d3d12_image_destroy(gpu_device *device, gpu_image *image) {
  if (!image)
    return;
  d3d12_unref(image->clear_heap);
  d3d12_unref(image->resource.handle);
  d3d12_release(device, image);
}

uint64_t d3d12_image_bytes(const gpu_image *image) {
  return image->bytes;
}

void d3d12_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out) {
  (void)device;
  *out = (gpu_native_image){.image = (uint64_t)(uintptr_t)image->resource.handle};
}

void d3d12_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor) {
  D3D12_SHADER_RESOURCE_VIEW_DESC view = {
      .Format = image->view_format,
      .Shader4ComponentMapping = D3D12_DEFAULT_SHADER_4_COMPONENT_MAPPING,
  };
  if (image->info.array) {
    view.ViewDimension = D3D12_SRV_DIMENSION_TEXTURE2DARRAY;
    view.Texture2DArray = (D3D12_TEX2D_ARRAY_SRV){.MipLevels = 1, .ArraySize = image->info.layers};
  } else {
    view.ViewDimension = D3D12_SRV_DIMENSION_TEXTURE2D;
    view.Texture2D = (D3D12_TEX2D_SRV){.MipLevels = 1};
  }
  ID3D12Device_CreateShaderResourceView(device->handle, image->resource.handle, &view,
                                        (D3D12_CPU_DESCRIPTOR_HANDLE){.ptr = (SIZE_T)descriptor});
}

csm_result d3d12_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out) {
  *out = NULL;
  gpu_target *target = d3d12_allocate(device, sizeof *target);
  if (!target)
    return CSM_ERROR_OUT_OF_MEMORY;
  const gpu_image_info *size = info->depth ? &info->depth->info : &info->color->info;
  target->depth = info->depth;
  target->color = info->color;
  target->width = size->width;
  target->height = size->height;
  HRESULT hr = S_OK;
  if (info->depth)
    hr = create_depth_view(device, info->depth, info->depth_layer, 1, &target->depth_heap);
  if (info->color && SUCCEEDED(hr))
    hr = create_color_view(device, info->color, info->color_layer, &target->color_heap);
  if (FAILED(hr)) {
    d3d12_target_destroy(device, target);
    return d3d12_check(device, hr, "making a target");
  }
  *out = target;
  return CSM_SUCCESS;
}

void d3d12_target_destroy(gpu_device *device, gpu_target *target) {
  if (!target)
    return;
  d3d12_unref(target->depth_heap);
  d3d12_unref(target->color_heap);
  d3d12_release(device, target);
}

/* ---- what clears by copies ---- */

csm_result d3d12_fill_create(gpu_device *device) {
  void *memory = NULL;
  HRESULT hr =
      d3d12_commit_buffer(device->handle, D3D12_HEAP_TYPE_UPLOAD, D3D12_FILL_PARTS * D3D12_FILL_SIZE, &device->fill);
  if (SUCCEEDED(hr))
    hr = ID3D12Resource_Map(device->fill, 0, NULL, &memory);
  if (FAILED(hr))
    return d3d12_check(device, hr, "CreateCommittedResource");
  unsigned char *bytes = memory;
  float *ones = (float *)(bytes + D3D12_FILL_ONE_D32 * D3D12_FILL_SIZE);
  memset(bytes + D3D12_FILL_ZERO * D3D12_FILL_SIZE, 0, D3D12_FILL_SIZE);
  for (uint32_t i = 0; i < D3D12_FILL_SIZE / sizeof *ones; i++)
    ones[i] = 1;
  memset(bytes + D3D12_FILL_ONE_D16 * D3D12_FILL_SIZE, 0xff, D3D12_FILL_SIZE);
  ID3D12Resource_Unmap(device->fill, 0, NULL);
  return CSM_SUCCESS;
}
