/* target.c: what draws go into: render passes and framebuffers, or views alone with dynamic rendering. */
#include "internal.h"

/* ---- render passes ---- */

/* The layout does not change in the pass: barriers before and after it do that, where the state is tracked. */
static VkAttachmentReference attachment_add(VkAttachmentDescription *attachments, uint32_t *count, gpu_format format,
                                            VkImageLayout layout, gpu_load load) {
  static const VkAttachmentLoadOp loads[VULKAN_LOADS] = {[GPU_LOAD_KEEP] = VK_ATTACHMENT_LOAD_OP_LOAD,
                                                         [GPU_LOAD_DISCARD] = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                         [GPU_LOAD_CLEAR] = VK_ATTACHMENT_LOAD_OP_CLEAR};
  attachments[*count] = (VkAttachmentDescription){.format = vulkan_format(format),
                                                  .samples = VK_SAMPLE_COUNT_1_BIT,
                                                  .loadOp = loads[load],
                                                  .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                                  .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                  .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                  .initialLayout = layout,
                                                  .finalLayout = layout};
  return (VkAttachmentReference){.attachment = (*count)++, .layout = layout};
}

static csm_result pass_create(gpu_device *device, gpu_format depth, gpu_format color, const gpu_load loads[2],
                              VkRenderPass *pass) {
  VkAttachmentDescription attachments[2];
  uint32_t count = 0;
  VkAttachmentReference depth_reference = {0}, color_reference = {0};
  if (depth)
    depth_reference = attachment_add(attachments, &count, depth, vulkan_use_depth.layout, loads[0]);
  if (color)
    color_reference = attachment_add(attachments, &count, color, vulkan_use_color.layout, loads[1]);
  const VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                        .colorAttachmentCount = color ? 1 : 0,
                                        .pColorAttachments = &color_reference,
                                        .pDepthStencilAttachment = depth ? &depth_reference : NULL};
  const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                       .attachmentCount = count,
                                       .pAttachments = attachments,
                                       .subpassCount = 1,
                                       .pSubpasses = &subpass};
  const csm_result result =
      vulkan_made(device, device->vk.CreateRenderPass(device->handle, &info, NULL, pass), pass, "vkCreateRenderPass");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_RENDER_PASS, (uint64_t)*pass,
                depth ? color ? "depth and colour" : "depth" : "colour");
  return result;
}

csm_result vulkan_passes_create(gpu_device *device, gpu_format depth, gpu_format color) {
  if (device->dynamic_rendering)
    return CSM_SUCCESS;
  csm_result result = CSM_SUCCESS;
  for (gpu_load d = 0; d < (depth ? VULKAN_LOADS : 1); d++)
    for (gpu_load c = 0; c < (color ? VULKAN_LOADS : 1) && result == CSM_SUCCESS; c++) {
      VkRenderPass *pass = &device->passes[depth][color][d][c];
      if (!*pass)
        result = pass_create(device, depth, color, (const gpu_load[]){d, c}, pass);
    }
  return result;
}

csm_result vulkan_target_native(gpu_device *device, gpu_format depth, gpu_format color, gpu_native_target *out) {
  *out = (gpu_native_target){0};
  const csm_result result = vulkan_passes_create(device, depth, color);
  if (result == CSM_SUCCESS)
    *out = (gpu_native_target){.depth_format = (uint32_t)vulkan_format(depth),
                               .color_format = (uint32_t)vulkan_format(color),
                               .render_pass = (uint64_t)device->passes[depth][color][GPU_LOAD_KEEP][GPU_LOAD_KEEP],
                               .dynamic_rendering = device->dynamic_rendering};
  return result;
}

/* ---- targets ---- */

static csm_result framebuffer_create(gpu_device *device, gpu_target *target, VkRenderPass pass, const char *name) {
  VkImageView views[2];
  uint32_t count = 0;
  if (target->depth.image)
    views[count++] = target->depth.view;
  if (target->color.image)
    views[count++] = target->color.view;
  const VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                        .renderPass = pass,
                                        .attachmentCount = count,
                                        .pAttachments = views,
                                        .width = target->width,
                                        .height = target->height,
                                        .layers = 1};
  const csm_result result =
      vulkan_made(device, device->vk.CreateFramebuffer(device->handle, &info, NULL, &target->framebuffer),
                  &target->framebuffer, "vkCreateFramebuffer");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_FRAMEBUFFER, (uint64_t)target->framebuffer, name);
  return result;
}

static csm_result attach(gpu_device *device, gpu_target *target, vulkan_attachment *attachment, const char *name) {
  gpu_image *image = attachment->image;
  if (!image)
    return CSM_SUCCESS;
  target->width = gpu_level_size(image->width, attachment->range.first_level);
  target->height = gpu_level_size(image->height, attachment->range.first_level);
  return vulkan_image_view(device, &(gpu_view_info){.name = name, .image = image, .range = attachment->range}, false,
                           &attachment->view);
}

csm_result vulkan_target_create(gpu_device *device, const gpu_target_info *info, gpu_target **out) {
  *out = NULL;
  gpu_target *target = lent_allocate(&device->lent, sizeof *target);
  if (!target)
    return CSM_ERROR_OUT_OF_MEMORY;
  target->depth = (vulkan_attachment){.image = info->depth, .range = {info->depth_layer, 1, info->depth_level, 1}};
  target->color = (vulkan_attachment){.image = info->color, .range = {info->color_layer, 1, info->color_level, 1}};
  const gpu_format depth = info->depth ? info->depth->format : GPU_FORMAT_NONE;
  const gpu_format color = info->color ? info->color->format : GPU_FORMAT_NONE;

  csm_result result = vulkan_passes_create(device, depth, color);
  if (result == CSM_SUCCESS)
    result = attach(device, target, &target->depth, info->name);
  if (result == CSM_SUCCESS)
    result = attach(device, target, &target->color, info->name);
  if (result == CSM_SUCCESS && !device->dynamic_rendering)
    result = framebuffer_create(device, target, device->passes[depth][color][GPU_LOAD_KEEP][GPU_LOAD_KEEP], info->name);
  if (result == CSM_SUCCESS)
    *out = target;
  else
    vulkan_target_destroy(device, target);
  return result;
}

void vulkan_target_destroy(gpu_device *device, gpu_target *target) {
  if (!target)
    return;
  device->vk.DestroyFramebuffer(device->handle, target->framebuffer, NULL);
  device->vk.DestroyImageView(device->handle, target->color.view, NULL);
  device->vk.DestroyImageView(device->handle, target->depth.view, NULL);
  lent_release(&device->lent, target);
}
