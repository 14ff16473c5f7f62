/* vulkan_callback.c: an engine's own draws in the cascades' passes: what it is told is true, and what it draws is
 * there. */
#include "vulkan_case.h"

#include "caster_vert.h"

#include <math.h>
#include <string.h>

static const case_step step = {0, 3, 256, 96, 64};

typedef struct caster {
  vulkan_case *c;
  VkPipelineLayout layout;
  VkPipeline pipeline;
  engine_buffer buffer; /* a box as triangles in world space */
  uint32_t corners;
  csm_draw_info calls[CSM_MAX_CASCADES];
  uint32_t count;
} caster;

/* ---- the engine's pipeline ---- */

/* With dynamic rendering where there is no render pass. */
static void pipeline_create(caster *it, VkRenderPass pass) {
  const VkDevice device = it->c->engine->device;
  const VkPushConstantRange range = {.stageFlags = VK_SHADER_STAGE_VERTEX_BIT, .size = 16 * sizeof(float)};
  const VkPipelineLayoutCreateInfo layout = {.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                             .pushConstantRangeCount = 1,
                                             .pPushConstantRanges = &range};
  assert_int_equal(vkCreatePipelineLayout(device, &layout, NULL, &it->layout), VK_SUCCESS);
  const VkShaderModuleCreateInfo code = {
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = sizeof caster_vert, .pCode = caster_vert};
  VkShaderModule module;
  assert_int_equal(vkCreateShaderModule(device, &code, NULL, &module), VK_SUCCESS);
  const VkPipelineShaderStageCreateInfo stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                 .stage = VK_SHADER_STAGE_VERTEX_BIT,
                                                 .module = module,
                                                 .pName = "main"};
  const VkVertexInputBindingDescription stream = {.stride = 12};
  const VkVertexInputAttributeDescription position = {.format = VK_FORMAT_R32G32B32_SFLOAT};
  const VkPipelineVertexInputStateCreateInfo input = {.sType =
                                                          VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
                                                      .vertexBindingDescriptionCount = 1,
                                                      .pVertexBindingDescriptions = &stream,
                                                      .vertexAttributeDescriptionCount = 1,
                                                      .pVertexAttributeDescriptions = &position};
  const VkPipelineInputAssemblyStateCreateInfo assembly = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  /* csm's viewport and scissor are set: the pipeline takes them as dynamic state. */
  const VkPipelineViewportStateCreateInfo viewport = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo raster = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO, .depthClampEnable = VK_TRUE, .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo samples = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO, .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkPipelineDepthStencilStateCreateInfo depth = {.sType =
                                                           VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                       .depthTestEnable = VK_TRUE,
                                                       .depthWriteEnable = VK_TRUE,
                                                       .depthCompareOp = VK_COMPARE_OP_LESS};
  const VkDynamicState states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic = {
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO, .dynamicStateCount = 2, .pDynamicStates = states};
  const VkPipelineRenderingCreateInfo rendering = {.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                   .depthAttachmentFormat = VK_FORMAT_D32_SFLOAT};
  const VkGraphicsPipelineCreateInfo create = {.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .pNext = pass ? NULL : &rendering,
                                               .stageCount = 1,
                                               .pStages = &stage,
                                               .pVertexInputState = &input,
                                               .pInputAssemblyState = &assembly,
                                               .pViewportState = &viewport,
                                               .pRasterizationState = &raster,
                                               .pMultisampleState = &samples,
                                               .pDepthStencilState = &depth,
                                               .pDynamicState = &dynamic,
                                               .layout = it->layout,
                                               .renderPass = pass};
  assert_int_equal(vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &create, NULL, &it->pipeline), VK_SUCCESS);
  vkDestroyShaderModule(device, module, NULL);
}

static void CSM_CALL draw_caster(void *user, const csm_draw_info *info) {
  caster *it = user;
  it->calls[it->count++ % CSM_MAX_CASCADES] = *info;
  if (!it->pipeline)
    pipeline_create(it, (VkRenderPass)info->render_pass);
  const VkCommandBuffer commands = info->command_buffer;
  float matrix[16];
  for (int i = 0; i < 16; ++i)
    matrix[i] = (float)info->world_to_clip[i];
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, it->pipeline);
  vkCmdPushConstants(commands, it->layout, VK_SHADER_STAGE_VERTEX_BIT, 0, sizeof matrix, matrix);
  vkCmdBindVertexBuffers(commands, 0, 1, &it->buffer.handle, &(VkDeviceSize){0});
  vkCmdDraw(commands, it->corners, 1, 0, 0);
}

/* Draws the first `count` instances by csm, and what the engine draws, if anything. */
static void draw(vulkan_case *c, uint32_t count, caster *it, case_image *out) {
  vulkan_engine_begin(c->engine);
  csm_frame frame = case_frame(c, step.time);
  frame.instance_count = count;
  frame.draw = it ? draw_caster : NULL;
  frame.draw_user = it;
  assert_int_equal(csm_render_cascades(c->cascades, &frame), CSM_SUCCESS);
  frame.instance_count = SUPPORT_INSTANCES;
  const csm_mask_info mask = {.struct_size = sizeof mask, .frame = &frame, .width = step.width, .height = step.height};
  assert_int_equal(csm_resolve_mask(c->cascades, &mask), CSM_SUCCESS);
  case_copy(c, &step);
  vulkan_engine_end(c->engine);
  vulkan_engine_run(c->engine, c->engine->frame);
  assert_int_equal(csm_retire(c->context, c->engine->frame), CSM_SUCCESS);
  case_read(c, c->engine->frame, &step, out);
}

/* ---- what the engine is told ---- */

static double plane_distance(const double plane[4], const double p[3]) {
  return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3];
}

/* The planes and the matrix speak of one volume, and the matrix is the one that csm_bind tells of. */
static void check_volume(const csm_draw_info *info, const csm_cascade_info *bound) {
  uint32_t inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const double p[3] = {fmod(i * 17.03, 160) - 80, fmod(i * 5.77, 60) - 20, fmod(i * 29.9, 160) - 90};
    double clip[3], shadow[3];
    assert_true(fabs(support_apply(info->world_to_clip, p, clip) - 1) < 1e-9);
    support_apply(bound->world_to_shadow, p, shadow);
    assert_true(fabs(shadow[0] - (clip[0] + 1) / 2) < 1e-6);
    assert_true(fabs(shadow[1] - (1 - clip[1]) / 2) < 1e-6);
    assert_true(fabs(shadow[2] - clip[2]) < 1e-6);
    const double beyond[5] = {clip[0] + 1, 1 - clip[0], clip[1] + 1, 1 - clip[1], 1 - clip[2]};
    bool within = true, near_edge = false;
    for (int plane = 0; plane < 5; ++plane) {
      near_edge |= fabs(beyond[plane]) < 1e-6;
      within &= beyond[plane] >= 0;
    }
    if (near_edge)
      continue;
    for (int plane = 0; plane < 5; ++plane)
      assert_int_equal(plane_distance(info->planes[plane], p) >= 0, beyond[plane] >= 0);
    inside += within;
  }
  assert_true(inside > 4);
}

static void check_calls(const caster *it) {
  const vulkan_engine *engine = it->c->engine;
  csm_binding binding = {.struct_size = sizeof binding};
  assert_int_equal(csm_bind(it->c->cascades, &binding), CSM_SUCCESS);
  assert_int_equal(it->count, step.cascades);
  for (uint32_t i = 0; i < it->count; ++i) {
    const csm_draw_info *info = &it->calls[i];
    assert_int_equal(info->struct_size, sizeof *info);
    assert_int_equal(info->cascade, i);
    assert_int_equal(info->resolution, step.resolution);
    assert_int_equal(info->depth_format, VK_FORMAT_D32_SFLOAT);
    assert_ptr_equal(info->command_buffer, engine->frames[engine->frame % VULKAN_ENGINE_FRAMES].commands);
    assert_int_equal(info->render_pass == 0, engine->native.dynamic_rendering);
    assert_true(info->depth_view == 0);
    check_volume(info, &binding.cascades[i]);
  }
}

/* ---- the tests ---- */

static void fill_box(caster *it, uint32_t instance) {
  static double corners[SUPPORT_TRIANGLES][3][3];
  support_triangles(&it->c->scene, corners);
  it->buffer = vulkan_engine_buffer(it->c->engine, 4096);
  it->corners = 36;
  float(*positions)[3] = it->buffer.mapped;
  for (uint32_t corner = 0; corner < it->corners; ++corner)
    for (int axis = 0; axis < 3; ++axis)
      positions[corner][axis] = (float)corners[2 + (instance - 1) * 12 + corner / 3][corner % 3][axis];
}

static uint32_t texels_apart(const case_image *a, const case_image *b, double tolerance) {
  uint32_t count = 0;
  for (uint32_t cascade = 0; cascade < step.cascades; ++cascade)
    for (uint32_t i = 0; i < step.resolution * step.resolution; ++i)
      count += fabs((double)a->maps[cascade][i] - b->maps[cascade][i]) > tolerance;
  return count;
}

/* The last box of the scene is drawn by csm, by nobody, and by the engine: the same maps but for its rounding. */
static void own_casters_are_drawn(vulkan_engine_kind kind) {
  static case_image by_csm, by_nobody, by_engine;
  const uint32_t last = 3; /* a plate high above the ground, so that it matters to every map */
  vulkan_engine engine;
  vulkan_case c;
  vulkan_engine_open(&engine, kind);
  case_open(&c, &engine);
  caster it = {.c = &c};
  const csm_instance moved = c.scene.instances[last];
  fill_box(&it, last);
  c.scene.instances[last] = c.scene.instances[SUPPORT_INSTANCES - 1];
  c.scene.instances[SUPPORT_INSTANCES - 1] = moved;
  draw(&c, SUPPORT_INSTANCES, NULL, &by_csm);
  draw(&c, SUPPORT_INSTANCES - 1, NULL, &by_nobody);
  draw(&c, SUPPORT_INSTANCES - 1, &it, &by_engine);
  check_calls(&it);
  const uint32_t of_box = texels_apart(&by_csm, &by_nobody, 1e-5);
  assert_true(of_box > 200);
  assert_true(texels_apart(&by_csm, &by_engine, 1e-5) < of_box / 50);
  it.count = 0;
  draw(&c, 0, &it, &by_nobody); /* no casters but the engine's */
  check_calls(&it);
  vkDestroyPipeline(engine.device, it.pipeline, NULL);
  vkDestroyPipelineLayout(engine.device, it.layout, NULL);
  vulkan_engine_buffer_destroy(&engine, &it.buffer);
  case_close(&c);
  vulkan_engine_close(&engine);
}

static void own_casters_are_drawn_in_render_passes(void **state) {
  (void)state;
  own_casters_are_drawn(VULKAN_ENGINE_TYPICAL);
}

static void own_casters_are_drawn_by_dynamic_rendering(void **state) {
  (void)state;
  own_casters_are_drawn(VULKAN_ENGINE_MODERN);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(own_casters_are_drawn_in_render_passes),
                                     cmocka_unit_test(own_casters_are_drawn_by_dynamic_rendering)};
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
