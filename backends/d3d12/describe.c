/* describe.c: what a device is, as far as Direct3D 12 tells. */
#include "internal.h"

bool d3d12_has_feature_level(ID3D12Device *handle) {
  const D3D_FEATURE_LEVEL levels[] = {D3D_FEATURE_LEVEL_11_0};
  D3D12_FEATURE_DATA_FEATURE_LEVELS data = {.NumFeatureLevels = 1, .pFeatureLevelsRequested = levels};
  return SUCCEEDED(ID3D12Device_CheckFeatureSupport(handle, D3D12_FEATURE_FEATURE_LEVELS, &data, sizeof data)) &&
         data.MaxSupportedFeatureLevel == D3D_FEATURE_LEVEL_11_0;
}

/* ---- capabilities ---- */

/* A view of a buffer holds 2^27 elements at most, and run times take them for 4 bytes each. */
void d3d12_describe_level(gpu_capabilities *out) {
  *out = (gpu_capabilities){
      .max_anisotropy = GPU_MAX_ANISOTROPY,
      .max_storage_size = (uint64_t)4 << 27,
      .compute = true,
      .indirect = true,
      .pixel_stores = true,
      .bias_clamp = true,
      .timestamps = true,
  };
}

static uint32_t format_can(ID3D12Device *handle, gpu_format format, bool loads_more) {
  D3D12_FEATURE_DATA_FORMAT_SUPPORT support = {.Format = d3d12_format(format)};
  if (FAILED(ID3D12Device_CheckFeatureSupport(handle, D3D12_FEATURE_FORMAT_SUPPORT, &support, sizeof support)))
    return 0;
  const bool single = format == GPU_FORMAT_R32_FLOAT || format == GPU_FORMAT_R32_UINT;
  const bool stores = support.Support1 & D3D12_FORMAT_SUPPORT1_TYPED_UNORDERED_ACCESS_VIEW;
  const bool loads = single || (loads_more && support.Support2 & D3D12_FORMAT_SUPPORT2_UAV_TYPED_LOAD);
  uint32_t can = 0;
  if (support.Support1 & (D3D12_FORMAT_SUPPORT1_SHADER_LOAD | D3D12_FORMAT_SUPPORT1_SHADER_SAMPLE))
    can |= GPU_CAN_SAMPLE;
  if (support.Support1 & D3D12_FORMAT_SUPPORT1_SHADER_SAMPLE)
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

static void describe_capabilities(ID3D12Device *handle, gpu_capabilities *out) {
  D3D12_FEATURE_DATA_D3D12_OPTIONS options = {0};
  ID3D12Device_CheckFeatureSupport(handle, D3D12_FEATURE_D3D12_OPTIONS, &options, sizeof options);
  d3d12_describe_level(out);
  for (gpu_format format = GPU_FORMAT_NONE + 1; format < GPU_FORMAT_COUNT; format++)
    out->formats[format] = format_can(handle, format, options.TypedUAVLoadAdditionalFormats);
}

/* ---- description ---- */

/* Direct3D 12 tells neither a device's name nor how much memory it has. */
void d3d12_describe_handle(gpu_device *device) {
  D3D12_FEATURE_DATA_ARCHITECTURE architecture = {0};
  D3D12_FEATURE_DATA_GPU_VIRTUAL_ADDRESS_SUPPORT addresses = {0};
  HRESULT hr =
      ID3D12Device_CheckFeatureSupport(device->handle, D3D12_FEATURE_ARCHITECTURE, &architecture, sizeof architecture);
  const uint32_t type = FAILED(hr) ? GPU_DEVICE_OTHER : architecture.UMA ? GPU_DEVICE_INTEGRATED : GPU_DEVICE_DISCRETE;
  hr = ID3D12Device_CheckFeatureSupport(device->handle, D3D12_FEATURE_GPU_VIRTUAL_ADDRESS_SUPPORT, &addresses,
                                        sizeof addresses);
  const UINT bits = addresses.MaxGPUVirtualAddressBitsPerResource;
  const uint64_t largest = SUCCEEDED(hr) && bits && bits < 64 ? (uint64_t)1 << bits : UINT64_MAX;
  device->info = (gpu_device_info){.type = type,
                                   .max_image_size = D3D12_REQ_TEXTURE2D_U_OR_V_DIMENSION,
                                   .max_image_layers = D3D12_REQ_TEXTURE2D_ARRAY_AXIS_DIMENSION,
                                   .max_buffer_size = largest,
                                   .max_allocation_size = largest,
                                   .memory_size = UINT64_MAX,
                                   .name = "the engine's device",
                                   .driver = "Direct3D 12"};
  describe_capabilities(device->handle, &device->info.can);
}

void d3d12_describe(const gpu_device *device, gpu_device_info *out) {
  *out = device->info;
}

/* ---- the budget ---- */

uint64_t d3d12_memory_available(gpu_device *device) {
  return device->own ? d3d12_runtime_memory_available(device->runtime) : UINT64_MAX;
}
