/*
 * The null backend: draws nothing, and writes a line to the host's log for every command, at CSM_LOG_TRACE, so that
 * tests read what a frame records. Buffers are real memory. A breach of gpu.h's rules is logged at CSM_LOG_ERROR.
 */
#include "gpu.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { NAME_SIZE = 64, OFFSET_ALIGNMENT = 256, PLACEMENT_ALIGNMENT = 512 };

struct gpu_device {
  gpu_host host;
  bool engine;              /* any engine's device will do */
  const gpu_target *target; /* of the pass that is open, as is the program */
  const gpu_program *program;
  bool recording, in_pass, bound;
};

struct gpu_buffer {
  char name[NAME_SIZE];
  gpu_buffer_kind kind;
  uint64_t size;
  uint8_t *memory;
};

struct gpu_image {
  char name[NAME_SIZE];
  gpu_image_info info;
};

struct gpu_target {
  char name[NAME_SIZE];
  uint32_t width, height;
};

struct gpu_program {
  char name[NAME_SIZE];
  gpu_program_info info;
};

struct gpu_bindings {
  char name[NAME_SIZE];
  gpu_bindings_info info;
};

/* ---- helpers ---- */

static void record(gpu_device *device, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void record(gpu_device *device, const char *format, ...) {
  char line[256];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(line, sizeof line, format, arguments);
  va_end(arguments);
  device->host.log(device->host.user, CSM_LOG_TRACE, line);
}

static void require(gpu_device *device, bool kept, const char *rule) {
  if (!kept)
    device->host.log(device->host.user, CSM_LOG_ERROR, rule);
}

static void *make(gpu_device *device, size_t size) {
  void *memory = device->host.allocate(device->host.user, size, 64);
  if (memory)
    memset(memory, 0, size);
  return memory;
}

static void release(gpu_device *device, void *object) {
  if (object)
    device->host.release(device->host.user, object);
}

static void set_name(char to[NAME_SIZE], const char *name) {
  snprintf(to, NAME_SIZE, "%s", name ? name : "");
}

/* Whether a piece of an image's width or height lies in it, and is one. */
static bool spans(uint32_t size, uint32_t first, uint32_t count) {
  return count > 0 && first <= size && count <= size - first;
}

static bool holds(const gpu_buffer *buffer, uint64_t offset, uint64_t size) {
  return buffer && offset <= buffer->size && size <= buffer->size - offset;
}

/* ---- device ---- */

static void null_describe(const gpu_device *device, gpu_device_info *out) {
  (void)device;
  *out = (gpu_device_info){.max_image_size = 16384,
                           .max_image_layers = 2048,
                           .max_buffer_size = 1ull << 32,
                           .max_allocation_size = 1ull << 32,
                           .memory_size = 1ull << 32,
                           .name = "null",
                           .driver = "null"};
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
  *device = (gpu_device){.host = *info->host};
  *out = device;
  return CSM_SUCCESS;
}

static void null_close(gpu_device *device) {
  const gpu_host host = device->host;
  host.release(host.user, device);
}

/* ---- objects ---- */

static csm_result null_buffer_create(gpu_device *device, const gpu_buffer_info *info, gpu_buffer **out) {
  *out = NULL;
  gpu_buffer *buffer = make(device, sizeof *buffer);
  if (!buffer)
    return CSM_ERROR_OUT_OF_MEMORY;
  set_name(buffer->name, info->name);
  buffer->kind = info->kind;
  buffer->size = info->size;
  buffer->memory = make(device, info->size);
  if (!buffer->memory) {
    release(device, buffer);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  *out = buffer;
  return CSM_SUCCESS;
}

static void null_buffer_destroy(gpu_device *device, gpu_buffer *buffer) {
  if (buffer)
    release(device, buffer->memory);
  release(device, buffer);
}

static void *null_buffer_memory(gpu_buffer *buffer) {
  return buffer->kind == GPU_BUFFER_DEVICE ? NULL : buffer->memory;
}

static csm_result null_image_create(gpu_device *device, const gpu_image_info *info, gpu_image **out) {
  gpu_image *image = *out = make(device, sizeof *image);
  if (!image)
    return CSM_ERROR_OUT_OF_MEMORY;
  set_name(image->name, info->name);
  image->info = *info;
  return CSM_SUCCESS;
}

static void null_image_destroy(gpu_device *device, gpu_image *image) {
  release(device, image);
}

static uint64_t null_image_bytes(const gpu_image *image) {
  return (uint64_t)image->info.width * image->info.height * image->info.layers * gpu_format_bytes(image->info.format);
}

static void null_image_native(const gpu_device *device, const gpu_image *image, gpu_native_image *out) {
  (void)device;
  *out = (gpu_native_image){.image = (uintptr_t)image};
}

static void null_image_describe(gpu_device *device, const gpu_image *image, uint64_t descriptor) {
  record(device, "image_describe %s %llu", image->name, (unsigned long long)descriptor);
}

/* Never reached: there is no engine's device to import from. */
static csm_result null_image_import(gpu_device *device, const void *native, gpu_image **out, gpu_imported *about) {
  (void)native;
  require(device, false, "image_import: not on an engine's device");
  *out = NULL;
  *about = (gpu_imported){0};
  return CSM_ERROR_UNSUPPORTED;
}

static csm_result null_geometry_import(gpu_device *device, const void *native, gpu_geometry *out) {
  (void)native;
  require(device, false, "geometry_import: not on an engine's device");
  *out = (gpu_geometry){0};
  return CSM_ERROR_UNSUPPORTED;
}

static uint64_t null_memory_available(gpu_device *device) {
  (void)device;
  return UINT64_MAX;
}

static csm_result null_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out) {
  require(device, info->depth || info->color, "target_create: without an image");
  require(device, !info->depth || info->depth_layer < info->depth->info.layers, "target_create: no such depth layer");
  require(device, !info->color || info->color_layer < info->color->info.layers, "target_create: no such colour layer");
  require(device, !info->depth || gpu_format_is_depth(info->depth->info.format), "target_create: depth has no depths");
  require(device, !info->color || !gpu_format_is_depth(info->color->info.format), "target_create: colour has depths");
  gpu_target *target = *out = make(device, sizeof *target);
  if (!target)
    return CSM_ERROR_OUT_OF_MEMORY;
  const gpu_image_info *size = info->depth ? &info->depth->info : &info->color->info;
  set_name(target->name, info->name);
  target->width = size->width;
  target->height = size->height;
  return CSM_SUCCESS;
}

static void null_target_destroy(gpu_device *device, gpu_target *target) {
  release(device, target);
}

static void check_program(gpu_device *device, const gpu_program_info *info) {
  const gpu_raster_bias *bias = &info->raster_bias;
  require(device, info->vertex.spirv_size && info->vertex.dxbc_size, "program_create: no vertex shader");
  require(device, !info->pixel.spirv_size == !info->pixel.dxbc_size, "program_create: half a pixel shader");
  require(device, !info->depth_format || gpu_format_is_depth(info->depth_format), "program_create: no depth format");
  require(device, !gpu_format_is_depth(info->color_format), "program_create: no colour format");
  require(device, info->depth_format || !(bias->constant || bias->slope != 0),
          "program_create: a raster bias without depth");
  for (uint32_t i = 0; i < info->sampler_count; i++)
    require(device, info->samplers[i] <= GPU_SAMPLER_COMPARE_GREATER_EQUAL, "program_create: no such sampler");
}

static csm_result null_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out) {
  check_program(device, info);
  gpu_program *program = *out = make(device, sizeof *program);
  if (!program)
    return CSM_ERROR_OUT_OF_MEMORY;
  set_name(program->name, info->name);
  program->info = *info;
  return CSM_SUCCESS;
}

static void null_program_destroy(gpu_device *device, gpu_program *program) {
  release(device, program);
}

static void null_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info) {
  for (uint32_t i = 0; i < info->program->info.constants_count; i++)
    require(device, info->constants[i], "bindings_write: constants are missing");
  for (uint32_t i = 0; i < info->program->info.texture_count; i++)
    require(device, info->textures[i] && (info->textures[i]->info.usage & GPU_IMAGE_SAMPLED),
            "bindings_write: a texture is missing, or not made to be sampled");
  bindings->info = *info;
}

static csm_result null_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out) {
  gpu_bindings *bindings = *out = make(device, sizeof *bindings);
  if (!bindings)
    return CSM_ERROR_OUT_OF_MEMORY;
  set_name(bindings->name, info->name);
  null_bindings_write(device, bindings, info);
  return CSM_SUCCESS;
}

static void null_bindings_destroy(gpu_device *device, gpu_bindings *bindings) {
  release(device, bindings);
}

/* ---- recording ---- */

static csm_result null_begin(gpu_device *device, const gpu_record_info *info) {
  require(device, !device->recording && !info->native, "begin: already recording, or into an engine's command buffer");
  device->recording = true;
  record(device, "begin %u%s", info->slot, info->first ? "" : ", again");
  return CSM_SUCCESS;
}

static void null_marker_begin(gpu_device *device, const char *name) {
  record(device, "marker_begin %s", name);
}

static void null_marker_end(gpu_device *device) {
  record(device, "marker_end");
}

static void null_timestamp(gpu_device *device, uint32_t index) {
  require(device, index < GPU_MAX_TIMESTAMPS, "timestamp: no such index");
  record(device, "timestamp %u", index);
}

static void null_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from,
                             uint64_t from_offset, uint64_t size) {
  record(device, "copy_buffer %s %llu %s %llu %llu", to->name, (unsigned long long)to_offset, from->name,
         (unsigned long long)from_offset, (unsigned long long)size);
  require(device, device->recording && !device->in_pass, "copy_buffer: not between begin and end, or in a pass");
  const bool fits = holds(to, to_offset, size) && holds(from, from_offset, size);
  require(device, fits, "copy_buffer: beyond a buffer's end");
  if (fits)
    memcpy(to->memory + to_offset, from->memory + from_offset, size);
}

/* Of a depth image a whole layer, of any other a piece of one. */
static void check_region(gpu_device *device, const gpu_image *image, const gpu_region *from) {
  const gpu_image_info *info = &image->info;
  const bool inside = spans(info->width, from->x, from->width) && spans(info->height, from->y, from->height);
  require(device, from->layer < info->layers, "copy_image: no such layer");
  require(device, inside, "copy_image: beyond the image, or empty");
  require(device, !gpu_format_is_depth(info->format) || (from->width == info->width && from->height == info->height),
          "copy_image: a part of a layer of depths");
  require(device, info->usage & GPU_IMAGE_COPY_SOURCE, "copy_image: the image is not made to be copied");
}

static void null_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                            const gpu_region *from) {
  record(device, "copy_image %s %llu %u %s %u %u %u %u %u", to->name, (unsigned long long)offset, row_bytes,
         image->name, from->layer, from->x, from->y, from->width, from->height);
  require(device, device->recording && !device->in_pass, "copy_image: not between begin and end, or in a pass");
  require(device, offset % PLACEMENT_ALIGNMENT == 0, "copy_image: offset is not a multiple of 512");
  require(device, row_bytes % OFFSET_ALIGNMENT == 0, "copy_image: row_bytes is not a multiple of 256");
  check_region(device, image, from);
  const uint64_t used = (uint64_t)from->width * gpu_format_bytes(image->info.format);
  const uint64_t size = from->height ? (uint64_t)row_bytes * (from->height - 1) + used : 0;
  const bool fits = used <= row_bytes && holds(to, offset, size);
  require(device, fits, "copy_image: beyond a row's or the buffer's end");
  if (fits)
    memset(to->memory + offset, 0, size);
}

static void null_copy_to_image(gpu_device *device, gpu_image *to, gpu_buffer *from, uint64_t offset,
                               uint32_t row_bytes) {
  record(device, "copy_to_image %s %s %llu %u", to->name, from->name, (unsigned long long)offset, row_bytes);
  require(device, device->recording && !device->in_pass, "copy_to_image: not between begin and end, or in a pass");
  require(device, row_bytes % OFFSET_ALIGNMENT == 0, "copy_to_image: row_bytes is not a multiple of 256");
  require(device, to->info.usage & GPU_IMAGE_COPY_TARGET, "copy_to_image: the image is not made to be copied to");
  require(device, holds(from, offset, (uint64_t)row_bytes * to->info.height), "copy_to_image: beyond the buffer's end");
}

static void null_clear_depth(gpu_device *device, gpu_image *image, float depth) {
  record(device, "clear_depth %s %g", image->name, (double)depth);
  require(device, device->recording && !device->in_pass, "clear_depth: not between begin and end, or in a pass");
  require(device, gpu_format_is_depth(image->info.format), "clear_depth: the image has no depths");
}

static void null_pass_begin(gpu_device *device, gpu_target *target) {
  record(device, "pass_begin %s", target->name);
  require(device, device->recording && !device->in_pass, "pass_begin: not between begin and end, or in a pass");
  device->in_pass = true;
  device->target = target;
  device->program = NULL;
  device->bound = false;
}

static void null_pass_area(gpu_device *device, const gpu_rect *area) {
  record(device, "area %u %u %u %u", area->x, area->y, area->width, area->height);
  require(device, device->in_pass, "pass_area: no pass is open");
  require(device,
          device->target && spans(device->target->width, area->x, area->width) &&
              spans(device->target->height, area->y, area->height),
          "pass_area: beyond the target, or empty");
}

static void null_pass_end(gpu_device *device) {
  record(device, "pass_end");
  require(device, device->in_pass, "pass_end: no pass is open");
  device->in_pass = false;
}

static void null_pass_program(gpu_device *device, gpu_program *program) {
  record(device, "program %s", program->name);
  require(device, device->in_pass, "pass_program: no pass is open");
  device->program = program;
  device->bound = false;
}

static bool same_shape(const gpu_program *a, const gpu_program *b) {
  return a->info.constants_count == b->info.constants_count && a->info.texture_count == b->info.texture_count &&
         a->info.sampler_count == b->info.sampler_count;
}

static void null_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets) {
  record(device, "bind %s", bindings->name);
  require(device, device->in_pass && device->program && same_shape(bindings->info.program, device->program),
          "pass_bind: no pass is open, or bindings of a program of another shape");
  const gpu_program_info *program = &bindings->info.program->info;
  for (uint32_t i = 0; i < program->constants_count; i++) {
    require(device, offsets[i] % OFFSET_ALIGNMENT == 0, "pass_bind: an offset is not a multiple of 256");
    require(device, holds(bindings->info.constants[i], offsets[i], program->constants_sizes[i]),
            "pass_bind: constants beyond the buffer's end");
  }
  device->bound = true;
}

static void check_draw(gpu_device *device, const gpu_draw *draw) {
  const gpu_program_info *program = &device->program->info;
  require(device, device->bound || !(program->constants_count + program->texture_count), "pass_draw: nothing is bound");
  require(device, draw->count > 0 && draw->instance_count > 0, "pass_draw: draws nothing");
  if (draw->indices) {
    require(device, draw->index_size == 2 || draw->index_size == 4, "pass_draw: index_size is not 2 or 4");
    require(device, holds(draw->indices, draw->index_offset, (uint64_t)draw->count * draw->index_size),
            "pass_draw: indices beyond the buffer's end");
  }
  for (uint32_t i = 0; i < program->stream_count; i++) {
    const uint32_t elements = program->streams[i].per_instance ? draw->instance_count : 1;
    require(device, holds(draw->streams[i], draw->stream_offsets[i], (uint64_t)elements * program->streams[i].stride),
            "pass_draw: a stream is missing, or ends too early");
  }
}

static void null_pass_draw(gpu_device *device, const gpu_draw *draw) {
  record(device, "draw count=%u instances=%u", draw->count, draw->instance_count);
  require(device, device->in_pass && device->program, "pass_draw: no pass is open, or no program is set");
  if (device->program)
    check_draw(device, draw);
}

static void null_pass_native(gpu_device *device, gpu_native_pass *out) {
  require(device, device->in_pass, "pass_native: no pass is open");
  *out = (gpu_native_pass){0};
}

static void null_make_readable(gpu_device *device, gpu_image *image) {
  record(device, "make_readable %s", image->name);
  require(device, device->recording && !device->in_pass, "make_readable: not between begin and end, or in a pass");
}

static csm_result null_end(gpu_device *device) {
  record(device, "end");
  require(device, device->recording && !device->in_pass, "end: not recording, or a pass is open");
  device->recording = false;
  return CSM_SUCCESS;
}

static csm_result null_wait(gpu_device *device, uint32_t slot) {
  record(device, "wait %u", slot);
  return CSM_SUCCESS;
}

/* A millisecond from each to the next. */
static csm_result null_timestamps(gpu_device *device, uint32_t slot, uint32_t first, uint32_t count,
                                  uint64_t *nanoseconds) {
  (void)device;
  (void)slot;
  for (uint32_t i = 0; i < count; i++)
    nanoseconds[i] = (first + i) * 1000000ull;
  return CSM_SUCCESS;
}

static const gpu_backend table = {
    .name = "null",
    .query = null_query,
    .open = null_open,
    .close = null_close,
    .describe = null_describe,
    .buffer_create = null_buffer_create,
    .buffer_destroy = null_buffer_destroy,
    .buffer_memory = null_buffer_memory,
    .image_create = null_image_create,
    .image_destroy = null_image_destroy,
    .image_bytes = null_image_bytes,
    .image_native = null_image_native,
    .image_describe = null_image_describe,
    .image_import = null_image_import,
    .geometry_import = null_geometry_import,
    .target_create = null_target_create,
    .target_destroy = null_target_destroy,
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
    .pass_begin = null_pass_begin,
    .pass_area = null_pass_area,
    .pass_end = null_pass_end,
    .pass_program = null_pass_program,
    .pass_bind = null_pass_bind,
    .pass_draw = null_pass_draw,
    .pass_native = null_pass_native,
    .make_readable = null_make_readable,
    .end = null_end,
    .wait = null_wait,
    .timestamps = null_timestamps,
};

__attribute__((visibility("default"))) void csm_backend_handshake(gpu_handshake *handshake);
void csm_backend_handshake(gpu_handshake *handshake) {
  handshake->backend_oldest = GPU_INTERFACE_VERSION;
  handshake->backend_newest = GPU_INTERFACE_VERSION;
  const bool common =
      handshake->front_oldest <= GPU_INTERFACE_VERSION && handshake->front_newest >= GPU_INTERFACE_VERSION;
  handshake->backend = common ? &table : NULL;
}
