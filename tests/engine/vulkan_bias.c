/* vulkan_bias.c LIBRARY: the rasterizer's bias is clamped on an engine's device only where the engine says that it
   may be. */
#include "../tools/gpu_host.h"
#include "gpu.h"
#include "shader_code.h"
#include "vulkan_engine.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

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
  vulkan_engine engine;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  engine.native.features = told ? told : &engine.features;
  uint32_t errors = 0;
  const gpu_host host = {.user = &errors, .allocate = test_allocate, .release = test_release, .log = count_error};
  gpu_device *device = NULL;
  assert_int_equal(gpu->open(&(gpu_open_info){.host = &host, .slots = 1, .native = &engine.native}, &device),
                   CSM_SUCCESS);
  assert_int_equal(make_program(device, (gpu_raster_bias){.constant = 1, .slope = 1}), CSM_SUCCESS);
  assert_int_equal(make_program(device, (gpu_raster_bias){.slope = 1, .clamp = 0.5f}), expected);
  assert_int_equal(errors, expected != CSM_SUCCESS);
  gpu->close(device);
  assert_int_equal(engine.messages, 0);
  vulkan_engine_close(&engine);
}

static void the_clamp_follows_the_engine(void **state) {
  (void)state;
  const VkPhysicalDeviceFeatures no_clamp = {.depthClamp = VK_TRUE};
  expect_clamp(NULL, CSM_SUCCESS);
  expect_clamp(&no_clamp, CSM_ERROR_UNSUPPORTED);
}

int main(int count, char **arguments) {
  void *library = count == 2 ? dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL) : NULL;
  void *symbol = library ? dlsym(library, GPU_HANDSHAKE_SYMBOL) : NULL;
  if (!symbol)
    return 2;
  gpu_handshake_function handshake;
  memcpy(&handshake, &symbol, sizeof symbol);
  gpu_handshake hello = {.front_oldest = GPU_INTERFACE_VERSION, .front_newest = GPU_INTERFACE_VERSION};
  handshake(&hello);
  gpu = hello.backend;
  const struct CMUnitTest tests[] = {cmocka_unit_test(the_clamp_follows_the_engine)};
  return gpu ? cmocka_run_group_tests(tests, NULL, NULL) : 2;
}
