#include "abi/cascades.h"

enum { ring_smallest = 1 << 16, ring_alignment = 256 };

/* Takes over what a slot's frame measured, now that it is done. */
static csm_result collect_timings(device *device, uint32_t index) {
  frame_slot *slot = &device->slots[index];
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < slot->timing_count && !result; ++i) {
    const timing *timing = &slot->timings[i];
    uint64_t stamps[GPU_MAX_TIMESTAMPS];
    if (!timing->cascades)
      continue;
    result = device->gpu.api->timestamps(device->gpu.device, index, timing->first, timing->count, stamps);
    if (!result)
      cascades_take_timing(timing->cascades, timing, stamps);
    else if (result == CSM_ERROR_UNSUPPORTED) /* a queue that measures nothing: the times stay negative */
      result = CSM_SUCCESS;
  }
  slot->timing_count = 0;
  return device_check(device, result, "reading timestamps");
}

static csm_result wait_for_slot(device *device, uint32_t index) {
  const csm_result result =
      device_check(device, device->gpu.api->wait(device->gpu.device, index), "waiting for the device");
  if (result)
    return result;
  if (device->slots[index].serial > device->done)
    device->done = device->slots[index].serial;
  return collect_timings(device, index);
}

/* ---- the ring ---- */

static void ring_free(device *device, retired *self) {
  ring_buffer *ring = (ring_buffer *)self;
  device_buffer_free(device, ring->buffer, ring->size);
  context_release(device->context, ring);
}

static csm_result ring_create(device *device, uint64_t size, ring_buffer **out) {
  ring_buffer *ring = context_allocate(device->context, sizeof *ring);
  if (!ring)
    return CSM_ERROR_OUT_OF_MEMORY;
  ring->size = ring_smallest;
  while (ring->size < size)
    ring->size *= 2;
  const gpu_buffer_info info = {.name = "frame ring", .kind = GPU_BUFFER_UPLOAD, .size = ring->size};
  const csm_result result = device_buffer(device, &info, &ring->buffer);
  if (result) {
    context_release(device->context, ring);
    return result;
  }
  *out = ring;
  return CSM_SUCCESS;
}

/* A ring that is too small gives way to one that holds all that the frame has asked for so far, and more. */
static csm_result ring_reserve(device *device, frame_slot *slot, bool fresh, uint64_t size, ring_range *range) {
  const uint64_t used = fresh || !slot->ring ? 0 : slot->ring->used;
  if (!slot->ring || slot->ring->size - used < size) {
    ring_buffer *ring;
    const csm_result result = ring_create(device, used + size, &ring);
    if (result)
      return result;
    if (slot->ring)
      retire(device, &slot->ring->retired, ring_free);
    slot->ring = ring;
    ring->used = 0;
  } else {
    slot->ring->used = used;
  }
  *range = (ring_range){.buffer = slot->ring->buffer,
                        .offset = slot->ring->used,
                        .memory = (char *)device->gpu.api->buffer_memory(slot->ring->buffer) + slot->ring->used};
  slot->ring->used += (size + ring_alignment - 1) / ring_alignment * ring_alignment;
  return CSM_SUCCESS;
}

/* ---- recordings ---- */

/* Which slot a frame takes. An engine's calls may share a frame. */
static csm_result find_slot(device *device, uint64_t frame, next_frame *out) {
  const bool fresh = device->own || frame != device->serial;
  *out = (next_frame){.serial = device->own ? device->serial + 1 : frame,
                      .slot = fresh ? (device->slot + 1) % device->slot_count : device->slot,
                      .fresh = fresh};
  if (out->serial < device->serial)
    return context_fail(device->context, CSM_ERROR_INVALID_VALUE, "csm_frame: frame %llu comes after frame %llu",
                        (unsigned long long)frame, (unsigned long long)device->serial);
  if (!device->own && out->serial <= device->done)
    return context_fail(device->context, CSM_ERROR_INVALID_VALUE, "csm_frame: frame %llu is retired already",
                        (unsigned long long)frame);
  const uint64_t holder = device->slots[out->slot].serial;
  if (!device->own && fresh && holder > device->done)
    return context_fail(device->context, CSM_ERROR_INVALID_STATE,
                        "frame %llu needs the place of frame %llu, which is not retired: more frames are in flight "
                        "than the %u frame_slots",
                        (unsigned long long)frame, (unsigned long long)holder, device->slot_count);
  return CSM_SUCCESS;
}

csm_result recording_prepare(device *device, uint64_t frame, uint64_t ring_size, ring_range *range) {
  next_frame next;
  csm_result result = find_slot(device, frame, &next);
  if (!result && device->own)
    result = wait_for_slot(device, next.slot);
  if (result)
    return result;
  retire_collect(device);
  if (ring_size)
    result = ring_reserve(device, &device->slots[next.slot], next.fresh, ring_size, range);
  if (!result)
    device->prepared = next;
  return result;
}

csm_result recording_begin(device *device, void *native) {
  const next_frame *next = &device->prepared;
  const gpu_record_info info = {.slot = next->slot, .native = native, .first = next->fresh};
  const csm_result result =
      device_check(device, device->gpu.api->begin(device->gpu.device, &info), "beginning a recording");
  if (result)
    return result;
  frame_slot *slot = &device->slots[next->slot];
  if (next->fresh)
    slot->stamps = 0;
  slot->serial = device->serial = next->serial;
  device->slot = next->slot;
  geometry_record(device);
  alpha_mask_record(device);
  return CSM_SUCCESS;
}

csm_result recording_end(device *device) {
  const csm_result result = device->gpu.api->end(device->gpu.device);
  if (!result)
    return CSM_SUCCESS;
  /* What was recorded is gone, uploads among it: there is no way back to what was. */
  device->lost = true;
  return context_fail(device->context, CSM_ERROR_DEVICE_LOST, "submitting a recording: %s", csm_result_name(result));
}

/* ---- timing ---- */

bool recording_expect_timing(device *device, csm_cascades *cascades, uint32_t count, bool mask, uint32_t *first) {
  frame_slot *slot = &device->slots[device->slot];
  if (slot->timing_count == DEVICE_MAX_TIMINGS || slot->stamps + count > GPU_MAX_TIMESTAMPS)
    return false;
  *first = slot->stamps;
  slot->timings[slot->timing_count++] =
      (timing){.cascades = cascades, .first = slot->stamps, .count = count, .mask = mask};
  slot->stamps += count;
  return true;
}

void recording_forget_timing(device *device, const csm_cascades *cascades) {
  for (uint32_t i = 0; i < device->slot_count; ++i)
    for (uint32_t t = 0; t < device->slots[i].timing_count; ++t)
      if (device->slots[i].timings[t].cascades == cascades)
        device->slots[i].timings[t].cascades = NULL;
}

/* ---- ends ---- */

csm_result recording_finish(device *device) {
  if (!device->own)
    return CSM_SUCCESS;
  for (uint32_t slot = 0; slot < device->slot_count; ++slot) {
    const csm_result result = wait_for_slot(device, slot);
    if (result)
      return result;
  }
  retire_collect(device);
  return CSM_SUCCESS;
}

csm_result recording_retire(device *device, uint64_t frame) {
  csm_result result = CSM_SUCCESS;
  for (uint32_t slot = 0; slot < device->slot_count && !result; ++slot)
    if (device->slots[slot].serial > device->done && device->slots[slot].serial <= frame)
      result = collect_timings(device, slot);
  if (frame > device->done)
    device->done = frame;
  retire_collect(device);
  return result;
}

void recording_destroy(device *device) {
  for (uint32_t slot = 0; slot < device->slot_count; ++slot)
    if (device->slots[slot].ring)
      ring_free(device, &device->slots[slot].ring->retired);
}
