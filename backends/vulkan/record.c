/*
 * record.c: recordings. State is tracked in recording order, which is submission order on the one queue, so a barrier
 * also orders a frame after the frames before it.
 *
 * Images: each layer's last use is known; a barrier stands where the next use differs or writes again.
 * Buffers: transfers among each other by range; transfers against draws for all buffers at once, since passes cannot
 * hold barriers and what they will draw is not known when they begin.
 */
#include "internal.h"

#include <string.h>

static const vulkan_use use_overwrite = {.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                         .stages = VK_PIPELINE_STAGE_TRANSFER_BIT,
                                         .access = VK_ACCESS_TRANSFER_WRITE_BIT};
static const vulkan_use use_copy = {.layout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                                    .stages = VK_PIPELINE_STAGE_TRANSFER_BIT,
                                    .access = VK_ACCESS_TRANSFER_READ_BIT};
static const vulkan_use use_depth = {
    .layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
    .stages = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT,
    .access = VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT};
static const vulkan_use use_color = {.layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                     .stages = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                     .access = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT};

static const VkAccessFlags write_access =
    VK_ACCESS_TRANSFER_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;

/* ---- barriers for images ---- */

static bool same_use(const vulkan_use *a, const vulkan_use *b) {
  return a->layout == b->layout && a->stages == b->stages && a->access == b->access && a->ready == b->ready;
}

static bool needs_barrier(const vulkan_use *last, const vulkan_use *next) {
  const bool again = last->layout == next->layout && last->stages == next->stages && last->access == next->access;
  return !again || ((next->access & write_access) && !last->ready);
}

static void layers_barrier(gpu_device *device, gpu_image *image, uint32_t first, uint32_t count, const vulkan_use *next,
                           bool discard) {
  const vulkan_use last = image->layers[first];
  const VkImageMemoryBarrier barrier = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
      .srcAccessMask = last.access & write_access,
      .dstAccessMask = next->access,
      .oldLayout = discard ? VK_IMAGE_LAYOUT_UNDEFINED : last.layout,
      .newLayout = next->layout,
      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .image = image->handle,
      .subresourceRange = {.aspectMask = image->aspect, .levelCount = 1, .baseArrayLayer = first, .layerCount = count}};
  device->vk.CmdPipelineBarrier(device->commands, last.stages ? last.stages : VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT,
                                next->stages, 0, 0, NULL, 0, NULL, 1, &barrier);
  for (uint32_t i = 0; i < count; i++) {
    image->layers[first + i] = *next;
    image->layers[first + i].ready = true;
  }
}

/* Puts the barriers that a use of these layers needs, one for each run of layers in the same state. */
static void image_prepare(gpu_device *device, gpu_image *image, uint32_t first, uint32_t count, const vulkan_use *next,
                          bool discard) {
  if (!image->used) {
    image->used = true;
    image->next_used = device->used;
    device->used = image;
    memcpy(image->before, image->layers, image->layer_count * sizeof *image->layers);
  }
  const uint32_t end = first + count;
  for (uint32_t run = first, stop; run < end; run = stop) {
    for (stop = run + 1; stop < end && same_use(&image->layers[run], &image->layers[stop]);)
      stop++;
    if (needs_barrier(&image->layers[run], next))
      layers_barrier(device, image, run, stop - run, next, discard);
  }
}

/* The same, for a use that takes place now. */
static void image_use(gpu_device *device, gpu_image *image, uint32_t first, uint32_t count, const vulkan_use *next,
                      bool discard) {
  image_prepare(device, image, first, count, next, discard);
  for (uint32_t i = 0; i < count; i++)
    image->layers[first + i].ready = false;
}

void vulkan_rest_images(gpu_device *device) {
  for (gpu_image *image = device->used; image; image = image->next_used)
    if (image->view)
      image_use(device, image, 0, image->layer_count, &device->read, false);
}

void vulkan_release_images(gpu_device *device, bool recorded) {
  for (gpu_image *image = device->used; image; image = image->next_used) {
    if (!recorded)
      memcpy(image->layers, image->before, image->layer_count * sizeof *image->layers);
    image->used = false;
  }
  device->used = NULL;
}

/* ---- barriers for buffers ---- */

void vulkan_memory_barrier(gpu_device *device, VkPipelineStageFlags from, VkAccessFlags written,
                           VkPipelineStageFlags to, VkAccessFlags access) {
  const VkMemoryBarrier barrier = {
      .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER, .srcAccessMask = written, .dstAccessMask = access};
  device->vk.CmdPipelineBarrier(device->commands, from, to, 0, 1, &barrier, 0, NULL, 0, NULL);
}

/* A copy is about to read or write this range. */
static void transfer_range(gpu_device *device, gpu_buffer *buffer, uint64_t offset, uint64_t size) {
  if (buffer->kind == GPU_BUFFER_UPLOAD)
    return; /* only ever read */
  if (buffer->epoch == device->epoch && offset < buffer->copied_to && buffer->copied_from < offset + size) {
    vulkan_memory_barrier(device, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                          VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT);
    device->epoch++;
  }
  const bool first = buffer->epoch != device->epoch;
  if (first || offset < buffer->copied_from)
    buffer->copied_from = offset;
  if (first || offset + size > buffer->copied_to)
    buffer->copied_to = offset + size;
  buffer->epoch = device->epoch;
}

/* ---- markers and timestamps ---- */

void vulkan_marker_begin(gpu_device *device, const char *name) {
  if (!device->debug)
    return;
  const VkDebugUtilsLabelEXT label = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT, .pLabelName = name};
  device->vk.CmdBeginDebugUtilsLabelEXT(device->commands, &label);
}

void vulkan_marker_end(gpu_device *device) {
  if (device->debug)
    device->vk.CmdEndDebugUtilsLabelEXT(device->commands);
}

/* Outside passes. What follows starts after what went before, so the time between two belongs to what is between. */
void vulkan_timestamp(gpu_device *device, uint32_t index) {
  if (!device->slot->queries)
    return;
  vulkan_memory_barrier(device, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0);
  device->vk.CmdWriteTimestamp(device->commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, device->slot->queries, index);
}

/* ---- outside passes ---- */

void vulkan_copy_buffer(gpu_device *device, gpu_buffer *to, uint64_t to_offset, gpu_buffer *from, uint64_t from_offset,
                        uint64_t size) {
  transfer_range(device, from, from_offset, size);
  transfer_range(device, to, to_offset, size);
  if (to->kind == GPU_BUFFER_READBACK) {
    device->readback_written = true;
  } else {
    if (device->vertices_drawn)
      vulkan_memory_barrier(device, VK_PIPELINE_STAGE_VERTEX_INPUT_BIT, 0, VK_PIPELINE_STAGE_TRANSFER_BIT, 0);
    device->vertices_drawn = false;
    device->vertices_copied = true;
  }
  const VkBufferCopy region = {.srcOffset = from_offset, .dstOffset = to_offset, .size = size};
  device->vk.CmdCopyBuffer(device->commands, from->handle, to->handle, 1, &region);
}

void vulkan_copy_image(gpu_device *device, gpu_buffer *to, uint64_t offset, uint32_t row_bytes, gpu_image *image,
                       const gpu_region *from) {
  transfer_range(device, to, offset, (uint64_t)row_bytes * from->height);
  device->readback_written = true;
  image_use(device, image, from->layer, 1, &use_copy, false);
  const VkBufferImageCopy region = {
      .bufferOffset = offset,
      .bufferRowLength = row_bytes / gpu_format_bytes(image->format),
      .imageSubresource = {.aspectMask = image->aspect, .baseArrayLayer = from->layer, .layerCount = 1},
      .imageOffset = {(int32_t)from->x, (int32_t)from->y, 0},
      .imageExtent = {from->width, from->height, 1}};
  device->vk.CmdCopyImageToBuffer(device->commands, image->handle, use_copy.layout, to->handle, 1, &region);
}

void vulkan_copy_to_image(gpu_device *device, gpu_image *to, gpu_buffer *from, uint64_t offset, uint32_t row_bytes) {
  transfer_range(device, from, offset, (uint64_t)row_bytes * to->height);
  image_use(device, to, 0, 1, &use_overwrite, true);
  const VkBufferImageCopy region = {.bufferOffset = offset,
                                    .bufferRowLength = row_bytes / gpu_format_bytes(to->format),
                                    .imageSubresource = {.aspectMask = to->aspect, .layerCount = 1},
                                    .imageExtent = {to->width, to->height, 1}};
  device->vk.CmdCopyBufferToImage(device->commands, from->handle, to->handle, use_overwrite.layout, 1, &region);
}

void vulkan_clear_depth(gpu_device *device, gpu_image *image, float depth) {
  image_use(device, image, 0, image->layer_count, &use_overwrite, true);
  const VkClearDepthStencilValue value = {.depth = depth};
  const VkImageSubresourceRange range = {
      .aspectMask = image->aspect, .levelCount = 1, .layerCount = image->layer_count};
  device->vk.CmdClearDepthStencilImage(device->commands, image->handle, use_overwrite.layout, &value, 1, &range);
  /* One barrier for all layers; else each layer's pass would begin with one, and wait for the pass before it. */
  image_prepare(device, image, 0, image->layer_count, &use_depth, false);
}

void vulkan_make_readable(gpu_device *device, gpu_image *image) {
  if (!image->borrowed)
    image_use(device, image, 0, image->layer_count, &device->read, false);
}

/* ---- passes ---- */

void vulkan_pass_begin(gpu_device *device, gpu_target *target) {
  const vulkan_functions *vk = &device->vk;
  if (device->vertices_copied)
    vulkan_memory_barrier(device, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
                          VK_PIPELINE_STAGE_VERTEX_INPUT_BIT,
                          VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_INDEX_READ_BIT);
  device->vertices_copied = false;
  device->vertices_drawn = true;
  device->target = target;
  if (target->depth)
    image_use(device, target->depth, target->depth_layer, 1, &use_depth, false);
  if (target->color)
    image_use(device, target->color, target->color_layer, 1, &use_color, true);

  const VkRenderPassBeginInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                      .renderPass = target->pass,
                                      .framebuffer = target->framebuffer,
                                      .renderArea = {.extent = {target->width, target->height}}};
  vk->CmdBeginRenderPass(device->commands, &info, VK_SUBPASS_CONTENTS_INLINE);
  vulkan_pass_area(device, &(gpu_rect){.width = target->width, .height = target->height});
}

void vulkan_pass_area(gpu_device *device, const gpu_rect *area) {
  /* Texel row 0 is clip y = +1; this very form gives the bits that vkd3d draws. */
  const VkViewport viewport = {.x = (float)area->x,
                               .y = (float)area->y + (float)area->height,
                               .width = (float)area->width,
                               .height = -(float)area->height,
                               .maxDepth = 1};
  const VkRect2D scissor = {.offset = {(int32_t)area->x, (int32_t)area->y}, .extent = {area->width, area->height}};
  device->vk.CmdSetViewport(device->commands, 0, 1, &viewport);
  device->vk.CmdSetScissor(device->commands, 0, 1, &scissor);
}

void vulkan_pass_end(gpu_device *device) {
  device->vk.CmdEndRenderPass(device->commands);
}

void vulkan_pass_program(gpu_device *device, gpu_program *program) {
  device->stream_count = program->stream_count;
  device->vk.CmdBindPipeline(device->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, program->pipeline);
}

void vulkan_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets) {
  if (bindings->set)
    device->vk.CmdBindDescriptorSets(device->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bindings->layout, 0, 1,
                                     &bindings->set, bindings->constants_count, offsets);
}

void vulkan_pass_draw(gpu_device *device, const gpu_draw *draw) {
  const vulkan_functions *vk = &device->vk;
  VkBuffer streams[GPU_MAX_STREAMS];
  for (uint32_t i = 0; i < device->stream_count; i++)
    streams[i] = draw->streams[i]->handle;
  if (device->stream_count)
    vk->CmdBindVertexBuffers(device->commands, 0, device->stream_count, streams, draw->stream_offsets);
  if (!draw->indices) {
    vk->CmdDraw(device->commands, draw->count, draw->instance_count, 0, 0);
    return;
  }
  vk->CmdBindIndexBuffer(device->commands, draw->indices->handle, draw->index_offset,
                         draw->index_size == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32);
  vk->CmdDrawIndexed(device->commands, draw->count, draw->instance_count, 0, 0, 0);
}

void vulkan_pass_native(gpu_device *device, gpu_native_pass *out) {
  const gpu_image *depth = device->target->depth;
  *out = (gpu_native_pass){.command_buffer = device->commands,
                           .render_pass = (uint64_t)device->target->pass,
                           .depth_format = depth ? (uint32_t)vulkan_format(depth->format) : VK_FORMAT_UNDEFINED};
}
