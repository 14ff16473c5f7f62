/* pass.c: what a recording holds in passes. */
#include "internal.h"

/* ---- beginning ---- */

static VkClearValue color_of(gpu_format format, const float color[4]) {
  VkClearValue value = {.color = {.float32 = {color[0], color[1], color[2], color[3]}}};
  if (format == GPU_FORMAT_R32_UINT)
    value = (VkClearValue){.color = {.uint32 = {(uint32_t)color[0]}}};
  return value;
}

static VkClearValue depth_of(float depth) {
  return (VkClearValue){.depthStencil = {.depth = depth}};
}

static void render_pass_begin(gpu_device *device, const gpu_pass_info *info, VkRect2D area) {
  const gpu_target *target = info->target;
  const gpu_format depth = target->depth.image ? target->depth.image->format : GPU_FORMAT_NONE;
  const gpu_format color = target->color.image ? target->color.image->format : GPU_FORMAT_NONE;
  VkClearValue values[2];
  uint32_t count = 0;
  if (depth)
    values[count++] = depth_of(info->clear_depth);
  if (color)
    values[count++] = color_of(color, info->clear_color);
  const VkRenderPassBeginInfo begin = {
      .sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
      .renderPass = device->passes[depth][color][depth ? info->depth_load : 0][color ? info->color_load : 0],
      .framebuffer = target->framebuffer,
      .renderArea = area,
      .clearValueCount = count,
      .pClearValues = values};
  device->vk.CmdBeginRenderPass(device->commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
}

static VkRenderingAttachmentInfo attachment_of(const vulkan_attachment *attachment, VkImageLayout layout, gpu_load load,
                                               VkClearValue clear) {
  static const VkAttachmentLoadOp loads[VULKAN_LOADS] = {[GPU_LOAD_KEEP] = VK_ATTACHMENT_LOAD_OP_LOAD,
                                                         [GPU_LOAD_DISCARD] = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                         [GPU_LOAD_CLEAR] = VK_ATTACHMENT_LOAD_OP_CLEAR};
  return (VkRenderingAttachmentInfo){.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                     .imageView = attachment->view,
                                     .imageLayout = layout,
                                     .loadOp = loads[load],
                                     .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                     .clearValue = clear};
}

static void rendering_begin(gpu_device *device, const gpu_pass_info *info, VkRect2D area) {
  const gpu_target *target = info->target;
  const gpu_image *drawn = target->color.image;
  const VkRenderingAttachmentInfo depth =
      attachment_of(&target->depth, vulkan_use_depth.layout, info->depth_load, depth_of(info->clear_depth));
  const VkRenderingAttachmentInfo color =
      attachment_of(&target->color, vulkan_use_color.layout, info->color_load,
                    color_of(drawn ? drawn->format : GPU_FORMAT_NONE, info->clear_color));
  const VkRenderingInfo rendering = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                     .renderArea = area,
                                     .layerCount = 1,
                                     .colorAttachmentCount = drawn ? 1 : 0,
                                     .pColorAttachments = &color,
                                     .pDepthAttachment = target->depth.image ? &depth : NULL};
  device->vk.CmdBeginRendering(device->commands, &rendering);
}

static void use_attachment(gpu_device *device, const vulkan_attachment *attachment, const vulkan_use *use,
                           bool discard) {
  if (attachment->image)
    vulkan_image_use(device, attachment->image, &attachment->range, use, discard);
}

static void use_stores(gpu_device *device, const gpu_bindings *stores) {
  for (uint32_t i = 0; i < stores->store_image_count; i++)
    vulkan_image_use(device, stores->store_images[i].image, &stores->store_images[i].range, &vulkan_use_draw_store,
                     false);
}

/* What clip space covers, and the part of it that is drawn. */
static void cover(gpu_device *device, const gpu_rect *space, const gpu_rect *area) {
  /* Texel row 0 is clip y = +1; this very form gives the bits that vkd3d draws. */
  const VkViewport viewport = {.x = (float)space->x,
                               .y = (float)space->y + (float)space->height,
                               .width = (float)space->width,
                               .height = -(float)space->height,
                               .maxDepth = 1};
  const VkRect2D scissor = {.offset = {(int32_t)area->x, (int32_t)area->y}, .extent = {area->width, area->height}};
  device->vk.CmdSetViewport(device->commands, 0, 1, &viewport);
  device->vk.CmdSetScissor(device->commands, 0, 1, &scissor);
}

void vulkan_pass_begin(gpu_device *device, const gpu_pass_info *info) {
  const gpu_target *target = info->target;
  const bool whole = !info->area.width || (info->area.width == target->width && info->area.height == target->height);
  const gpu_rect area = whole ? (gpu_rect){.width = target->width, .height = target->height} : info->area;
  const VkRect2D rect = {.offset = {(int32_t)area.x, (int32_t)area.y}, .extent = {area.width, area.height}};
  device->target = target;
  vulkan_use_buffers(device, VULKAN_DRAWS, info->stores && info->stores->store_buffer_count);
  use_attachment(device, &target->depth, &vulkan_use_depth, whole && info->depth_load != GPU_LOAD_KEEP);
  use_attachment(device, &target->color, &vulkan_use_color, whole && info->color_load != GPU_LOAD_KEEP);
  if (info->stores)
    use_stores(device, info->stores);
  if (device->dynamic_rendering)
    rendering_begin(device, info, rect);
  else
    render_pass_begin(device, info, rect);
  cover(device, info->clip_space.width ? &info->clip_space : &area, &area);
}

void vulkan_pass_area(gpu_device *device, const gpu_rect *area) {
  cover(device, area, area);
}

void vulkan_pass_end(gpu_device *device) {
  if (device->dynamic_rendering)
    device->vk.CmdEndRendering(device->commands);
  else
    device->vk.CmdEndRenderPass(device->commands);
}

/* ---- drawing ---- */

void vulkan_pass_program(gpu_device *device, gpu_program *program) {
  device->stream_count = program->stream_count;
  device->vk.CmdBindPipeline(device->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, program->pipeline);
}

void vulkan_pass_bind(gpu_device *device, gpu_bindings *bindings, const uint32_t *offsets) {
  if (bindings->set)
    device->vk.CmdBindDescriptorSets(device->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, bindings->layout, 0, 1,
                                     &bindings->set, bindings->constants_count, offsets);
}

static void draw_vertices(gpu_device *device, const gpu_draw *draw) {
  if (draw->arguments)
    device->vk.CmdDrawIndirect(device->commands, draw->arguments->handle, draw->arguments_offset, 1,
                               sizeof(gpu_indirect_draw));
  else
    device->vk.CmdDraw(device->commands, draw->count, draw->instance_count, 0, 0);
}

static void draw_indices(gpu_device *device, const gpu_draw *draw) {
  device->vk.CmdBindIndexBuffer(device->commands, draw->indices->handle, draw->index_offset,
                                draw->index_size == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32);
  if (draw->arguments)
    device->vk.CmdDrawIndexedIndirect(device->commands, draw->arguments->handle, draw->arguments_offset, 1,
                                      sizeof(gpu_indirect_indexed));
  else
    device->vk.CmdDrawIndexed(device->commands, draw->count, draw->instance_count, 0, 0, 0);
}

void vulkan_pass_draw(gpu_device *device, const gpu_draw *draw) {
  VkBuffer streams[GPU_MAX_STREAMS];
  for (uint32_t i = 0; i < device->stream_count; i++)
    streams[i] = draw->streams[i]->handle;
  if (device->stream_count)
    device->vk.CmdBindVertexBuffers(device->commands, 0, device->stream_count, streams, draw->stream_offsets);
  if (draw->indices)
    draw_indices(device, draw);
  else
    draw_vertices(device, draw);
}

void vulkan_pass_native(gpu_device *device, gpu_native_pass *out) {
  const gpu_target *target = device->target;
  *out = (gpu_native_pass){.command_buffer = device->commands};
  vulkan_target_native(device, target->depth.image ? target->depth.image->format : GPU_FORMAT_NONE,
                       target->color.image ? target->color.image->format : GPU_FORMAT_NONE, &out->target);
}
