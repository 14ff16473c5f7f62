/* pipeline.c: pipelines, of programs that draw and of those that compute. */
#include "internal.h"

static csm_result module_create(gpu_device *device, const gpu_code *code, const char *name, VkShaderModule *out) {
  const VkShaderModuleCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code->spirv_size, .pCode = code->spirv};
  const csm_result result =
      vulkan_made(device, device->vk.CreateShaderModule(device->handle, &info, NULL, out), out, "vkCreateShaderModule");
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_SHADER_MODULE, (uint64_t)*out, name);
  return result;
}

static VkPipelineShaderStageCreateInfo stage_of(VkShaderStageFlagBits stage, VkShaderModule module) {
  return (VkPipelineShaderStageCreateInfo){
      .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = stage, .module = module, .pName = "main"};
}

/* ---- the states of a pipeline that draws ---- */

/* What the descriptions of Vulkan point at. */
typedef struct vertex_state {
  VkVertexInputBindingDescription streams[GPU_MAX_STREAMS];
  VkVertexInputAttributeDescription attributes[GPU_MAX_ATTRIBUTES];
  VkPipelineVertexInputStateCreateInfo input;
} vertex_state;

static void describe_vertices(const gpu_program_info *info, vertex_state *out) {
  for (uint32_t i = 0; i < info->stream_count; i++)
    out->streams[i] = (VkVertexInputBindingDescription){
        .binding = i,
        .stride = info->streams[i].stride,
        .inputRate = info->streams[i].per_instance ? VK_VERTEX_INPUT_RATE_INSTANCE : VK_VERTEX_INPUT_RATE_VERTEX};
  for (uint32_t i = 0; i < info->attribute_count; i++)
    out->attributes[i] = (VkVertexInputAttributeDescription){.location = i,
                                                             .binding = info->attributes[i].stream,
                                                             .format = vulkan_format(info->attributes[i].format),
                                                             .offset = info->attributes[i].offset};
  out->input =
      (VkPipelineVertexInputStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                             .vertexBindingDescriptionCount = info->stream_count,
                                             .pVertexBindingDescriptions = out->streams,
                                             .vertexAttributeDescriptionCount = info->attribute_count,
                                             .pVertexAttributeDescriptions = out->attributes};
}

static VkPipelineRasterizationStateCreateInfo raster_of(const gpu_program_info *info) {
  static const VkCullModeFlags culls[] = {[GPU_CULL_NONE] = VK_CULL_MODE_NONE,
                                          [GPU_CULL_BACK] = VK_CULL_MODE_BACK_BIT,
                                          [GPU_CULL_FRONT] = VK_CULL_MODE_FRONT_BIT};
  const gpu_raster_bias *bias = &info->raster_bias;
  return (VkPipelineRasterizationStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                  .depthClampEnable = !info->depth_clip,
                                                  .polygonMode = VK_POLYGON_MODE_FILL,
                                                  .cullMode = culls[info->cull],
                                                  .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
                                                  .depthBiasEnable = bias->constant || bias->slope != 0,
                                                  .depthBiasConstantFactor = (float)bias->constant,
                                                  .depthBiasClamp = bias->clamp,
                                                  .depthBiasSlopeFactor = bias->slope,
                                                  .lineWidth = 1};
}

static VkPipelineDepthStencilStateCreateInfo depth_of(const gpu_program_info *info) {
  static const VkCompareOp compares[] = {[GPU_COMPARE_NONE] = VK_COMPARE_OP_LESS,
                                         [GPU_COMPARE_LESS] = VK_COMPARE_OP_LESS,
                                         [GPU_COMPARE_GREATER] = VK_COMPARE_OP_GREATER,
                                         [GPU_COMPARE_ALWAYS] = VK_COMPARE_OP_ALWAYS};
  return (VkPipelineDepthStencilStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                 .depthTestEnable = info->depth_compare != GPU_COMPARE_NONE,
                                                 .depthWriteEnable = info->depth_compare != GPU_COMPARE_NONE,
                                                 .depthCompareOp = compares[info->depth_compare]};
}

/* ---- pipelines ---- */

static csm_result graphics_create(gpu_device *device, gpu_program *program, const gpu_program_info *info,
                                  const VkPipelineShaderStageCreateInfo *stages, uint32_t stage_count) {
  static const VkPipelineInputAssemblyStateCreateInfo assembly = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  static const VkPipelineViewportStateCreateInfo viewport = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  static const VkPipelineMultisampleStateCreateInfo samples = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  static const VkPipelineColorBlendAttachmentState write_all = {
      .colorWriteMask =
          VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT | VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT};
  static const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  static const VkPipelineDynamicStateCreateInfo dynamic = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = 2, .pDynamicStates = states};
  const VkPipelineColorBlendStateCreateInfo blend = {.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                     .attachmentCount = info->color_format ? 1 : 0,
                                                     .pAttachments = &write_all};
  vertex_state vertices;
  describe_vertices(info, &vertices);
  const VkPipelineRasterizationStateCreateInfo raster = raster_of(info);
  const VkPipelineDepthStencilStateCreateInfo depth = depth_of(info);
  const VkFormat color_format = vulkan_format(info->color_format);
  const VkPipelineRenderingCreateInfo rendering = {.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                   .colorAttachmentCount = info->color_format ? 1 : 0,
                                                   .pColorAttachmentFormats = &color_format,
                                                   .depthAttachmentFormat = vulkan_format(info->depth_format)};
  const VkGraphicsPipelineCreateInfo create = {
      .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
      .pNext = device->dynamic_rendering ? &rendering : NULL,
      .stageCount = stage_count,
      .pStages = stages,
      .pVertexInputState = &vertices.input,
      .pInputAssemblyState = &assembly,
      .pViewportState = &viewport,
      .pRasterizationState = &raster,
      .pMultisampleState = &samples,
      .pDepthStencilState = &depth,
      .pColorBlendState = &blend,
      .pDynamicState = &dynamic,
      .layout = program->layout,
      .renderPass = device->passes[info->depth_format][info->color_format][GPU_LOAD_KEEP][GPU_LOAD_KEEP]};
  return vulkan_check(
      device,
      device->vk.CreateGraphicsPipelines(device->handle, device->pipeline_cache, 1, &create, NULL, &program->pipeline),
      "vkCreateGraphicsPipelines");
}

static csm_result drawing_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  VkShaderModule vertex = VK_NULL_HANDLE, pixel = VK_NULL_HANDLE;
  csm_result result = vulkan_passes_create(device, info->depth_format, info->color_format);
  if (result == CSM_SUCCESS)
    result = module_create(device, &info->vertex, info->name, &vertex);
  if (result == CSM_SUCCESS && info->pixel.spirv_size)
    result = module_create(device, &info->pixel, info->name, &pixel);
  const VkPipelineShaderStageCreateInfo stages[] = {stage_of(VK_SHADER_STAGE_VERTEX_BIT, vertex),
                                                    stage_of(VK_SHADER_STAGE_FRAGMENT_BIT, pixel)};
  if (result == CSM_SUCCESS)
    result = graphics_create(device, program, info, stages, pixel ? 2 : 1);
  device->vk.DestroyShaderModule(device->handle, pixel, NULL);
  device->vk.DestroyShaderModule(device->handle, vertex, NULL);
  return result;
}

static csm_result computing_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  VkShaderModule module = VK_NULL_HANDLE;
  const csm_result made = module_create(device, &info->compute, info->name, &module);
  if (made != CSM_SUCCESS)
    return made;
  const VkComputePipelineCreateInfo create = {.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                              .stage = stage_of(VK_SHADER_STAGE_COMPUTE_BIT, module),
                                              .layout = program->layout};
  const csm_result result = vulkan_check(
      device,
      device->vk.CreateComputePipelines(device->handle, device->pipeline_cache, 1, &create, NULL, &program->pipeline),
      "vkCreateComputePipelines");
  device->vk.DestroyShaderModule(device->handle, module, NULL);
  return result;
}

csm_result vulkan_pipeline_create(gpu_device *device, gpu_program *program, const gpu_program_info *info) {
  const csm_result result =
      info->compute.spirv_size ? computing_create(device, program, info) : drawing_create(device, program, info);
  if (result == CSM_SUCCESS)
    vulkan_name(device, VK_OBJECT_TYPE_PIPELINE, (uint64_t)program->pipeline, info->name);
  return result;
}
