/* backend.c: the table and the one symbol that the library exports. */
#define INITGUID /* this file holds the interface ids that the headers declare */
#include "internal.h"

static const gpu_backend backend = {
    .name = "d3d12",
    .api = GPU_API_D3D12,
    .query = d3d12_query,
    .open = d3d12_open,
    .close = d3d12_close,
    .describe = d3d12_describe,
    .buffer_create = d3d12_buffer_create,
    .buffer_destroy = d3d12_buffer_destroy,
    .buffer_memory = d3d12_buffer_memory,
    .buffer_native = d3d12_buffer_native,
    .image_create = d3d12_image_create,
    .image_destroy = d3d12_image_destroy,
    .image_bytes = d3d12_image_bytes,
    .image_native = d3d12_image_native,
    .image_describe = d3d12_image_describe,
    .image_import = d3d12_image_import,
    .geometry_import = d3d12_geometry_import,
    .view_create = d3d12_view_create,
    .view_destroy = d3d12_view_destroy,
    .target_create = d3d12_target_create,
    .target_destroy = d3d12_target_destroy,
    .target_native = d3d12_target_native,
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
    .make_readable = d3d12_make_readable,
    .dispatch = d3d12_dispatch,
    .pass_begin = d3d12_pass_begin,
    .pass_area = d3d12_pass_area,
    .pass_end = d3d12_pass_end,
    .pass_program = d3d12_pass_program,
    .pass_bind = d3d12_pass_bind,
    .pass_draw = d3d12_pass_draw,
    .pass_native = d3d12_pass_native,
    .end = d3d12_end,
    .wait = d3d12_wait,
    .timestamps = d3d12_timestamps,
};

CSM_API void csm_backend_handshake(gpu_handshake *handshake);

CSM_API void csm_backend_handshake(gpu_handshake *handshake) {
  const bool common =
      handshake->front_oldest <= GPU_INTERFACE_VERSION && GPU_INTERFACE_VERSION <= handshake->front_newest;
  handshake->backend_oldest = GPU_INTERFACE_VERSION;
  handshake->backend_newest = GPU_INTERFACE_VERSION;
  handshake->backend = common ? &backend : NULL;
}
