/*
 * state.c: barriers. States are tracked in the order of recording, across recordings. Barriers are gathered until the
 * next command that needs them.
 *
 * Images that shaders read rest readable between recordings.
 * Buffers of the device's own memory rest in COMMON. When a list has run they decay to it; within a list `rest` brings
 * them there. So the next use always starts from COMMON. Draws and dispatches promote them without a barrier. vkd3d
 * does neither, and there the barriers to COMMON order what follows.
 */
#include "internal.h"

#include <string.h>

void d3d12_flush_barriers(gpu_device *device) {
  if (device->barrier_count)
    ID3D12GraphicsCommandList_ResourceBarrier(device->list, device->barrier_count, device->barriers);
  device->barrier_count = 0;
}

static void add(gpu_device *device, const D3D12_RESOURCE_BARRIER *barrier) {
  if (device->barrier_count == D3D12_MAX_BARRIERS)
    d3d12_flush_barriers(device);
  device->barriers[device->barrier_count++] = *barrier;
}

static void add_transition(gpu_device *device, const d3d12_resource *resource, uint32_t subresource,
                           D3D12_RESOURCE_STATES before, D3D12_RESOURCE_STATES after) {
  add(device, &(D3D12_RESOURCE_BARRIER){.Type = D3D12_RESOURCE_BARRIER_TYPE_TRANSITION,
                                        .Transition = {.pResource = resource->handle,
                                                       .Subresource = subresource,
                                                       .StateBefore = before,
                                                       .StateAfter = after}});
}

/* A UAV barrier for all resources. vkd3d turns one for a single image into a barrier of all its levels, and some may be
   in another state. */
static void add_store_barrier(gpu_device *device) {
  add(device, &(D3D12_RESOURCE_BARRIER){.Type = D3D12_RESOURCE_BARRIER_TYPE_UAV});
}

/* ---- images ---- */

/* Whether the range is all of the image, in one state. */
static bool is_uniform(const gpu_image *image, const gpu_range *range) {
  const uint32_t count = image->layer_count * image->level_count;
  if (range->layer_count * range->level_count != count)
    return false;
  for (uint32_t i = 1; i < count; i++)
    if (image->states[i] != image->states[0])
      return false;
  return true;
}

/* Copies into one place are ordered by a barrier from their state to itself, where the run time wants one. */
static bool needs_transition(const gpu_device *device, D3D12_RESOURCE_STATES last, D3D12_RESOURCE_STATES next) {
  return last != next || (next == D3D12_RESOURCE_STATE_COPY_DEST && device->traits->self_barriers);
}

void d3d12_image_use(gpu_device *device, gpu_image *image, const gpu_range *part, D3D12_RESOURCE_STATES state) {
  const gpu_range range = d3d12_range(image, part);
  if (image->borrowed)
    return;
  if (!image->used) {
    image->used = true;
    image->next_used = device->used_images;
    device->used_images = image;
    memcpy(image->before, image->states, image->layer_count * image->level_count * sizeof *image->states);
  }
  const bool uniform = is_uniform(image, &range);
  bool stored = false;
  if (uniform && needs_transition(device, image->states[0], state))
    add_transition(device, &image->resource, D3D12_RESOURCE_BARRIER_ALL_SUBRESOURCES, image->states[0], state);
  for (uint32_t layer = range.first_layer; layer < range.first_layer + range.layer_count; layer++)
    for (uint32_t level = range.first_level; level < range.first_level + range.level_count; level++) {
      const uint32_t subresource = level + layer * image->level_count;
      D3D12_RESOURCE_STATES *last = &image->states[subresource];
      stored |= *last == state && state == D3D12_RESOURCE_STATE_UNORDERED_ACCESS;
      if (!uniform && needs_transition(device, *last, state))
        add_transition(device, &image->resource, subresource, *last, state);
      *last = state;
    }
  if (stored)
    add_store_barrier(device);
}

/* ---- buffers ---- */

/* `end` brings the buffer back to rest then. */
static void mark_used(gpu_device *device, gpu_buffer *buffer) {
  if (buffer->used)
    return;
  buffer->used = true;
  buffer->next_used = device->used_buffers;
  device->used_buffers = buffer;
}

/* Only buffers of the device's own memory change their state. */
static bool keeps_state(const gpu_buffer *buffer) {
  return buffer->borrowed || buffer->kind != GPU_BUFFER_DEVICE;
}

static void buffer_use(gpu_device *device, gpu_buffer *buffer, D3D12_RESOURCE_STATES state) {
  mark_used(device, buffer);
  if (buffer->state != state)
    add_transition(device, &buffer->resource, D3D12_RESOURCE_BARRIER_ALL_SUBRESOURCES, buffer->state, state);
  buffer->state = state;
}

/* A second copy into one place is ordered after the first by a way through another state. A readback buffer never
   leaves its state: there the run time may want a barrier from it to itself. */
void d3d12_buffer_use_target(gpu_device *device, gpu_buffer *buffer, uint64_t begin, uint64_t size) {
  const uint64_t end = begin + size;
  const bool overlaps = begin < buffer->copied_end && buffer->copied_begin < end;
  if (overlaps && keeps_state(buffer)) {
    if (device->traits->self_barriers)
      add_transition(device, &buffer->resource, D3D12_RESOURCE_BARRIER_ALL_SUBRESOURCES, buffer->state, buffer->state);
  } else if (overlaps) {
    buffer_use(device, buffer, buffer->readable);
  }
  if (overlaps || buffer->state != D3D12_RESOURCE_STATE_COPY_DEST) {
    d3d12_flush_barriers(device);
    buffer->copied_end = 0;
  }
  if (!keeps_state(buffer))
    buffer_use(device, buffer, D3D12_RESOURCE_STATE_COPY_DEST);
  if (buffer->copied_end == 0 || begin < buffer->copied_begin)
    buffer->copied_begin = begin;
  if (buffer->copied_end < end)
    buffer->copied_end = end;
}

void d3d12_buffer_use_source(gpu_device *device, gpu_buffer *buffer) {
  if (!keeps_state(buffer))
    buffer_use(device, buffer, D3D12_RESOURCE_STATE_COPY_SOURCE);
}

/* Whether a buffer is in a state out of which draws and dispatches do not promote it. */
static bool is_apart(const gpu_buffer *buffer) {
  return buffer->state &
         (D3D12_RESOURCE_STATE_COPY_DEST | D3D12_RESOURCE_STATE_COPY_SOURCE | D3D12_RESOURCE_STATE_UNORDERED_ACCESS);
}

void d3d12_buffer_use_read(gpu_device *device, gpu_buffer *buffer, D3D12_RESOURCE_STATES state) {
  if (keeps_state(buffer))
    return;
  if (is_apart(buffer))
    buffer_use(device, buffer, buffer->readable);
  mark_used(device, buffer);
  buffer->state |= state;
}

void d3d12_buffer_use_store(gpu_device *device, gpu_buffer *buffer) {
  if (buffer->state == D3D12_RESOURCE_STATE_UNORDERED_ACCESS)
    add_store_barrier(device);
  buffer_use(device, buffer, D3D12_RESOURCE_STATE_UNORDERED_ACCESS);
}

void d3d12_settle_buffers(gpu_device *device) {
  for (gpu_buffer *buffer = device->used_buffers; buffer; buffer = buffer->next_used)
    if (is_apart(buffer))
      buffer_use(device, buffer, buffer->readable);
}

/* ---- what shaders write ---- */

void d3d12_use_stores(gpu_device *device, const gpu_bindings *bindings) {
  const gpu_bindings_info *info = &bindings->info;
  for (uint32_t i = 0; i < bindings->store_image_count; i++)
    d3d12_image_use(device, info->store_images[i]->image, &info->store_images[i]->range,
                    D3D12_RESOURCE_STATE_UNORDERED_ACCESS);
  for (uint32_t i = 0; i < bindings->store_buffer_count; i++)
    d3d12_buffer_use_store(device, info->store_buffers[i].buffer);
}

/* ---- the end of a recording ---- */

void d3d12_rest(gpu_device *device) {
  d3d12_settle_buffers(device);
  d3d12_flush_barriers(device);
  for (gpu_buffer *buffer = device->used_buffers; buffer; buffer = buffer->next_used)
    buffer_use(device, buffer, D3D12_RESOURCE_STATE_COMMON);
  for (gpu_image *image = device->used_images; image; image = image->next_used)
    if (image->sampled)
      d3d12_image_use(device, image, NULL, D3D12_STATE_READABLE);
  d3d12_flush_barriers(device);
}

/* Buffers end in the state that they began in. */
void d3d12_release_used(gpu_device *device, bool recorded) {
  for (gpu_buffer *buffer = device->used_buffers; buffer; buffer = buffer->next_used)
    buffer->used = false;
  for (gpu_image *image = device->used_images; image; image = image->next_used) {
    if (!recorded)
      memcpy(image->states, image->before, image->layer_count * image->level_count * sizeof *image->states);
    image->used = false;
  }
  device->used_buffers = NULL;
  device->used_images = NULL;
}
