#include "bench/floor_casters.h"
#include "base/host.h"
#include "csm/csm.h"
#include "drawn_code.h"
#include "private/alpha_mask.h"
#include "scene/mesh_watertight.h"
#include "shader_code.h"
#include <stdlib.h>
#include <string.h>

/* Bindings are where shaders/compile.py puts them. Blocks of constants begin where any device allows. */
enum { constants_binding = 0, texture_binding = 16, block_stride = 256, position_bytes = 12, uv_bytes = 8 };

VkCullModeFlags floor_cull(const floor_mesh *mesh, bool mirrored) {
  if (!mesh->watertight)
    return VK_CULL_MODE_NONE;
  return mirrored ? VK_CULL_MODE_FRONT_BIT : VK_CULL_MODE_BACK_BIT;
}

/* ---- meshes ---- */

/* Places a mesh at `at`, and returns where the next one begins. */
static VkDeviceSize lay_out(floor_mesh *out, const scene *s, const scene_mesh *mesh, VkDeviceSize at) {
  const bool cut_out = scene_cut_out(s, mesh) != NULL;
  out->vertices = at;
  out->uvs = out->vertices + (VkDeviceSize)mesh->vertex_count * position_bytes;
  out->indices = out->uvs + (cut_out ? (VkDeviceSize)mesh->vertex_count * uv_bytes : 0);
  out->index_type = mesh->index_size == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32;
  out->index_count = mesh->index_count;
  out->watertight = !cut_out && mesh_is_closed(mesh);
  return (out->indices + (VkDeviceSize)mesh->index_count * mesh->index_size + 15) / 16 * 16;
}

/* As csm stores them: near to 0. */
static void write_positions(float *to, const scene_mesh *mesh, const double offset[3]) {
  for (size_t i = 0; i < (size_t)mesh->vertex_count * 3; ++i)
    to[i] = (float)(mesh->positions[i] - offset[i % 3]);
}

static VkResult upload_meshes(floor_casters *c, const scene *s, const plan_bounds *bounds) {
  VkDeviceSize size = 0;
  c->meshes = host_allocate(s->mesh_count, sizeof *c->meshes);
  for (size_t i = 0; i < s->mesh_count; ++i)
    size = lay_out(&c->meshes[i], s, &s->meshes[i], size);
  const VkResult result = vulkan_buffer_open(&c->geometry, c->vulkan, size,
                                             VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  for (size_t i = 0; i < s->mesh_count && !result; ++i) {
    const scene_mesh *mesh = &s->meshes[i];
    const floor_mesh *to = &c->meshes[i];
    char *mapped = c->geometry.mapped;
    write_positions((float *)(mapped + to->vertices), mesh, bounds[i].offset);
    if (to->indices > to->uvs)
      memcpy(mapped + to->uvs, mesh->uvs, (size_t)mesh->vertex_count * uv_bytes);
    memcpy(mapped + to->indices, mesh->indices, (size_t)mesh->index_count * mesh->index_size);
  }
  return result;
}

/* ---- alpha masks ---- */

static VkResult upload_image(const floor_casters *c, vulkan_image *out, const scene_alpha_mask *mask,
                             vulkan_commands *commands) {
  static const vulkan_use nothing = {VK_IMAGE_LAYOUT_UNDEFINED, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT, 0};
  static const vulkan_use written = {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                     VK_ACCESS_TRANSFER_WRITE_BIT};
  static const vulkan_use read = {VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_PIPELINE_STAGE_FRAGMENT_SHADER_BIT,
                                  VK_ACCESS_SHADER_READ_BIT};
  const size_t size = (size_t)mask->width * mask->height;
  const vulkan_image_info info = {.format = VK_FORMAT_R8_UNORM,
                                  .width = mask->width,
                                  .height = mask->height,
                                  .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
  vulkan_buffer staging = {0};
  VkResult result = vulkan_image_open(out, c->vulkan, &info);
  if (!result)
    result = vulkan_buffer_open(&staging, c->vulkan, size, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  if (!result)
    result = vulkan_commands_begin(commands);
  if (!result) {
    const VkBufferImageCopy region = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                      .imageExtent = {mask->width, mask->height, 1}};
    memcpy(staging.mapped, mask->alpha, size);
    vulkan_transition(commands->buffer, out->image, VK_IMAGE_ASPECT_COLOR_BIT, nothing, written);
    vkCmdCopyBufferToImage(commands->buffer, staging.buffer, out->image, written.layout, 1, &region);
    vulkan_transition(commands->buffer, out->image, VK_IMAGE_ASPECT_COLOR_BIT, written, read);
    result = vulkan_commands_finish(commands);
  }
  vulkan_buffer_close(&staging, c->vulkan);
  return result;
}

static VkResult make_layouts(floor_casters *c, uint32_t set_count) {
  const VkDescriptorSetLayoutBinding bindings[] = {
      {constants_binding, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL},
      {texture_binding, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, 1, VK_SHADER_STAGE_FRAGMENT_BIT, NULL}};
  const VkDescriptorSetLayoutCreateInfo set = {
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 2, .pBindings = bindings};
  VkResult result = vkCreateDescriptorSetLayout(c->vulkan->device, &set, NULL, &c->set_layout);
  const VkPipelineLayoutCreateInfo layout = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO, .setLayoutCount = 1, .pSetLayouts = &c->set_layout};
  if (!result)
    result = vkCreatePipelineLayout(c->vulkan->device, &layout, NULL, &c->layout);
  const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, set_count},
                                        {VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE, set_count}};
  const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                           .maxSets = set_count,
                                           .poolSizeCount = 2,
                                           .pPoolSizes = sizes};
  return result ? result : vkCreateDescriptorPool(c->vulkan->device, &pool, NULL, &c->descriptors);
}

static void write_block(const floor_casters *c, size_t material, const scene_alpha_mask *mask) {
  static const float wraps[] = {[SCENE_WRAP_REPEAT] = CSM_WRAP_REPEAT,
                                [SCENE_WRAP_MIRROR] = CSM_WRAP_MIRROR,
                                [SCENE_WRAP_CLAMP] = CSM_WRAP_CLAMP};
  float *block = (float *)((char *)c->constants.mapped + material * block_stride);
  const float size[4] = {(float)mask->width, (float)mask->height, (float)mask->cutoff};
  const float wrap[4] = {wraps[mask->wrap[0]], wraps[mask->wrap[1]]};
  memcpy(block + 4 * ALPHA_MASK_SIZE, size, sizeof size);
  memcpy(block + 4 * ALPHA_MASK_WRAP, wrap, sizeof wrap);
}

static VkResult make_set(const floor_casters *c, size_t material, VkDescriptorSet *out) {
  const VkDescriptorSetAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                            .descriptorPool = c->descriptors,
                                            .descriptorSetCount = 1,
                                            .pSetLayouts = &c->set_layout};
  const VkResult result = vkAllocateDescriptorSets(c->vulkan->device, &info, out);
  if (result)
    return result;
  const VkDescriptorBufferInfo block = {c->constants.buffer, material * block_stride, 16 * ALPHA_MASK_COUNT};
  const VkDescriptorImageInfo image = {VK_NULL_HANDLE, c->images[material].view,
                                       VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkWriteDescriptorSet writes[] = {{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                          .dstSet = *out,
                                          .dstBinding = constants_binding,
                                          .descriptorCount = 1,
                                          .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                          .pBufferInfo = &block},
                                         {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                          .dstSet = *out,
                                          .dstBinding = texture_binding,
                                          .descriptorCount = 1,
                                          .descriptorType = VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE,
                                          .pImageInfo = &image}};
  vkUpdateDescriptorSets(c->vulkan->device, 2, writes, 0, NULL);
  return VK_SUCCESS;
}

/* What a mesh is cut out by: its material's image, uploaded with the first mesh that has it. */
static VkResult add_cut_out(floor_casters *c, const scene *s, size_t mesh, vulkan_commands *commands) {
  const size_t material = s->meshes[mesh].material;
  const scene_alpha_mask *mask = scene_cut_out(s, &s->meshes[mesh]);
  VkResult result = VK_SUCCESS;
  if (!mask)
    return result;
  if (!c->images[material].view) {
    result = upload_image(c, &c->images[material], mask, commands);
    write_block(c, material, mask);
  }
  return result ? result : make_set(c, material, &c->meshes[mesh].cut_out);
}

VkResult floor_casters_open(floor_casters *out, vulkan_commands *commands, const scene *s, const plan_bounds *bounds) {
  const vulkan_device *vulkan = commands->vulkan;
  *out = (floor_casters){.vulkan = vulkan,
                         .images = host_allocate(s->material_count, sizeof *out->images),
                         .image_count = s->material_count};
  VkResult result = upload_meshes(out, s, bounds);
  if (!result)
    result = vulkan_buffer_open(&out->constants, vulkan, s->material_count * block_stride,
                                VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
  if (!result)
    result = make_layouts(out, (uint32_t)s->mesh_count);
  for (size_t i = 0; i < s->mesh_count && !result; ++i)
    result = add_cut_out(out, s, i, commands);
  return result;
}

/* ---- pipelines ---- */

static const VkVertexInputBindingDescription vertex_bindings[] = {
    {0, position_bytes, VK_VERTEX_INPUT_RATE_VERTEX},
    {1, floor_matrix_bytes, VK_VERTEX_INPUT_RATE_INSTANCE},
    {2, uv_bytes, VK_VERTEX_INPUT_RATE_VERTEX}};
static const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                               {1, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 0},
                                                               {2, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 16},
                                                               {3, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 32},
                                                               {4, 2, VK_FORMAT_R32G32_SFLOAT, 0}};

/* Stages without a module are left out. */
static VkResult make_pipeline(floor_casters *c, const floor_target *target,
                              const VkPipelineShaderStageCreateInfo stages[2], bool cut_out, VkCullModeFlags cull) {
  const bool colour = target->moments != VK_FORMAT_UNDEFINED;
  const VkPipelineVertexInputStateCreateInfo input = {.sType =
                                                          VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                      .vertexBindingDescriptionCount = cut_out ? 3 : 2,
                                                      .pVertexBindingDescriptions = vertex_bindings,
                                                      .vertexAttributeDescriptionCount = cut_out ? 5 : 4,
                                                      .pVertexAttributeDescriptions = attributes};
  const VkPipelineInputAssemblyStateCreateInfo assembly = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
      .viewportCount = 1,
      .pViewports = &(VkViewport){0, (float)target->side, (float)target->side, -(float)target->side, 0, 1},
      .scissorCount = 1,
      .pScissors = &(VkRect2D){{0, 0}, {target->side, target->side}}};
  const VkPipelineRasterizationStateCreateInfo raster = {.sType =
                                                             VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                         .depthClampEnable = VK_TRUE,
                                                         .cullMode = cull,
                                                         .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo samples = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth = {.sType =
                                                           VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                       .depthTestEnable = VK_TRUE,
                                                       .depthWriteEnable = VK_TRUE,
                                                       .depthCompareOp = VK_COMPARE_OP_LESS};
  const VkPipelineColorBlendAttachmentState written = {.colorWriteMask = 0xf};
  const VkPipelineColorBlendStateCreateInfo blend = {.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                     .attachmentCount = 1,
                                                     .pAttachments = &written};
  const VkPipelineRenderingCreateInfo rendering = {.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                   .colorAttachmentCount = colour,
                                                   .pColorAttachmentFormats = &target->moments,
                                                   .depthAttachmentFormat = VK_FORMAT_D32_SFLOAT};
  const VkGraphicsPipelineCreateInfo info = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                             .pNext = target->pass ? NULL : &rendering,
                                             .stageCount = stages[1].module ? 2 : 1,
                                             .pStages = stages,
                                             .pVertexInputState = &input,
                                             .pInputAssemblyState = &assembly,
                                             .pViewportState = &viewport,
                                             .pRasterizationState = &raster,
                                             .pMultisampleState = &samples,
                                             .pDepthStencilState = &depth,
                                             .pColorBlendState = colour ? &blend : NULL,
                                             .layout = c->layout,
                                             .renderPass = target->pass};
  return vkCreateGraphicsPipelines(c->vulkan->device, VK_NULL_HANDLE, 1, &info, NULL, &c->pipelines[cut_out][cull]);
}

static VkPipelineShaderStageCreateInfo make_stage(VkShaderStageFlagBits stage, VkShaderModule module) {
  return (VkPipelineShaderStageCreateInfo){
      .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO, .stage = stage, .module = module, .pName = "main"};
}

/* Pairs by cut out or not. */
enum { VERTEX, PIXEL = 2, SHADER_COUNT = 4 };

static VkResult make_from(floor_casters *c, const floor_target *target, const VkShaderModule *modules) {
  VkResult result = VK_SUCCESS;
  for (VkCullModeFlags cull = VK_CULL_MODE_NONE; cull <= VK_CULL_MODE_BACK_BIT && !result; ++cull)
    for (int cut_out = 0; cut_out < 2 && !result; ++cut_out) {
      const VkPipelineShaderStageCreateInfo stages[2] = {
          make_stage(VK_SHADER_STAGE_VERTEX_BIT, modules[VERTEX + cut_out]),
          make_stage(VK_SHADER_STAGE_FRAGMENT_BIT, modules[PIXEL + cut_out])};
      result = make_pipeline(c, target, stages, cut_out, cull);
    }
  return result;
}

typedef struct spirv {
  const void *code;
  size_t size;
} spirv;

/* Opaque casters have no pixel shader where depth alone is drawn. */
static void choose_shaders(spirv out[SHADER_COUNT], VkFormat moments) {
  const spirv vertex[] = {{shader_cascade_depth_vs.spirv, shader_cascade_depth_vs.spirv_size},
                          {shader_cascade_depth_alpha_mask_vs.spirv, shader_cascade_depth_alpha_mask_vs.spirv_size}};
  const spirv depth[] = {{NULL, 0}, {shader_alpha_mask_ps.spirv, shader_alpha_mask_ps.spirv_size}};
  const spirv vsm[] = {{drawn_moments_vsm_ps, sizeof drawn_moments_vsm_ps},
                       {drawn_moments_vsm_alpha_mask_ps, sizeof drawn_moments_vsm_alpha_mask_ps}};
  const spirv evsm4[] = {{drawn_moments_evsm4_ps, sizeof drawn_moments_evsm4_ps},
                         {drawn_moments_evsm4_alpha_mask_ps, sizeof drawn_moments_evsm4_alpha_mask_ps}};
  const spirv *pixel = moments == VK_FORMAT_UNDEFINED ? depth : moments == VK_FORMAT_R32G32_SFLOAT ? vsm : evsm4;
  memcpy(out + VERTEX, vertex, sizeof vertex);
  memcpy(out + PIXEL, pixel, sizeof depth);
}

VkResult floor_casters_make_pipelines(floor_casters *c, const floor_target *target) {
  spirv codes[SHADER_COUNT];
  VkShaderModule modules[SHADER_COUNT] = {VK_NULL_HANDLE};
  VkResult result = VK_SUCCESS;
  choose_shaders(codes, target->moments);
  for (int i = 0; i < SHADER_COUNT && !result; ++i)
    if (codes[i].code)
      result = vulkan_shader(c->vulkan, codes[i].code, codes[i].size, &modules[i]);
  if (!result)
    result = make_from(c, target, modules);
  for (int i = 0; i < SHADER_COUNT; ++i)
    vkDestroyShaderModule(c->vulkan->device, modules[i], NULL);
  return result;
}

void floor_casters_close(floor_casters *c) {
  if (!c->vulkan)
    return;
  const VkDevice device = c->vulkan->device;
  for (int cut_out = 0; cut_out < 2; ++cut_out)
    for (int cull = 0; cull < 3; ++cull)
      vkDestroyPipeline(device, c->pipelines[cut_out][cull], NULL);
  vkDestroyPipelineLayout(device, c->layout, NULL);
  vkDestroyDescriptorPool(device, c->descriptors, NULL);
  vkDestroyDescriptorSetLayout(device, c->set_layout, NULL);
  for (size_t i = 0; i < c->image_count; ++i)
    vulkan_image_close(&c->images[i], c->vulkan);
  vulkan_buffer_close(&c->geometry, c->vulkan);
  vulkan_buffer_close(&c->constants, c->vulkan);
  free(c->meshes);
  free(c->images);
}
