#include "device/device.h"

enum { smallest = 1 << 16 };
/* Constants are bound at offsets of 32 bits. */
static const uint64_t largest = UINT32_MAX - RING_ALIGNMENT + 1;

static void ring_free(device *device, retired *self) {
  ring_buffer *ring = (ring_buffer *)self;
  device_buffer_free(device, ring->buffer, ring->size);
  host_release(device->host, ring);
}

static csm_result ring_create(device *device, uint64_t size, ring_buffer **out) {
  ring_buffer *ring = host_allocate(device->host, sizeof *ring);
  if (!ring)
    return CSM_ERROR_OUT_OF_MEMORY;
  ring->size = smallest;
  while (ring->size < size)
    ring->size *= 2;
  const gpu_buffer_info info = {
      .name = "frame ring", .kind = GPU_BUFFER_UPLOAD, .size = ring->size, .usage = GPU_BUFFER_READ};
  const csm_result result = device_buffer(device, &info, &ring->buffer);
  if (result) {
    host_release(device->host, ring);
    return result;
  }
  *out = ring;
  return CSM_SUCCESS;
}

/* A ring that is too small gives way to one that holds all that the frame has asked for so far, and more. */
csm_result ring_reserve(device *device, frame_slot *slot, uint64_t size, ring_range *range) {
  const uint64_t used = slot->ring ? slot->ring->used : 0;
  if (size > largest - used)
    return host_fail(device->host, CSM_ERROR_LIMIT_EXCEEDED,
                     "the frame takes %llu bytes; it may take %llu: there are too many instances",
                     (unsigned long long)(used + size), (unsigned long long)largest);
  if (!slot->ring || slot->ring->size - used < size) {
    ring_buffer *ring;
    const csm_result result = ring_create(device, used + size, &ring);
    if (result)
      return result;
    if (slot->ring)
      retire(device, &slot->ring->retired, ring_free);
    slot->ring = ring;
  }
  *range = (ring_range){.buffer = slot->ring->buffer,
                        .offset = slot->ring->used,
                        .memory = (char *)gpu_buffer_memory(device->gpu, slot->ring->buffer) + slot->ring->used};
  slot->ring->used += (size + RING_ALIGNMENT - 1) / RING_ALIGNMENT * RING_ALIGNMENT;
  return CSM_SUCCESS;
}

uint64_t ring_bytes(const device *device) {
  uint64_t bytes = 0;
  for (uint32_t slot = 0; slot < device->slot_count; ++slot)
    bytes += device->slots[slot].ring ? device->slots[slot].ring->size : 0;
  return bytes;
}

void ring_destroy(device *device) {
  for (uint32_t slot = 0; slot < device->slot_count; ++slot)
    if (device->slots[slot].ring)
      ring_free(device, &device->slots[slot].ring->retired);
}
