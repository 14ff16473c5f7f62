#include "cascades.h"

#include <string.h>

enum { row_alignment = 256 };

/* An image's layer, and how to turn its texels into floats. */
typedef struct source {
  gpu_image *image;
  uint32_t layer, width, height;
  uint32_t texel_bytes; /* 4: floats, 1: unorm */
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
    *out = (source){cascades->maps->image, info->cascade, cascades->maps->resolution, cascades->maps->resolution, 4};
    return CSM_SUCCESS;
  }
  if (!mask || !(info->source == CSM_READ_MASK ? mask->drawn : mask->depth_drawn))
    return context_fail(context, CSM_ERROR_INVALID_STATE, "no mask has been resolved yet");
  *out = info->source == CSM_READ_MASK ? (source){mask->mask, 0, mask->width, mask->height, 1}
                                       : (source){mask->depth, 0, mask->width, mask->height, 4};
  return CSM_SUCCESS;
}

static void unpack(const source *from, const unsigned char *rows, uint32_t row_bytes, float *out) {
  for (uint32_t y = 0; y < from->height; ++y, rows += row_bytes, out += from->width) {
    if (from->texel_bytes == sizeof(float)) {
      memcpy(out, rows, from->width * sizeof(float));
    } else {
      for (uint32_t x = 0; x < from->width; ++x)
        out[x] = (float)rows[x] / 255.0f;
    }
  }
}

static csm_result copy_out(device *device, const source *from, float *data) {
  const uint32_t row_bytes = (from->width * from->texel_bytes + row_alignment - 1) / row_alignment * row_alignment;
  const uint64_t size = (uint64_t)row_bytes * from->height;
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
    const gpu_region whole = {.layer = from->layer, .width = from->width, .height = from->height};
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
  const uint64_t size = (uint64_t)from.width * from.height * sizeof(float);
  if (!info.data)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "csm_read_info: data is NULL");
  if (info.size != size)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_read_info: size is %llu, not %llu",
                        (unsigned long long)info.size, (unsigned long long)size);
  return copy_out(context->device, &from, info.data);
}
