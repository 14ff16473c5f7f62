/* resource.c: buffers, images, and views of them. */
#include "internal.h"

#include <string.h>

/* ---- buffers ---- */

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

/* The state that a buffer begins in; those of upload and readback heaps stay in it. */
static D3D12_RESOURCE_STATES first_state(gpu_buffer_kind kind) {
  switch (kind) {
  case GPU_BUFFER_UPLOAD:
    return D3D12_RESOURCE_STATE_GENERIC_READ;
  case GPU_BUFFER_READBACK:
    return D3D12_RESOURCE_STATE_COPY_DEST;
  case GPU_BUFFER_DEVICE:
    break;
  }
  return D3D12_RESOURCE_STATE_COMMON;
}

static D3D12_RESOURCE_STATES readable_state(uint32_t usage) {
  D3D12_RESOURCE_STATES state = D3D12_RESOURCE_STATE_VERTEX_AND_CONSTANT_BUFFER | D3D12_RESOURCE_STATE_INDEX_BUFFER;
  if (usage & GPU_BUFFER_READ)
    state |= D3D12_STATE_READABLE;
  if (usage & GPU_BUFFER_INDIRECT)
    state |= D3D12_RESOURCE_STATE_INDIRECT_ARGUMENT;
  return state;
}

csm_result d3d12_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out) {
  *out = NULL;
  gpu_buffer *buffer = lent_allocate(&device->lent, sizeof *buffer);
  if (!buffer)
    return CSM_ERROR_OUT_OF_MEMORY;
  buffer->kind = info->kind;
  buffer->size = info->size;
  buffer->state = first_state(info->kind);
  buffer->readable = readable_state(info->usage);

  const D3D12_RESOURCE_DESC description = {
      .Dimension = D3D12_RESOURCE_DIMENSION_BUFFER,
      .Width = info->size,
      .Height = 1,
      .DepthOrArraySize = 1,
      .MipLevels = 1,
      .SampleDesc = {.Count = 1},
      .Layout = D3D12_TEXTURE_LAYOUT_ROW_MAJOR,
      .Flags = info->usage & GPU_BUFFER_WRITE ? D3D12_RESOURCE_FLAG_ALLOW_UNORDERED_ACCESS : D3D12_RESOURCE_FLAG_NONE};
  csm_result result =
      d3d12_resource_create(device, heap_type(info->kind), &description, buffer->state, info->name, &buffer->resource);
  if (result == CSM_SUCCESS && info->kind != GPU_BUFFER_DEVICE)
    result = d3d12_check(device, ID3D12Resource_Map(buffer->resource.handle, 0, NULL, &buffer->mapped), "Map");
  if (result != CSM_SUCCESS) {
    d3d12_buffer_destroy(device, buffer);
    return result;
  }
  buffer->address = ID3D12Resource_GetGPUVirtualAddress(buffer->resource.handle);
  *out = buffer;
  return CSM_SUCCESS;
}

void d3d12_buffer_destroy(gpu_device *device, gpu_buffer *buffer) {
  if (!buffer)
    return;
  d3d12_resource_destroy(device, &buffer->resource);
  lent_release(&device->lent, buffer);
}

void *d3d12_buffer_memory(gpu_buffer *buffer) {
  return buffer->mapped;
}

uint64_t d3d12_buffer_native(const gpu_buffer *buffer) {
  return (uint64_t)(uintptr_t)buffer->resource.handle;
}

/* ---- images ---- */

static D3D12_RESOURCE_FLAGS image_flags(const gpu_image_info *info) {
  D3D12_RESOURCE_FLAGS flags = D3D12_RESOURCE_FLAG_NONE;
  if (gpu_format_is_depth(info->format))
    flags |= D3D12_RESOURCE_FLAG_ALLOW_DEPTH_STENCIL;
  else if (info->usage & GPU_IMAGE_TARGET)
    flags |= D3D12_RESOURCE_FLAG_ALLOW_RENDER_TARGET;
  if (info->usage & GPU_IMAGE_STORED)
    flags |= D3D12_RESOURCE_FLAG_ALLOW_UNORDERED_ACCESS;
  return flags;
}

/* An image begins in COMMON, so its first use is a barrier. With that vkd3d moves it out of Vulkan's undefined layout,
   which it does not when a descriptor reads or writes it. */
csm_result d3d12_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out) {
  *out = NULL;
  const uint32_t levels = info->levels ? info->levels : 1;
  const size_t count = (size_t)info->layers * levels;
  gpu_image *image = lent_allocate(&device->lent, sizeof *image + 2 * count * sizeof *image->states);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  image->format = info->format;
  image->view_format = d3d12_view_format(info->format);
  image->sampled = info->usage & GPU_IMAGE_SAMPLED;
  image->array = info->array || info->layers > 1;
  image->width = info->width;
  image->height = info->height;
  image->layer_count = info->layers;
  image->level_count = levels;
  image->before = image->states + count;

  const D3D12_RESOURCE_DESC description = {.Dimension = D3D12_RESOURCE_DIMENSION_TEXTURE2D,
                                           .Width = info->width,
                                           .Height = info->height,
                                           .DepthOrArraySize = (UINT16)info->layers,
                                           .MipLevels = (UINT16)levels,
                                           .Format = d3d12_resource_format(info->format),
                                           .SampleDesc = {.Count = 1},
                                           .Flags = image_flags(info)};
  csm_result result = d3d12_resource_create(device, D3D12_HEAP_TYPE_DEFAULT, &description, D3D12_RESOURCE_STATE_COMMON,
                                            info->name, &image->resource);
  if (result == CSM_SUCCESS && gpu_format_is_depth(info->format))
    result = d3d12_depth_views_create(device, image, d3d12_range(image, NULL), &image->clear_heap);
  if (result == CSM_SUCCESS)
    *out = image;
  else
    d3d12_image_destroy(device, image);
  return result;
}

void d3d12_image_destroy(gpu_device *device, gpu_image *image) {
  if (!image)
    return;
  d3d12_unref(image->clear_heap);
  d3d12_resource_destroy(device, &image->resource);
  lent_release(&device->lent, image);
}

uint64_t d3d12_image_bytes(const gpu_image *image) {
  return image->resource.bytes;
}

void d3d12_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out) {
  (void)device;
  *out = (gpu_native_image){.image = (uint64_t)(uintptr_t)image->resource.handle};
}

/* ---- views ---- */

gpu_range d3d12_range(const gpu_image *image, const gpu_range *range) {
  gpu_range out = range ? *range : (gpu_range){0};
  if (!out.layer_count)
    out.layer_count = image->layer_count - out.first_layer;
  if (!out.level_count)
    out.level_count = image->level_count - out.first_level;
  return out;
}

void d3d12_view_read(gpu_device *device, const gpu_view *view, D3D12_CPU_DESCRIPTOR_HANDLE descriptor) {
  const gpu_range *range = &view->range;
  D3D12_SHADER_RESOURCE_VIEW_DESC description = {.Format = view->image->view_format,
                                                 .Shader4ComponentMapping = D3D12_DEFAULT_SHADER_4_COMPONENT_MAPPING};
  if (view->image->array) {
    description.ViewDimension = D3D12_SRV_DIMENSION_TEXTURE2DARRAY;
    description.Texture2DArray = (D3D12_TEX2D_ARRAY_SRV){.MostDetailedMip = range->first_level,
                                                         .MipLevels = range->level_count,
                                                         .FirstArraySlice = range->first_layer,
                                                         .ArraySize = range->layer_count};
  } else {
    description.ViewDimension = D3D12_SRV_DIMENSION_TEXTURE2D;
    description.Texture2D = (D3D12_TEX2D_SRV){.MostDetailedMip = range->first_level, .MipLevels = range->level_count};
  }
  ID3D12Device_CreateShaderResourceView(device->handle, view->image->resource.handle, &description, descriptor);
}

void d3d12_view_store(gpu_device *device, const gpu_view *view, D3D12_CPU_DESCRIPTOR_HANDLE descriptor) {
  const gpu_range *range = &view->range;
  D3D12_UNORDERED_ACCESS_VIEW_DESC description = {.Format = view->image->view_format};
  if (view->image->array) {
    description.ViewDimension = D3D12_UAV_DIMENSION_TEXTURE2DARRAY;
    description.Texture2DArray = (D3D12_TEX2D_ARRAY_UAV){
        .MipSlice = range->first_level, .FirstArraySlice = range->first_layer, .ArraySize = range->layer_count};
  } else {
    description.ViewDimension = D3D12_UAV_DIMENSION_TEXTURE2D;
    description.Texture2D = (D3D12_TEX2D_UAV){.MipSlice = range->first_level};
  }
  ID3D12Device_CreateUnorderedAccessView(device->handle, view->image->resource.handle, NULL, &description, descriptor);
}

void d3d12_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor) {
  const gpu_view whole = {.image = (gpu_image *)image, .range = d3d12_range(image, NULL)};
  d3d12_view_read(device, &whole, (D3D12_CPU_DESCRIPTOR_HANDLE){.ptr = (SIZE_T)descriptor});
}

csm_result d3d12_view_create(gpu_device *device, const gpu_view_info *info, gpu_view **out) {
  *out = lent_allocate(&device->lent, sizeof **out);
  if (!*out)
    return CSM_ERROR_OUT_OF_MEMORY;
  **out = (gpu_view){.image = info->image, .range = d3d12_range(info->image, &info->range)};
  return CSM_SUCCESS;
}

void d3d12_view_destroy(gpu_device *device, gpu_view *view) {
  lent_release(&device->lent, view);
}

/* ---- what clears depths by copies ---- */

csm_result d3d12_fill_create(gpu_device *device) {
  const gpu_buffer_info info = {
      .name = "csm fill", .kind = GPU_BUFFER_UPLOAD, .size = D3D12_FILL_PARTS * D3D12_FILL_SIZE};
  const csm_result result = d3d12_buffer_create(device, &info, &device->fill);
  if (result != CSM_SUCCESS)
    return result;
  unsigned char *bytes = device->fill->mapped;
  float *ones = (float *)(bytes + D3D12_FILL_ONE_D32 * D3D12_FILL_SIZE);
  memset(bytes + D3D12_FILL_ZERO * D3D12_FILL_SIZE, 0, D3D12_FILL_SIZE);
  for (uint32_t i = 0; i < D3D12_FILL_SIZE / sizeof *ones; i++)
    ones[i] = 1;
  memset(bytes + D3D12_FILL_ONE_D16 * D3D12_FILL_SIZE, 0xff, D3D12_FILL_SIZE);
  return CSM_SUCCESS;
}
