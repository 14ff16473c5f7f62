/* null_test.c LIBRARY: the null backend alone: it writes down what it is told, and tells of breaches of gpu.h's rules.
 */
#include "gpu_host.h"
#include "gpu.h"

#include <dlfcn.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 64, HEIGHT = 32, LAYERS = 2, BUFFER_SIZE = 1 << 16 };

typedef struct fixture {
  const gpu_backend *gpu;
  gpu_host host;
  gpu_device *device;
  gpu_image *depth, *color;
  gpu_target *target;
  gpu_buffer *readback;
  char command[256], breach[256]; /* the last of each */
} fixture;

static void CSM_CALL take_line(void *user, int32_t level, const char *message) {
  fixture *f = user;
  strncpy(level == CSM_LOG_ERROR ? f->breach : f->command, message, sizeof f->command - 1);
}

static const char *null_library;

static int set_up(void **state) {
  static fixture all;
  fixture *f = &all;
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  *f = (fixture){.host = {.user = f, .allocate = test_allocate, .release = test_release, .log = take_line}};
  *state = f;
  void *library = dlopen(null_library, RTLD_NOW | RTLD_LOCAL);
  gpu_handshake_function handshake = NULL;
  void *symbol = library ? dlsym(library, GPU_HANDSHAKE_SYMBOL) : NULL;
  memcpy(&handshake, &symbol, sizeof symbol);
  if (!handshake)
    return -1;
  gpu_handshake hello = {.front_oldest = GPU_INTERFACE_VERSION, .front_newest = GPU_INTERFACE_VERSION};
  handshake(&hello);
  f->gpu = hello.backend;
  if (f->gpu->open(&(gpu_open_info){.host = &f->host, .slots = 1}, &f->device))
    return -1;
  f->gpu->image_create(
      f->device, &(gpu_image_info){"depth", GPU_FORMAT_D16_UNORM, usage, WIDTH, HEIGHT, LAYERS, true, 1}, &f->depth);
  f->gpu->image_create(f->device, &(gpu_image_info){"color", GPU_FORMAT_RG32_FLOAT, usage, WIDTH, HEIGHT, 1, false, 1},
                       &f->color);
  f->gpu->target_create(f->device, &(gpu_target_info){.name = "target", .depth = f->depth}, &f->target);
  f->gpu->buffer_create(f->device,
                        &(gpu_buffer_info){.name = "readback", .kind = GPU_BUFFER_READBACK, .size = BUFFER_SIZE},
                        &f->readback);
  f->gpu->begin(f->device, &(gpu_record_info){.first = true});
  return f->breach[0] ? -1 : 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  f->gpu->end(f->device);
  f->gpu->buffer_destroy(f->device, f->readback);
  f->gpu->target_destroy(f->device, f->target);
  f->gpu->image_destroy(f->device, f->depth);
  f->gpu->image_destroy(f->device, f->color);
  f->gpu->close(f->device);
  return 0;
}

/* The breach told since the last call, or none for NULL. */
static void expect(fixture *f, const char *breach) {
  assert_string_equal(f->breach, breach ? breach : "");
  f->breach[0] = 0;
}

static void test_areas(void **state) {
  fixture *f = *state;
  const gpu_rect inside = {1, 2, WIDTH - 1, HEIGHT - 2}, wide = {1, 0, WIDTH, 1}, empty = {0, 0, 1, 0},
                 wrapped = {UINT32_MAX, 0, 2, 1};
  f->gpu->pass_begin(f->device, f->target);
  f->gpu->pass_area(f->device, &inside);
  assert_string_equal(f->command, "area 1 2 63 30");
  expect(f, NULL);
  f->gpu->pass_area(f->device, &wide);
  expect(f, "pass_area: beyond the target, or empty");
  f->gpu->pass_area(f->device, &empty);
  expect(f, "pass_area: beyond the target, or empty");
  f->gpu->pass_area(f->device, &wrapped);
  expect(f, "pass_area: beyond the target, or empty");
  f->gpu->pass_end(f->device);
  f->gpu->pass_area(f->device, &inside);
  expect(f, "pass_area: no pass is open");
}

static void copy(fixture *f, gpu_image *image, uint64_t offset, gpu_region from, const char *breach) {
  f->gpu->copy_image(f->device, f->readback, offset, 512, image, &from);
  expect(f, breach);
}

static void test_regions(void **state) {
  fixture *f = *state;
  copy(f, f->color, 512, (gpu_region){0, 1, 2, 3, 4, 0}, NULL);
  assert_string_equal(f->command, "copy_image readback 512 512 color 0 1 2 3 4");
  copy(f, f->depth, 0, (gpu_region){1, 0, 0, WIDTH, HEIGHT, 0}, NULL);
  copy(f, f->depth, 0, (gpu_region){1, 0, 0, WIDTH, HEIGHT - 1, 0}, "copy_image: a part of a layer of depths");
  copy(f, f->color, 0, (gpu_region){1, 0, 0, 1, 1, 0}, "copy_image: no such layer");
  copy(f, f->color, 0, (gpu_region){0, WIDTH, 0, 1, 1, 0}, "copy_image: beyond the image, or empty");
  copy(f, f->color, 0, (gpu_region){0, 0, HEIGHT - 1, 1, 2, 0}, "copy_image: beyond the image, or empty");
  copy(f, f->color, 0, (gpu_region){0, 0, 0, 1, 0, 0}, "copy_image: beyond the image, or empty");
  copy(f, f->color, 256, (gpu_region){0, 0, 0, 1, 1, 0}, "copy_image: offset is not a multiple of 512");
  copy(f, f->color, BUFFER_SIZE, (gpu_region){0, 0, 0, 1, 1, 0}, "copy_image: beyond a row's or the buffer's end");
}

static void program(fixture *f, const gpu_program_info *info, const char *breach) {
  gpu_program *made = NULL;
  assert_int_equal(f->gpu->program_create(f->device, info, &made), CSM_SUCCESS);
  f->gpu->program_destroy(f->device, made);
  expect(f, breach);
}

static void test_programs(void **state) {
  fixture *f = *state;
  gpu_program_info info = {.name = "program",
                           .vertex = {.spirv_size = 4, .dxbc_size = 4},
                           .sampler_count = 1,
                           .samplers = {GPU_SAMPLER_COMPARE_GREATER_EQUAL},
                           .depth_format = GPU_FORMAT_D16_UNORM,
                           .color_format = GPU_FORMAT_RG32_FLOAT,
                           .raster_bias = {.constant = 1, .slope = 1}};
  program(f, &info, NULL);
  info.samplers[0] = (gpu_sampler)(GPU_SAMPLER_COMPARE_GREATER_EQUAL + 1);
  program(f, &info, "program_create: no such sampler");
  info.sampler_count = 0;
  info.depth_format = GPU_FORMAT_NONE;
  program(f, &info, "program_create: a raster bias without depth");
  info.depth_format = GPU_FORMAT_R8_UNORM;
  program(f, &info, "program_create: no depth format");
  info.depth_format = GPU_FORMAT_D32_FLOAT;
  info.color_format = GPU_FORMAT_D16_UNORM;
  program(f, &info, "program_create: no colour format");
}

static void test_depth_and_color(void **state) {
  fixture *f = *state;
  gpu_target *target = NULL;
  f->gpu->clear_depth(f->device, f->depth, 0);
  assert_string_equal(f->command, "clear_depth depth 0");
  expect(f, NULL);
  f->gpu->clear_depth(f->device, f->color, 0);
  expect(f, "clear_depth: the image has no depths");
  f->gpu->target_create(f->device, &(gpu_target_info){.name = "wrong", .depth = f->color}, &target);
  f->gpu->target_destroy(f->device, target);
  expect(f, "target_create: depth has no depths");
  f->gpu->target_create(f->device, &(gpu_target_info){.name = "wrong", .color = f->depth}, &target);
  f->gpu->target_destroy(f->device, target);
  expect(f, "target_create: colour has depths");
  assert_true(f->gpu->image_bytes(f->depth) == WIDTH * HEIGHT * LAYERS * 2);
}

int main(int count, char **arguments) {
  if (count != 2)
    return 2;
  null_library = arguments[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_areas, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_regions, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_programs, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_depth_and_color, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
