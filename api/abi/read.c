#include "abi/cascades.h"

#include <string.h>

/* A part of an image's layer. The layer is copied whole, for Direct3D 12 does not copy parts of depth. */
typedef struct source {
  gpu_image *image;
  gpu_format format;
  uint32_t layer, image_width, image_height;
  gpu_rect part;
} source;

static csm_result find_source(csm_cascades *cascades, const csm_read_info *info, source *out) {
  csm_context *context = cascades->context;
  const cascade_mask *mask = cascades->mask;
  if (info->source > CSM_READ_CAMERA_DEPTH || info->reserved)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_read_info: there is no source %u", info->source);
  if (info->source == CSM_READ_MAP) {
    if (info->cascade >= cascades->config.cascade_count)
      return context_fail(context, CSM_ERROR_INVALID_INDEX, "csm_read_info: cascade %u of %u", info->cascade,
                          cascades->config.cascade_count);
    if (!cascades->drawn)
      return context_fail(context, CSM_ERROR_INVALID_STATE, "no maps have been drawn with this configuration yet");
    const cascade_maps *maps = cascades->resources.maps;
    const plan_rect *rect = &maps->layout.rects[info->cascade];
    *out = (source){.image = maps->image,
                    .format = maps->format,
                    .layer = rect->layer,
                    .image_width = maps->layout.width,
                    .image_height = maps->layout.height,
                    .part = {.x = rect->x, .y = rect->y, .width = rect->side, .height = rect->side}};
    return CSM_SUCCESS;
  }
  if (!mask || !(info->source == CSM_READ_MASK ? mask->drawn : mask->depth_drawn))
    return context_fail(context, CSM_ERROR_INVALID_STATE, "no mask has been resolved yet");
  const bool wants_mask = info->source == CSM_READ_MASK;
  *out = (source){.image = wants_mask ? mask->mask : mask->depth,
                  .format = wants_mask ? GPU_FORMAT_R8_UNORM : GPU_FORMAT_D32_FLOAT,
                  .image_width = mask->width,
                  .image_height = mask->height,
                  .part = {.width = mask->width, .height = mask->height}};
  return CSM_SUCCESS;
}

static float texel(const unsigned char *from, gpu_format format) {
  uint16_t unorm;
  float value;
  switch (format) {
  case GPU_FORMAT_R8_UNORM:
    return (float)from[0] / 255.0f;
  case GPU_FORMAT_D16_UNORM:
    memcpy(&unorm, from, sizeof unorm);
    return (float)unorm / 65535.0f;
  default:
    memcpy(&value, from, sizeof value);
    return value;
  }
}

static void unpack(const source *from, const unsigned char *rows, uint32_t row_bytes, float *out) {
  const uint32_t bytes = gpu_format_bytes(from->format);
  for (uint32_t y = 0; y < from->part.height; ++y) {
    const unsigned char *row = rows + (size_t)(from->part.y + y) * row_bytes + (size_t)from->part.x * bytes;
    for (uint32_t x = 0; x < from->part.width; ++x)
      *out++ = texel(row + (size_t)x * bytes, from->format);
  }
}

static csm_result copy_out(device *device, const source *from, float *data) {
  const gpu_region whole = {.layer = from->layer, .width = from->image_width, .height = from->image_height};
  const uint32_t row_bytes = device_row_bytes(whole.width, from->format);
  const uint64_t size = (uint64_t)row_bytes * whole.height;
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
    device->gpu.api->copy_image(device->gpu.device, buffer, 0, row_bytes, from->image, &whole);
    result = recording_end(device);
  }
  if (!result)
    result = recording_finish(device);
  if (!result)
    unpack(from, device->gpu.api->buffer_memory(buffer), row_bytes, data);
  device_buffer_free(device, buffer, size);
  return result;
}

csm_result CSM_CALL csm_read(csm_cascades *cascades, const csm_read_info *in) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  csm_read_info info;
  source from = {0};
  result = context_check_struct(context, struct_read(&info, sizeof info, in), "csm_read_info");
  if (!result && !context->device->own)
    result = context_fail(context, CSM_ERROR_UNSUPPORTED, "csm_read needs an own device: it submits and waits");
  if (!result)
    result = find_source(cascades, &info, &from);
  if (result)
    return result;
  const uint64_t size = (uint64_t)from.part.width * from.part.height * sizeof(float);
  if (!info.data)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "csm_read_info: data is NULL");
  if (info.size != size)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_read_info: size is %llu, not %llu",
                        (unsigned long long)info.size, (unsigned long long)size);
  return copy_out(context->device, &from, info.data);
}
