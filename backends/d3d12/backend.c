/* backend.c: the backend's table and its handshake, and what all its files use: results, texts, memory, names. */
#define INITGUID /* this file holds the interface ids that the headers declare */
#include "d3d12.h"
#include <stdio.h>
#include <string.h>

csm_result d3d12_refuse(const gpu_open_info *info, csm_result result, const char *format, ...) {
  if (info->error && info->error_size) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(info->error, info->error_size, format, arguments);
    va_end(arguments);
  }
  return result;
}

void d3d12_log(const gpu_host *host, int32_t level, const char *format, ...) {
  char text[1024];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  host->log(host->user, level, text);
}

csm_result d3d12_result(HRESULT hr) {
  if (SUCCEEDED(hr))
    return CSM_SUCCESS;
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

csm_result d3d12_check(const gpu_device *device, HRESULT hr, const char *what) {
  if (SUCCEEDED(hr))
    return CSM_SUCCESS;
  const bool removed = FAILED(ID3D12Device_GetDeviceRemovedReason(device->device));
  d3d12_log(&device->host, CSM_LOG_ERROR, "d3d12: %s failed: HRESULT 0x%08x%s", what, (uint32_t)hr,
            removed ? ", the device is lost" : "");
  return removed ? CSM_ERROR_DEVICE_LOST : d3d12_result(hr);
}

void *d3d12_new(const gpu_host *host, size_t size) {
  void *memory = host->allocate(host->user, size, 16);
  if (memory)
    memset(memory, 0, size);
  return memory;
}

void d3d12_name(ID3D12Object *object, const char *name) {
  WCHAR wide[64];
  size_t length = 0;
  if (!name)
    return;
  for (; name[length] && length + 1 < sizeof wide / sizeof *wide; ++length)
    wide[length] = (unsigned char)name[length] < 128 ? (WCHAR)name[length] : (WCHAR)'?';
  wide[length] = 0;
  ID3D12Object_SetName(object, wide);
}

static const gpu_backend backend = {
    .name = "d3d12",
    .query = d3d12_query,
    .open = d3d12_open,
    .close = d3d12_close,
    .describe = d3d12_describe,
    .buffer_create = d3d12_buffer_create,
    .buffer_destroy = d3d12_buffer_destroy,
    .buffer_memory = d3d12_buffer_memory,
    .image_create = d3d12_image_create,
    .image_destroy = d3d12_image_destroy,
    .image_bytes = d3d12_image_bytes,
    .image_native = d3d12_image_native,
    .image_describe = d3d12_image_describe,
    .image_import = d3d12_image_import,
    .geometry_import = d3d12_geometry_import,
    .target_create = d3d12_target_create,
    .target_destroy = d3d12_target_destroy,
    .program_create = d3d12_program_create,
    .program_destroy = d3d12_program_destroy,
    .bindings_create = d3d12_bindings_create,
    .bindings_write = d3d12_bindings_write,
    .bindings_destroy = d3d12_bindings_destroy,
    .memory_available = d3d12_memory_available,
    .begin = d3d12_begin,
    .marker_begin = d3d12_marker_begin,
    .marker_end = d3d12_marker_end,
    .timestamp = d3d12_timestamp,
    .copy_buffer = d3d12_copy_buffer,
    .copy_image = d3d12_copy_image,
    .copy_to_image = d3d12_copy_to_image,
    .clear_depth = d3d12_clear_depth,
    .pass_begin = d3d12_pass_begin,
    .pass_area = d3d12_pass_area,
    .pass_end = d3d12_pass_end,
    .pass_program = d3d12_pass_program,
    .pass_bind = d3d12_pass_bind,
    .pass_draw = d3d12_pass_draw,
    .pass_native = d3d12_pass_native,
    .make_readable = d3d12_make_readable,
    .end = d3d12_end,
    .wait = d3d12_wait,
    .timestamps = d3d12_timestamps,
};

CSM_API void csm_backend_handshake(gpu_handshake *handshake);

/* The one export: see gpu_handshake. */
CSM_API void csm_backend_handshake(gpu_handshake *handshake) {
  handshake->backend_oldest = GPU_INTERFACE_VERSION;
  handshake->backend_newest = GPU_INTERFACE_VERSION;
  const bool common =
      handshake->front_oldest <= GPU_INTERFACE_VERSION && GPU_INTERFACE_VERSION <= handshake->front_newest;
  handshake->backend = common ? &backend : NULL;
}
