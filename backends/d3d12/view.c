/* view.c: parts of images as shaders see them, and the targets that draws go into. */
#include "internal.h"

/* ---- ranges ---- */

gpu_range d3d12_range(const gpu_image *image, const gpu_range *range) {
  gpu_range out = range ? *range : (gpu_range){0};
  if (!out.layer_count)
    out.layer_count = image->layer_count - out.first_layer;
  if (!out.level_count)
    out.level_count = image->level_count - out.first_level;
  return out;
}

/* ---- what shaders read and write ---- */

void d3d12_view_read(gpu_device *device, const gpu_view *view, D3D12_CPU_DESCRIPTOR_HANDLE descriptor) {
  const gpu_range *range = &view->range;
  D3D12_SHADER_RESOURCE_VIEW_DESC description = {.Format = view->image->view_format,
                                                 .Shader4ComponentMapping = D3D12_DEFAULT_SHADER_4_COMPONENT_MAPPING};
  if (view->array) {
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
  if (view->array) {
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
  const gpu_view whole = {.image = (gpu_image *)image, .range = d3d12_range(image, NULL), .array = image->array};
  d3d12_view_read(device, &whole, (D3D12_CPU_DESCRIPTOR_HANDLE){.ptr = (SIZE_T)descriptor});
}

csm_result d3d12_view_create(gpu_device *device, const gpu_view_info *info, gpu_view **out) {
  *out = d3d12_allocate(device, sizeof **out);
  if (!*out)
    return CSM_ERROR_OUT_OF_MEMORY;
  **out = (gpu_view){.image = info->image, .range = d3d12_range(info->image, &info->range), .array = info->array};
  return CSM_SUCCESS;
}

void d3d12_view_destroy(gpu_device *device, gpu_view *view) {
  d3d12_release(device, view);
}

/* ---- what draws and clears write ---- */

static csm_result heap_create(gpu_device *device, D3D12_DESCRIPTOR_HEAP_TYPE type, uint32_t count,
                              ID3D12DescriptorHeap **out) {
  const D3D12_DESCRIPTOR_HEAP_DESC description = {.Type = type, .NumDescriptors = count};
  return d3d12_check(
      device, ID3D12Device_CreateDescriptorHeap(device->handle, &description, &IID_ID3D12DescriptorHeap, (void **)out),
      "CreateDescriptorHeap");
}

D3D12_CPU_DESCRIPTOR_HANDLE d3d12_depth_view(gpu_device *device, ID3D12DescriptorHeap *heap, uint32_t index) {
  const UINT size = ID3D12Device_GetDescriptorHandleIncrementSize(device->handle, D3D12_DESCRIPTOR_HEAP_TYPE_DSV);
  const SIZE_T start = ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(heap).ptr;
  return (D3D12_CPU_DESCRIPTOR_HANDLE){.ptr = start + (SIZE_T)index * size};
}

csm_result d3d12_depth_views_create(gpu_device *device, const gpu_image *image, gpu_range range,
                                    ID3D12DescriptorHeap **out) {
  const csm_result result = heap_create(device, D3D12_DESCRIPTOR_HEAP_TYPE_DSV, range.level_count, out);
  for (uint32_t i = 0; result == CSM_SUCCESS && i < range.level_count; i++) {
    const D3D12_DEPTH_STENCIL_VIEW_DESC view = {.Format = d3d12_format(image->format),
                                                .ViewDimension = D3D12_DSV_DIMENSION_TEXTURE2DARRAY,
                                                .Texture2DArray = {.MipSlice = range.first_level + i,
                                                                   .FirstArraySlice = range.first_layer,
                                                                   .ArraySize = range.layer_count}};
    ID3D12Device_CreateDepthStencilView(device->handle, image->resource.handle, &view,
                                        d3d12_depth_view(device, *out, i));
  }
  return result;
}

static csm_result color_view_create(gpu_device *device, const gpu_image *image, gpu_range range,
                                    ID3D12DescriptorHeap **out) {
  const D3D12_RENDER_TARGET_VIEW_DESC view = {.Format = d3d12_format(image->format),
                                              .ViewDimension = D3D12_RTV_DIMENSION_TEXTURE2DARRAY,
                                              .Texture2DArray = {.MipSlice = range.first_level,
                                                                 .FirstArraySlice = range.first_layer,
                                                                 .ArraySize = range.layer_count}};
  const csm_result result = heap_create(device, D3D12_DESCRIPTOR_HEAP_TYPE_RTV, 1, out);
  if (result == CSM_SUCCESS)
    ID3D12Device_CreateRenderTargetView(device->handle, image->resource.handle, &view,
                                        ID3D12DescriptorHeap_GetCPUDescriptorHandleForHeapStart(*out));
  return result;
}

csm_result d3d12_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out) {
  *out = NULL;
  gpu_target *target = d3d12_allocate(device, sizeof *target);
  if (!target)
    return CSM_ERROR_OUT_OF_MEMORY;
  target->depth = info->depth;
  target->depth_range = (gpu_range){info->depth_layer, 1, info->depth_level, 1};
  target->color = info->color;
  target->color_range = (gpu_range){info->color_layer, 1, info->color_level, 1};
  const gpu_image *image = info->depth ? info->depth : info->color;
  const uint32_t level = info->depth ? info->depth_level : info->color_level;
  target->width = gpu_level_size(image->width, level);
  target->height = gpu_level_size(image->height, level);

  csm_result result = CSM_SUCCESS;
  if (info->depth)
    result = d3d12_depth_views_create(device, info->depth, target->depth_range, &target->depth_heap);
  if (info->color && result == CSM_SUCCESS)
    result = color_view_create(device, info->color, target->color_range, &target->color_heap);
  if (result == CSM_SUCCESS)
    *out = target;
  else
    d3d12_target_destroy(device, target);
  return result;
}

void d3d12_target_destroy(gpu_device *device, gpu_target *target) {
  if (!target)
    return;
  d3d12_unref(target->depth_heap);
  d3d12_unref(target->color_heap);
  d3d12_release(device, target);
}

csm_result d3d12_target_native(gpu_device *device, gpu_format depth, gpu_format color, gpu_native_target *out) {
  (void)device;
  *out = (gpu_native_target){.depth_format = d3d12_format(depth), .color_format = d3d12_format(color)};
  return CSM_SUCCESS;
}
