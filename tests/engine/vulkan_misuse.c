/* vulkan_misuse.c: what an engine may get wrong is told by name, and changes nothing; csm asks for no more than it may.
 */
#include "vulkan_case.h"

#include "csm/csm_d3d12.h"

#include <string.h>

/* ---- devices ---- */

static void expect_create(const csm_vulkan_device *native, const char *backend, csm_result expected, const char *what) {
  record record = {0};
  char text[512] = "";
  csm_context *context = NULL;
  csm_create_info info = support_create_info(&record);
  record.quiet = true;
  info.backend = backend;
  info.vulkan = native;
  info.error = text;
  info.error_size = sizeof text;
  const csm_result result = csm_create(&info, &context);
  csm_destroy(context);
  if (result != expected)
    fail_msg("%s: %s (%s), not %s", what, csm_result_name(result), text, csm_result_name(expected));
  assert_true(!result || text[0]);
  assert_int_equal(record.blocks, 0);
}

static PFN_vkVoidFunction VKAPI_CALL knows_nothing(VkInstance instance, const char *name) {
  (void)instance, (void)name;
  return NULL;
}

static VkResult CSM_CALL allocates_nothing(void *user, const csm_vulkan_memory_request *request,
                                           csm_vulkan_memory *out) {
  (void)user, (void)request, (void)out;
  return VK_ERROR_OUT_OF_DEVICE_MEMORY;
}

static void CSM_CALL frees_nothing(void *user, const csm_vulkan_memory *memory) {
  (void)user, (void)memory;
}

static void devices_are_checked(void **state) {
  (void)state;
  vulkan_engine engine;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  struct {
    csm_vulkan_device device;
    uint64_t tail[2];
  } later = {.device = engine.native};
  const csm_vulkan_device *good = &engine.native;
  const char *const nothing[] = {NULL};
  const VkPhysicalDeviceFeatures no_features = {0};
  csm_vulkan_device device = *good;
#define WITH(field, value) (device = *good, device.field = (value), &device)
  expect_create(good, "vulkan", CSM_SUCCESS, "a good device");
  expect_create(good, "null", CSM_ERROR_UNSUPPORTED, "another backend");
  expect_create(WITH(instance, NULL), "vulkan", CSM_ERROR_NULL_POINTER, "no instance");
  expect_create(WITH(physical_device, NULL), "vulkan", CSM_ERROR_NULL_POINTER, "no physical device");
  expect_create(WITH(device, NULL), "vulkan", CSM_ERROR_NULL_POINTER, "no device");
  expect_create(WITH(get_instance_proc_addr, NULL), "vulkan", CSM_ERROR_NULL_POINTER, "no functions");
  expect_create(WITH(get_instance_proc_addr, knows_nothing), "vulkan", CSM_ERROR_UNSUPPORTED, "functions of nothing");
  expect_create(WITH(extension_count, 1), "vulkan", CSM_ERROR_NULL_POINTER, "no extensions");
  device.extensions = nothing;
  expect_create(&device, "vulkan", CSM_ERROR_NULL_POINTER, "an extension without a name");
  expect_create(WITH(reserved, 1), "vulkan", CSM_ERROR_INVALID_VALUE, "reserved");
  expect_create(WITH(reserved2, 1), "vulkan", CSM_ERROR_INVALID_VALUE, "reserved2");
  expect_create(WITH(reserved3, 1), "vulkan", CSM_ERROR_INVALID_VALUE, "reserved3");
  expect_create(WITH(dynamic_rendering, 2), "vulkan", CSM_ERROR_INVALID_VALUE, "dynamic_rendering of 2");
  expect_create(WITH(dynamic_rendering, 1), "vulkan", CSM_ERROR_UNSUPPORTED, "dynamic rendering on Vulkan 1.2");
  expect_create(WITH(allocate_memory, allocates_nothing), "vulkan", CSM_ERROR_NULL_POINTER, "no free_memory");
  expect_create(WITH(free_memory, frees_nothing), "vulkan", CSM_ERROR_NULL_POINTER, "no allocate_memory");
  expect_create(WITH(api_version, VK_API_VERSION_1_0), "vulkan", CSM_ERROR_UNSUPPORTED, "Vulkan 1.0");
  expect_create(WITH(queue_family, 9), "vulkan", CSM_ERROR_UNSUPPORTED, "no such queue family");
  expect_create(WITH(features, NULL), "vulkan", CSM_ERROR_UNSUPPORTED, "no features");
  expect_create(WITH(features, &no_features), "vulkan", CSM_ERROR_UNSUPPORTED, "no depthClamp");
  expect_create(WITH(struct_size, 0), "vulkan", CSM_ERROR_STRUCT_SIZE, "no size");
  expect_create(WITH(struct_size, offsetof(csm_vulkan_device, features)), "vulkan", CSM_ERROR_UNSUPPORTED,
                "an older struct, without features");
  later.device.struct_size = sizeof later;
  expect_create(&later.device, "vulkan", CSM_SUCCESS, "a later struct, whose tail is zero");
  later.tail[1] = 1;
  expect_create(&later.device, "vulkan", CSM_ERROR_STRUCT_SIZE, "a later struct, whose tail is not");
#undef WITH
  assert_int_equal(engine.messages, 0);
  vulkan_engine_close(&engine);

  vulkan_engine_open(&engine, VULKAN_ENGINE_CLIPPING);
  expect_create(&engine.native, "vulkan", CSM_ERROR_UNSUPPORTED, "a device without depthClamp");
  assert_int_equal(engine.messages, 0);
  vulkan_engine_close(&engine);
}

static VkResult CSM_CALL allocates_the_wrong(void *user, const csm_vulkan_memory_request *request,
                                             csm_vulkan_memory *out) {
  (void)request, (void)out; /* leaves the memory VK_NULL_HANDLE */
  ++*(int *)user;
  return VK_SUCCESS;
}

static void CSM_CALL takes_the_wrong_back(void *user, const csm_vulkan_memory *memory) {
  *(int *)user -= memory->memory == VK_NULL_HANDLE;
}

/* What an allocator cannot give, or gives wrong, is an error by name. What it gave wrong, it gets back. */
static void allocators_may_fail(void **state) {
  (void)state;
  const struct {
    csm_vulkan_allocate_function allocate;
    csm_result expected;
  } cases[] = {{allocates_nothing, CSM_ERROR_OUT_OF_DEVICE_MEMORY}, {allocates_the_wrong, CSM_ERROR_DEVICE}};
  vulkan_engine engine;
  int given = 0;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  engine.native.free_memory = takes_the_wrong_back;
  engine.native.memory_user = &given;
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    record record = {0};
    csm_context *context = NULL;
    csm_cascades *cascades = NULL;
    csm_create_info info = support_create_info(&record);
    const csm_config config = support_config();
    engine.native.allocate_memory = cases[i].allocate;
    record.quiet = true;
    info.vulkan = &engine.native;
    assert_int_equal(csm_create(&info, &context), CSM_SUCCESS);
    assert_int_equal(csm_cascades_create(context, &config, &cascades), cases[i].expected);
    assert_null(cascades);
    csm_destroy(context);
    assert_int_equal(record.blocks, 0);
    assert_int_equal(given, 0);
  }
  assert_int_equal(engine.messages, 0);
  vulkan_engine_close(&engine);
}

static void other_apis_are_refused(void **state) {
  (void)state;
  record record = {0};
  csm_context *context;
  int not_a_device;
  const csm_d3d12_device d3d12 = {.struct_size = sizeof d3d12, .device = &not_a_device};
  csm_create_info info = support_create_info(&record);
  record.quiet = true;
  info.d3d12 = &d3d12;
  assert_int_equal(csm_create(&info, &context), CSM_ERROR_UNSUPPORTED);
  assert_int_equal(record.blocks, 0);

  vulkan_engine engine;
  vulkan_case c;
  vulkan_engine_open(&engine, VULKAN_ENGINE_BARE);
  case_open(&c, &engine);
  c.record.quiet = true;
  const csm_d3d12_mesh native = {.struct_size = sizeof native, .vertex_stride = 12, .vertices = &c, .indices = &c};
  const csm_mesh_info mesh_info = {.struct_size = sizeof mesh_info,
                                   .vertex_count = 3,
                                   .index_count = 3,
                                   .index_size = 2,
                                   .d3d12 = &native,
                                   .bounds_max = {1, 1, 1}};
  csm_mesh mesh;
  assert_int_equal(csm_mesh_create(c.context, &mesh_info, &mesh), CSM_ERROR_UNSUPPORTED);
  case_close(&c);
  vulkan_engine_close(&engine);
}

/* ---- frames ---- */

static csm_result render(vulkan_case *c, uint64_t number, VkCommandBuffer commands) {
  csm_frame frame = case_frame(c, 0);
  frame.frame = number;
  frame.command_buffer = commands;
  return csm_render_cascades(c->cascades, &frame);
}

static csm_result resolve(vulkan_case *c, uint64_t number, VkCommandBuffer commands, const void *depth,
                          const void *normals) {
  csm_frame frame = case_frame(c, 0);
  frame.frame = number;
  frame.command_buffer = commands;
  const csm_mask_info info = {.struct_size = sizeof info,
                              .frame = &frame,
                              .width = 96,
                              .height = 64,
                              .camera_depth = depth,
                              .normals = normals};
  return csm_resolve_mask(c->cascades, &info);
}

static void frames_are_counted(void **state) {
  (void)state;
  static const case_step step = {0, 3, 256, 96, 64};
  static case_image drawn, expected;
  vulkan_engine engine;
  vulkan_case c;
  case_reference(&step, 1, &expected);
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  c.record.quiet = true;
  assert_int_equal(csm_retire(c.context, 1), CSM_SUCCESS); /* the engine had frames without csm */
  assert_int_equal(render(&c, 1, engine.frames[0].commands), CSM_ERROR_INVALID_VALUE);
  assert_int_equal(resolve(&c, 1, engine.frames[0].commands, NULL, NULL), CSM_ERROR_INVALID_STATE);
  assert_int_equal(render(&c, 1, NULL), CSM_ERROR_NULL_POINTER);
  assert_int_equal(render(&c, 0, engine.frames[0].commands), CSM_ERROR_INVALID_VALUE);
  VkCommandBuffer commands = NULL;
  for (uint64_t frame = 1; frame <= VULKAN_ENGINE_FRAMES; ++frame) {
    commands = vulkan_engine_begin(&engine);
    assert_int_equal(render(&c, 10 * frame, commands), CSM_SUCCESS);
    assert_int_equal(render(&c, 10 * frame, commands), CSM_SUCCESS);
    assert_int_equal(render(&c, 10 * frame - 1, commands), CSM_ERROR_INVALID_VALUE);
    if (frame < VULKAN_ENGINE_FRAMES)
      vulkan_engine_end(&engine);
  }
  /* The last command buffer is open: what is refused leaves no trace in it. */
  assert_int_equal(render(&c, 40, commands), CSM_ERROR_INVALID_STATE);
  assert_int_equal(resolve(&c, 41, commands, NULL, NULL), CSM_ERROR_INVALID_STATE);
  assert_int_equal(resolve(&c, 30, commands, NULL, NULL), CSM_SUCCESS);
  csm_read_info read = {.struct_size = sizeof read, .data = drawn.maps[0], .size = sizeof drawn.maps[0]};
  assert_int_equal(csm_read(c.cascades, &read), CSM_ERROR_UNSUPPORTED);
  case_copy(&c, &step);
  vulkan_engine_end(&engine);
  vulkan_engine_run(&engine, engine.frame);
  case_read(&c, engine.frame, &step, &drawn);
  case_compare(&drawn, &expected, &step);
  assert_int_equal(csm_retire(c.context, 10), CSM_SUCCESS);
  commands = vulkan_engine_begin(&engine);
  assert_int_equal(render(&c, 40, commands), CSM_SUCCESS);
  assert_int_equal(render(&c, 41, commands), CSM_ERROR_INVALID_STATE);
  vulkan_engine_end(&engine);
  vulkan_engine_run(&engine, engine.frame);
  assert_int_equal(csm_retire(c.context, 40), CSM_SUCCESS);
  case_close(&c);
  vulkan_engine_close(&engine);
}

/* ---- images and buffers ---- */

static void images_are_checked(void **state) {
  (void)state;
  static const float depth[96 * 64];
  vulkan_engine engine;
  vulkan_case c;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  c.record.quiet = true;
  engine_image image = vulkan_engine_image(&engine, VK_FORMAT_D32_SFLOAT, 96, 64,
                                           VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, depth, sizeof depth);
  const csm_vulkan_image *good = &image.native;
  const csm_d3d12_image d3d12 = {
      .struct_size = sizeof d3d12, .format = 41, .resource = &engine, .width = 96, .height = 64};
  csm_vulkan_image wrong = *good;
  const VkCommandBuffer commands = vulkan_engine_begin(&engine);
  assert_int_equal(render(&c, 1, commands), CSM_SUCCESS);
#define WITH(field, value) (wrong = *good, wrong.field = (value), &wrong)
  struct {
    const char *what;
    csm_vulkan_image image;
    csm_result expected;
  } cases[] = {
      {"no view", *WITH(view, VK_NULL_HANDLE), CSM_ERROR_NULL_POINTER},
      {"no size", *WITH(struct_size, 0), CSM_ERROR_STRUCT_SIZE},
      {"an attachment", *WITH(layout, VK_IMAGE_LAYOUT_DEPTH_STENCIL_ATTACHMENT_OPTIMAL), CSM_ERROR_INVALID_VALUE},
      {"undefined layout", *WITH(layout, VK_IMAGE_LAYOUT_UNDEFINED), CSM_ERROR_INVALID_VALUE},
      {"undefined format", *WITH(format, VK_FORMAT_UNDEFINED), CSM_ERROR_INVALID_VALUE},
      {"integers", *WITH(format, VK_FORMAT_R8G8B8A8_UINT), CSM_ERROR_INVALID_VALUE},
      {"no width", *WITH(width, 0), CSM_ERROR_INVALID_VALUE},
      {"no height", *WITH(height, 0), CSM_ERROR_INVALID_VALUE},
      {"reserved", *WITH(reserved, 1), CSM_ERROR_INVALID_VALUE},
  };
#undef WITH
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    const csm_result as_depth = resolve(&c, 1, commands, &cases[i].image, NULL);
    const csm_result as_normals = resolve(&c, 1, commands, good, &cases[i].image);
    if (as_depth != cases[i].expected || as_normals != cases[i].expected)
      fail_msg("%s: %s, %s", cases[i].what, csm_result_name(as_depth), csm_result_name(as_normals));
    assert_true(csm_last_error(c.context)[0]);
  }
  assert_int_equal(resolve(&c, 1, commands, &d3d12, NULL), CSM_ERROR_INVALID_VALUE);
  assert_int_equal(resolve(&c, 1, commands, good, NULL), CSM_SUCCESS);
  vulkan_engine_end(&engine);
  vulkan_engine_run(&engine, engine.frame);
  assert_int_equal(csm_retire(c.context, 1), CSM_SUCCESS);
  vulkan_engine_image_destroy(&engine, &image);
  case_close(&c);
  vulkan_engine_close(&engine);
}

static void buffers_are_checked(void **state) {
  (void)state;
  vulkan_engine engine;
  vulkan_case c;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  c.record.quiet = true;
  engine_buffer buffer = vulkan_engine_buffer(&engine, 4096);
  const csm_vulkan_mesh good = {.struct_size = sizeof good,
                                .vertex_stride = 16,
                                .vertices = buffer.handle,
                                .vertex_offset = 4,
                                .indices = buffer.handle,
                                .index_offset = 1024};
  csm_vulkan_mesh wrong;
#define WITH(field, value) (wrong = good, wrong.field = (value), &wrong)
  struct {
    const char *what;
    csm_vulkan_mesh mesh;
    csm_result expected;
  } cases[] = {
      {"no vertices", *WITH(vertices, VK_NULL_HANDLE), CSM_ERROR_NULL_POINTER},
      {"no indices", *WITH(indices, VK_NULL_HANDLE), CSM_ERROR_NULL_POINTER},
      {"no size", *WITH(struct_size, 0), CSM_ERROR_STRUCT_SIZE},
      {"stride of 8", *WITH(vertex_stride, 8), CSM_ERROR_INVALID_VALUE},
      {"stride of 14", *WITH(vertex_stride, 14), CSM_ERROR_INVALID_VALUE},
      {"stride of 1 GiB", *WITH(vertex_stride, 1u << 30), CSM_ERROR_INVALID_VALUE},
      {"vertices at 2", *WITH(vertex_offset, 2), CSM_ERROR_INVALID_VALUE},
      {"indices at 1026", *WITH(index_offset, 1026), CSM_ERROR_INVALID_VALUE},
      {"good", good, CSM_SUCCESS},
  };
#undef WITH
  csm_mesh_info info = {
      .struct_size = sizeof info, .vertex_count = 3, .index_count = 3, .index_size = 2, .bounds_max = {1, 1, 1}};
  csm_mesh mesh;
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    info.vulkan = &cases[i].mesh;
    const csm_result result = csm_mesh_create(c.context, &info, &mesh);
    if (result != cases[i].expected)
      fail_msg("%s: %s", cases[i].what, csm_result_name(result));
  }
  assert_int_equal(csm_mesh_destroy(c.context, mesh), CSM_SUCCESS);
  vulkan_engine_buffer_destroy(&engine, &buffer);
  case_close(&c);
  vulkan_engine_close(&engine);
}

/* ---- manners ---- */

/* All that csm may record; csm_vulkan.h tells what these leave changed. */
static const char *const allowed_commands[] = {"vkCmdBeginDebugUtilsLabelEXT",
                                               "vkCmdEndDebugUtilsLabelEXT",
                                               "vkCmdResetQueryPool",
                                               "vkCmdWriteTimestamp",
                                               "vkCmdPipelineBarrier",
                                               "vkCmdCopyBuffer",
                                               "vkCmdCopyBufferToImage",
                                               "vkCmdCopyImageToBuffer",
                                               "vkCmdClearDepthStencilImage",
                                               "vkCmdBeginRenderPass",
                                               "vkCmdEndRenderPass",
                                               "vkCmdSetViewport",
                                               "vkCmdSetScissor",
                                               "vkCmdBindPipeline",
                                               "vkCmdBindDescriptorSets",
                                               "vkCmdBindVertexBuffers",
                                               "vkCmdBindIndexBuffer",
                                               "vkCmdDraw",
                                               "vkCmdDrawIndexed",
                                               "vkCmdDrawIndirect",
                                               "vkCmdDrawIndexedIndirect",
                                               "vkCmdDispatch",
                                               "vkCmdDispatchIndirect"};
/* What an engine's device is its own for. */
static const char *const forbidden[] = {"Queue",         "Wait",     "Idle",  "Fence",       "Semaphore",
                                        "CommandBuffer", "KHR",      "Event", "CommandPool", "CreateDevice",
                                        "DestroyDevice", "Instance", "2"};

static const char *asked_too_much; /* the first such name, while the functions below are csm's */

static void judge(const char *name) {
  bool fine = strncmp(name, "vkCmd", 5) != 0;
  for (size_t i = 0; !fine && i < sizeof allowed_commands / sizeof allowed_commands[0]; ++i)
    fine = !strcmp(name, allowed_commands[i]);
  for (size_t i = 0; fine && i < sizeof forbidden / sizeof forbidden[0]; ++i)
    fine = !strstr(name, forbidden[i]) || !strncmp(name, "vkGetPhysicalDevice", 19);
  if (!fine && !asked_too_much)
    asked_too_much = name;
}

static PFN_vkVoidFunction VKAPI_CALL judged_device_function(VkDevice device, const char *name) {
  judge(name);
  return vkGetDeviceProcAddr(device, name);
}

static PFN_vkVoidFunction VKAPI_CALL judged_function(VkInstance instance, const char *name) {
  if (!strcmp(name, "vkGetDeviceProcAddr"))
    return (PFN_vkVoidFunction)judged_device_function;
  judge(name);
  return vkGetInstanceProcAddr(instance, name);
}

static void asks_for_no_more_than_it_may(void **state) {
  (void)state;
  vulkan_engine engine;
  vulkan_case c;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  engine.native.get_instance_proc_addr = judged_function;
  case_open(&c, &engine);
  if (asked_too_much)
    fail_msg("csm asked an engine's device for %s", asked_too_much);
  case_close(&c);
  vulkan_engine_close(&engine);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(devices_are_checked),          cmocka_unit_test(allocators_may_fail),
      cmocka_unit_test(other_apis_are_refused),       cmocka_unit_test(frames_are_counted),
      cmocka_unit_test(images_are_checked),           cmocka_unit_test(buffers_are_checked),
      cmocka_unit_test(asks_for_no_more_than_it_may),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
