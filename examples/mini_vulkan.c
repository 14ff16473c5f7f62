/*
 * mini_vulkan.c: an engine with a Vulkan device of its own that draws its shadows with csm.
 *
 * Read main and draw_frame first. What the engine does for csm:
 *   - it makes its device with what csm needs (vulkan_base.c: depthClamp), and hands it over (open_shadows);
 *   - it hands over its vertex and index buffers, which csm draws as they are (add_meshes);
 *   - each frame, it has csm record the maps into its own command buffer (shadows.c), draws the tree, which only its
 * own shader can bend, when csm calls back (draw_tree), and samples the maps in its forward shader (forward.frag);
 *   - it tells csm which frames the GPU has finished (begin_frame).
 * csm submits nothing and waits for nothing: all that is here.
 */
#include "csm/csm_vulkan.h"
#include "shadows.h"
#include "vulkan_base.h"
#include "caster.vert.h"
#include "forward.frag.h"
#include "forward.vert.h"
#include <string.h>

static const VkFormat color_format = VK_FORMAT_R8G8B8A8_SRGB;
static const VkFormat depth_format = VK_FORMAT_D32_SFLOAT;

/* What changes every frame, once for each frame in flight. */
typedef struct frame_slot {
  VkCommandPool pool;
  VkCommandBuffer commands;
  VkFence done;
  VkDescriptorSet set;
  vulkan_buffer shadow_block; /* csm_binding.constants */
  vulkan_buffer frame_block;  /* frame_constants */
} frame_slot;

typedef struct engine {
  vulkan_base base;
  world world;
  shadows shadows;
  vulkan_buffer vertices[WORLD_MESHES], indices[WORLD_MESHES];
  vulkan_image color, depth;
  vulkan_buffer picture; /* the last frame, for the CPU */
  VkRenderPass pass;
  VkFramebuffer framebuffer;
  VkDescriptorSetLayout set_layout;
  VkDescriptorPool set_pool;
  VkPipelineLayout layout; /* of both pipelines */
  VkPipeline forward, caster;
  frame_slot slots[SHADOWS_FRAMES_IN_FLIGHT];
} engine;

/* ---- what the engine owns ---- */

static void create_meshes(engine *e) {
  for (int i = 0; i < WORLD_MESHES; i++) {
    const mesh *m = &e->world.meshes[i];
    const size_t vertex_bytes = m->vertex_count * sizeof *m->vertices,
                 index_bytes = m->index_count * sizeof *m->indices;
    e->vertices[i] = vulkan_buffer_create(&e->base, vertex_bytes, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
    e->indices[i] = vulkan_buffer_create(&e->base, index_bytes, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
    memcpy(e->vertices[i].mapped, m->vertices, vertex_bytes);
    memcpy(e->indices[i].mapped, m->indices, index_bytes);
  }
}

static void create_pass(engine *e) {
  const VkAttachmentDescription attachments[2] = {{.format = color_format,
                                                   .samples = VK_SAMPLE_COUNT_1_BIT,
                                                   .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                   .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                                   .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                   .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                   .finalLayout = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL},
                                                  {.format = depth_format,
                                                   .samples = VK_SAMPLE_COUNT_1_BIT,
                                                   .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                                   .storeOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                   .stencilLoadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                                   .stencilStoreOp = VK_ATTACHMENT_STORE_OP_DONT_CARE,
                                                   .finalLayout = VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL}};
  const VkAttachmentReference color = {0, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL};
  const VkAttachmentReference depth = {1, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL};
  const VkSubpassDescription subpass = {.pipelineBindPoint = VK_PIPELINE_BIND_POINT_GRAPHICS,
                                        .colorAttachmentCount = 1,
                                        .pColorAttachments = &color,
                                        .pDepthStencilAttachment = &depth};
  const VkPipelineStageFlags depth_stages =
      VK_PIPELINE_STAGE_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_LATE_FRAGMENT_TESTS_BIT;
  const VkAccessFlags depth_access =
      VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_READ_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT;
  const VkAccessFlags color_access = VK_ACCESS_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT;
  const VkSubpassDependency dependencies[2] = {
      /* The frame before drew into the same images. */
      {.srcSubpass = VK_SUBPASS_EXTERNAL,
       .dstSubpass = 0,
       .srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT | depth_stages,
       .dstStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT | depth_stages,
       .srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT,
       .dstAccessMask = color_access | depth_access},
      {.srcSubpass = 0,
       .dstSubpass = VK_SUBPASS_EXTERNAL,
       .srcStageMask = VK_PIPELINE_STAGE_COLOR_ATTACHMENT_OUTPUT_BIT,
       .dstStageMask = VK_PIPELINE_STAGE_TRANSFER_BIT,
       .srcAccessMask = VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT,
       .dstAccessMask = VK_ACCESS_TRANSFER_READ_BIT}};
  const VkRenderPassCreateInfo pass = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_CREATE_INFO,
                                       .attachmentCount = 2,
                                       .pAttachments = attachments,
                                       .subpassCount = 1,
                                       .pSubpasses = &subpass,
                                       .dependencyCount = 2,
                                       .pDependencies = dependencies};
  vulkan_check(vkCreateRenderPass(e->base.device, &pass, NULL, &e->pass), "vkCreateRenderPass");
}

static void create_targets(engine *e) {
  e->color = vulkan_image_create(&e->base, color_format, WORLD_WIDTH, WORLD_HEIGHT,
                                 VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                                 VK_IMAGE_ASPECT_COLOR_BIT);
  e->depth = vulkan_image_create(&e->base, depth_format, WORLD_WIDTH, WORLD_HEIGHT,
                                 VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT, VK_IMAGE_ASPECT_DEPTH_BIT);
  e->picture = vulkan_buffer_create(&e->base, WORLD_WIDTH * WORLD_HEIGHT * 4, VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  create_pass(e);
  const VkImageView views[2] = {e->color.view, e->depth.view};
  const VkFramebufferCreateInfo framebuffer = {.sType = VK_STRUCTURE_TYPE_FRAMEBUFFER_CREATE_INFO,
                                               .renderPass = e->pass,
                                               .attachmentCount = 2,
                                               .pAttachments = views,
                                               .width = WORLD_WIDTH,
                                               .height = WORLD_HEIGHT,
                                               .layers = 1};
  vulkan_check(vkCreateFramebuffer(e->base.device, &framebuffer, NULL, &e->framebuffer), "vkCreateFramebuffer");
}

/* csm's constants, the engine's own, and the maps, as forward.frag declares them; a draw's are pushed. */
static void create_layouts(engine *e) {
  const VkShaderStageFlags stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
  const VkDescriptorSetLayoutBinding bindings[3] = {
      {.binding = 0, .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, .descriptorCount = 1, .stageFlags = stages},
      {.binding = 1, .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, .descriptorCount = 1, .stageFlags = stages},
      {.binding = 2,
       .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
       .descriptorCount = 1,
       .stageFlags = stages}};
  const VkDescriptorSetLayoutCreateInfo set = {
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 3, .pBindings = bindings};
  vulkan_check(vkCreateDescriptorSetLayout(e->base.device, &set, NULL, &e->set_layout), "vkCreateDescriptorSetLayout");

  const VkPushConstantRange push = {.stageFlags = stages, .size = sizeof(draw_constants)};
  const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                             .setLayoutCount = 1,
                                             .pSetLayouts = &e->set_layout,
                                             .pushConstantRangeCount = 1,
                                             .pPushConstantRanges = &push};
  vulkan_check(vkCreatePipelineLayout(e->base.device, &layout, NULL, &e->layout), "vkCreatePipelineLayout");

  const VkDescriptorPoolSize sizes[2] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2 * SHADOWS_FRAMES_IN_FLIGHT},
                                         {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, SHADOWS_FRAMES_IN_FLIGHT}};
  const VkDescriptorPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                           .maxSets = SHADOWS_FRAMES_IN_FLIGHT,
                                           .poolSizeCount = 2,
                                           .pPoolSizes = sizes};
  vulkan_check(vkCreateDescriptorPool(e->base.device, &pool, NULL, &e->set_pool), "vkCreateDescriptorPool");
}

static const VkVertexInputBindingDescription vertex_stream = {0, sizeof(vertex), VK_VERTEX_INPUT_RATE_VERTEX};
static const VkVertexInputAttributeDescription vertex_attributes[2] = {
    {.location = 0, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(vertex, position)},
    {.location = 1, .format = VK_FORMAT_R32G32B32_SFLOAT, .offset = offsetof(vertex, normal)}};

static VkPipelineVertexInputStateCreateInfo vertex_input(uint32_t attribute_count) {
  return (VkPipelineVertexInputStateCreateInfo){.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                .vertexBindingDescriptionCount = 1,
                                                .pVertexBindingDescriptions = &vertex_stream,
                                                .vertexAttributeDescriptionCount = attribute_count,
                                                .pVertexAttributeDescriptions = vertex_attributes};
}

static void create_forward(engine *e) {
  const vulkan_pipeline_info info = {.layout = e->layout,
                                     .render_pass = e->pass,
                                     .vertex_code = forward_vert,
                                     .vertex_size = sizeof forward_vert,
                                     .fragment_code = forward_frag,
                                     .fragment_size = sizeof forward_frag,
                                     .input = vertex_input(2),
                                     .cull = VK_CULL_MODE_BACK_BIT,
                                     .depth_compare = VK_COMPARE_OP_GREATER}; /* reversed-Z */
  e->forward = vulkan_pipeline_create(&e->base, &info);
}

static void create_slot(engine *e, frame_slot *slot) {
  const VkDevice device = e->base.device;
  const VkCommandPoolCreateInfo pool = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                        .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                        .queueFamilyIndex = e->base.queue_family};
  vulkan_check(vkCreateCommandPool(device, &pool, NULL, &slot->pool), "vkCreateCommandPool");
  const VkCommandBufferAllocateInfo commands = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                .commandPool = slot->pool,
                                                .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                .commandBufferCount = 1};
  vulkan_check(vkAllocateCommandBuffers(device, &commands, &slot->commands), "vkAllocateCommandBuffers");
  const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, .flags = VK_FENCE_CREATE_SIGNALED_BIT};
  vulkan_check(vkCreateFence(device, &fence, NULL, &slot->done), "vkCreateFence");
  const VkDescriptorSetAllocateInfo set = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = e->set_pool,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &e->set_layout};
  vulkan_check(vkAllocateDescriptorSets(device, &set, &slot->set), "vkAllocateDescriptorSets");
  slot->shadow_block = vulkan_buffer_create(&e->base, SHADOWS_CONSTANTS_BYTES, VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
  slot->frame_block = vulkan_buffer_create(&e->base, sizeof(frame_constants), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
}

/* ---- csm ---- */

static void open_shadows(engine *e, const char *library) {
  const csm_vulkan_device device = {.struct_size = sizeof device,
                                    .api_version = VK_API_VERSION_1_1,
                                    .instance = e->base.instance,
                                    .physical_device = e->base.physical_device,
                                    .device = e->base.device,
                                    .queue_family = e->base.queue_family,
                                    .get_instance_proc_addr = vkGetInstanceProcAddr,
                                    .features = &e->base.features};
  csm_create_info create = {.backend = "vulkan", .vulkan = &device};
  shadows_open(&e->shadows, library, &create);
}

/* csm draws from the engine's own buffers: it is told where positions lie, and copies nothing. */
static void add_meshes(engine *e) {
  for (uint32_t i = 0; i < WORLD_MESHES; i++) {
    const csm_vulkan_mesh buffers = {.struct_size = sizeof buffers,
                                     .vertex_stride = sizeof(vertex),
                                     .vertices = e->vertices[i].buffer,
                                     .vertex_offset = offsetof(vertex, position),
                                     .indices = e->indices[i].buffer};
    csm_mesh_info info = {.vulkan = &buffers};
    shadows_add_mesh(&e->shadows, i, &e->world.meshes[i], &info);
  }
}

static void draw_mesh(const engine *e, VkCommandBuffer commands, uint32_t mesh, const draw_constants *constants) {
  const VkDeviceSize start = 0;
  vkCmdPushConstants(commands, e->layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                     sizeof *constants, constants);
  vkCmdBindVertexBuffers(commands, 0, 1, &e->vertices[mesh].buffer, &start);
  vkCmdBindIndexBuffer(commands, e->indices[mesh].buffer, 0, VK_INDEX_TYPE_UINT16);
  vkCmdDrawIndexed(commands, e->world.meshes[mesh].index_count, 1, 0, 0, 0);
}

/* Fits csm's pass. Depth is clamped, so that a caster before the map's near plane still casts; both sides are drawn, as
   csm draws its own casters. */
static void create_caster(engine *e) {
  const csm_draw_target target = shadows_target(&e->shadows);
  const vulkan_pipeline_info info = {.layout = e->layout,
                                     .render_pass = (VkRenderPass)target.render_pass,
                                     .vertex_code = caster_vert,
                                     .vertex_size = sizeof caster_vert,
                                     .input = vertex_input(1),
                                     .depth_compare = VK_COMPARE_OP_LESS,
                                     .depth_clamp = true};
  e->caster = vulkan_pipeline_create(&e->base, &info);
}

/* csm's callback, inside each cascade's pass: draws the tree, bent as the forward pass bends it. */
static void CSM_CALL draw_tree(void *user, const csm_draw_info *info) {
  engine *e = user;
  const thing *tree = &e->world.things[e->world.thing_count - 1];
  const VkCommandBuffer commands = info->command_buffer;
  double center[3];
  const double radius = world_skinned_bounds(&e->world, center);
  if (!shadows_reaches(info, center, radius))
    return;
  draw_constants constants;
  world_caster_constants(&constants, tree, info->world_to_clip);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, e->caster);
  draw_mesh(e, commands, tree->mesh, &constants);
}

/* ---- one frame ---- */

/* Waits until the slot's last frame is done, and lets csm free what it kept for it. */
static void begin_frame(engine *e, const frame_slot *slot, uint32_t frame) {
  vulkan_check(vkWaitForFences(e->base.device, 1, &slot->done, VK_TRUE, UINT64_MAX), "vkWaitForFences");
  vulkan_check(vkResetFences(e->base.device, 1, &slot->done), "vkResetFences");
  shadows_retire(&e->shadows, (int64_t)frame - SHADOWS_FRAMES_IN_FLIGHT);

  const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                          .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  vulkan_check(vkResetCommandPool(e->base.device, slot->pool, 0), "vkResetCommandPool");
  vulkan_check(vkBeginCommandBuffer(slot->commands, &begin), "vkBeginCommandBuffer");
}

/* Hands the forward shader what it samples the maps with. The slot's set is not in use: its frame is done. */
static void write_bindings(const engine *e, const frame_slot *slot, const csm_binding *binding) {
  shadows_write_constants(slot->shadow_block.mapped, binding);
  world_frame_constants(slot->frame_block.mapped, &e->world, binding->origin);

  const VkDescriptorBufferInfo blocks[2] = {{slot->shadow_block.buffer, 0, VK_WHOLE_SIZE},
                                            {slot->frame_block.buffer, 0, VK_WHOLE_SIZE}};
  const VkDescriptorImageInfo maps = {.sampler = (VkSampler)binding->native_sampler,
                                      .imageView = (VkImageView)binding->native_maps_view,
                                      .imageLayout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkWriteDescriptorSet writes[2] = {{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                           .dstSet = slot->set,
                                           .dstBinding = 0,
                                           .descriptorCount = 2,
                                           .descriptorType = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                                           .pBufferInfo = blocks},
                                          {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                           .dstSet = slot->set,
                                           .dstBinding = 2,
                                           .descriptorCount = 1,
                                           .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                           .pImageInfo = &maps}};
  vkUpdateDescriptorSets(e->base.device, 2, writes, 0, NULL);
}

static void draw_forward(const engine *e, const frame_slot *slot, const double origin[3]) {
  const VkCommandBuffer commands = slot->commands;
  const VkRect2D area = {{0, 0}, {WORLD_WIDTH, WORLD_HEIGHT}};
  const VkViewport viewport = {0, WORLD_HEIGHT, WORLD_WIDTH, -WORLD_HEIGHT, 0, 1}; /* negative height: clip y is up */
  const VkClearValue clear[2] = {{.color = {.float32 = {0.4f, 0.55f, 0.8f, 1.0f}}}, {.depthStencil = {0.0f, 0}}};
  const VkRenderPassBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_RENDER_PASS_BEGIN_INFO,
                                       .renderPass = e->pass,
                                       .framebuffer = e->framebuffer,
                                       .renderArea = area,
                                       .clearValueCount = 2,
                                       .pClearValues = clear};
  vkCmdBeginRenderPass(commands, &begin, VK_SUBPASS_CONTENTS_INLINE);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, e->forward);
  vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, e->layout, 0, 1, &slot->set, 0, NULL);
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetScissor(commands, 0, 1, &area);
  for (uint32_t i = 0; i < e->world.thing_count; i++) {
    draw_constants constants;
    world_draw_constants(&constants, &e->world.things[i], origin);
    draw_mesh(e, commands, e->world.things[i].mesh, &constants);
  }
  vkCmdEndRenderPass(commands);
}

static void copy_picture(const engine *e, VkCommandBuffer commands) {
  const VkBufferImageCopy copy = {.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                  .imageExtent = {WORLD_WIDTH, WORLD_HEIGHT, 1}};
  vkCmdCopyImageToBuffer(commands, e->color.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, e->picture.buffer, 1, &copy);
  const VkMemoryBarrier barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER,
                                   .srcAccessMask = VK_ACCESS_TRANSFER_WRITE_BIT,
                                   .dstAccessMask = VK_ACCESS_HOST_READ_BIT};
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, NULL, 0,
                       NULL);
}

/* Frames are numbered from 1 on, as csm wants them. */
static void draw_frame(engine *e, uint32_t frame) {
  frame_slot *slot = &e->slots[frame % SHADOWS_FRAMES_IN_FLIGHT];
  const shadows_frame shadows = {.number = frame, .command_buffer = slot->commands, .draw = draw_tree, .user = e};
  csm_binding binding = {.struct_size = sizeof binding};
  begin_frame(e, slot, frame);
  world_animate(&e->world, frame);

  shadows_record(&e->shadows, &e->world, &shadows, &binding);
  write_bindings(e, slot, &binding);
  draw_forward(e, slot, binding.origin);
  if (frame == SHADOWS_FRAMES)
    copy_picture(e, slot->commands);

  const VkSubmitInfo submit = {
      .sType = VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &slot->commands};
  vulkan_check(vkEndCommandBuffer(slot->commands), "vkEndCommandBuffer");
  vulkan_check(vkQueueSubmit(e->base.queue, 1, &submit, slot->done), "vkQueueSubmit");
}

/* ---- the program ---- */

static void engine_open(engine *e, const app_options *options) {
  world_create(&e->world);
  vulkan_open(&e->base, options->validate);
  create_meshes(e);
  create_targets(e);
  create_layouts(e);
  create_forward(e);
  for (int i = 0; i < SHADOWS_FRAMES_IN_FLIGHT; i++)
    create_slot(e, &e->slots[i]);
  open_shadows(e, options->csm);
  add_meshes(e);
  shadows_place(&e->shadows, &e->world);
  create_caster(e);
}

static void engine_close(engine *e) {
  const VkDevice device = e->base.device;
  shadows_close(&e->shadows); /* before the device and the buffers that it was lent */
  for (int i = 0; i < SHADOWS_FRAMES_IN_FLIGHT; i++) {
    vulkan_buffer_destroy(&e->base, &e->slots[i].shadow_block);
    vulkan_buffer_destroy(&e->base, &e->slots[i].frame_block);
    vkDestroyFence(device, e->slots[i].done, NULL);
    vkDestroyCommandPool(device, e->slots[i].pool, NULL);
  }
  for (int i = 0; i < WORLD_MESHES; i++) {
    vulkan_buffer_destroy(&e->base, &e->vertices[i]);
    vulkan_buffer_destroy(&e->base, &e->indices[i]);
  }
  vkDestroyPipeline(device, e->caster, NULL);
  vkDestroyPipeline(device, e->forward, NULL);
  vkDestroyPipelineLayout(device, e->layout, NULL);
  vkDestroyDescriptorPool(device, e->set_pool, NULL);
  vkDestroyDescriptorSetLayout(device, e->set_layout, NULL);
  vkDestroyFramebuffer(device, e->framebuffer, NULL);
  vkDestroyRenderPass(device, e->pass, NULL);
  vulkan_buffer_destroy(&e->base, &e->picture);
  vulkan_image_destroy(&e->base, &e->depth);
  vulkan_image_destroy(&e->base, &e->color);
  vulkan_close(&e->base);
  world_destroy(&e->world);
}

int main(int count, char **arguments) {
  static engine e;
  app_options options;
  app_parse(&options, count, arguments);
  engine_open(&e, &options);

  const double start = app_now_ms();
  for (uint32_t frame = 1; frame <= SHADOWS_FRAMES; frame++)
    draw_frame(&e, frame);
  vulkan_check(vkDeviceWaitIdle(e.base.device), "vkDeviceWaitIdle");
  shadows_retire(&e.shadows, SHADOWS_FRAMES);
  const double frame_ms = (app_now_ms() - start) / SHADOWS_FRAMES;

  app_write_png(options.out, e.picture.mapped, WORLD_WIDTH, WORLD_HEIGHT);
  shadows_report(&e.shadows, "mini_vulkan", e.base.properties.deviceName, frame_ms, e.base.messages);
  engine_close(&e);
  return e.base.messages ? APP_FAILED : 0;
}
