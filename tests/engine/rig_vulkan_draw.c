/* rig_vulkan_draw.c: casters that a Vulkan engine draws by itself. */
#include "rig_vulkan.h"

#include "engine_code.h"

#include <stdlib.h>
#include <string.h>

enum { FIRST_FREE_STREAM = 3 /* csm's own recordings change those before it */ };

struct rig_caster {
  rig *rig;
  rig_buffer vertices, indices, rows;
  uint32_t index_count;
  VkPipelineLayout layout;
  VkPipeline pipeline;
};

enum { ROWS_OF_CASCADE = RIG_CASTER_INSTANCES * RIG_ROWS * sizeof(float) };

static VkShaderModule make_module(const rig *rig) {
  const VkShaderModuleCreateInfo code = {.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                         .codeSize = shader_caster_vs.spirv_size,
                                         .pCode = shader_caster_vs.spirv};
  VkShaderModule module;
  rig_vulkan_must(vkCreateShaderModule(rig->device, &code, NULL, &module), "vkCreateShaderModule");
  return module;
}

/* csm's viewport and scissor are set: the pipeline takes them as dynamic state. */
static VkPipeline make_pipeline(const rig_caster *caster, const csm_draw_target *target) {
  const VkShaderModule module = make_module(caster->rig);
  const VkPipelineShaderStageCreateInfo stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                 .stage = VK_SHADER_STAGE_VERTEX_BIT,
                                                 .module = module,
                                                 .pName = "main"};
  const VkVertexInputBindingDescription streams[] = {
      {.stride = 12},
      {.binding = FIRST_FREE_STREAM, .stride = RIG_ROWS * sizeof(float), .inputRate = VK_VERTEX_INPUT_RATE_INSTANCE}};
  const VkVertexInputAttributeDescription attributes[] = {
      {.location = 0, .format = VK_FORMAT_R32G32B32_SFLOAT},
      {.location = 1, .binding = FIRST_FREE_STREAM, .format = VK_FORMAT_R32G32B32A32_SFLOAT, .offset = 0},
      {.location = 2, .binding = FIRST_FREE_STREAM, .format = VK_FORMAT_R32G32B32A32_SFLOAT, .offset = 16},
      {.location = 3, .binding = FIRST_FREE_STREAM, .format = VK_FORMAT_R32G32B32A32_SFLOAT, .offset = 32}};
  const VkPipelineVertexInputStateCreateInfo input = {.sType =
                                                          VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                      .vertexBindingDescriptionCount = 2,
                                                      .pVertexBindingDescriptions = streams,
                                                      .vertexAttributeDescriptionCount = 4,
                                                      .pVertexAttributeDescriptions = attributes};
  const VkPipelineInputAssemblyStateCreateInfo assembly = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo raster = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .depthClampEnable = VK_TRUE, .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo samples = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
      .depthTestEnable = VK_TRUE,
      .depthWriteEnable = VK_TRUE,
      .depthCompareOp = target->reversed ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_LESS};
  const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = 2, .pDynamicStates = states};
  const VkPipelineRenderingCreateInfo rendering = {.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                   .depthAttachmentFormat = target->depth_format};
  const VkGraphicsPipelineCreateInfo create = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .pNext = target->dynamic_rendering ? &rendering : NULL,
                                               .stageCount = 1,
                                               .pStages = &stage,
                                               .pVertexInputState = &input,
                                               .pInputAssemblyState = &assembly,
                                               .pViewportState = &viewport,
                                               .pRasterizationState = &raster,
                                               .pMultisampleState = &samples,
                                               .pDepthStencilState = &depth,
                                               .pDynamicState = &dynamic,
                                               .layout = caster->layout,
                                               .renderPass = (VkRenderPass)target->render_pass};
  VkPipeline pipeline;
  rig_vulkan_must(vkCreateGraphicsPipelines(caster->rig->device, VK_NULL_HANDLE, 1, &create, NULL, &pipeline),
                  "vkCreateGraphicsPipelines");
  vkDestroyShaderModule(caster->rig->device, module, NULL);
  return pipeline;
}

rig_caster *rig_caster_make(rig *rig, const rig_caster_info *info) {
  rig_caster *caster = calloc(1, sizeof *caster);
  assert_non_null(caster);
  *caster = (rig_caster){.rig = rig, .index_count = info->index_count};
  caster->vertices = rig_buffer_make(rig, RIG_GEOMETRY, info->vertex_count * sizeof *info->positions);
  caster->indices = rig_buffer_make(rig, RIG_GEOMETRY, info->index_count * sizeof *info->indices);
  caster->rows = rig_buffer_make(rig, RIG_GEOMETRY, CSM_MAX_CASCADES * ROWS_OF_CASCADE);
  memcpy(caster->vertices.mapped, info->positions, info->vertex_count * sizeof *info->positions);
  memcpy(caster->indices.mapped, info->indices, info->index_count * sizeof *info->indices);
  const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  rig_vulkan_must(vkCreatePipelineLayout(rig->device, &layout, NULL, &caster->layout), "vkCreatePipelineLayout");
  caster->pipeline = make_pipeline(caster, &info->target);
  return caster;
}

void rig_caster_free(rig_caster *caster) {
  rig *rig = caster->rig;
  vkDestroyPipeline(rig->device, caster->pipeline, NULL);
  vkDestroyPipelineLayout(rig->device, caster->layout, NULL);
  rig_buffer_free(rig, &caster->vertices);
  rig_buffer_free(rig, &caster->indices);
  rig_buffer_free(rig, &caster->rows);
  free(caster);
}

void rig_caster_draw(rig_caster *caster, const csm_draw_info *info, const float (*rows)[RIG_ROWS], uint32_t count) {
  const VkCommandBuffer commands = info->command_buffer;
  const VkDeviceSize offsets[2] = {0, info->cascade * (VkDeviceSize)ROWS_OF_CASCADE};
  memcpy((char *)caster->rows.mapped + offsets[1], rows, count * sizeof *rows);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, caster->pipeline);
  vkCmdBindVertexBuffers(commands, 0, 1, (VkBuffer *)&caster->vertices.object, &offsets[0]);
  vkCmdBindVertexBuffers(commands, FIRST_FREE_STREAM, 1, (VkBuffer *)&caster->rows.object, &offsets[1]);
  vkCmdBindIndexBuffer(commands, caster->indices.object, 0, VK_INDEX_TYPE_UINT16);
  vkCmdDrawIndexed(commands, caster->index_count, count, 0, 0, 0);
  /* What it may change, csm sets again. */
  vkCmdSetViewport(commands, 0, 1, &(VkViewport){.width = 1, .height = 1, .maxDepth = 0.5f});
  vkCmdSetScissor(commands, 0, 1, &(VkRect2D){.extent = {1, 1}});
}

void rig_check_target(const rig *rig, const csm_draw_target *target, uint32_t map_format) {
  assert_int_equal(target->depth_format, map_format == CSM_MAP_D16 ? VK_FORMAT_D16_UNORM : VK_FORMAT_D32_SFLOAT);
  assert_int_equal(target->dynamic_rendering, rig->native.dynamic_rendering);
  assert_int_equal(target->render_pass == 0, target->dynamic_rendering);
}

void rig_check_draw(const rig *rig, const csm_draw_info *info) {
  (void)rig;
  assert_true(info->depth_view == 0);
}
