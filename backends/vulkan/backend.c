/* backend.c: the table and the one symbol that the library exports. */
#include "internal.h"

static const gpu_backend backend = {
    .name = "vulkan",
    .api = GPU_API_VULKAN,
    .query = vulkan_query,
    .open = vulkan_open,
    .close = vulkan_close,
    .describe = vulkan_describe,
    .buffer_create = vulkan_buffer_create,
    .buffer_destroy = vulkan_buffer_destroy,
    .buffer_memory = vulkan_buffer_memory,
    .buffer_native = vulkan_buffer_native,
    .image_create = vulkan_image_create,
    .image_destroy = vulkan_image_destroy,
    .image_bytes = vulkan_image_bytes,
    .image_native = vulkan_image_native,
    .image_describe = vulkan_image_describe,
    .image_import = vulkan_image_import,
    .geometry_import = vulkan_geometry_import,
    .view_create = vulkan_view_create,
    .view_destroy = vulkan_view_destroy,
    .target_create = vulkan_target_create,
    .target_destroy = vulkan_target_destroy,
    .target_native = vulkan_target_native,
    .program_create = vulkan_program_create,
    .program_destroy = vulkan_program_destroy,
    .bindings_create = vulkan_bindings_create,
    .bindings_write = vulkan_bindings_write,
    .bindings_destroy = vulkan_bindings_destroy,
    .memory_available = vulkan_memory_available,
    .begin = vulkan_begin,
    .marker_begin = vulkan_marker_begin,
    .marker_end = vulkan_marker_end,
    .timestamp = vulkan_timestamp,
    .copy_buffer = vulkan_copy_buffer,
    .copy_image = vulkan_copy_image,
    .copy_to_image = vulkan_copy_to_image,
    .clear_depth = vulkan_clear_depth,
    .make_readable = vulkan_make_readable,
    .dispatch = vulkan_dispatch,
    .pass_begin = vulkan_pass_begin,
    .pass_area = vulkan_pass_area,
    .pass_end = vulkan_pass_end,
    .pass_program = vulkan_pass_program,
    .pass_bind = vulkan_pass_bind,
    .pass_draw = vulkan_pass_draw,
    .pass_native = vulkan_pass_native,
    .end = vulkan_end,
    .wait = vulkan_wait,
    .timestamps = vulkan_timestamps,
};

CSM_API void csm_backend_handshake(gpu_handshake *handshake);

CSM_API void csm_backend_handshake(gpu_handshake *handshake) {
  const bool common =
      handshake->front_oldest <= GPU_INTERFACE_VERSION && GPU_INTERFACE_VERSION <= handshake->front_newest;
  handshake->backend_oldest = GPU_INTERFACE_VERSION;
  handshake->backend_newest = GPU_INTERFACE_VERSION;
  handshake->backend = common ? &backend : NULL;
}
