#include "bench/bare_mask.h"

#include "bench/bare_code.h"
#include "csm/csm.h"
#include "csm_constants.h"
#include "base/host.h"
#include "shader_code.h"
#include "native/vulkan_commands.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Where shaders/compile.py puts textures and samplers. */
enum { first_texture = 16, first_sampler = 48, camera_offset = 1024, block_bytes = 1280 };

struct bare_mask {
  bare_mask_info info;
  vulkan_device vulkan;
  VkDevice device; /* of it */
  vulkan_image depth, maps, mask;
  vulkan_buffer upload, blocks, read_back;
  VkSampler samplers[2]; /* point, of the depth and of the maps; comparing, linear */
  VkDescriptorSetLayout set_layout;
  VkDescriptorPool descriptors;
  VkDescriptorSet set;
  VkRenderPass pass;
  VkFramebuffer framebuffer;
  VkPipelineLayout layout;
  VkPipeline pipelines[BARE_PASSES];
  vulkan_commands commands;
};

static VkResult make_resources(bare_mask *m) {
  const uint32_t width = m->info.width, height = m->info.height, side = m->info.resolution;
  const VkDeviceSize pixels = (VkDeviceSize)width * height, texels = (VkDeviceSize)side * side;
  const VkImageUsageFlags read = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  const VkImageUsageFlags drawn = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  const vulkan_image_info images[] = {{VK_FORMAT_D32_SFLOAT, width, height, 0, read},
                                      {VK_FORMAT_D32_SFLOAT, side, side, m->info.cascade_count, read},
                                      {VK_FORMAT_R8_UNORM, width, height, 0, drawn}};
  vulkan_image *const made[] = {&m->depth, &m->maps, &m->mask};
  const vulkan_device *vulkan = &m->vulkan;
  VkResult result = VK_SUCCESS;
  for (int i = 0; i < 3 && !result; ++i)
    result = vulkan_image_open(made[i], vulkan, &images[i]);
  if (!result)
    result = vulkan_buffer_open(&m->upload, vulkan, 4 * (pixels > texels ? pixels : texels),
                                VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  if (!result)
    result = vulkan_buffer_open(&m->blocks, vulkan, block_bytes, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
  return result ? result : vulkan_buffer_open(&m->read_back, vulkan, pixels, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
}

/* ---- bindings and pipelines ---- */

static VkResult make_sampler(bare_mask *m, VkSampler *out, bool compares) {
  const VkFilter filter = compares ? VK_FILTER_LINEAR : VK_FILTER_NEAREST;
  const VkSamplerCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                    .magFilter = filter,
                                    .minFilter = filter,
                                    .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                    .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                    .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                    .compareEnable = compares,
                                    .compareOp = VK_COMPARE_OP_LESS_OR_EQUAL};
  return vkCreateSampler(m->device, &info, NULL, out);
}

enum { binding_count = 7, stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT };

static const VkDescriptorSetLayoutBinding bindings[binding_count] = {
    {0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, stages, NULL},
    {1, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, stages, NULL},
    {first_texture, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL},
    {first_texture + 1, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL},
    {first_sampler, VK_DESCRIPTOR_TYPE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL},
    {first_sampler + 1, VK_DESCRIPTOR_TYPE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL},
    {first_sampler + 2, VK_DESCRIPTOR_TYPE_SAMPLER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL}};

static VkResult make_set(bare_mask *m) {
  const VkDescriptorSetLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                  .bindingCount = binding_count,
                                                  .pBindings = bindings};
  VkResult result = vkCreateDescriptorSetLayout(m->device, &layout, NULL, &m->set_layout);
  if (result)
    return result;
  const VkDescriptorPoolSize sizes[] = {
      {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2}, {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 2}, {VK_DESCRIPTOR_TYPE_SAMPLER, 3}};
  const VkDescriptorPoolCreateInfo pool = {
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, .maxSets = 1, .poolSizeCount = 3, .pPoolSizes = sizes};
  result = vkCreateDescriptorPool(m->device, &pool, NULL, &m->descriptors);
  if (result)
    return result;
  const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = m->descriptors,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &m->set_layout};
  return vkAllocateDescriptorSets(m->device, &set, &m->set);
}

static void write_set(bare_mask *m) {
  const VkDescriptorBufferInfo blocks[] = {{m->blocks.buffer, 0, CSM_C_COUNT * 16},
                                           {m->blocks.buffer, camera_offset, CSM_M_COUNT * 16}};
  const VkDescriptorImageInfo images[] = {{VK_NULL_HANDLE, m->maps.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL},
                                          {VK_NULL_HANDLE, m->depth.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL},
                                          {m->samplers[0], VK_NULL_HANDLE, VK_IMAGE_LAYOUT_UNDEFINED},
                                          {m->samplers[0], VK_NULL_HANDLE, VK_IMAGE_LAYOUT_UNDEFINED},
                                          {m->samplers[1], VK_NULL_HANDLE, VK_IMAGE_LAYOUT_UNDEFINED}};
  VkWriteDescriptorSet writes[binding_count];
  for (uint32_t i = 0; i < binding_count; ++i)
    writes[i] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                       .dstSet = m->set,
                                       .dstBinding = bindings[i].binding,
                                       .descriptorCount = 1,
                                       .descriptorType = bindings[i].descriptorType,
                                       .pBufferInfo = i < 2 ? &blocks[i] : NULL,
                                       .pImageInfo = i < 2 ? NULL : &images[i - 2]};
  vkUpdateDescriptorSets(m->device, binding_count, writes, 0, NULL);
}

static VkResult make_bindings(bare_mask *m) {
  VkResult result = make_sampler(m, &m->samplers[0], false);
  if (!result)
    result = make_sampler(m, &m->samplers[1], true);
  if (!result)
    result = make_set(m);
  if (result)
    return result;
  write_set(m);
  const VkPipelineLayoutCreateInfo layout = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &m->set_layout};
  return vkCreatePipelineLayout(m->device, &layout, NULL, &m->layout);
}

static VkResult make_target(bare_mask *m) {
  const VkAttachmentDescription attachment = {.format = VK_FORMAT_R8_UNORM,
                                              .samples = VK_SAMPLE_COUNT_1_BIT,
                                              .loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                              .finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
  const VkAttachmentReference color = {.layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkSubpassDescription subpass = {
      .pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS, .colorAttachmentCount = 1, .pColorAttachments = &color};
  const VkRenderPassCreateInfo pass = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                       .attachmentCount = 1,
                                       .pAttachments = &attachment,
                                       .subpassCount = 1,
                                       .pSubpasses = &subpass};
  const VkResult result = vkCreateRenderPass(m->device, &pass, NULL, &m->pass);
  const VkFramebufferCreateInfo framebuffer = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                               .renderPass = m->pass,
                                               .attachmentCount = 1,
                                               .pAttachments = &m->mask.view,
                                               .width = m->info.width,
                                               .height = m->info.height,
                                               .layers = 1};
  return result ? result : vkCreateFramebuffer(m->device, &framebuffer, NULL, &m->framebuffer);
}

static VkResult create_pipeline(bare_mask *m, VkShaderModule vertex, VkShaderModule pixel, VkPipeline *out) {
  const VkPipelineShaderStageCreateInfo stages[] = {{.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                     .stage = VK_SHADER_STAGE_VERTEX_BIT,
                                                     .module = vertex,
                                                     .pName = "main"},
                                                    {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                     .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
                                                     .module = pixel,
                                                     .pName = "main"}};
  const VkPipelineVertexInputStateCreateInfo input = {.sType =
                                                          VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const VkPipelineInputAssemblyStateCreateInfo assembly = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const float width = (float)m->info.width, height = (float)m->info.height;
  const VkPipelineViewportStateCreateInfo viewport = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                                      .viewportCount = 1,
                                                      .pViewports = &(VkViewport){0, height, width, -height, 0, 1},
                                                      .scissorCount = 1,
                                                      .pScissors =
                                                          &(VkRect2D){{0, 0}, {m->info.width, m->info.height}}};
  const VkPipelineRasterizationStateCreateInfo raster = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo samples = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineColorBlendStateCreateInfo blend = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
      .attachmentCount = 1,
      .pAttachments = &(VkPipelineColorBlendAttachmentState){.colorWriteMask = VK_COLOR_COMPONENT_R_BIT}};
  const VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                             .stageCount = 2,
                                             .pStages = stages,
                                             .pVertexInputState = &input,
                                             .pInputAssemblyState = &assembly,
                                             .pViewportState = &viewport,
                                             .pRasterizationState = &raster,
                                             .pMultisampleState = &samples,
                                             .pColorBlendState = &blend,
                                             .layout = m->layout,
                                             .renderPass = m->pass};
  return vkCreateGraphicsPipelines(m->device, VK_NULL_HANDLE, 1, &info, NULL, out);
}

static VkResult make_pipeline(bare_mask *m, VkShaderModule vertex, const void *code, size_t size, bare_pass pass) {
  VkShaderModule pixel;
  VkResult result = vulkan_shader(&m->vulkan, code, size, &pixel);
  if (result)
    return result;
  result = create_pipeline(m, vertex, pixel, &m->pipelines[pass]);
  vkDestroyShaderModule(m->device, pixel, NULL);
  return result;
}

static VkResult make_pipelines(bare_mask *m) {
  const gpu_code *seven = shader_find(shader_key_mask(CSM_FILTER_PCF_7X7, CSM_BIAS_SLOPE, 0, 0, 0, 0));
  VkShaderModule vertex;
  VkResult result = vulkan_shader(&m->vulkan, shader_mask_vs.spirv, shader_mask_vs.spirv_size, &vertex);
  if (result)
    return result;
  result = make_pipeline(m, vertex, bare_floor_ps, sizeof bare_floor_ps, BARE_FLOOR);
  if (!result)
    result = make_pipeline(m, vertex, bare_set_up_ps, sizeof bare_set_up_ps, BARE_SET_UP);
  if (!result)
    result = make_pipeline(m, vertex, bare_loop_49_ps, sizeof bare_loop_49_ps, BARE_LOOP_49);
  if (!result)
    result = make_pipeline(m, vertex, seven->spirv, seven->spirv_size, BARE_PCF_7X7);
  vkDestroyShaderModule(m->device, vertex, NULL);
  return result;
}

/* ---- commands ---- */

static VkResult make_commands(bare_mask *m) {
  return vulkan_commands_open(&m->commands, &m->vulkan);
}

static void transition(bare_mask *m, VkImage image, uint32_t layer, bool written) {
  const VkImageMemoryBarrier info = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
      .srcAccessMask = written ? VK_ACCESS_TRANSFER_WRITE_BIT : 0,
      .dstAccessMask = written ? VK_ACCESS_SHADER_READ_BIT : VK_ACCESS_TRANSFER_WRITE_BIT,
      .oldLayout = written ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
      .newLayout = written ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .image = image,
      .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, layer, 1}};
  vkCmdPipelineBarrier(m->commands.buffer, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0,
                       NULL, 0, NULL, 1, &info);
}

static VkResult upload(bare_mask *m, VkImage image, uint32_t layer, uint32_t width, uint32_t height,
                       const float *depths) {
  const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, layer, 1},
                                    .imageExtent = {width, height, 1}};
  memcpy(m->upload.mapped, depths, (size_t)width * height * sizeof *depths);
  const VkResult result = vulkan_commands_begin(&m->commands);
  if (result)
    return result;
  transition(m, image, layer, false);
  vkCmdCopyBufferToImage(m->commands.buffer, m->upload.buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &region);
  transition(m, image, layer, true);
  return vulkan_commands_finish(&m->commands);
}

static VkResult upload_all(bare_mask *m) {
  const bare_mask_info *info = &m->info;
  memcpy(m->blocks.mapped, info->cascades, CSM_C_COUNT * 16);
  memcpy((char *)m->blocks.mapped + camera_offset, info->camera, CSM_M_COUNT * 16);
  VkResult result = upload(m, m->depth.image, 0, info->width, info->height, info->camera_depth);
  for (uint32_t i = 0; i < info->cascade_count && !result; ++i)
    result = upload(m, m->maps.image, i, info->resolution, info->resolution, info->maps[i]);
  return result;
}

static void record(bare_mask *m, bare_pass pass) {
  const VkRenderPassBeginInfo begin_pass = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                            .renderPass = m->pass,
                                            .framebuffer = m->framebuffer,
                                            .renderArea = {{0, 0}, {m->info.width, m->info.height}}};
  const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                    .imageExtent = {m->info.width, m->info.height, 1}};
  const VkCommandBuffer commands = m->commands.buffer;
  vulkan_commands_stamp(&m->commands, 0);
  vkCmdBeginRenderPass(commands, &begin_pass, VK_SUBPASS_CONTENTS_INLINE);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, m->pipelines[pass]);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, m->layout, 0, 1, &m->set, 0, NULL);
  vkCmdDraw(commands, 3, 1, 0, 0);
  vkCmdEndRenderPass(commands);
  vulkan_commands_stamp(&m->commands, 1);
  const VkMemoryBarrier drawn = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                 .srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                 .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT, VK_PIPELINE_STAGE_TRANSFER_BIT, 0, 1,
                       &drawn, 0, NULL, 0, NULL);
  vkCmdCopyImageToBuffer(commands, m->mask.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, m->read_back.buffer, 1,
                         &region);
}

double bare_mask_draw(bare_mask *m, bare_pass pass) {
  if (vulkan_commands_begin(&m->commands))
    return -1.0;
  record(m, pass);
  return vulkan_commands_finish(&m->commands) ? -1.0 : vulkan_commands_ms(&m->commands);
}

const uint8_t *bare_mask_pixels(const bare_mask *m) {
  return m->read_back.mapped;
}

/* ---- opening and closing ---- */

int bare_mask_open(bare_mask **out, const bare_mask_info *info, char *error, size_t error_size) {
  bare_mask *m = host_allocate(1, sizeof *m);
  *out = NULL;
  m->info = *info;
  VkResult result = vulkan_device_open(&m->vulkan, info->device);
  m->device = m->vulkan.device;
  VkResult (*const steps[])(bare_mask *) = {make_resources, make_bindings, make_target,
                                            make_pipelines, make_commands, upload_all};
  for (size_t i = 0; i < sizeof steps / sizeof steps[0] && !result; ++i)
    result = steps[i](m);
  if (result) {
    snprintf(error, error_size, "the bare mask: %s (VkResult %d)", vulkan_reason(result), (int)result);
    bare_mask_close(m);
    return HOST_NO_DEVICE;
  }
  *out = m;
  return 0;
}

static void destroy_objects(bare_mask *m) {
  vkDeviceWaitIdle(m->device);
  vulkan_commands_close(&m->commands);
  for (int i = 0; i < BARE_PASSES; ++i)
    vkDestroyPipeline(m->device, m->pipelines[i], NULL);
  vkDestroyFramebuffer(m->device, m->framebuffer, NULL);
  vkDestroyRenderPass(m->device, m->pass, NULL);
  vkDestroyPipelineLayout(m->device, m->layout, NULL);
  vkDestroyDescriptorPool(m->device, m->descriptors, NULL);
  vkDestroyDescriptorSetLayout(m->device, m->set_layout, NULL);
  for (int i = 0; i < 2; ++i)
    vkDestroySampler(m->device, m->samplers[i], NULL);
  const vulkan_image *const images[] = {&m->depth, &m->maps, &m->mask};
  const vulkan_buffer *const buffers[] = {&m->upload, &m->blocks, &m->read_back};
  for (int i = 0; i < 3; ++i) {
    vulkan_image_close(images[i], &m->vulkan);
    vulkan_buffer_close(buffers[i], &m->vulkan);
  }
}

void bare_mask_close(bare_mask *m) {
  if (!m)
    return;
  if (m->device)
    destroy_objects(m);
  vulkan_device_close(&m->vulkan);
  free(m);
}
