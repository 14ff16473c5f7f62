/* program.c: samplers, render passes, programs, and what programs read. */
#include "internal.h"

/* Where HLSL registers lie in a descriptor set: what the shaders were compiled with. */
enum { BINDING_CONSTANTS = 0, BINDING_TEXTURES = 16, BINDING_SAMPLERS = 48 };
enum { MAX_BINDINGS = GPU_MAX_CONSTANTS + GPU_MAX_TEXTURES + GPU_MAX_SAMPLERS };

/* ---- samplers ---- */

csm_result vulkan_samplers_create(gpu_device *device) {
  const char *const names[VULKAN_SAMPLERS] = {"point", "linear", "compare", "compare reversed"};
  for (uint32_t i = 0; i < VULKAN_SAMPLERS; i++) {
    const VkFilter filter = i == GPU_SAMPLER_POINT_CLAMP ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
    const VkSamplerCreateInfo info = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                      .magFilter = filter,
                                      .minFilter = filter,
                                      .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                      .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                      .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                      .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                      .compareEnable = i >= GPU_SAMPLER_COMPARE_LESS_EQUAL,
                                      .compareOp = i == GPU_SAMPLER_COMPARE_GREATER_EQUAL
                                                       ? VK_COMPARE_OP_GREATER_OR_EQUAL
                                                       : VK_COMPARE_OP_LESS_OR_EQUAL};
    const csm_result result =
        vulkan_made(device, device->vk.CreateSampler(device->handle, &info, NULL, &device->samplers[i]),
                    &device->samplers[i], "vkCreateSampler");
    if (result != CSM_SUCCESS)
      return result;
    vulkan_name(device, VK_OBJECT_TYPE_SAMPLER, (uint64_t)device->samplers[i], names[i]);
  }
  return CSM_SUCCESS;
}

/* ---- render passes ---- */

/* The layout does not change in the pass: barriers before and after it do that, where the state is tracked. */
static VkAttachmentReference attachment_add(VkAttachmentDescription *attachments, uint32_t *count, gpu_format format,
                                            VkImageLayout layout, VkAttachmentLoadOp load) {
  attachments[*count] = (VkAttachmentDescription){.format = vulkan_format(format),
                                                  .samples = VK_SAMPLE_COUNT_1_BIT,
                                                  .loadOp = load,
                                                  .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                                  .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                  .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                  .initialLayout = layout,
                                                  .finalLayout = layout};
  return (VkAttachmentReference){.attachment = (*count)++, .layout = layout};
}

csm_result vulkan_pass_get(gpu_device *device, gpu_format depth, gpu_format color, VkRenderPass *out) {
  VkRenderPass *pass = &device->passes[depth][color];
  *out = *pass;
  if (*pass)
    return CSM_SUCCESS;

  VkAttachmentDescription attachments[2];
  uint32_t count = 0;
  VkAttachmentReference depth_reference = {0}, color_reference = {0};
  if (depth)
    depth_reference = attachment_add(attachments, &count, depth, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
                                     VK_ATTACHMENT_LOAD_OP_LOAD);
  if (color)
    color_reference = attachment_add(attachments, &count, color, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                     VK_ATTACHMENT_LOAD_OP_DONT_CARE);
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
  *out = *pass;
  return result;
}

/* ---- programs ---- */

static csm_result layouts_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  VkDescriptorSetLayoutBinding bindings[MAX_BINDINGS];
  uint32_t count = 0;
  for (uint32_t i = 0; i < info->constants_count; i++)
    bindings[count++] =
        (VkDescriptorSetLayoutBinding){.binding = BINDING_CONSTANTS + i,
                                       .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC,
                                       .descriptorCount = 1,
                                       .stageFlags = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT};
  for (uint32_t i = 0; i < info->texture_count; i++)
    bindings[count++] = (VkDescriptorSetLayoutBinding){.binding = BINDING_TEXTURES + i,
                                                       .descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
                                                       .descriptorCount = 1,
                                                       .stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT};
  for (uint32_t i = 0; i < info->sampler_count; i++)
    bindings[count++] = (VkDescriptorSetLayoutBinding){.binding = BINDING_SAMPLERS + i,
                                                       .descriptorType = VK_DESCRIPTOR_TYPE_SAMPLER,
                                                       .descriptorCount = 1,
                                                       .stageFlags = VK_SHADER_STAGE_FRAGMENT_BIT,
                                                       .pImmutableSamplers = &device->samplers[info->samplers[i]]};
  const VkDescriptorSetLayoutCreateInfo set = {
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = count, .pBindings = bindings};
  csm_result result =
      vulkan_made(device, device->vk.CreateDescriptorSetLayout(device->handle, &set, NULL, &program->set_layout),
                  &program->set_layout, "vkCreateDescriptorSetLayout");
  if (result != CSM_SUCCESS)
    return result;
  vulkan_name(device, VK_OBJECT_TYPE_DESCRIPTOR_SET_LAYOUT, (uint64_t)program->set_layout, info->name);

  const VkPipelineLayoutCreateInfo layout = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &program->set_layout};
  result = vulkan_made(device, device->vk.CreatePipelineLayout(device->handle, &layout, NULL, &program->layout),
                       &program->layout, "vkCreatePipelineLayout");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_PIPELINE_LAYOUT, (uint64_t)program->layout, info->name);
  return result;
}

static csm_result module_create(gpu_device *device, const gpu_code *code, const char *name, VkShaderModule *out) {
  const VkShaderModuleCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code->spirv_size, .pCode = code->spirv};
  const csm_result result =
      vulkan_made(device, device->vk.CreateShaderModule(device->handle, &info, NULL, out), out, "vkCreateShaderModule");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_SHADER_MODULE, (uint64_t)*out, name);
  return result;
}

static VkCullModeFlags face_culling(gpu_cull cull) {
  switch (cull) {
  case GPU_CULL_BACK:
    return VK_CULL_MODE_BACK_BIT;
  case GPU_CULL_FRONT:
    return VK_CULL_MODE_FRONT_BIT;
  case GPU_CULL_NONE:
    break;
  }
  return VK_CULL_MODE_NONE;
}

static csm_result pipeline_create(gpu_device *device, gpu_program *program, const gpu_program_info *info,
                                  VkRenderPass pass, VkShaderModule vertex, VkShaderModule pixel) {
  const VkPipelineShaderStageCreateInfo stages[] = {{.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                     .stage = VK_SHADER_STAGE_VERTEX_BIT,
                                                     .module = vertex,
                                                     .pName = "main"},
                                                    {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                     .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
                                                     .module = pixel,
                                                     .pName = "main"}};
  VkVertexInputBindingDescription streams[GPU_MAX_STREAMS];
  for (uint32_t i = 0; i < info->stream_count; i++)
    streams[i] = (VkVertexInputBindingDescription){
        .binding = i,
        .stride = info->streams[i].stride,
        .inputRate = info->streams[i].per_instance ? VK_VERTEX_INPUT_RATE_INSTANCE : VK_VERTEX_INPUT_RATE_VERTEX};
  VkVertexInputAttributeDescription attributes[GPU_MAX_ATTRIBUTES];
  for (uint32_t i = 0; i < info->attribute_count; i++)
    attributes[i] = (VkVertexInputAttributeDescription){.location = i,
                                                        .binding = info->attributes[i].stream,
                                                        .format = vulkan_format(info->attributes[i].format),
                                                        .offset = info->attributes[i].offset};
  const VkPipelineVertexInputStateCreateInfo input = {.sType =
                                                          VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                      .vertexBindingDescriptionCount = info->stream_count,
                                                      .pVertexBindingDescriptions = streams,
                                                      .vertexAttributeDescriptionCount = info->attribute_count,
                                                      .pVertexAttributeDescriptions = attributes};
  const VkPipelineInputAssemblyStateCreateInfo assembly = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const gpu_raster_bias *bias = &info->raster_bias;
  const VkPipelineRasterizationStateCreateInfo raster = {.sType =
                                                             VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                         .depthClampEnable = !info->depth_clip,
                                                         .polygonMode = VK_POLYGON_MODE_FILL,
                                                         .cullMode = face_culling(info->cull),
                                                         .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
                                                         .depthBiasEnable = bias->constant || bias->slope != 0,
                                                         .depthBiasConstantFactor = (float)bias->constant,
                                                         .depthBiasClamp = bias->clamp,
                                                         .depthBiasSlopeFactor = bias->slope,
                                                         .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo samples = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
      .depthTestEnable = info->depth_compare != GPU_COMPARE_NONE,
      .depthWriteEnable = info->depth_compare != GPU_COMPARE_NONE,
      .depthCompareOp = info->depth_compare == GPU_COMPARE_GREATER ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_LESS};
  const VkPipelineColorBlendAttachmentState write_all = {.colorWriteMask =
                                                             VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                                                             VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
  const VkPipelineColorBlendStateCreateInfo blend = {.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                     .attachmentCount = info->color_format ? 1 : 0,
                                                     .pAttachments = &write_all};
  const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = 2, .pDynamicStates = states};
  const VkGraphicsPipelineCreateInfo create = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .stageCount = pixel ? 2 : 1,
                                               .pStages = stages,
                                               .pVertexInputState = &input,
                                               .pInputAssemblyState = &assembly,
                                               .pViewportState = &viewport,
                                               .pRasterizationState = &raster,
                                               .pMultisampleState = &samples,
                                               .pDepthStencilState = &depth,
                                               .pColorBlendState = &blend,
                                               .pDynamicState = &dynamic,
                                               .layout = program->layout,
                                               .renderPass = pass};
  const csm_result result = vulkan_check(
      device, device->vk.CreateGraphicsPipelines(device->handle, VK_NULL_HANDLE, 1, &create, NULL, &program->pipeline),
      "vkCreateGraphicsPipelines");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_PIPELINE, (uint64_t)program->pipeline, info->name);
  return result;
}

csm_result vulkan_program_create(gpu_device *device, const gpu_program_info *info, gpu_program **out) {
  *out = NULL;
  if (info->raster_bias.clamp != 0 && !device->bias_clamp)
    return vulkan_fail(device, CSM_ERROR_UNSUPPORTED, "%s: the device clamps no bias: depthBiasClamp is not enabled",
                       info->name);
  gpu_program *program = vulkan_allocate(device, sizeof *program);
  if (!program)
    return CSM_ERROR_OUT_OF_MEMORY;
  program->stream_count = info->stream_count;
  program->constants_count = info->constants_count;
  program->texture_count = info->texture_count;
  program->sampler_count = info->sampler_count;
  for (uint32_t i = 0; i < info->constants_count; i++)
    program->constants_sizes[i] = info->constants_sizes[i];

  VkShaderModule vertex = VK_NULL_HANDLE, pixel = VK_NULL_HANDLE;
  VkRenderPass pass = VK_NULL_HANDLE;
  csm_result result = vulkan_pass_get(device, info->depth_format, info->color_format, &pass);
  if (result == CSM_SUCCESS)
    result = layouts_create(device, program, info);
  if (result == CSM_SUCCESS)
    result = module_create(device, &info->vertex, info->name, &vertex);
  if (result == CSM_SUCCESS && info->pixel.spirv_size)
    result = module_create(device, &info->pixel, info->name, &pixel);
  if (result == CSM_SUCCESS)
    result = pipeline_create(device, program, info, pass, vertex, pixel);
  device->vk.DestroyShaderModule(device->handle, pixel, NULL);
  device->vk.DestroyShaderModule(device->handle, vertex, NULL);
  if (result == CSM_SUCCESS)
    *out = program;
  else
    vulkan_program_destroy(device, program);
  return result;
}

void vulkan_program_destroy(gpu_device *device, gpu_program *program) {
  if (!program)
    return;
  device->vk.DestroyPipeline(device->handle, program->pipeline, NULL);
  device->vk.DestroyPipelineLayout(device->handle, program->layout, NULL);
  device->vk.DestroyDescriptorSetLayout(device->handle, program->set_layout, NULL);
  vulkan_release(device, program);
}

/* ---- bindings ---- */

static csm_result set_allocate(gpu_device *device, gpu_bindings *bindings, const gpu_program *program,
                               const char *name) {
  const VkDescriptorPoolSize all[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC, program->constants_count},
                                      {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, program->texture_count},
                                      {VK_DESCRIPTOR_TYPE_SAMPLER, program->sampler_count}};
  VkDescriptorPoolSize sizes[3];
  uint32_t count = 0;
  for (uint32_t i = 0; i < 3; i++)
    if (all[i].descriptorCount)
      sizes[count++] = all[i];
  if (count == 0)
    return CSM_SUCCESS;

  const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                           .maxSets = 1,
                                           .poolSizeCount = count,
                                           .pPoolSizes = sizes};
  csm_result result = vulkan_made(device, device->vk.CreateDescriptorPool(device->handle, &pool, NULL, &bindings->pool),
                                  &bindings->pool, "vkCreateDescriptorPool");
  if (result != CSM_SUCCESS)
    return result;
  vulkan_name(device, VK_OBJECT_TYPE_DESCRIPTOR_POOL, (uint64_t)bindings->pool, name);
  const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = bindings->pool,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &program->set_layout};
  result = vulkan_check(device, device->vk.AllocateDescriptorSets(device->handle, &set, &bindings->set),
                        "vkAllocateDescriptorSets");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_DESCRIPTOR_SET, (uint64_t)bindings->set, name);
  return result;
}

void vulkan_bindings_write(gpu_device *device, gpu_bindings *bindings, const gpu_bindings_info *info) {
  const gpu_program *program = info->program;
  VkDescriptorBufferInfo buffers[GPU_MAX_CONSTANTS];
  VkDescriptorImageInfo images[GPU_MAX_TEXTURES];
  VkWriteDescriptorSet writes[GPU_MAX_CONSTANTS + GPU_MAX_TEXTURES];
  uint32_t count = 0;
  for (uint32_t i = 0; i < program->constants_count; i++) {
    buffers[i] = (VkDescriptorBufferInfo){.buffer = info->constants[i]->handle, .range = program->constants_sizes[i]};
    writes[count++] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                             .dstSet = bindings->set,
                                             .dstBinding = BINDING_CONSTANTS + i,
                                             .descriptorCount = 1,
                                             .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER_DYNAMIC,
                                             .pBufferInfo = &buffers[i]};
  }
  for (uint32_t i = 0; i < program->texture_count; i++) {
    images[i] =
        (VkDescriptorImageInfo){.imageView = info->textures[i]->view, .imageLayout = info->textures[i]->sampled_layout};
    writes[count++] = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                             .dstSet = bindings->set,
                                             .dstBinding = BINDING_TEXTURES + i,
                                             .descriptorCount = 1,
                                             .descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
                                             .pImageInfo = &images[i]};
  }
  device->vk.UpdateDescriptorSets(device->handle, count, writes, 0, NULL);
}

csm_result vulkan_bindings_create(gpu_device *device, const gpu_bindings_info *info, gpu_bindings **out) {
  *out = NULL;
  gpu_bindings *bindings = vulkan_allocate(device, sizeof *bindings);
  if (!bindings)
    return CSM_ERROR_OUT_OF_MEMORY;
  bindings->layout = info->program->layout;
  bindings->constants_count = info->program->constants_count;
  const csm_result result = set_allocate(device, bindings, info->program, info->name);
  if (result != CSM_SUCCESS) {
    vulkan_bindings_destroy(device, bindings);
    return result;
  }
  vulkan_bindings_write(device, bindings, info);
  *out = bindings;
  return CSM_SUCCESS;
}

void vulkan_bindings_destroy(gpu_device *device, gpu_bindings *bindings) {
  if (!bindings)
    return;
  device->vk.DestroyDescriptorPool(device->handle, bindings->pool, NULL);
  vulkan_release(device, bindings);
}
