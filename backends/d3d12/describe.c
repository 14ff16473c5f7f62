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
      .max_texels_size = (uint64_t)GPU_TEXEL_SIZE << 27,
      .max_buffers = GPU_MAX_BUFFERS + GPU_MAX_STORES,
      .compute = true,
      .indirect = true,
      .pixel_stores = true,
      .bias_clamp = true,
      .timestamps = true,
  };
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
  d3d12_describe_level(&device->info.can);
  d3d12_describe_formats(device);
}

void d3d12_describe(const gpu_device *device, gpu_device_info *out) {
  *out = device->info;
}

/* ---- the budget ---- */

uint64_t d3d12_memory_available(gpu_device *device) {
  return device->own ? d3d12_runtime_memory_available(device->runtime) : UINT64_MAX;
}
