/* main.c LIBRARY: the null backend alone: it writes down what it is told, and tells of breaches of gpu.h's rules.
   Breaches are rows: what is done, and the words that it is told of with. */
#include "null_test.h"

#include "../../tools/gpu_host.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

static void CSM_CALL take_line(void *user, int32_t level, const char *message) {
  fixture *f = user;
  if (level != CSM_LOG_ERROR)
    strncpy(f->command, message, sizeof f->command - 1);
  else if (!f->breach[0])
    strncpy(f->breach, message, sizeof f->breach - 1);
}

void expect(fixture *f, const char *breach) {
  assert_string_equal(f->breach, breach ? breach : "");
  f->breach[0] = 0;
}

/* ---- the fixture ---- */

static const gpu_code code = {.spirv_size = 4, .dxbc_size = 4};

const gpu_program_info null_drawing = {.name = "drawing",
                                       .vertex = {.spirv_size = 4, .dxbc_size = 4},
                                       .stream_count = 1,
                                       .streams = {{.stride = 12}},
                                       .attribute_count = 1,
                                       .attributes = {{GPU_FORMAT_RGB32_FLOAT, 0, 0}},
                                       .depth_format = GPU_FORMAT_D16_UNORM,
                                       .color_format = GPU_FORMAT_RG32_FLOAT,
                                       .depth_compare = GPU_COMPARE_LESS};

const gpu_program_info null_computing = {.name = "computing",
                                         .compute = {.spirv_size = 4, .dxbc_size = 4},
                                         .constants_count = 1,
                                         .constants_sizes = {256},
                                         .texture_count = 1,
                                         .buffer_count = 1,
                                         .texel_buffer_count = 1,
                                         .store_image_count = 1,
                                         .store_buffer_count = 1};

static void make_resources(fixture *f) {
  const uint32_t drawn = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  const uint32_t all = drawn | GPU_IMAGE_COPY_TARGET | GPU_IMAGE_STORED;
  const uint32_t usage = GPU_BUFFER_READ | GPU_BUFFER_WRITE | GPU_BUFFER_INDIRECT | GPU_BUFFER_TEXELS;
  gpu_image_create(f->g, &(gpu_image_info){"depth", GPU_FORMAT_D16_UNORM, drawn, WIDTH, HEIGHT, LAYERS, true, 1},
                   &f->depth);
  gpu_image_create(f->g, &(gpu_image_info){"colour", GPU_FORMAT_RG32_FLOAT, drawn, WIDTH, HEIGHT, 1, false, 0},
                   &f->color);
  gpu_image_create(f->g, &(gpu_image_info){"texture", GPU_FORMAT_R32_FLOAT, all, WIDTH, HEIGHT, LAYERS, true, LEVELS},
                   &f->texture);
  for (uint32_t i = 0; i < LEVELS; i++)
    gpu_view_create(f->g, &(gpu_view_info){"level", f->texture, {0, 1, i, 1}}, &f->levels[i]);
  gpu_target_create(f->g, &(gpu_target_info){.name = "target", .depth = f->depth, .color = f->color}, &f->target);
  for (uint32_t i = 0; i < LEVELS; i++)
    gpu_target_create(f->g, &(gpu_target_info){.name = "level", .color = f->texture, .color_level = i},
                      &f->level_targets[i]);
  f->level_1 = f->level_targets[1];
  gpu_buffer_create(f->g,
                    &(gpu_buffer_info){"upload", GPU_BUFFER_UPLOAD, BUFFER_SIZE, GPU_BUFFER_READ | GPU_BUFFER_TEXELS},
                    &f->upload);
  gpu_buffer_create(f->g, &(gpu_buffer_info){"device", GPU_BUFFER_DEVICE, BUFFER_SIZE, usage}, &f->device);
  gpu_buffer_create(f->g, &(gpu_buffer_info){"other", GPU_BUFFER_DEVICE, BUFFER_SIZE, usage}, &f->other);
  gpu_buffer_create(f->g, &(gpu_buffer_info){.name = "readback", .kind = GPU_BUFFER_READBACK, .size = BUFFER_SIZE},
                    &f->readback);
}

static gpu_bindings *make_bindings(fixture *f, gpu_bindings_info info, const gpu_program *program) {
  gpu_bindings *bindings = NULL;
  info.program = program;
  gpu_bindings_create(f->g, &info, &bindings);
  return bindings;
}

static void make_programs(fixture *f) {
  gpu_program_info info = null_drawing;
  gpu_program_create(f->g, &info, &f->drawing);
  info.depth_format = GPU_FORMAT_NONE;
  info.depth_compare = GPU_COMPARE_NONE;
  info.color_format = GPU_FORMAT_R32_FLOAT;
  gpu_program_create(f->g, &info, &f->drawing_level);
  info.texture_count = 1;
  gpu_program_create(f->g, &info, &f->reading);
  info.texture_count = 0;
  info.store_buffer_count = 1;
  gpu_program_create(f->g, &info, &f->storing);
  gpu_program_create(f->g, &null_computing, &f->computing);
  gpu_program_create(f->g, &(gpu_program_info){.name = "plain", .compute = code}, &f->plain_computing);
  f->reads = make_bindings(f, (gpu_bindings_info){.name = "level 0", .texture_views = {f->levels[0]}}, f->reading);
  f->reads_all = make_bindings(f, (gpu_bindings_info){.name = "all", .textures = {f->texture}}, f->reading);
  f->stores =
      make_bindings(f, (gpu_bindings_info){.name = "stores", .store_buffers = {{f->device, 0, 0, 4}}}, f->storing);
  f->computes = make_bindings(f,
                              (gpu_bindings_info){.name = "computes",
                                                  .constants = {f->upload},
                                                  .texture_views = {f->levels[0]},
                                                  .buffers = {{f->upload, 0, 0, 0}},
                                                  .texel_buffers = {f->upload},
                                                  .store_images = {f->levels[1]},
                                                  .store_buffers = {{f->device, 0, 0, 4}}},
                              f->computing);
}

static const char *null_library;

static int set_up(void **state) {
  static fixture all;
  fixture *f = &all;
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
  f->g.api = hello.backend;
  if (f->g.api->open(&(gpu_open_info){.host = &f->host, .slots = 1}, &f->g.device))
    return -1;
  make_resources(f);
  make_programs(f);
  gpu_begin(f->g, &(gpu_record_info){.first = true});
  return f->breach[0] ? -1 : 0;
}

static int tear_down(void **state) {
  fixture *f = *state;
  gpu_bindings *const bindings[] = {f->reads, f->reads_all, f->stores, f->computes};
  gpu_program *const programs[] = {f->drawing, f->drawing_level, f->reading,
                                   f->storing, f->computing,     f->plain_computing};
  gpu_buffer *const buffers[] = {f->upload, f->device, f->other, f->readback};
  gpu_end(f->g);
  gpu_wait(f->g, 0);
  f->breach[0] = 0;
  for (size_t i = 0; i < COUNT_OF(bindings); i++)
    gpu_bindings_destroy(f->g, bindings[i]);
  for (size_t i = 0; i < COUNT_OF(programs); i++)
    gpu_program_destroy(f->g, programs[i]);
  for (size_t i = 0; i < COUNT_OF(buffers); i++)
    gpu_buffer_destroy(f->g, buffers[i]);
  gpu_target_destroy(f->g, f->target);
  for (uint32_t i = 0; i < LEVELS; i++) {
    gpu_target_destroy(f->g, f->level_targets[i]);
    gpu_view_destroy(f->g, f->levels[i]);
  }
  gpu_image_destroy(f->g, f->depth);
  gpu_image_destroy(f->g, f->color);
  gpu_image_destroy(f->g, f->texture);
  gpu_close(f->g);
  return f->breach[0] != 0;
}

int main(int count, char **arguments) {
  if (count != 2)
    return 2;
  null_library = arguments[1];
  const struct CMUnitTest tests[] = {
      cmocka_unit_test_setup_teardown(test_buffers, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_images, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_views, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_targets, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_programs, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_bindings, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_capabilities, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_recordings, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_passes, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_commands, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_stamps, set_up, tear_down),
      cmocka_unit_test_setup_teardown(test_lives, set_up, tear_down),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
