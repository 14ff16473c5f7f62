/*
 * state.c: barriers. State is tracked in recording order, which is submission order on the one queue, so a barrier also
 * orders a frame after the frames before it.
 *
 * Images: the last use of each {layer, level} is known. A barrier stands where the next use differs, or writes again.
 * Buffers: copies are ordered among each other by range. Copies, draws and dispatches are ordered against each other
 * for all buffers at once: a pass can hold no barrier, and what it draws is not known when it begins.
 */
#include "internal.h"

#include <string.h>

/* ---- images ---- */

const vulkan_use vulkan_use_overwrite = {.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                         .stages = VK_PIPELINE_STAGE_TRANSFER_BIT,
                                         .access = VK_ACCESS_TRANSFER_WRITE_BIT};
const vulkan_use vulkan_use_copy = {.layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                    .stages = VK_PIPELINE_STAGE_TRANSFER_BIT,
                                    .access = VK_ACCESS_TRANSFER_READ_BIT};
const vulkan_use vulkan_use_depth = {
    .layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    .stages = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT,
    .access = VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT};
const vulkan_use vulkan_use_color = {.layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                     .stages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                     .access =
                                         VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT};
const vulkan_use vulkan_use_dispatch_store = {.layout = VK_IMAGE_LAYOUT_GENERAL,
                                              .stages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                              .access = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
const vulkan_use vulkan_use_draw_store = {.layout = VK_IMAGE_LAYOUT_GENERAL,
                                          .stages = VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                                          .access = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};

static const VkAccessFlags write_access = VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
                                          VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_SHADER_WRITE_BIT;

static vulkan_use *state_at(gpu_image *image, uint32_t layer, uint32_t level) {
  return &image->states[layer * image->level_count + level];
}

static bool same_use(const vulkan_use *a, const vulkan_use *b) {
  return a->layout == b->layout && a->stages == b->stages && a->access == b->access && a->ready == b->ready;
}

static bool needs_barrier(const vulkan_use *last, const vulkan_use *next) {
  const bool again = last->layout == next->layout && last->stages == next->stages && last->access == next->access;
  return !again || ((next->access & write_access) && !last->ready);
}

static void set_use(gpu_image *image, const gpu_range *range, const vulkan_use *use, bool ready) {
  for (uint32_t layer = 0; layer < range->layer_count; layer++)
    for (uint32_t level = 0; level < range->level_count; level++) {
      vulkan_use *state = state_at(image, range->first_layer + layer, range->first_level + level);
      *state = *use;
      state->ready = ready;
    }
}

/* A barrier for states that are all the same. */
static void range_barrier(gpu_device *device, gpu_image *image, const gpu_range *range, const vulkan_use *next,
                          bool discard) {
  const vulkan_use last = *state_at(image, range->first_layer, range->first_level);
  if (!needs_barrier(&last, next))
    return;
  const VkImageMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
                                        .srcAccessMask = last.access & write_access,
                                        .dstAccessMask = next->access,
                                        .oldLayout = discard ? VK_IMAGE_LAYOUT_UNDEFINED : last.layout,
                                        .newLayout = next->layout,
                                        .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                        .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                        .image = image->handle,
                                        .subresourceRange = vulkan_subresources(image, range)};
  device->vk.CmdPipelineBarrier(device->commands, last.stages ? last.stages : VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                                next->stages, 0, 0, NULL, 0, NULL, 1, &barrier);
  set_use(image, range, next, true);
}

static bool uniform(gpu_image *image, const gpu_range *range) {
  const vulkan_use *first = state_at(image, range->first_layer, range->first_level);
  for (uint32_t layer = 0; layer < range->layer_count; layer++)
    for (uint32_t level = 0; level < range->level_count; level++)
      if (!same_use(first, state_at(image, range->first_layer + layer, range->first_level + level)))
        return false;
  return true;
}

/* One barrier for each run of layers of a level that is in the same state. */
static void level_barriers(gpu_device *device, gpu_image *image, const gpu_range *layers, uint32_t level,
                           const vulkan_use *next, bool discard) {
  const uint32_t end = layers->first_layer + layers->layer_count;
  for (uint32_t run = layers->first_layer, stop; run < end; run = stop) {
    for (stop = run + 1; stop < end && same_use(state_at(image, run, level), state_at(image, stop, level));)
      stop++;
    const gpu_range part = {.first_layer = run, .layer_count = stop - run, .first_level = level, .level_count = 1};
    range_barrier(device, image, &part, next, discard);
  }
}

void vulkan_image_prepare(gpu_device *device, gpu_image *image, const gpu_range *range, const vulkan_use *next,
                          bool discard) {
  if (!image->used) {
    image->used = true;
    image->next_used = device->used_images;
    device->used_images = image;
    memcpy(image->before, image->states, image->layer_count * image->level_count * sizeof *image->states);
  }
  if (uniform(image, range)) {
    range_barrier(device, image, range, next, discard);
    return;
  }
  for (uint32_t level = 0; level < range->level_count; level++)
    level_barriers(device, image, range, range->first_level + level, next, discard);
}

void vulkan_image_use(gpu_device *device, gpu_image *image, const gpu_range *range, const vulkan_use *next,
                      bool discard) {
  vulkan_image_prepare(device, image, range, next, discard);
  set_use(image, range, next, false);
}

void vulkan_release_used(gpu_device *device, bool recorded) {
  for (gpu_image *image = device->used_images; image; image = image->next_used) {
    if (!recorded)
      memcpy(image->states, image->before, image->layer_count * image->level_count * sizeof *image->states);
    image->used = false;
  }
  device->used_images = NULL;
}

/* ---- buffers ---- */

void vulkan_memory_barrier(gpu_device *device, VkPipelineStageFlags from, VkAccessFlags written,
                           VkPipelineStageFlags to, VkAccessFlags access) {
  const VkMemoryBarrier barrier = {
      .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER, .srcAccessMask = written, .dstAccessMask = access};
  device->vk.CmdPipelineBarrier(device->commands, from, to, 0, 1, &barrier, 0, NULL, 0, NULL);
}

/* Where work of a kind reads and writes buffers. */
typedef struct work_scope {
  VkPipelineStageFlags stages;
  VkAccessFlags reads, writes;
} work_scope;

/* No stage is waited for that no buffer is made for. */
static work_scope scope_of(const gpu_device *device, vulkan_work work) {
  const bool shaders = device->buffer_usage & (GPU_BUFFER_READ | GPU_BUFFER_WRITE);
  work_scope scope = {.stages = VK_PIPELINE_STAGE_TRANSFER_BIT,
                      .reads = VK_ACCESS_TRANSFER_READ_BIT,
                      .writes = VK_ACCESS_TRANSFER_WRITE_BIT};
  if (work == VULKAN_DRAWS)
    scope = (work_scope){.stages = VK_PIPELINE_STAGE_VERTEX_INPUT_BIT,
                         .reads = VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_INDEX_READ_BIT};
  if (work == VULKAN_DRAWS && shaders)
    scope.stages |= VK_PIPELINE_STAGE_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT;
  if (work == VULKAN_DISPATCHES)
    scope = (work_scope){.stages = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT};
  if (work != VULKAN_COPIES && shaders) {
    scope.reads |= VK_ACCESS_SHADER_READ_BIT;
    scope.writes |= VK_ACCESS_SHADER_WRITE_BIT;
  }
  if (work != VULKAN_COPIES && (device->buffer_usage & GPU_BUFFER_INDIRECT)) {
    scope.stages |= VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT;
    scope.reads |= VK_ACCESS_INDIRECT_COMMAND_READ_BIT;
  }
  return scope;
}

void vulkan_use_buffers(gpu_device *device, vulkan_work work, bool writes) {
  const uint32_t all = (1u << VULKAN_WORKS) - 1, bit = 1u << work;
  VkPipelineStageFlags from = 0;
  VkAccessFlags written = 0;
  for (vulkan_work before = 0; before < VULKAN_WORKS; before++) {
    if (work == VULKAN_COPIES && before == VULKAN_COPIES)
      continue; /* vulkan_copy_range sees to these */
    const work_scope scope = scope_of(device, before);
    if (device->written[before] & bit)
      written |= scope.writes;
    if ((device->written[before] & bit) || (writes && (device->accessed[before] & bit)))
      from |= scope.stages;
    else
      continue;
    device->written[before] &= ~bit;
    device->accessed[before] &= ~bit;
  }
  const work_scope to = scope_of(device, work);
  if (from)
    vulkan_memory_barrier(device, from, written, to.stages, written ? to.reads | to.writes : 0);
  device->accessed[work] |= all;
  if (writes)
    device->written[work] |= all;
}

/* An engine's shaders may read buffers between recordings, as draws and dispatches do. */
static void rest_buffers(gpu_device *device) {
  if (!(device->buffer_usage & GPU_BUFFER_READ))
    return;
  vulkan_use_buffers(device, VULKAN_DRAWS, false);
  if (device->info.can.compute)
    vulkan_use_buffers(device, VULKAN_DISPATCHES, false);
}

void vulkan_rest(gpu_device *device) {
  for (gpu_image *image = device->used_images; image; image = image->next_used) {
    const gpu_range all = vulkan_range(image, NULL);
    if (image->view)
      vulkan_image_use(device, image, &all, &device->read, false);
  }
  rest_buffers(device);
}

void vulkan_copy_range(gpu_device *device, gpu_buffer *buffer, uint64_t offset, uint64_t size) {
  if (buffer->kind == GPU_BUFFER_UPLOAD)
    return; /* only ever read */
  if (buffer->epoch == device->epoch && offset < buffer->copied_end && buffer->copied_begin < offset + size) {
    vulkan_memory_barrier(device, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
    device->epoch++;
  }
  const bool first = buffer->epoch != device->epoch;
  if (first || offset < buffer->copied_begin)
    buffer->copied_begin = offset;
  if (first || offset + size > buffer->copied_end)
    buffer->copied_end = offset + size;
  buffer->epoch = device->epoch;
}
