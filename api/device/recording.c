#include "device/device.h"

/* Takes over what a slot's frame measured, now that it is done. A lost device has measured nothing. */
static csm_result collect_timings(device *device, uint32_t index) {
  frame_slot *slot = &device->slots[index];
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < slot->timing_count && !result && !device->lost; ++i) {
    const timing *timing = &slot->timings[i];
    uint64_t stamps[GPU_MAX_TIMESTAMPS];
    if (!timing->sink.user)
      continue;
    result = gpu_timestamps(device->gpu, index, timing->first, timing->count, stamps);
    if (!result)
      timing->sink.take(timing->sink.user, stamps, timing->count);
    else if (result == CSM_ERROR_UNSUPPORTED) /* a queue that measures nothing: the times stay negative */
      result = CSM_SUCCESS;
  }
  slot->timing_count = 0;
  return device_check(device, result, "reading timestamps");
}

static csm_result wait_for_slot(device *device, uint32_t index) {
  const csm_result result = device_check(device, gpu_wait(device->gpu, index), "waiting for the device");
  if (result)
    return result;
  if (device->slots[index].serial > device->done)
    device->done = device->slots[index].serial;
  return collect_timings(device, index);
}

/* ---- recordings ---- */

/* Which slot a frame takes. An engine's calls may share a frame. */
static csm_result find_slot(device *device, uint64_t frame, next_frame *out) {
  const bool fresh = device->own || frame != device->serial;
  *out = (next_frame){.serial = device->own ? device->serial + 1 : frame,
                      .slot = fresh ? (device->slot + 1) % device->slot_count : device->slot,
                      .fresh = fresh};
  if (out->serial < device->serial)
    return host_fail(device->host, CSM_ERROR_INVALID_VALUE, "csm_frame: frame %llu comes after frame %llu",
                     (unsigned long long)frame, (unsigned long long)device->serial);
  if (!device->own && out->serial <= device->done)
    return host_fail(device->host, CSM_ERROR_INVALID_VALUE, "csm_frame: frame %llu is retired already",
                     (unsigned long long)frame);
  const uint64_t holder = device->slots[out->slot].serial;
  if (!device->own && fresh && holder > device->done)
    return host_fail(device->host, CSM_ERROR_INVALID_STATE,
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
  frame_slot *slot = &device->slots[next.slot];
  if (next.fresh && slot->ring) /* whatever this recording asks for: the next of its frame goes on from here */
    slot->ring->used = 0;
  if (ring_size)
    result = ring_reserve(device, slot, ring_size, range);
  if (!result)
    device->prepared = next;
  return result;
}

csm_result recording_begin(device *device, void *native) {
  const next_frame *next = &device->prepared;
  const gpu_record_info info = {.slot = next->slot, .native = native, .first = next->fresh};
  feholdexcept(&device->floats);
  const csm_result result = device_check(device, gpu_begin(device->gpu, &info), "beginning a recording");
  if (result) {
    fesetenv(&device->floats);
    return result;
  }
  frame_slot *slot = &device->slots[next->slot];
  if (next->fresh)
    slot->stamps = slot->timing_count = 0;
  slot->serial = device->serial = next->serial;
  device->slot = next->slot;
  geometry_record(device);
  alpha_images_record(device);
  return CSM_SUCCESS;
}

csm_result recording_end(device *device) {
  const csm_result result = gpu_end(device->gpu);
  fesetenv(&device->floats);
  if (!result)
    return CSM_SUCCESS;
  /* What was recorded is gone, uploads among it: there is no way back to what was. */
  device->lost = true;
  return host_fail(device->host, CSM_ERROR_DEVICE_LOST, "submitting a recording: %s", csm_result_name(result));
}

/* ---- timing ---- */

bool recording_expect_timing(device *device, const timing_sink *sink, uint32_t count, uint32_t *first) {
  frame_slot *slot = &device->slots[device->slot];
  if (slot->timing_count == DEVICE_MAX_TIMINGS || slot->stamps + count > GPU_MAX_TIMESTAMPS)
    return false;
  *first = slot->stamps;
  slot->timings[slot->timing_count++] = (timing){.sink = *sink, .first = slot->stamps, .count = count};
  slot->stamps += count;
  return true;
}

void recording_forget_timing(device *device, const void *user) {
  for (uint32_t i = 0; i < device->slot_count; ++i)
    for (uint32_t t = 0; t < device->slots[i].timing_count; ++t)
      if (device->slots[i].timings[t].sink.user == user)
        device->slots[i].timings[t].sink.user = NULL;
}

/* ---- ends ---- */

/* The slot of the i-th oldest frame, so that what was measured last is told last. */
static uint32_t oldest_slot(const device *device, uint32_t i) {
  return (device->slot + 1 + i) % device->slot_count;
}

csm_result recording_wait(device *device, uint64_t serial) {
  csm_result result = CSM_SUCCESS;
  if (serial > device->done && !device->own)
    return host_fail(device->host, CSM_ERROR_INVALID_STATE, "frame %llu is not retired yet",
                     (unsigned long long)serial);
  for (uint32_t i = 0; i < device->slot_count && serial > device->done && !result; ++i)
    result = wait_for_slot(device, oldest_slot(device, i));
  return result;
}

csm_result recording_finish(device *device) {
  if (!device->own)
    return CSM_SUCCESS;
  for (uint32_t i = 0; i < device->slot_count; ++i) {
    const csm_result result = wait_for_slot(device, oldest_slot(device, i));
    if (result)
      return result;
  }
  retire_collect(device);
  return CSM_SUCCESS;
}

csm_result recording_retire(device *device, uint64_t frame) {
  csm_result first = CSM_SUCCESS;
  for (uint32_t i = 0; i < device->slot_count; ++i) {
    const uint32_t slot = oldest_slot(device, i);
    if (device->slots[slot].serial <= device->done || device->slots[slot].serial > frame)
      continue;
    const csm_result result = collect_timings(device, slot);
    first = first ? first : result;
  }
  if (frame > device->done)
    device->done = frame;
  retire_collect(device);
  return first;
}
