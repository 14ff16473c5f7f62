#include "abi/cascades.h"
#include "abi/view.h"

#include <math.h>
#include <string.h>

static bool of_cascades(const csm_read_info *info) {
  return info->source == CSM_READ_MAP || info->source == CSM_READ_MOMENTS;
}

static csm_result check_owner(csm_context *context, const csm_read_info *info) {
  host *host = &context->host;
  const bool map = of_cascades(info);
  if (info->source > CSM_READ_MOMENTS)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_read_info: there is no source %u", info->source);
  if (info->reserved || info->reserved_level)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_read_info: reserved is %u, not 0",
                     info->reserved ? info->reserved : info->reserved_level);
  if (map ? !info->cascades : !info->view)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "csm_read_info: %s is NULL", map ? "cascades" : "view");
  if (map ? !cascades_known(context, info->cascades) : !view_known(context, info->view))
    return host_fail(host, CSM_ERROR_INVALID_HANDLE, "csm_read_info: %s is none of this context",
                     map ? "cascades" : "view");
  if (map && info->cascade >= info->cascades->config.cascade_count)
    return host_fail(host, CSM_ERROR_INVALID_INDEX, "csm_read_info: cascade %u of %u", info->cascade,
                     info->cascades->config.cascade_count);
  return CSM_SUCCESS;
}

/* Makes an image's sizes those of one of its levels. */
static csm_result take_level(csm_context *context, uint32_t level, technique_image *image) {
  const uint32_t levels = image->levels ? image->levels : 1;
  if (level >= levels)
    return host_fail(&context->host, CSM_ERROR_INVALID_INDEX, "csm_read_info: level %u of %u", level, levels);
  image->width = gpu_level_size(image->width, level);
  image->height = gpu_level_size(image->height, level);
  image->part.width = gpu_level_size(image->part.width, level);
  image->part.height = gpu_level_size(image->part.height, level);
  return CSM_SUCCESS;
}

static csm_result find_source(csm_context *context, const csm_read_info *info, technique_image *out) {
  csm_result result = check_owner(context, info);
  if (result)
    return result;
  const bool map = of_cascades(info);
  result = map ? cascades_drawn(info->cascades) : CSM_SUCCESS;
  if (result)
    return result;
  result =
      technique_set_find(map ? &info->cascades->techniques : &info->view->techniques, info->source, info->cascade, out);
  if (map && result)
    return host_fail(&context->host, CSM_ERROR_INVALID_STATE, "the configured filter reads no moments");
  return result ? host_fail(&context->host, CSM_ERROR_INVALID_STATE, "no mask has been resolved yet")
                : take_level(context, info->level, out);
}

/* The numbers of a float in 16 bits. */
static float from_half(uint16_t half) {
  const int exponent = half >> 10 & 31;
  const float mantissa = (float)(half & 1023);
  const float size = exponent == 31  ? (half & 1023 ? NAN : INFINITY)
                     : exponent == 0 ? ldexpf(mantissa, -24)
                                     : ldexpf(mantissa + 1024.0f, exponent - 25);
  return half & 0x8000 ? -size : size;
}

/* How many numbers a texel has. */
static uint32_t channels_of(gpu_format format) {
  switch (format) {
  case GPU_FORMAT_RG16_FLOAT:
  case GPU_FORMAT_RG32_FLOAT:
    return 2;
  case GPU_FORMAT_RGBA16_FLOAT:
  case GPU_FORMAT_RGBA32_FLOAT:
    return 4;
  default:
    return 1;
  }
}

static float number(const unsigned char *from, gpu_format format) {
  uint16_t bits;
  float value;
  switch (format) {
  case GPU_FORMAT_R8_UNORM:
    return (float)from[0] / 255.0f;
  case GPU_FORMAT_D16_UNORM:
    memcpy(&bits, from, sizeof bits);
    return (float)bits / 65535.0f;
  case GPU_FORMAT_R16_FLOAT:
  case GPU_FORMAT_RG16_FLOAT:
  case GPU_FORMAT_RGBA16_FLOAT:
    memcpy(&bits, from, sizeof bits);
    return from_half(bits);
  default:
    memcpy(&value, from, sizeof value);
    return value;
  }
}

static float converted(const technique_image *from, uint32_t x, uint32_t y, float value) {
  if (!from->drawn_with)
    return value;
  const plan_pixel pixel = {
      .x = (2.0 * x + 1.0) / from->width - 1.0, .y = 1.0 - (2.0 * y + 1.0) / from->height, .depth = value};
  return (float)plan_convert_depth(from->drawn_with, from->read_as, &pixel);
}

/* A map that is made of pages begins within its layer, and goes on at the other side. */
static void unpack_pages(const technique_image *from, const unsigned char *rows, uint32_t row_bytes, float *out) {
  const technique_pages *pages = from->pages;
  const uint32_t bytes = gpu_format_bytes(from->format), side = from->part.width, page = side / pages->across;
  for (uint32_t y = 0; y < side; ++y)
    for (uint32_t x = 0; x < side; ++x) {
      const uint32_t column = (x + pages->begin[0]) % side, row = (y + pages->begin[1]) % side;
      const bool valid = pages->valid[row / page] >> column / page & 1;
      *out++ = valid ? number(rows + (size_t)row * row_bytes + (size_t)column * bytes, from->format) : from->cleared;
    }
}

static void unpack(const technique_image *from, const unsigned char *rows, uint32_t row_bytes, float *out) {
  const uint32_t bytes = gpu_format_bytes(from->format), channels = channels_of(from->format);
  if (from->pages) {
    unpack_pages(from, rows, row_bytes, out);
    return;
  }
  for (uint32_t y = 0; y < from->part.height; ++y) {
    const unsigned char *row = rows + (size_t)(from->part.y + y) * row_bytes + (size_t)from->part.x * bytes;
    for (uint32_t x = 0; x < from->part.width * channels; ++x)
      *out++ = converted(from, x, y, number(row + (size_t)x * (bytes / channels), from->format));
  }
}

static uint32_t layers_of(const technique_image *from) {
  return from->layers ? from->layers : 1;
}

static csm_result copy_out(device *device, const technique_image *from, uint32_t level, float *data) {
  const uint32_t row_bytes = device_row_bytes(from->width, from->format);
  const uint64_t layer = (uint64_t)row_bytes * from->height, step = (layer + 511) / 512 * 512;
  const uint64_t size = step * layers_of(from);
  gpu_buffer *buffer;
  ring_range ring = {0};
  csm_result result = device_buffer(
      device, &(gpu_buffer_info){.name = "read back", .kind = GPU_BUFFER_READBACK, .size = size}, &buffer);
  if (result)
    return result;
  result = recording_prepare(device, 0, 0, &ring);
  if (!result)
    result = recording_begin(device, NULL);
  if (!result) {
    for (uint32_t i = 0; i < layers_of(from); ++i) /* whole, for Direct3D 12 does not copy parts of depth */
      gpu_copy_image(
          device->gpu, buffer, i * step, row_bytes, from->image,
          &(gpu_region){.layer = from->layer + i, .level = level, .width = from->width, .height = from->height});
    result = recording_end(device);
  }
  if (!result)
    result = recording_finish(device);
  const size_t numbers = (size_t)from->part.width * from->part.height * channels_of(from->format);
  for (uint32_t i = 0; i < layers_of(from) && !result; ++i)
    unpack(from, (const unsigned char *)gpu_buffer_memory(device->gpu, buffer) + i * step, row_bytes,
           data + i * numbers);
  device_buffer_free(device, buffer, size);
  return result;
}

csm_result CSM_CALL csm_read(csm_context *context, const csm_read_info *in) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  host *host = &context->host;
  device *device = context_device(context);
  csm_read_info info;
  technique_image from = {0};
  csm_result result = context_usable(context);
  if (!result)
    result = host_check_struct(host, struct_read(&info, sizeof info, in), "csm_read_info");
  if (!result && !device->own)
    result = host_fail(host, CSM_ERROR_UNSUPPORTED, "csm_read needs an own device: it submits and waits");
  if (!result)
    result = find_source(context, &info, &from);
  if (result)
    return result;
  const uint64_t size =
      (uint64_t)from.part.width * from.part.height * channels_of(from.format) * layers_of(&from) * sizeof(float);
  if (!info.data)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "csm_read_info: data is NULL");
  if (info.size != size)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_read_info: size is %llu, not %llu",
                     (unsigned long long)info.size, (unsigned long long)size);
  return copy_out(device, &from, info.level, info.data);
}
