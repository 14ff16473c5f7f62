/* format.c: what formats are called, and what a device can do with them. */
#include "internal.h"

DXGI_FORMAT d3d12_format(gpu_format format) {
  static const DXGI_FORMAT formats[GPU_FORMAT_COUNT] = {
      [GPU_FORMAT_NONE] = DXGI_FORMAT_UNKNOWN,
      [GPU_FORMAT_D32_FLOAT] = DXGI_FORMAT_D32_FLOAT,
      [GPU_FORMAT_D16_UNORM] = DXGI_FORMAT_D16_UNORM,
      [GPU_FORMAT_R8_UNORM] = DXGI_FORMAT_R8_UNORM,
      [GPU_FORMAT_R16_UNORM] = DXGI_FORMAT_R16_UNORM,
      [GPU_FORMAT_RG16_UNORM] = DXGI_FORMAT_R16G16_UNORM,
      [GPU_FORMAT_R16_FLOAT] = DXGI_FORMAT_R16_FLOAT,
      [GPU_FORMAT_RG16_FLOAT] = DXGI_FORMAT_R16G16_FLOAT,
      [GPU_FORMAT_RGBA16_FLOAT] = DXGI_FORMAT_R16G16B16A16_FLOAT,
      [GPU_FORMAT_R32_FLOAT] = DXGI_FORMAT_R32_FLOAT,
      [GPU_FORMAT_RG32_FLOAT] = DXGI_FORMAT_R32G32_FLOAT,
      [GPU_FORMAT_RGB32_FLOAT] = DXGI_FORMAT_R32G32B32_FLOAT,
      [GPU_FORMAT_RGBA32_FLOAT] = DXGI_FORMAT_R32G32B32A32_FLOAT,
      [GPU_FORMAT_R32_UINT] = DXGI_FORMAT_R32_UINT,
  };
  return formats[format];
}

DXGI_FORMAT d3d12_resource_format(gpu_format format) {
  switch (format) {
  case GPU_FORMAT_D32_FLOAT:
    return DXGI_FORMAT_R32_TYPELESS;
  case GPU_FORMAT_D16_UNORM:
    return DXGI_FORMAT_R16_TYPELESS;
  default:
    return d3d12_format(format);
  }
}

DXGI_FORMAT d3d12_view_format(gpu_format format) {
  switch (format) {
  case GPU_FORMAT_D32_FLOAT:
    return DXGI_FORMAT_R32_FLOAT;
  case GPU_FORMAT_D16_UNORM:
    return DXGI_FORMAT_R16_UNORM;
  default:
    return d3d12_format(format);
  }
}

static uint32_t format_can(ID3D12Device *handle, gpu_format format, bool loads_more) {
  D3D12_FEATURE_DATA_FORMAT_SUPPORT support = {.Format = d3d12_format(format)};
  if (FAILED(ID3D12Device_CheckFeatureSupport(handle, D3D12_FEATURE_FORMAT_SUPPORT, &support, sizeof support)))
    return 0;
  /* A depth is drawn in its own format, and read in its view's. */
  D3D12_FEATURE_DATA_FORMAT_SUPPORT read = {.Format = d3d12_view_format(format)};
  if (FAILED(ID3D12Device_CheckFeatureSupport(handle, D3D12_FEATURE_FORMAT_SUPPORT, &read, sizeof read)))
    return 0;
  const bool single = format == GPU_FORMAT_R32_FLOAT || format == GPU_FORMAT_R32_UINT;
  const bool stores = support.Support1 & D3D12_FORMAT_SUPPORT1_TYPED_UNORDERED_ACCESS_VIEW;
  const bool loads = single || (loads_more && support.Support2 & D3D12_FORMAT_SUPPORT2_UAV_TYPED_LOAD);
  uint32_t can = 0;
  if (read.Support1 & (D3D12_FORMAT_SUPPORT1_SHADER_LOAD | D3D12_FORMAT_SUPPORT1_SHADER_SAMPLE))
    can |= GPU_CAN_SAMPLE;
  if (read.Support1 & D3D12_FORMAT_SUPPORT1_SHADER_SAMPLE)
    can |= GPU_CAN_FILTER;
  if (support.Support1 & (D3D12_FORMAT_SUPPORT1_RENDER_TARGET | D3D12_FORMAT_SUPPORT1_DEPTH_STENCIL))
    can |= GPU_CAN_DRAW;
  if (stores)
    can |= GPU_CAN_STORE;
  if (stores && loads)
    can |= GPU_CAN_LOAD;
  if (stores && support.Support2 & D3D12_FORMAT_SUPPORT2_UAV_ATOMIC_ADD)
    can |= GPU_CAN_ATOMIC;
  return can;
}

void d3d12_describe_formats(gpu_device *device) {
  D3D12_FEATURE_DATA_D3D12_OPTIONS options = {0};
  ID3D12Device_CheckFeatureSupport(device->handle, D3D12_FEATURE_D3D12_OPTIONS, &options, sizeof options);
  for (gpu_format format = GPU_FORMAT_NONE + 1; format < GPU_FORMAT_COUNT; format++)
    if (format != GPU_FORMAT_RGB32_FLOAT)
      device->info.can.formats[format] = format_can(device->handle, format, options.TypedUAVLoadAdditionalFormats);
}
