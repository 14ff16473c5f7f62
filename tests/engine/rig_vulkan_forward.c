/* rig_vulkan_forward.c: a Vulkan engine's forward shader. */
#include "rig_forward.h"
#include "rig_vulkan.h"

#include "csm_constants.h"
#include "forward_code.h"
#include "shader_code.h"

#include <stdlib.h>
#include <string.h>

enum { CONSTANTS = CSM_C_COUNT * 16, AT_PLANE = (CONSTANTS + 255) / 256 * 256, PLANE = FORWARD_PLANE * 4 };

/* Where the shader's registers lie: b0 and b1, t0 and t1, t8 and t9, s0 and s1. */
enum { BINDINGS = 8 };
static const struct place {
  uint32_t binding;
  VkDescriptorType type;
} places[BINDINGS] = {{0, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},  {1, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER},
                      {16, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE},  {17, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE},
                      {24, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}, {25, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER},
                      {48, VK_DESCRIPTOR_TYPE_SAMPLER},        {49, VK_DESCRIPTOR_TYPE_SAMPLER}};

struct rig_forward {
  rig *rig;
  uint32_t width, height;
  VkImage image;
  VkDeviceMemory memory;
  VkImageView view;
  VkRenderPass pass;
  VkFramebuffer framebuffer;
  VkSampler sampler; /* point, repeated, as pages need it */
  VkDescriptorSetLayout set_layout;
  VkPipelineLayout layout;
  VkPipeline pipeline;
  VkDescriptorPool pool;
  VkDescriptorSet set;
  rig_buffer constants, copy;
};

/* ---- objects ---- */

static void make_image(rig_forward *f) {
  const VkDevice device = f->rig->device;
  const VkImageCreateInfo image = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                   .imageType = VK_IMAGE_TYPE_2D,
                                   .format = VK_FORMAT_R8_UNORM,
                                   .extent = {f->width, f->height, 1},
                                   .mipLevels = 1,
                                   .arrayLayers = 1,
                                   .samples = VK_SAMPLE_COUNT_1_BIT,
                                   .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
  rig_vulkan_must(vkCreateImage(device, &image, NULL, &f->image), "vkCreateImage");
  VkMemoryRequirements needs;
  vkGetImageMemoryRequirements(device, f->image, &needs);
  f->memory = rig_vulkan_allocate(f->rig, &needs, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  rig_vulkan_must(vkBindImageMemory(device, f->image, f->memory, 0), "vkBindImageMemory");
  const VkImageViewCreateInfo view = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
      .image = f->image,
      .viewType = VK_IMAGE_VIEW_TYPE_2D,
      .format = VK_FORMAT_R8_UNORM,
      .subresourceRange = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .levelCount = 1, .layerCount = 1}};
  rig_vulkan_must(vkCreateImageView(device, &view, NULL, &f->view), "vkCreateImageView");
}

/* It leaves the picture to be copied. */
static void make_pass(rig_forward *f) {
  const VkAttachmentDescription attachment = {.format = VK_FORMAT_R8_UNORM,
                                              .samples = VK_SAMPLE_COUNT_1_BIT,
                                              .loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                              .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                              .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                              .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                              .finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL};
  const VkAttachmentReference reference = {.layout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkSubpassDescription subpass = {
      .pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS, .colorAttachmentCount = 1, .pColorAttachments = &reference};
  const VkSubpassDependency after = {.dstSubpass = VK_SUBPASS_EXTERNAL,
                                     .srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
                                     .dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT,
                                     .srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
                                     .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT};
  const VkRenderPassCreateInfo pass = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                       .attachmentCount = 1,
                                       .pAttachments = &attachment,
                                       .subpassCount = 1,
                                       .pSubpasses = &subpass,
                                       .dependencyCount = 1,
                                       .pDependencies = &after};
  rig_vulkan_must(vkCreateRenderPass(f->rig->device, &pass, NULL, &f->pass), "vkCreateRenderPass");
  const VkFramebufferCreateInfo framebuffer = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                               .renderPass = f->pass,
                                               .attachmentCount = 1,
                                               .pAttachments = &f->view,
                                               .width = f->width,
                                               .height = f->height,
                                               .layers = 1};
  rig_vulkan_must(vkCreateFramebuffer(f->rig->device, &framebuffer, NULL, &f->framebuffer), "vkCreateFramebuffer");
}

static void make_set(rig_forward *f) {
  const VkDevice device = f->rig->device;
  VkDescriptorSetLayoutBinding bindings[BINDINGS];
  VkDescriptorPoolSize sizes[BINDINGS];
  for (uint32_t i = 0; i < BINDINGS; ++i) {
    bindings[i] =
        (VkDescriptorSetLayoutBinding){places[i].binding, places[i].type, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL};
    sizes[i] = (VkDescriptorPoolSize){places[i].type, 1};
  }
  const VkDescriptorSetLayoutCreateInfo set = {
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = BINDINGS, .pBindings = bindings};
  rig_vulkan_must(vkCreateDescriptorSetLayout(device, &set, NULL, &f->set_layout), "vkCreateDescriptorSetLayout");
  const VkPipelineLayoutCreateInfo layout = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &f->set_layout};
  rig_vulkan_must(vkCreatePipelineLayout(device, &layout, NULL, &f->layout), "vkCreatePipelineLayout");
  const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                           .maxSets = 1,
                                           .poolSizeCount = BINDINGS,
                                           .pPoolSizes = sizes};
  rig_vulkan_must(vkCreateDescriptorPool(device, &pool, NULL, &f->pool), "vkCreateDescriptorPool");
  const VkDescriptorSetAllocateInfo one = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = f->pool,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &f->set_layout};
  rig_vulkan_must(vkAllocateDescriptorSets(device, &one, &f->set), "vkAllocateDescriptorSets");
  const VkSamplerCreateInfo sampler = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                       .addressModeU = VK_SAMPLER_ADDRESS_MODE_REPEAT,
                                       .addressModeV = VK_SAMPLER_ADDRESS_MODE_REPEAT,
                                       .addressModeW = VK_SAMPLER_ADDRESS_MODE_REPEAT};
  rig_vulkan_must(vkCreateSampler(device, &sampler, NULL, &f->sampler), "vkCreateSampler");
}

static VkPipelineShaderStageCreateInfo make_stage(const rig_forward *f, VkShaderStageFlagBits stage,
                                                  const gpu_code *code) {
  const VkShaderModuleCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code->spirv_size, .pCode = code->spirv};
  VkPipelineShaderStageCreateInfo out = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = stage, .pName = "main"};
  rig_vulkan_must(vkCreateShaderModule(f->rig->device, &info, NULL, &out.module), "vkCreateShaderModule");
  return out;
}

static void make_pipeline(rig_forward *f, bool rays) {
  const VkPipelineShaderStageCreateInfo stages[] = {
      make_stage(f, VK_SHADER_STAGE_VERTEX_BIT, &shader_screen_vs),
      make_stage(f, VK_SHADER_STAGE_FRAGMENT_BIT, rays ? &shader_forward_exact_ps : &shader_forward_gathers_ps)};
  const VkPipelineVertexInputStateCreateInfo input = {.sType =
                                                          VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const VkPipelineInputAssemblyStateCreateInfo assembly = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkViewport all = {.width = (float)f->width, .height = (float)f->height, .maxDepth = 1};
  const VkRect2D scissor = {.extent = {f->width, f->height}};
  const VkPipelineViewportStateCreateInfo viewport = {.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                                      .viewportCount = 1,
                                                      .pViewports = &all,
                                                      .scissorCount = 1,
                                                      .pScissors = &scissor};
  const VkPipelineRasterizationStateCreateInfo raster = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo samples = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineColorBlendAttachmentState written = {.colorWriteMask = VK_COLOR_COMPONENT_R_BIT};
  const VkPipelineColorBlendStateCreateInfo blend = {.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                     .attachmentCount = 1,
                                                     .pAttachments = &written};
  const VkGraphicsPipelineCreateInfo create = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .stageCount = 2,
                                               .pStages = stages,
                                               .pVertexInputState = &input,
                                               .pInputAssemblyState = &assembly,
                                               .pViewportState = &viewport,
                                               .pRasterizationState = &raster,
                                               .pMultisampleState = &samples,
                                               .pColorBlendState = &blend,
                                               .layout = f->layout,
                                               .renderPass = f->pass};
  rig_vulkan_must(vkCreateGraphicsPipelines(f->rig->device, VK_NULL_HANDLE, 1, &create, NULL, &f->pipeline),
                  "vkCreateGraphicsPipelines");
  for (uint32_t i = 0; i < 2; ++i)
    vkDestroyShaderModule(f->rig->device, stages[i].module, NULL);
}

rig_forward *rig_forward_make(rig *rig, uint32_t width, uint32_t height, bool rays) {
  rig_forward *f = calloc(1, sizeof *f);
  assert_non_null(f);
  *f = (rig_forward){.rig = rig, .width = width, .height = height};
  make_image(f);
  make_pass(f);
  make_set(f);
  make_pipeline(f, rays);
  f->constants = rig_buffer_make(rig, RIG_CONSTANTS, AT_PLANE + PLANE);
  f->copy = rig_buffer_make(rig, RIG_READBACK, (uint64_t)rig_pitch(width, 1) * height);
  return f;
}

void rig_forward_free(rig_forward *f) {
  const VkDevice device = f->rig->device;
  rig_buffer_free(f->rig, &f->constants);
  rig_buffer_free(f->rig, &f->copy);
  vkDestroyPipeline(device, f->pipeline, NULL);
  vkDestroyPipelineLayout(device, f->layout, NULL);
  vkDestroyDescriptorPool(device, f->pool, NULL);
  vkDestroyDescriptorSetLayout(device, f->set_layout, NULL);
  vkDestroySampler(device, f->sampler, NULL);
  vkDestroyFramebuffer(device, f->framebuffer, NULL);
  vkDestroyRenderPass(device, f->pass, NULL);
  vkDestroyImageView(device, f->view, NULL);
  vkDestroyImage(device, f->image, NULL);
  vkFreeMemory(device, f->memory, NULL);
  free(f);
}

/* ---- a picture ---- */

static void write_set(const rig_forward *f, const csm_binding *binding) {
  const VkDescriptorBufferInfo buffers[BINDINGS] = {{f->constants.object, 0, CONSTANTS},
                                                    {f->constants.object, AT_PLANE, PLANE},
                                                    [4] = {(VkBuffer)binding->native_ray_meshes, 0, VK_WHOLE_SIZE},
                                                    [5] = {(VkBuffer)binding->native_ray_instances, 0, VK_WHOLE_SIZE}};
  const VkDescriptorImageInfo image = {.sampler = f->sampler,
                                       .imageView = (VkImageView)binding->native_maps_view,
                                       .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  VkWriteDescriptorSet writes[BINDINGS];
  uint32_t count = 0;
  for (uint32_t i = 0; i < BINDINGS; ++i)
    if (places[i].type != VK_DESCRIPTOR_TYPE_STORAGE_BUFFER || buffers[i].buffer) /* none without rays */
      writes[count++] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                               .dstSet = f->set,
                                               .dstBinding = places[i].binding,
                                               .descriptorCount = 1,
                                               .descriptorType = places[i].type,
                                               .pImageInfo = &image,
                                               .pBufferInfo = &buffers[i]};
  vkUpdateDescriptorSets(f->rig->device, count, writes, 0, NULL);
}

void rig_forward_draw(rig_forward *f, const csm_binding *binding, const float plane[FORWARD_PLANE]) {
  const VkCommandBuffer commands = rig_commands(f->rig);
  char *constants = f->constants.mapped;
  memcpy(constants, binding->cascade_constants, binding->cascade_constants_size);
  memcpy(constants + 16 * CSM_S_BEGIN, binding->setting_constants, binding->setting_constants_size);
  memcpy(constants + AT_PLANE, plane, PLANE);
  write_set(f, binding);
  const VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                       .renderPass = f->pass,
                                       .framebuffer = f->framebuffer,
                                       .renderArea = {.extent = {f->width, f->height}}};
  vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, f->pipeline);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, f->layout, 0, 1, &f->set, 0, NULL);
  vkCmdDraw(commands, 3, 1, 0, 0);
  vkCmdEndRenderPass(commands);
  const VkBufferImageCopy region = {.imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT, .layerCount = 1},
                                    .imageExtent = {f->width, f->height, 1}};
  vkCmdCopyImageToBuffer(commands, f->image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, f->copy.object, 1, &region);
}

const unsigned char *rig_forward_picture(const rig_forward *f) {
  return f->copy.mapped;
}
