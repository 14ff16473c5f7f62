#include "bench/floor.h"
#include "base/host.h"
#include "bench/floor_casters.h"
#include "bench/shaders/drawn_moments.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What a cascade is drawn into: its depths, and its moments where they are wanted. */
enum { DEPTHS, MOMENTS, MOST_TARGETS };

typedef struct floor_target_image {
  vulkan_image image; /* a layer for each cascade */
  VkImageView views[CSM_MAX_CASCADES];
} floor_target_image;

struct floor_loop {
  floor_info info;
  vulkan_device vulkan;
  VkDevice device; /* of it */
  vulkan_commands commands;
  floor_casters casters;
  vulkan_buffer matrices;
  VkDeviceSize matrices_offsets[CSM_MAX_CASCADES];
  floor_target_image targets[MOST_TARGETS];
  uint32_t target_count;
  VkFramebuffer framebuffers[CSM_MAX_CASCADES]; /* these and the pass: without dynamic rendering */
  VkRenderPass pass;
};

enum { depth_tests = VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT };

/* By target: how passes use it. */
static const vulkan_use drawn[MOST_TARGETS] = {
    {VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL, depth_tests,
     VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT},
    {VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
     VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT}};
static const VkImageAspectFlags aspects[MOST_TARGETS] = {VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_ASPECT_COLOR_BIT};

static VkFormat moments_format(const floor_loop *loop) {
  static const VkFormat formats[] = {[FLOOR_DEPTH] = VK_FORMAT_UNDEFINED,
                                     [FLOOR_VSM] = VK_FORMAT_R32G32_SFLOAT,
                                     [FLOOR_EVSM4] = VK_FORMAT_R32G32B32A32_SFLOAT};
  return formats[loop->info.moments];
}

static VkFormat format_of(const floor_loop *loop, uint32_t target) {
  return target == DEPTHS ? VK_FORMAT_D32_SFLOAT : moments_format(loop);
}

/* ---- making it ---- */

static VkResult upload_matrices(floor_loop *loop) {
  const plan_frame *frame = loop->info.frame;
  VkDeviceSize size = 0;
  for (uint32_t i = 0; i < frame->cascade_count; ++i) {
    loop->matrices_offsets[i] = size;
    size += (VkDeviceSize)frame->windows[i].list.instance_count * floor_matrix_bytes;
  }
  const VkResult result = vulkan_buffer_open(&loop->matrices, &loop->vulkan, size, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  for (uint32_t i = 0; i < frame->cascade_count && !result; ++i)
    plan_write_window_matrices((float *)((char *)loop->matrices.mapped + loop->matrices_offsets[i]), frame, i,
                                loop->info.plan_scene);
  return result;
}

static VkResult make_image(floor_loop *loop, uint32_t target) {
  floor_target_image *out = &loop->targets[target];
  const uint32_t layers = loop->info.frame->cascade_count;
  const vulkan_image_info info = {
      .format = format_of(loop, target),
      .width = loop->info.resolution,
      .height = loop->info.resolution,
      .layers = layers,
      .usage = (target == DEPTHS ? VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT : VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT) |
               VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT};
  VkResult result = vulkan_image_open(&out->image, &loop->vulkan, &info);
  for (uint32_t layer = 0; layer < layers && !result; ++layer) {
    const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                        .image = out->image.image,
                                        .viewType = VK_IMAGE_VIEW_TYPE_2D,
                                        .format = info.format,
                                        .subresourceRange = {aspects[target], 0, 1, layer, 1}};
    result = vkCreateImageView(loop->device, &view, NULL, &out->views[layer]);
  }
  return result;
}

static VkResult make_pass(floor_loop *loop) {
  VkAttachmentDescription attachments[MOST_TARGETS];
  for (uint32_t i = 0; i < loop->target_count; ++i)
    attachments[i] = (VkAttachmentDescription){.format = format_of(loop, i),
                                               .samples = VK_SAMPLE_COUNT_1_BIT,
                                               .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                               .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                               .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                               .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                               .initialLayout = drawn[i].layout,
                                               .finalLayout = drawn[i].layout};
  const VkAttachmentReference depth = {.attachment = DEPTHS, .layout = drawn[DEPTHS].layout};
  const VkAttachmentReference moments = {.attachment = MOMENTS, .layout = drawn[MOMENTS].layout};
  const VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                        .colorAttachmentCount = loop->target_count - 1,
                                        .pColorAttachments = &moments,
                                        .pDepthStencilAttachment = &depth};
  const VkRenderPassCreateInfo info = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                       .attachmentCount = loop->target_count,
                                       .pAttachments = attachments,
                                       .subpassCount = 1,
                                       .pSubpasses = &subpass};
  return vkCreateRenderPass(loop->device, &info, NULL, &loop->pass);
}

static VkResult make_framebuffer(floor_loop *loop, uint32_t layer) {
  const VkImageView views[MOST_TARGETS] = {loop->targets[DEPTHS].views[layer], loop->targets[MOMENTS].views[layer]};
  const VkFramebufferCreateInfo info = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                        .renderPass = loop->pass,
                                        .attachmentCount = loop->target_count,
                                        .pAttachments = views,
                                        .width = loop->info.resolution,
                                        .height = loop->info.resolution,
                                        .layers = 1};
  return vkCreateFramebuffer(loop->device, &info, NULL, &loop->framebuffers[layer]);
}

static VkResult make_targets(floor_loop *loop) {
  VkResult result = VK_SUCCESS;
  for (uint32_t i = 0; i < loop->target_count && !result; ++i)
    result = make_image(loop, i);
  if (result || loop->vulkan.begin_rendering)
    return result;
  result = make_pass(loop);
  for (uint32_t i = 0; i < loop->info.frame->cascade_count && !result; ++i)
    result = make_framebuffer(loop, i);
  return result;
}

static VkResult make_pipelines(floor_loop *loop) {
  const floor_target target = {.pass = loop->pass, .side = loop->info.resolution, .moments = moments_format(loop)};
  return floor_casters_make_pipelines(&loop->casters, &target);
}

int floor_open(floor_loop **out, const floor_info *info, char *error, size_t error_size) {
  *out = NULL;
  floor_loop *loop = calloc(1, sizeof *loop);
  if (!loop)
    return HOST_NO_DEVICE;
  loop->info = *info;
  loop->target_count = info->moments ? 2 : 1;
  VkResult result = vulkan_device_open_rendering(&loop->vulkan, info->device);
  loop->device = loop->vulkan.device;
  if (!result)
    result = vulkan_commands_open(&loop->commands, &loop->vulkan);
  if (!result)
    result = floor_casters_open(&loop->casters, &loop->commands, info->scene, info->plan_scene->meshes);
  if (!result)
    result = upload_matrices(loop);
  if (!result)
    result = make_targets(loop);
  if (!result)
    result = make_pipelines(loop);
  if (result) {
    snprintf(error, error_size, "the bare Vulkan loop: %s (VkResult %d)", vulkan_reason(result), (int)result);
    floor_close(loop);
    return HOST_NO_DEVICE;
  }
  *out = loop;
  return 0;
}

/* ---- a frame ---- */

/* Of what lies where nothing is drawn. */
static VkClearColorValue far_moments(floor_moments moments) {
  if (moments == FLOOR_VSM)
    return (VkClearColorValue){.float32 = {1, 1}};
  const double grown = exp(DRAWN_EXPONENT), fallen = exp(-DRAWN_EXPONENT_NEGATIVE);
  return (VkClearColorValue){
      .float32 = {(float)grown, (float)(grown * grown), (float)-fallen, (float)(fallen * fallen)}};
}

static void record_clear(const floor_loop *loop, uint32_t target) {
  const vulkan_use before = {VK_IMAGE_LAYOUT_UNDEFINED, drawn[target].stages, 0};
  static const vulkan_use cleared = {VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                     VK_ACCESS_TRANSFER_WRITE_BIT};
  const VkImageSubresourceRange all = {aspects[target], 0, 1, 0, VK_REMAINING_ARRAY_LAYERS};
  const VkClearDepthStencilValue far = {.depth = 1};
  const VkClearColorValue moments = far_moments(loop->info.moments);
  const VkCommandBuffer commands = loop->commands.buffer;
  const VkImage image = loop->targets[target].image.image;
  vulkan_transition(commands, image, aspects[target], before, cleared);
  if (target == DEPTHS)
    vkCmdClearDepthStencilImage(commands, image, cleared.layout, &far, 1, &all);
  else
    vkCmdClearColorImage(commands, image, cleared.layout, &moments, 1, &all);
  vulkan_transition(commands, image, aspects[target], cleared, drawn[target]);
}

static void record_draws(const floor_loop *loop, uint32_t cascade) {
  const VkCommandBuffer commands = loop->commands.buffer;
  const plan_list *list = &loop->info.frame->windows[cascade].list;
  const floor_casters *casters = &loop->casters;
  VkPipeline current = VK_NULL_HANDLE;
  for (uint32_t i = 0; i < list->draw_count; ++i) {
    const plan_draw *draw = &list->draws[i];
    const floor_mesh *mesh = &casters->meshes[draw->mesh];
    const bool cut_out = mesh->cut_out != VK_NULL_HANDLE;
    const VkPipeline pipeline = casters->pipelines[cut_out][floor_cull(mesh, draw->mirrored)];
    const VkBuffer buffers[] = {casters->geometry.buffer, loop->matrices.buffer, casters->geometry.buffer};
    const VkDeviceSize first = (VkDeviceSize)draw->first * floor_matrix_bytes;
    const VkDeviceSize offsets[] = {mesh->vertices, loop->matrices_offsets[cascade] + first, mesh->uvs};
    if (pipeline != current)
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
    current = pipeline;
    if (cut_out)
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, casters->layout, 0, 1, &mesh->cut_out, 0,
                              NULL);
    vkCmdBindVertexBuffers(commands, 0, cut_out ? 3 : 2, buffers, offsets);
    vkCmdBindIndexBuffer(commands, buffers[0], mesh->indices, mesh->index_type);
    vkCmdDrawIndexed(commands, mesh->index_count, draw->count, 0, 0, 0);
  }
}

/* As csm's own device begins a pass: with dynamic rendering where there is any. */
static void begin_cascade(const floor_loop *loop, uint32_t cascade) {
  const VkRect2D area = {{0, 0}, {loop->info.resolution, loop->info.resolution}};
  VkRenderingAttachmentInfo attachments[MOST_TARGETS];
  for (uint32_t i = 0; i < loop->target_count; ++i)
    attachments[i] = (VkRenderingAttachmentInfo){.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                                 .imageView = loop->targets[i].views[cascade],
                                                 .imageLayout = drawn[i].layout,
                                                 .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                                 .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
  const VkRenderingInfo rendering = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                     .renderArea = area,
                                     .layerCount = 1,
                                     .colorAttachmentCount = loop->target_count - 1,
                                     .pColorAttachments = &attachments[MOMENTS],
                                     .pDepthAttachment = &attachments[DEPTHS]};
  const VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                       .renderPass = loop->pass,
                                       .framebuffer = loop->framebuffers[cascade],
                                       .renderArea = area};
  if (loop->pass)
    vkCmdBeginRenderPass(loop->commands.buffer, &begin, VK_SUBPASS_CONTENTS_INLINE);
  else
    loop->vulkan.begin_rendering(loop->commands.buffer, &rendering);
}

static void record_cascade(const floor_loop *loop, uint32_t cascade) {
  begin_cascade(loop, cascade);
  record_draws(loop, cascade);
  if (loop->pass)
    vkCmdEndRenderPass(loop->commands.buffer);
  else
    loop->vulkan.end_rendering(loop->commands.buffer);
}

double floor_frame(floor_loop *loop) {
  const double start_ms = host_now_ms();
  if (vulkan_commands_begin(&loop->commands))
    return -1;
  vulkan_commands_stamp(&loop->commands, 0);
  for (uint32_t i = 0; i < loop->target_count; ++i)
    record_clear(loop, i);
  for (uint32_t i = 0; i < loop->info.frame->cascade_count; ++i)
    record_cascade(loop, i);
  vulkan_commands_stamp(&loop->commands, 1);
  return vulkan_commands_finish(&loop->commands) ? -1 : host_now_ms() - start_ms;
}

double floor_gpu_ms(const floor_loop *loop) {
  return vulkan_commands_ms(&loop->commands);
}

static bool read_target(floor_loop *loop, uint32_t target, uint32_t cascade, float *out) {
  static const vulkan_use copied = {VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_TRANSFER_BIT,
                                    VK_ACCESS_TRANSFER_READ_BIT};
  const uint32_t side = loop->info.resolution, floats = target == DEPTHS ? 1 : (uint32_t)loop->info.moments;
  const VkDeviceSize size = (VkDeviceSize)side * side * floats * sizeof *out;
  const VkImage image = loop->targets[target].image.image;
  const VkBufferImageCopy region = {.imageSubresource = {aspects[target], 0, cascade, 1},
                                    .imageExtent = {side, side, 1}};
  vulkan_buffer buffer;
  VkResult result = vulkan_buffer_open(&buffer, &loop->vulkan, size, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  if (!result)
    result = vulkan_commands_begin(&loop->commands);
  if (!result) {
    vulkan_transition(loop->commands.buffer, image, aspects[target], drawn[target], copied);
    vkCmdCopyImageToBuffer(loop->commands.buffer, image, copied.layout, buffer.buffer, 1, &region);
    vulkan_transition(loop->commands.buffer, image, aspects[target], copied, drawn[target]);
    result = vulkan_commands_finish(&loop->commands);
  }
  if (!result)
    memcpy(out, buffer.mapped, size);
  vulkan_buffer_close(&buffer, &loop->vulkan);
  return !result;
}

bool floor_read(floor_loop *loop, uint32_t cascade, float *out) {
  return read_target(loop, DEPTHS, cascade, out);
}

bool floor_read_moments(floor_loop *loop, uint32_t cascade, float *out) {
  return read_target(loop, MOMENTS, cascade, out);
}

static void destroy_objects(floor_loop *loop) {
  vkDeviceWaitIdle(loop->device);
  floor_casters_close(&loop->casters);
  vulkan_commands_close(&loop->commands);
  for (int i = 0; i < CSM_MAX_CASCADES; ++i) {
    vkDestroyFramebuffer(loop->device, loop->framebuffers[i], NULL);
    for (int k = 0; k < MOST_TARGETS; ++k)
      vkDestroyImageView(loop->device, loop->targets[k].views[i], NULL);
  }
  vkDestroyRenderPass(loop->device, loop->pass, NULL);
  for (int k = 0; k < MOST_TARGETS; ++k)
    vulkan_image_close(&loop->targets[k].image, &loop->vulkan);
  vulkan_buffer_close(&loop->matrices, &loop->vulkan);
}

void floor_close(floor_loop *loop) {
  if (!loop)
    return;
  if (loop->device)
    destroy_objects(loop);
  vulkan_device_close(&loop->vulkan);
  free(loop);
}
