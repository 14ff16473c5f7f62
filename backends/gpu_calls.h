/*
 * gpu_calls.h: the calls of gpu.h as functions, for callers with an opened device: gpu_buffer_create(g, ...) is
 * g.api->buffer_create(g.device, ...). What each does stands in gpu.h.
 */
#ifndef GPU_CALLS_H
#define GPU_CALLS_H

#include "gpu.h"
#include <fenv.h>

/*
 * Drivers, their compilers and the threads that they start compute as they like. Where a caller lets floating-point
 * exceptions trap, they run without: what opens, creates or waits sees to it here, and whoever records holds the
 * environment from gpu_begin to gpu_end, rather than anew for each draw.
 */
typedef struct gpu {
  const gpu_backend *api;
  gpu_device *device;
} gpu;

static inline csm_result gpu_query(const gpu_backend *api, const gpu_open_info *info, gpu_device_info *out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = api->query(info, out);
  fesetenv(&floats);
  return result;
}

static inline csm_result gpu_open(const gpu_backend *api, const gpu_open_info *info, gpu *out) {
  fenv_t floats;
  feholdexcept(&floats);
  out->api = api;
  const csm_result result = api->open(info, &out->device);
  fesetenv(&floats);
  return result;
}

static inline void gpu_close(gpu g) {
  fenv_t floats;
  feholdexcept(&floats);
  g.api->close(g.device);
  fesetenv(&floats);
}

static inline void gpu_describe(gpu g, gpu_device_info *out) {
  g.api->describe(g.device, out);
}

static inline csm_result gpu_buffer_create(gpu g, const gpu_buffer_info *info, gpu_buffer **out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->buffer_create(g.device, info, out);
  fesetenv(&floats);
  return result;
}

static inline void gpu_buffer_destroy(gpu g, gpu_buffer *buffer) {
  g.api->buffer_destroy(g.device, buffer);
}

static inline void *gpu_buffer_memory(gpu g, gpu_buffer *buffer) {
  return g.api->buffer_memory(buffer);
}

static inline uint64_t gpu_buffer_native(gpu g, const gpu_buffer *buffer) {
  return g.api->buffer_native(buffer);
}

static inline csm_result gpu_image_create(gpu g, const gpu_image_info *info, gpu_image **out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->image_create(g.device, info, out);
  fesetenv(&floats);
  return result;
}

static inline void gpu_image_destroy(gpu g, gpu_image *image) {
  g.api->image_destroy(g.device, image);
}

static inline uint64_t gpu_image_bytes(gpu g, const gpu_image *image) {
  return g.api->image_bytes(image);
}

static inline void gpu_image_native(gpu g, const gpu_image *image, gpu_native_image *out) {
  g.api->image_native(g.device, image, out);
}

static inline void gpu_image_describe(gpu g, const gpu_image *image, uint64_t descriptor) {
  g.api->image_describe(g.device, image, descriptor);
}

static inline csm_result gpu_image_import(gpu g, const void *native, gpu_texels texels, gpu_image **out,
                                          gpu_imported *about) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->image_import(g.device, native, texels, out, about);
  fesetenv(&floats);
  return result;
}

static inline csm_result gpu_geometry_import(gpu g, const void *native, gpu_geometry *out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->geometry_import(g.device, native, out);
  fesetenv(&floats);
  return result;
}

static inline csm_result gpu_view_create(gpu g, const gpu_view_info *info, gpu_view **out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->view_create(g.device, info, out);
  fesetenv(&floats);
  return result;
}

static inline void gpu_view_destroy(gpu g, gpu_view *view) {
  g.api->view_destroy(g.device, view);
}

static inline csm_result gpu_target_create(gpu g, const gpu_target_info *info, gpu_target **out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->target_create(g.device, info, out);
  fesetenv(&floats);
  return result;
}

static inline void gpu_target_destroy(gpu g, gpu_target *target) {
  g.api->target_destroy(g.device, target);
}

static inline csm_result gpu_target_native(gpu g, gpu_format depth, gpu_format color, gpu_native_target *out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->target_native(g.device, depth, color, out);
  fesetenv(&floats);
  return result;
}

static inline csm_result gpu_program_create(gpu g, const gpu_program_info *info, gpu_program **out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->program_create(g.device, info, out);
  fesetenv(&floats);
  return result;
}

static inline void gpu_program_destroy(gpu g, gpu_program *program) {
  g.api->program_destroy(g.device, program);
}

static inline csm_result gpu_bindings_create(gpu g, const gpu_bindings_info *info, gpu_bindings **out) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->bindings_create(g.device, info, out);
  fesetenv(&floats);
  return result;
}

static inline void gpu_bindings_write(gpu g, gpu_bindings *bindings, const gpu_bindings_info *info) {
  g.api->bindings_write(g.device, bindings, info);
}

static inline void gpu_bindings_destroy(gpu g, gpu_bindings *bindings) {
  g.api->bindings_destroy(g.device, bindings);
}

static inline uint64_t gpu_memory_available(gpu g) {
  return g.api->memory_available(g.device);
}

static inline csm_result gpu_begin(gpu g, const gpu_record_info *info) {
  return g.api->begin(g.device, info);
}

static inline void gpu_marker_begin(gpu g, const char *name) {
  g.api->marker_begin(g.device, name);
}

static inline void gpu_marker_end(gpu g) {
  g.api->marker_end(g.device);
}

static inline void gpu_timestamp(gpu g, uint32_t index) {
  g.api->timestamp(g.device, index);
}

static inline void gpu_copy_buffer(gpu g, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                                   uint64_t size) {
  g.api->copy_buffer(g.device, to, to_offset, from, from_offset, size);
}

static inline void gpu_copy_image(gpu g, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                                  const gpu_region *from) {
  g.api->copy_image(g.device, to, offset, row_bytes, image, from);
}

static inline void gpu_copy_to_image(gpu g, gpu_image *image, const gpu_region *to, gpu_buffer *from, uint64_t offset,
                                     uint32_t row_bytes) {
  g.api->copy_to_image(g.device, image, to, from, offset, row_bytes);
}

static inline void gpu_clear_depth(gpu g, gpu_image *image, float depth) {
  g.api->clear_depth(g.device, image, depth);
}

static inline void gpu_make_readable(gpu g, gpu_image *image, const gpu_range *range) {
  g.api->make_readable(g.device, image, range);
}

static inline void gpu_dispatch(gpu g, const gpu_dispatch_info *info) {
  g.api->dispatch(g.device, info);
}

static inline void gpu_pass_begin(gpu g, const gpu_pass_info *info) {
  g.api->pass_begin(g.device, info);
}

static inline void gpu_pass_area(gpu g, const gpu_rect *area) {
  g.api->pass_area(g.device, area);
}

static inline void gpu_pass_end(gpu g) {
  g.api->pass_end(g.device);
}

static inline void gpu_pass_program(gpu g, gpu_program *program) {
  g.api->pass_program(g.device, program);
}

static inline void gpu_pass_bind(gpu g, gpu_bindings *bindings, const uint32_t *offsets) {
  g.api->pass_bind(g.device, bindings, offsets);
}

static inline void gpu_pass_draw(gpu g, const gpu_draw *draw) {
  g.api->pass_draw(g.device, draw);
}

static inline void gpu_pass_native(gpu g, gpu_native_pass *out) {
  g.api->pass_native(g.device, out);
}

static inline csm_result gpu_end(gpu g) {
  return g.api->end(g.device);
}

static inline csm_result gpu_wait(gpu g, uint32_t slot) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->wait(g.device, slot);
  fesetenv(&floats);
  return result;
}

static inline csm_result gpu_timestamps(gpu g, uint32_t slot, uint32_t first, uint32_t count, uint64_t *nanoseconds) {
  fenv_t floats;
  feholdexcept(&floats);
  const csm_result result = g.api->timestamps(g.device, slot, first, count, nanoseconds);
  fesetenv(&floats);
  return result;
}

#endif
