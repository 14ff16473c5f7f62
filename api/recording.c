#include "context.h"
#include "cascades.h"

enum { ring_smallest = 1 << 16 };

/* The serial that a slot's last recording had is done once the slot was waited for. */
static csm_result finish_slot(csm_context *context, uint32_t slot) {
  csm_result result =
      context_check(context, context->gpu.api->wait(context->gpu.device, slot), "waiting for the device");
  slot_timing *timing = &context->timing[slot];
  if (!result && timing->cascades) {
    uint64_t stamps[GPU_MAX_TIMESTAMPS];
    result = context_check(context, context->gpu.api->timestamps(context->gpu.device, slot, timing->count, stamps),
                           "reading timestamps");
    if (!result)
      cascades_take_timing(timing->cascades, timing, stamps);
    timing->cascades = NULL;
  }
  return result;
}

static csm_result reserve(csm_context *context, ring_slot *ring, uint64_t size) {
  if (size <= ring->size)
    return CSM_SUCCESS;
  uint64_t grown = ring_smallest;
  while (grown < size)
    grown *= 2;
  gpu_buffer *buffer;
  const csm_result result = context_buffer(
      context, &(gpu_buffer_info){.name = "frame ring", .kind = GPU_BUFFER_UPLOAD, .size = grown}, &buffer);
  if (result)
    return result;
  context_buffer_free(context, ring->buffer, ring->size);
  *ring = (ring_slot){.buffer = buffer, .size = grown};
  return CSM_SUCCESS;
}

csm_result recording_prepare(csm_context *context, uint64_t ring_size, ring_range *range) {
  const uint64_t serial = context->serial + 1;
  const uint32_t slot = (uint32_t)(serial % context->slot_count);
  csm_result result = finish_slot(context, slot);
  if (result)
    return result;
  if (serial > context->slot_count)
    retire_collect(context, serial - context->slot_count);
  ring_slot *ring = &context->ring[slot];
  result = reserve(context, ring, ring_size);
  if (result || !ring->buffer)
    return result;
  *range = (ring_range){.buffer = ring->buffer, .memory = context->gpu.api->buffer_memory(ring->buffer)};
  return CSM_SUCCESS;
}

csm_result recording_begin(csm_context *context) {
  const uint32_t slot = (uint32_t)((context->serial + 1) % context->slot_count);
  const csm_result result =
      context_check(context, context->gpu.api->begin(context->gpu.device, slot, NULL), "beginning a recording");
  if (result)
    return result;
  ++context->serial;
  geometry_record(context);
  return CSM_SUCCESS;
}

csm_result recording_end(csm_context *context) {
  const csm_result result = context->gpu.api->end(context->gpu.device);
  /* What was recorded is gone, uploads among it: there is no way back to what was. */
  return result ? context_fail(context, CSM_ERROR_DEVICE_LOST, "submitting a recording: %s", csm_result_name(result))
                : CSM_SUCCESS;
}

uint32_t recording_slot(const csm_context *context) {
  return (uint32_t)(context->serial % context->slot_count);
}

csm_result recording_finish(csm_context *context) {
  for (uint32_t slot = 0; slot < context->slot_count; ++slot) {
    const csm_result result = finish_slot(context, slot);
    if (result)
      return result;
  }
  retire_collect(context, context->serial);
  return CSM_SUCCESS;
}

void recording_destroy(csm_context *context) {
  for (uint32_t slot = 0; slot < context->slot_count; ++slot)
    context_buffer_free(context, context->ring[slot].buffer, context->ring[slot].size);
}
