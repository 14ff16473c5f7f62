/*
 * vulkan_only.c LIBRARY: what only Vulkan has: a feature that clamps the rasterizer's bias, a device that clips depth,
 * and functions that are asked for by name.
 */
#include "../tools/gpu_host.h"
#include "gpu.h"
#include "rig_vulkan.h"
#include "shader_code.h"
#include "stage.h"

#include <dlfcn.h>
#include <string.h>

/* ---- the rasterizer's bias is clamped only where the engine says that it may be ---- */

static const gpu_backend *gpu;

static void CSM_CALL count_error(void *user, int32_t level, const char *message) {
  (void)message;
  *(uint32_t *)user += level == CSM_LOG_ERROR;
}

static csm_result make_program(gpu_device *device, gpu_raster_bias bias) {
  const gpu_program_info info = {.name = "biased",
                                 .vertex = shader_screen_vs,
                                 .depth_format = GPU_FORMAT_D32_FLOAT,
                                 .depth_compare = GPU_COMPARE_LESS,
                                 .raster_bias = bias};
  gpu_program *program = NULL;
  const csm_result result = gpu->program_create(device, &info, &program);
  assert_true((program != NULL) == (result == CSM_SUCCESS));
  gpu->program_destroy(device, program);
  return result;
}

static void expect_clamp(const VkPhysicalDeviceFeatures *told, csm_result expected) {
  rig *rig = rig_open(RIG_TYPICAL);
  rig->native.features = told ? told : &rig->features;
  uint32_t errors = 0;
  const gpu_host host = {.user = &errors, .allocate = test_allocate, .release = test_release, .log = count_error};
  gpu_device *device = NULL;
  assert_int_equal(gpu->open(&(gpu_open_info){.host = &host, .slots = 1, .native = &rig->native}, &device),
                   CSM_SUCCESS);
  assert_int_equal(make_program(device, (gpu_raster_bias){.constant = 1, .slope = 1}), CSM_SUCCESS);
  assert_int_equal(make_program(device, (gpu_raster_bias){.slope = 1, .clamp = 0.5f}), expected);
  assert_int_equal(errors, expected != CSM_SUCCESS);
  gpu->close(device);
  rig_close(rig);
}

static void the_clamp_follows_the_engine(void **state) {
  (void)state;
  const VkPhysicalDeviceFeatures no_clamp = {.depthClamp = VK_TRUE};
  expect_clamp(NULL, CSM_SUCCESS);
  expect_clamp(&no_clamp, CSM_ERROR_UNSUPPORTED);
}

/* ---- a device that clips ---- */

static void a_device_that_clips_is_refused(void **state) {
  (void)state;
  record record = {0};
  char text[512] = "";
  csm_context *context = NULL;
  rig *rig = rig_vulkan_open_clipping();
  csm_create_info info = stage_create_info(rig, &record);
  record.quiet = true;
  info.error = text;
  info.error_size = sizeof text;
  assert_int_equal(csm_create(&info, &context), CSM_ERROR_UNSUPPORTED);
  assert_non_null(strstr(text, "depthClamp"));
  assert_int_equal(record.blocks, 0);
  rig_close(rig);
}

/* ---- a device whose shaders cannot write masks ---- */

static void a_bare_device_sends_no_rays(void **state) {
  (void)state;
  stage stage;
  rig *rig = rig_open(RIG_BARE);
  stage_open_with(&stage, rig, CSM_CREATE_RAYS);
  stage.record.quiet = true;
  stage.config.filter = CSM_FILTER_EXACT;
  assert_int_equal(csm_cascades_configure(stage.cascades, &stage.config), CSM_ERROR_UNSUPPORTED);
  assert_non_null(strstr(csm_last_error(stage.context), "shaderStorageImageExtendedFormats"));
  picture drawn = stage_draw_at(&stage, 0, (picture_size){64, 48}); /* as it was configured before */
  picture_expect_casters(&drawn, drawn.count - 1);
  picture_free(&drawn);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- what csm asks for ---- */

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

/* ---- structs of Direct3D 12 ---- */

/* An image's struct of the other API is told by what it would mean here. */
static void a_foreign_image_is_refused(void **state) {
  (void)state;
  stage stage;
  rig *rig = rig_open(RIG_TYPICAL);
  const csm_d3d12_image foreign = {
      .struct_size = sizeof foreign, .format = 41, .resource = rig, .width = 96, .height = 64};
  stage_open(&stage, rig);
  stage.record.quiet = true;
  rig_begin(rig);
  shot shot = stage_shot(&stage, 0);
  stage_render(&stage, &shot);
  const csm_mask_info mask = {
      .struct_size = sizeof mask, .frame = shot_frame(&shot), .width = 96, .height = 64, .camera_depth = &foreign};
  assert_int_equal(csm_resolve_mask(stage.view, stage.cascades, &mask), CSM_ERROR_INVALID_VALUE);
  stage_finish(&stage);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- what an engine lends ---- */

/* Every pipeline is made with the engine's cache. */
static void the_engines_cache_is_used(void **state) {
  (void)state;
  uint32_t before, cached, uncached;
  stage stage;
  rig_vulkan_pipelines(&before, &uncached);
  rig *rig = rig_open(RIG_MODERN);
  stage_open(&stage, rig);
  picture drawn = stage_draw_at(&stage, 0, (picture_size){96, 64});
  picture_free(&drawn);
  stage_close(&stage);
  rig_close(rig);
  rig_vulkan_pipelines(&cached, &uncached);
  assert_true(cached > before);
  assert_int_equal(uncached, 0);
}

/* ---- manners ---- */

/* From opening to a mask, with what is loaded late. */
static void asks_for_no_more_than_it_may(void **state) {
  (void)state;
  stage stage;
  rig *rig = rig_open(RIG_TYPICAL);
  rig->native.get_instance_proc_addr = judged_function;
  stage_open(&stage, rig);
  picture drawn = stage_draw_at(&stage, 0, (picture_size){96, 64});
  picture_free(&drawn);
  if (asked_too_much)
    fail_msg("csm asked an engine's device for %s", asked_too_much);
  stage_close(&stage);
  rig_close(rig);
}

int main(int argc, char **argv) {
  void *library = argc == 2 ? dlopen(argv[1], RTLD_NOW | RTLD_LOCAL) : NULL;
  void *symbol = library ? dlsym(library, GPU_HANDSHAKE_SYMBOL) : NULL;
  if (!symbol)
    return 2;
  gpu_handshake_function handshake;
  memcpy(&handshake, &symbol, sizeof symbol);
  gpu_handshake hello = {.front_oldest = GPU_INTERFACE_VERSION, .front_newest = GPU_INTERFACE_VERSION};
  handshake(&hello);
  gpu = hello.backend;
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_clamp_follows_the_engine), cmocka_unit_test(a_device_that_clips_is_refused),
      cmocka_unit_test(the_engines_cache_is_used),    cmocka_unit_test(asks_for_no_more_than_it_may),
      cmocka_unit_test(a_foreign_image_is_refused),   cmocka_unit_test(a_bare_device_sends_no_rays),
  };
  char *arguments[] = {argv[0], (char *)"vulkan"};
  return gpu ? support_main(2, arguments, tests, sizeof tests / sizeof tests[0]) : 2;
}
