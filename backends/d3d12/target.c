/* target.c: what draws go into, and what clears write. */
#include "internal.h"

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
  gpu_target *target = lent_allocate(&device->lent, sizeof *target);
  if (!target)
    return CSM_ERROR_OUT_OF_MEMORY;
  target->depth = (d3d12_attachment){.image = info->depth, .range = {info->depth_layer, 1, info->depth_level, 1}};
  target->color = (d3d12_attachment){.image = info->color, .range = {info->color_layer, 1, info->color_level, 1}};
  const gpu_image *image = info->depth ? info->depth : info->color;
  const uint32_t level = info->depth ? info->depth_level : info->color_level;
  target->width = gpu_level_size(image->width, level);
  target->height = gpu_level_size(image->height, level);

  csm_result result = CSM_SUCCESS;
  if (info->depth)
    result = d3d12_depth_views_create(device, info->depth, target->depth.range, &target->depth.heap);
  if (info->color && result == CSM_SUCCESS)
    result = color_view_create(device, info->color, target->color.range, &target->color.heap);
  if (result == CSM_SUCCESS)
    *out = target;
  else
    d3d12_target_destroy(device, target);
  return result;
}

void d3d12_target_destroy(gpu_device *device, gpu_target *target) {
  if (!target)
    return;
  d3d12_unref(target->depth.heap);
  d3d12_unref(target->color.heap);
  lent_release(&device->lent, target);
}

csm_result d3d12_target_native(gpu_device *device, gpu_format depth, gpu_format color, gpu_native_target *out) {
  (void)device;
  *out = (gpu_native_target){.depth_format = d3d12_format(depth), .color_format = d3d12_format(color)};
  return CSM_SUCCESS;
}
