/* backend.c: the device, the table, and the one symbol that the library exports. */
#include "null.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* ---- helpers ---- */

void null_record(gpu_device *device, const char *format, ...) {
  char line[256];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  device->host.log(device->host.user, CSM_LOG_TRACE, line);
}

bool null_require(gpu_device *device, bool kept, const char *rule) {
  if (!kept)
    device->host.log(device->host.user, CSM_LOG_ERROR, rule);
  return kept;
}

void null_use_now(const gpu_device *device, null_used *used) {
  *used = device->serial;
}

void null_require_unused(gpu_device *device, null_used used, const char *rule) {
  bool in_use = used && device->recording && used == device->serial;
  for (uint32_t i = 0; i < device->slot_count; i++)
    in_use |= used && used == device->slots[i].in_flight;
  null_require(device, !in_use, rule);
}

void *null_make(gpu_device *device, size_t size) {
  void *memory = device->host.allocate(device->host.user, size, 64);
  if (memory)
    memset(memory, 0, size);
  return memory;
}

void null_release(gpu_device *device, void *object) {
  if (object)
    device->host.release(device->host.user, object);
}

void null_set_name(char to[NULL_NAME_SIZE], const char *name) {
  snprintf(to, NULL_NAME_SIZE, "%s", name ? name : "");
}

/* ---- the device ---- */

/* It can whatever gpu.h has words for. */
static uint32_t format_can(gpu_format format) {
  if (gpu_format_is_depth(format))
    return GPU_CAN_SAMPLE | GPU_CAN_DRAW;
  if (format == GPU_FORMAT_NONE || format == GPU_FORMAT_RGB32_FLOAT)
    return 0;
  if (format == GPU_FORMAT_R32_UINT)
    return GPU_CAN_SAMPLE | GPU_CAN_DRAW | GPU_CAN_STORE | GPU_CAN_LOAD | GPU_CAN_ATOMIC;
  return GPU_CAN_SAMPLE | GPU_CAN_FILTER | GPU_CAN_DRAW | GPU_CAN_STORE | GPU_CAN_LOAD;
}

void null_describe(const gpu_device *device, gpu_device_info *out) {
  (void)device;
  *out = (gpu_device_info){.max_image_size = 16384,
                           .max_image_layers = 2048,
                           .max_buffer_size = 1ull << 32,
                           .max_allocation_size = 1ull << 32,
                           .memory_size = 1ull << 32,
                           .name = "null",
                           .driver = "null",
                           .can = {.max_anisotropy = GPU_MAX_ANISOTROPY,
                                   .max_texels_size = 1ull << 32,
                                   .max_buffers = GPU_MAX_BUFFERS + GPU_MAX_STORES,
                                   .compute = true,
                                   .indirect = true,
                                   .pixel_stores = true,
                                   .bias_clamp = true,
                                   .timestamps = true}};
  for (gpu_format format = GPU_FORMAT_NONE; format < GPU_FORMAT_COUNT; format++)
    out->can.formats[format] = format_can(format);
}

static csm_result null_query(const gpu_open_info *info, gpu_device_info *out) {
  (void)info;
  null_describe(NULL, out);
  return CSM_SUCCESS;
}

static csm_result null_open(const gpu_open_info *info, gpu_device **out) {
  *out = NULL;
  const char *refusal = NULL;
  if (info->native)
    refusal = "the null backend opens no engine's device";
  else if (info->device_name && !strstr("null", info->device_name))
    refusal = "the null backend has one device, named null";
  if (refusal) {
    if (info->error)
      snprintf(info->error, info->error_size, "%s", refusal);
    return info->native ? CSM_ERROR_UNSUPPORTED : CSM_ERROR_NO_DEVICE;
  }
  gpu_device *device = info->host->allocate(info->host->user, sizeof *device, 64);
  if (!device)
    return CSM_ERROR_OUT_OF_MEMORY;
  *device = (gpu_device){.host = *info->host, .slot_count = info->slots};
  *out = device;
  return CSM_SUCCESS;
}

static void null_close(gpu_device *device) {
  const gpu_host host = device->host;
  host.release(host.user, device);
}

static uint64_t null_memory_available(gpu_device *device) {
  (void)device;
  return UINT64_MAX;
}

/* ---- the table ---- */

static const gpu_backend table = {
    .name = "null",
    .api = GPU_API_NULL,
    .query = null_query,
    .open = null_open,
    .close = null_close,
    .describe = null_describe,
    .buffer_create = null_buffer_create,
    .buffer_destroy = null_buffer_destroy,
    .buffer_memory = null_buffer_memory,
    .buffer_native = null_buffer_native,
    .image_create = null_image_create,
    .image_destroy = null_image_destroy,
    .image_bytes = null_image_bytes,
    .image_native = null_image_native,
    .image_describe = null_image_describe,
    .image_import = null_image_import,
    .geometry_import = null_geometry_import,
    .view_create = null_view_create,
    .view_destroy = null_view_destroy,
    .target_create = null_target_create,
    .target_destroy = null_target_destroy,
    .target_native = null_target_native,
    .program_create = null_program_create,
    .program_destroy = null_program_destroy,
    .bindings_create = null_bindings_create,
    .bindings_write = null_bindings_write,
    .bindings_destroy = null_bindings_destroy,
    .memory_available = null_memory_available,
    .begin = null_begin,
    .marker_begin = null_marker_begin,
    .marker_end = null_marker_end,
    .timestamp = null_timestamp,
    .copy_buffer = null_copy_buffer,
    .copy_image = null_copy_image,
    .copy_to_image = null_copy_to_image,
    .clear_depth = null_clear_depth,
    .make_readable = null_make_readable,
    .dispatch = null_dispatch,
    .pass_begin = null_pass_begin,
    .pass_area = null_pass_area,
    .pass_end = null_pass_end,
    .pass_program = null_pass_program,
    .pass_bind = null_pass_bind,
    .pass_draw = null_pass_draw,
    .pass_native = null_pass_native,
    .end = null_end,
    .wait = null_wait,
    .timestamps = null_timestamps,
};

CSM_API void csm_backend_handshake(gpu_handshake *handshake);

CSM_API void csm_backend_handshake(gpu_handshake *handshake) {
  const bool common =
      handshake->front_oldest <= GPU_INTERFACE_VERSION && GPU_INTERFACE_VERSION <= handshake->front_newest;
  handshake->backend_oldest = GPU_INTERFACE_VERSION;
  handshake->backend_newest = GPU_INTERFACE_VERSION;
  handshake->backend = common ? &table : NULL;
}
