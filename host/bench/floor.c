#include "bench/floor.h"

#include "clock.h"
#include "base/host.h"
#include "shader_code.h"
#include "bench/vulkan_memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { matrix_bytes = 12 * sizeof(float) };

/* Where a mesh lies in the one buffer that holds them all. */
typedef struct floor_mesh {
  VkDeviceSize vertices, indices;
  VkIndexType index_type;
  uint32_t index_count;
} floor_mesh;

struct floor_loop {
  floor_info info;
  vulkan_device vulkan;
  VkDevice device; /* of it */
  VkBuffer geometry, matrices;
  VkDeviceMemory geometry_memory, matrices_memory, maps_memory;
  floor_mesh *meshes;
  VkDeviceSize matrices_offsets[CSM_MAX_CASCADES];
  VkImage maps;
  VkImageView views[CSM_MAX_CASCADES];
  VkFramebuffer framebuffers[CSM_MAX_CASCADES];
  VkRenderPass pass;
  VkPipelineLayout layout;
  VkPipeline pipeline;
  VkCommandPool pool;
  VkCommandBuffer commands;
  VkFence fence;
  VkQueryPool queries; /* before and after a frame's work */
};

/* ---- memory ---- */

enum { geometry_usage = VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT };

static VkResult upload_geometry(floor_loop *loop) {
  const scene *scene = loop->info.scene;
  VkDeviceSize size = 0;
  loop->meshes = calloc(scene->mesh_count + 1, sizeof *loop->meshes);
  if (!loop->meshes)
    return VK_ERROR_OUT_OF_HOST_MEMORY;
  for (size_t i = 0; i < scene->mesh_count; ++i) {
    const scene_mesh *mesh = &scene->meshes[i];
    loop->meshes[i] = (floor_mesh){.vertices = size,
                                   .indices = size + (VkDeviceSize)mesh->vertex_count * 12,
                                   .index_type = mesh->index_size == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32,
                                   .index_count = mesh->index_count};
    size = (loop->meshes[i].indices + (VkDeviceSize)mesh->index_count * mesh->index_size + 15) / 16 * 16;
  }
  void *mapped;
  const VkResult result =
      vulkan_buffer(&loop->vulkan, size, geometry_usage, &loop->geometry, &loop->geometry_memory, &mapped);
  for (size_t i = 0; i < scene->mesh_count && !result; ++i) {
    const scene_mesh *mesh = &scene->meshes[i];
    memcpy((char *)mapped + loop->meshes[i].vertices, mesh->positions, (size_t)mesh->vertex_count * 12);
    memcpy((char *)mapped + loop->meshes[i].indices, mesh->indices, (size_t)mesh->index_count * mesh->index_size);
  }
  return result;
}

static VkResult upload_matrices(floor_loop *loop) {
  const plan_frame *frame = loop->info.frame;
  VkDeviceSize size = 0;
  for (uint32_t i = 0; i < frame->cascade_count; ++i) {
    loop->matrices_offsets[i] = size;
    size += (VkDeviceSize)frame->cascades[i].list.instance_count * matrix_bytes;
  }
  void *mapped;
  const VkResult result =
      vulkan_buffer(&loop->vulkan, size, geometry_usage, &loop->matrices, &loop->matrices_memory, &mapped);
  for (uint32_t i = 0; i < frame->cascade_count && !result; ++i)
    plan_write_cascade_matrices((float *)((char *)mapped + loop->matrices_offsets[i]), frame, i, loop->info.plan_scene);
  return result;
}

/* ---- maps and pipeline ---- */

static VkResult make_maps(floor_loop *loop) {
  const VkImageCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
      .imageType = VK_IMAGE_TYPE_2D,
      .format = VK_FORMAT_D32_SFLOAT,
      .extent = {loop->info.resolution, loop->info.resolution, 1},
      .mipLevels = 1,
      .arrayLayers = loop->info.frame->cascade_count,
      .samples = VK_SAMPLE_COUNT_1_BIT,
      .usage =
          VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
  };
  return vulkan_image(&loop->vulkan, &info, &loop->maps, &loop->maps_memory);
}

static VkResult make_pass(floor_loop *loop) {
  const VkAttachmentDescription attachment = {
      .format = VK_FORMAT_D32_SFLOAT,
      .samples = VK_SAMPLE_COUNT_1_BIT,
      .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
      .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
      .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
      .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
      .initialLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
      .finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
  };
  const VkAttachmentReference depth = {.layout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  const VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                        .pDepthStencilAttachment = &depth};
  const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                       .attachmentCount = 1,
                                       .pAttachments = &attachment,
                                       .subpassCount = 1,
                                       .pSubpasses = &subpass};
  return vkCreateRenderPass(loop->device, &info, NULL, &loop->pass);
}

static VkResult make_framebuffer(floor_loop *loop, uint32_t layer) {
  const VkImageViewCreateInfo view = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
      .image = loop->maps,
      .viewType = VK_IMAGE_VIEW_TYPE_2D,
      .format = VK_FORMAT_D32_SFLOAT,
      .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, layer, 1},
  };
  const VkResult result = vkCreateImageView(loop->device, &view, NULL, &loop->views[layer]);
  const VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                        .renderPass = loop->pass,
                                        .attachmentCount = 1,
                                        .pAttachments = &loop->views[layer],
                                        .width = loop->info.resolution,
                                        .height = loop->info.resolution,
                                        .layers = 1};
  return result ? result : vkCreateFramebuffer(loop->device, &info, NULL, &loop->framebuffers[layer]);
}

static VkResult make_pipeline(floor_loop *loop) {
  VkShaderModule module;
  VkResult result =
      vulkan_shader(&loop->vulkan, shader_cascade_depth_vs.spirv, shader_cascade_depth_vs.spirv_size, &module);
  if (result)
    return result;
  const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  result = vkCreatePipelineLayout(loop->device, &layout, NULL, &loop->layout);
  const float side = (float)loop->info.resolution;
  const VkPipelineShaderStageCreateInfo stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                 .stage = VK_SHADER_STAGE_VERTEX_BIT,
                                                 .module = module,
                                                 .pName = "main"};
  const VkVertexInputBindingDescription bindings[] = {{0, 12, VK_VERTEX_INPUT_RATE_VERTEX},
                                                      {1, matrix_bytes, VK_VERTEX_INPUT_RATE_INSTANCE}};
  const VkVertexInputAttributeDescription attributes[] = {{0, 0, VK_FORMAT_R32G32B32_SFLOAT, 0},
                                                          {1, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 0},
                                                          {2, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 16},
                                                          {3, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 32}};
  const VkGraphicsPipelineCreateInfo info = {
      .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
      .stageCount = 1,
      .pStages = &stage,
      .pVertexInputState =
          &(VkPipelineVertexInputStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                  .vertexBindingDescriptionCount = 2,
                                                  .pVertexBindingDescriptions = bindings,
                                                  .vertexAttributeDescriptionCount = 4,
                                                  .pVertexAttributeDescriptions = attributes},
      .pInputAssemblyState = &(
          VkPipelineInputAssemblyStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
                                                  .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST},
      .pViewportState =
          &(VkPipelineViewportStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
                                               .viewportCount = 1,
                                               .pViewports = &(VkViewport){0, side, side, -side, 0, 1},
                                               .scissorCount = 1,
                                               .pScissors =
                                                   &(VkRect2D){{0, 0}, {loop->info.resolution, loop->info.resolution}}},
      .pRasterizationState =
          &(VkPipelineRasterizationStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
                                                    .depthClampEnable = VK_TRUE,
                                                    .lineWidth = 1},
      .pMultisampleState =
          &(VkPipelineMultisampleStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
                                                  .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT},
      .pDepthStencilState =
          &(VkPipelineDepthStencilStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                   .depthTestEnable = VK_TRUE,
                                                   .depthWriteEnable = VK_TRUE,
                                                   .depthCompareOp = VK_COMPARE_OP_LESS},
      .layout = loop->layout,
      .renderPass = loop->pass,
  };
  if (!result)
    result = vkCreateGraphicsPipelines(loop->device, VK_NULL_HANDLE, 1, &info, NULL, &loop->pipeline);
  vkDestroyShaderModule(loop->device, module, NULL);
  return result;
}

static VkResult make_commands(floor_loop *loop) {
  const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                        .flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT,
                                        .queueFamilyIndex = loop->vulkan.family};
  VkResult result = vkCreateCommandPool(loop->device, &pool, NULL, &loop->pool);
  if (result)
    return result;
  const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                .commandPool = loop->pool,
                                                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                .commandBufferCount = 1};
  result = vkAllocateCommandBuffers(loop->device, &commands, &loop->commands);
  if (!result)
    result = vulkan_timestamps(&loop->vulkan, 2, &loop->queries);
  const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  return result ? result : vkCreateFence(loop->device, &fence, NULL, &loop->fence);
}

int floor_open(floor_loop **out, const floor_info *info, char *error, size_t error_size) {
  *out = NULL;
  floor_loop *loop = calloc(1, sizeof *loop);
  if (!loop)
    return HOST_NO_DEVICE;
  loop->info = *info;
  VkResult result = vulkan_device_open(&loop->vulkan, info->device);
  loop->device = loop->vulkan.device;
  if (!result)
    result = upload_geometry(loop);
  if (!result)
    result = upload_matrices(loop);
  if (!result)
    result = make_maps(loop);
  if (!result)
    result = make_pass(loop);
  for (uint32_t i = 0; i < info->frame->cascade_count && !result; ++i)
    result = make_framebuffer(loop, i);
  if (!result)
    result = make_pipeline(loop);
  if (!result)
    result = make_commands(loop);
  if (result) {
    snprintf(error, error_size, "the bare Vulkan loop: %s (VkResult %d)", vulkan_reason(result), (int)result);
    floor_close(loop);
    return HOST_NO_DEVICE;
  }
  *out = loop;
  return 0;
}

/* ---- a frame ---- */

static void barrier(const floor_loop *loop, VkImageLayout from, VkImageLayout to, VkPipelineStageFlags from_stage,
                    VkPipelineStageFlags to_stage, VkAccessFlags from_access, VkAccessFlags to_access) {
  const VkImageMemoryBarrier info = {
      .sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER,
      .srcAccessMask = from_access,
      .dstAccessMask = to_access,
      .oldLayout = from,
      .newLayout = to,
      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
      .image = loop->maps,
      .subresourceRange = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS},
  };
  vkCmdPipelineBarrier(loop->commands, from_stage, to_stage, 0, 0, NULL, 0, NULL, 1, &info);
}

static void record_clear(const floor_loop *loop) {
  const VkPipelineStageFlags tests =
      VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
  const VkAccessFlags depth =
      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  const VkImageSubresourceRange all = {VK_IMAGE_ASPECT_DEPTH_BIT, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
  const VkClearDepthStencilValue far = {.depth = 1};
  barrier(loop, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, tests, VK_PIPELINE_STAGE_TRANSFER_BIT,
          0, VK_ACCESS_TRANSFER_WRITE_BIT);
  vkCmdClearDepthStencilImage(loop->commands, loop->maps, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &far, 1, &all);
  barrier(loop, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL,
          VK_PIPELINE_STAGE_TRANSFER_BIT, tests, VK_ACCESS_TRANSFER_WRITE_BIT, depth);
}

static void record_cascade(const floor_loop *loop, uint32_t cascade) {
  const plan_list *list = &loop->info.frame->cascades[cascade].list;
  const VkRenderPassBeginInfo begin = {
      .sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
      .renderPass = loop->pass,
      .framebuffer = loop->framebuffers[cascade],
      .renderArea = {{0, 0}, {loop->info.resolution, loop->info.resolution}},
  };
  vkCmdBeginRenderPass(loop->commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
  vkCmdBindPipeline(loop->commands, VK_PIPELINE_BIND_POINT_GRAPHICS, loop->pipeline);
  for (uint32_t i = 0; i < list->draw_count; ++i) {
    const plan_draw *draw = &list->draws[i];
    const floor_mesh *mesh = &loop->meshes[draw->mesh];
    const VkBuffer buffers[] = {loop->geometry, loop->matrices};
    const VkDeviceSize offsets[] = {mesh->vertices,
                                    loop->matrices_offsets[cascade] + (VkDeviceSize)draw->first * matrix_bytes};
    vkCmdBindVertexBuffers(loop->commands, 0, 2, buffers, offsets);
    vkCmdBindIndexBuffer(loop->commands, loop->geometry, mesh->indices, mesh->index_type);
    vkCmdDrawIndexed(loop->commands, mesh->index_count, draw->count, 0, 0, 0);
  }
  vkCmdEndRenderPass(loop->commands);
}

double floor_frame(floor_loop *loop) {
  const double start_ms = clock_ms();
  const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                          .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  if (vkBeginCommandBuffer(loop->commands, &begin))
    return -1;
  if (loop->queries)
    vkCmdResetQueryPool(loop->commands, loop->queries, 0, 2);
  vulkan_write_timestamp(loop->commands, loop->queries, 0);
  record_clear(loop);
  for (uint32_t i = 0; i < loop->info.frame->cascade_count; ++i)
    record_cascade(loop, i);
  vulkan_write_timestamp(loop->commands, loop->queries, 1);
  const VkSubmitInfo submit = {
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &loop->commands};
  if (vkEndCommandBuffer(loop->commands) || vkQueueSubmit(loop->vulkan.queue, 1, &submit, loop->fence) ||
      vkWaitForFences(loop->device, 1, &loop->fence, VK_TRUE, UINT64_MAX) ||
      vkResetFences(loop->device, 1, &loop->fence))
    return -1;
  return clock_ms() - start_ms;
}

double floor_gpu_ms(const floor_loop *loop) {
  return vulkan_elapsed_ms(&loop->vulkan, loop->queries);
}

static void destroy_objects(floor_loop *loop) {
  vkDeviceWaitIdle(loop->device);
  vkDestroyFence(loop->device, loop->fence, NULL);
  vkDestroyQueryPool(loop->device, loop->queries, NULL);
  vkDestroyCommandPool(loop->device, loop->pool, NULL);
  vkDestroyPipeline(loop->device, loop->pipeline, NULL);
  vkDestroyPipelineLayout(loop->device, loop->layout, NULL);
  for (int i = 0; i < CSM_MAX_CASCADES; ++i) {
    vkDestroyFramebuffer(loop->device, loop->framebuffers[i], NULL);
    vkDestroyImageView(loop->device, loop->views[i], NULL);
  }
  vkDestroyRenderPass(loop->device, loop->pass, NULL);
  vkDestroyImage(loop->device, loop->maps, NULL);
  vkDestroyBuffer(loop->device, loop->geometry, NULL);
  vkDestroyBuffer(loop->device, loop->matrices, NULL);
  vkFreeMemory(loop->device, loop->maps_memory, NULL);
  vkFreeMemory(loop->device, loop->geometry_memory, NULL);
  vkFreeMemory(loop->device, loop->matrices_memory, NULL);
}

void floor_close(floor_loop *loop) {
  if (!loop)
    return;
  if (loop->device)
    destroy_objects(loop);
  vulkan_device_close(&loop->vulkan);
  free(loop->meshes);
  free(loop);
}
