/* device.c: a device that own.c opened or engine.c took; errors and names. */
#include "internal.h"

/* ---- errors and names ---- */

static csm_result result_of(HRESULT hr) {
  switch ((uint32_t)hr) {
  case 0x8007000eu: /* E_OUTOFMEMORY: vkd3d says so for either memory; the device's is the one that runs out */
    return CSM_ERROR_OUT_OF_DEVICE_MEMORY;
  case 0x887a0005u: /* DXGI_ERROR_DEVICE_REMOVED */
  case 0x887a0006u: /* DXGI_ERROR_DEVICE_HUNG */
  case 0x887a0007u: /* DXGI_ERROR_DEVICE_RESET */
  case 0x887a0020u: /* DXGI_ERROR_DRIVER_INTERNAL_ERROR */
    return CSM_ERROR_DEVICE_LOST;
  default:
    return CSM_ERROR_DEVICE;
  }
}

csm_result d3d12_check(const gpu_device *device, HRESULT hr, const char *function) {
  if (SUCCEEDED(hr))
    return CSM_SUCCESS;
  const bool lost = FAILED(ID3D12Device_GetDeviceRemovedReason(device->handle));
  return lent_fail(&device->lent, lost ? CSM_ERROR_DEVICE_LOST : result_of(hr), "%s: HRESULT 0x%08x%s", function,
                   (uint32_t)hr, lost ? ", the device is lost" : "");
}

void d3d12_name(void *object, const char *name) {
  WCHAR wide[64];
  size_t length = 0;
  if (!name)
    return;
  for (; name[length] && length + 1 < sizeof wide / sizeof *wide; length++)
    wide[length] = (unsigned char)name[length] < 128 ? (WCHAR)name[length] : (WCHAR)'?';
  wide[length] = 0;
  ID3D12Object_SetName((ID3D12Object *)object, wide);
}

void d3d12_unref(void *object) {
  if (object)
    IUnknown_Release((IUnknown *)object);
}

/* ---- opening and closing ---- */

static csm_result device_new(const gpu_open_info *info, gpu_device **out) {
  const gpu_lent lent = lent_begin(info);
  gpu_device *device = lent_allocate(&lent, sizeof *device);
  if (!device)
    return CSM_ERROR_OUT_OF_MEMORY;
  *device =
      (gpu_device){.lent = lent, .slot_count = info->slots, .own = !info->native, .traits = d3d12_runtime_traits()};
  *out = device;
  return CSM_SUCCESS;
}

/* Makes everything that recordings need. */
static csm_result device_use(gpu_device *device) {
  csm_result result = d3d12_descriptors_create(device);
  if (result == CSM_SUCCESS)
    result = d3d12_command_signatures_create(device);
  if (result == CSM_SUCCESS)
    result = d3d12_queries_create(device);
  for (uint32_t i = 0; result == CSM_SUCCESS && i < device->slot_count; i++)
    result = d3d12_slot_create(device, &device->slots[i]);
  if (result == CSM_SUCCESS && device->info.type == GPU_DEVICE_CPU && device->traits->partial_depth_copies)
    result = d3d12_fill_create(device);
  return result;
}

static csm_result select_and_describe(gpu_device *device, const gpu_open_info *info) {
  const csm_result result = device->own ? d3d12_own_select(device, info) : d3d12_engine_take(device, info->native);
  device->info.required = device->traits->required;
  device->info.optional = device->traits->optional;
  return result;
}

csm_result d3d12_query(const gpu_open_info *info, gpu_device_info *out) {
  gpu_device *device = NULL;
  csm_result result = device_new(info, &device);
  if (result != CSM_SUCCESS)
    return result;
  result = select_and_describe(device, info);
  if (result == CSM_SUCCESS)
    *out = device->info;
  d3d12_close(device);
  return result;
}

csm_result d3d12_open(const gpu_open_info *info, gpu_device **out) {
  *out = NULL;
  gpu_device *device = NULL;
  csm_result result = device_new(info, &device);
  if (result != CSM_SUCCESS)
    return result;
  result = select_and_describe(device, info);
  if (result == CSM_SUCCESS && device->own)
    result = d3d12_own_open(device);
  if (result == CSM_SUCCESS)
    result = device_use(device);
  device->lent.error = NULL;
  if (result == CSM_SUCCESS)
    *out = device;
  else
    d3d12_close(device);
  return result;
}

void d3d12_close(gpu_device *device) {
  for (uint32_t i = 0; device->fence && i < device->slot_count; i++)
    if (d3d12_wait(device, i) != CSM_SUCCESS)
      break; /* a lost device runs nothing any more */
  for (uint32_t i = 0; i < device->slot_count; i++)
    d3d12_slot_destroy(&device->slots[i]);
  d3d12_buffer_destroy(device, device->fill);
  d3d12_buffer_destroy(device, device->query_results);
  d3d12_unref(device->queries);
  for (uint32_t i = 0; i < D3D12_COMMANDS; i++)
    d3d12_unref(device->command_signatures[i]);
  d3d12_descriptors_destroy(device);
  if (device->own)
    d3d12_own_close(device);
  else
    d3d12_unref(device->handle);
  const gpu_lent lent = device->lent;
  lent_release(&lent, device);
}
