/* objects.c: breaches at creation. */
#include "null_test.h"

/* ---- creation ---- */

void test_buffers(void **state) {
  fixture *f = *state;
  const struct {
    gpu_buffer_info info;
    const char *breach;
  } rows[] = {
      {{"b", GPU_BUFFER_DEVICE, 16, GPU_BUFFER_READ | GPU_BUFFER_WRITE | GPU_BUFFER_INDIRECT}, NULL},
      {{"b", GPU_BUFFER_UPLOAD, 16, GPU_BUFFER_READ | GPU_BUFFER_INDIRECT}, NULL},
      {{"b", GPU_BUFFER_DEVICE, 0, 0}, "buffer_create: a size of 0"},
      {{"b", GPU_BUFFER_UPLOAD, 16, GPU_BUFFER_WRITE}, "buffer_create: shaders write to device buffers alone"},
      {{"b", GPU_BUFFER_READBACK, 16, GPU_BUFFER_READ}, "buffer_create: a readback buffer is for nothing else"},
      {{"b", GPU_BUFFER_DEVICE, 16, GPU_BUFFER_READ | GPU_BUFFER_TEXELS}, NULL},
      {{"b", GPU_BUFFER_DEVICE, 16, GPU_BUFFER_TEXELS},
       "buffer_create: a texel buffer that is not read, or whose size is not a multiple of 16"},
      {{"b", GPU_BUFFER_DEVICE, 24, GPU_BUFFER_READ | GPU_BUFFER_TEXELS},
       "buffer_create: a texel buffer that is not read, or whose size is not a multiple of 16"},
  };
  for (size_t i = 0; i < COUNT_OF(rows); i++) {
    gpu_buffer *buffer = NULL;
    gpu_buffer_create(f->g, &rows[i].info, &buffer);
    gpu_buffer_destroy(f->g, buffer);
    expect(f, rows[i].breach);
  }
}

void test_images(void **state) {
  fixture *f = *state;
  const uint32_t drawn = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED;
  const struct {
    gpu_image_info info;
    const char *breach;
  } rows[] = {
      {{"i", GPU_FORMAT_RG16_FLOAT, drawn | GPU_IMAGE_STORED, 64, 1, 1, false, 7}, NULL},
      {{"i", GPU_FORMAT_D32_FLOAT, drawn, 64, 64, 1, false, 0}, NULL},
      {{"i", GPU_FORMAT_R8_UNORM, drawn, 64, 64, 2, false, 1}, NULL},
      {{"i", GPU_FORMAT_NONE, drawn, 64, 64, 1, false, 1}, "image_create: no format of an image"},
      {{"i", GPU_FORMAT_RGB32_FLOAT, drawn, 64, 64, 1, false, 1}, "image_create: no format of an image"},
      {{"i", GPU_FORMAT_COUNT, drawn, 64, 64, 1, false, 1}, "image_create: no format of an image"},
      {{"i", GPU_FORMAT_D32_FLOAT, GPU_IMAGE_STORED, 64, 64, 1, false, 1},
       "image_create: the format cannot what the usage asks"},
      {{"i", GPU_FORMAT_D16_UNORM, GPU_IMAGE_COPY_TARGET, 64, 64, 1, false, 1},
       "image_create: depth is no target of copies"},
      {{"i", GPU_FORMAT_R8_UNORM, drawn, 64, 0, 1, false, 1}, "image_create: a size or a count of layers of 0"},
      {{"i", GPU_FORMAT_R8_UNORM, drawn, 64, 64, 0, false, 1}, "image_create: a size or a count of layers of 0"},
      {{"i", GPU_FORMAT_R8_UNORM, drawn, 64, 32, 1, false, 8}, "image_create: more levels than its size has"},
  };
  for (size_t i = 0; i < COUNT_OF(rows); i++) {
    gpu_image *image = NULL;
    gpu_image_create(f->g, &rows[i].info, &image);
    gpu_image_destroy(f->g, image);
    expect(f, rows[i].breach);
  }
  assert_true(gpu_image_bytes(f->g, f->depth) == WIDTH * HEIGHT * LAYERS * 2);
  assert_true(gpu_image_bytes(f->g, f->texture) == (64 * 32 + 32 * 16 + 16 * 8) * LAYERS * 4);
}

void test_views(void **state) {
  fixture *f = *state;
  gpu_image *unseen = NULL;
  gpu_image_create(f->g, &(gpu_image_info){"u", GPU_FORMAT_R8_UNORM, GPU_IMAGE_COPY_SOURCE, 8, 8, 1, false, 1},
                   &unseen);
  const struct {
    gpu_view_info info;
    const char *breach;
  } rows[] = {
      {{"v", f->texture, {0}}, NULL},
      {{"v", f->texture, {1, 0, 2, 0}}, NULL},
      {{"v", f->texture, {2, 0, 0, 0}}, "view_create: no such layers or levels"},
      {{"v", f->texture, {1, 2, 0, 0}}, "view_create: no such layers or levels"},
      {{"v", f->texture, {0, 1, 3, 1}}, "view_create: no such layers or levels"},
      {{"v", f->texture, {0, 1, 1, UINT32_MAX}}, "view_create: no such layers or levels"},
      {{"v", unseen, {0}}, "view_create: of an image that shaders do not see"},
  };
  for (size_t i = 0; i < COUNT_OF(rows); i++) {
    gpu_view *view = NULL;
    gpu_view_create(f->g, &rows[i].info, &view);
    gpu_view_destroy(f->g, view);
    expect(f, rows[i].breach);
  }
  gpu_image_destroy(f->g, unseen);
}

void test_targets(void **state) {
  fixture *f = *state;
  const struct {
    gpu_target_info info;
    const char *breach;
  } rows[] = {
      {{"t", f->depth, 1, f->color, 0, 0, 0}, NULL},
      {{"t", NULL, 0, f->texture, 1, 0, 2}, NULL},
      {{"t", NULL, 0, NULL, 0, 0, 0}, "target_create: without an image"},
      {{"t", f->depth, 2, NULL, 0, 0, 0}, "target_create: no such depth layer"},
      {{"t", f->depth, 0, NULL, 0, 1, 0}, "target_create: no such depth level"},
      {{"t", NULL, 0, f->texture, 2, 0, 0}, "target_create: no such colour layer"},
      {{"t", NULL, 0, f->texture, 0, 0, 3}, "target_create: no such colour level"},
      {{"t", f->color, 0, NULL, 0, 0, 0}, "target_create: depth has no depths"},
      {{"t", NULL, 0, f->depth, 0, 0, 0}, "target_create: colour has depths"},
      {{"t", f->depth, 0, f->texture, 0, 0, 1}, "target_create: depth and colour differ in size"},
  };
  for (size_t i = 0; i < COUNT_OF(rows); i++) {
    gpu_target *target = NULL;
    gpu_target_create(f->g, &rows[i].info, &target);
    gpu_target_destroy(f->g, target);
    expect(f, rows[i].breach);
  }
  gpu_native_target told;
  assert_int_equal(gpu_target_native(f->g, GPU_FORMAT_D16_UNORM, GPU_FORMAT_R8_UNORM, &told), CSM_SUCCESS);
  expect(f, NULL);
  gpu_target_native(f->g, GPU_FORMAT_NONE, GPU_FORMAT_NONE, &told);
  expect(f, "target_native: without a format");
  gpu_target_native(f->g, GPU_FORMAT_R8_UNORM, GPU_FORMAT_NONE, &told);
  expect(f, "target_native: no depth format");
  gpu_target_native(f->g, GPU_FORMAT_NONE, GPU_FORMAT_D32_FLOAT, &told);
  expect(f, "target_native: no colour format");
}

/* A good program with one field changed. */
#define WITH(base, field, value) (info = (base), info.field = (value), info)

void test_programs(void **state) {
  fixture *f = *state;
  gpu_program_info info;
  const gpu_attribute narrow = {GPU_FORMAT_R16_FLOAT, 0, 0}, nowhere = {GPU_FORMAT_RG32_FLOAT, 1, 0},
                      odd = {GPU_FORMAT_RG32_FLOAT, 0, 2};
  const gpu_raster_bias bias = {.constant = 1};
  gpu_program_info depthless = null_drawing, sampling = null_drawing;
  depthless.depth_format = GPU_FORMAT_NONE;
  depthless.depth_compare = GPU_COMPARE_NONE;
  sampling.sampler_count = 1;
  const struct {
    gpu_program_info info;
    const char *breach;
  } rows[] = {
      {null_drawing, NULL},
      {null_computing, NULL},
      {WITH(null_drawing, depth_compare, GPU_COMPARE_ALWAYS), NULL},
      {WITH(null_drawing, vertex, (gpu_code){0}), "program_create: no vertex shader"},
      {WITH(null_drawing, pixel, (gpu_code){.spirv_size = 4}), "program_create: half a pixel shader"},
      {WITH(null_drawing, depth_format, GPU_FORMAT_R8_UNORM), "program_create: no depth format"},
      {WITH(null_drawing, color_format, GPU_FORMAT_D16_UNORM), "program_create: no colour format"},
      {WITH(null_drawing, color_format, GPU_FORMAT_RGB32_FLOAT), "program_create: no colour format"},
      {WITH(null_drawing, depth_format, GPU_FORMAT_NONE), "program_create: a comparison without depth"},
      {WITH(null_drawing, depth_compare, (gpu_compare)(GPU_COMPARE_ALWAYS + 1)), "program_create: no such comparison"},
      {WITH(depthless, raster_bias, bias), "program_create: a raster bias without depth"},
      {WITH(null_drawing, store_image_count, 1), "program_create: images stored to beside a colour target"},
      {WITH(null_drawing, texture_count, GPU_MAX_TEXTURES + 1), "program_create: more than there are places for"},
      {WITH(null_drawing, streams[0].stride, 6), "program_create: a stride is not a multiple of 4"},
      {WITH(null_drawing, attributes[0], narrow), "program_create: no format of an attribute"},
      {WITH(null_drawing, attributes[0], nowhere), "program_create: an attribute of no stream"},
      {WITH(null_drawing, attributes[0], odd), "program_create: an attribute's offset is not a multiple of 4"},
      {WITH(sampling, samplers[0], GPU_SAMPLER_COUNT), "program_create: no such sampler"},
      {WITH(null_computing, compute.dxbc_size, 0), "program_create: half a compute shader"},
      {WITH(null_computing, color_format, GPU_FORMAT_R8_UNORM), "program_create: a compute program that draws"},
      {WITH(null_computing, vertex, null_drawing.vertex), "program_create: a compute program that draws"},
  };
  for (size_t i = 0; i < COUNT_OF(rows); i++) {
    gpu_program *program = NULL;
    assert_int_equal(gpu_program_create(f->g, &rows[i].info, &program), CSM_SUCCESS);
    gpu_program_destroy(f->g, program);
    expect(f, rows[i].breach);
  }
}

void test_bindings(void **state) {
  fixture *f = *state;
  gpu_view *all_levels = NULL;
  gpu_view_create(f->g, &(gpu_view_info){"all levels", f->texture, {0, 1, 0, 0}}, &all_levels);
  const gpu_bindings_info good = {.name = "bindings",
                                  .program = f->computing,
                                  .constants = {f->upload},
                                  .texture_views = {f->levels[0]},
                                  .buffers = {{f->upload, 256, 512, 16}},
                                  .texel_buffers = {f->upload},
                                  .store_images = {f->levels[1]},
                                  .store_buffers = {{f->device, 0, 1024, 4}}};
  gpu_bindings_info info, elsewhere = good;
  elsewhere.texture_views[0] = NULL;
  elsewhere.textures[0] = f->color;
  const gpu_buffer_part none = {0}, raw = {f->device, 0, 1024, 0}, odd = {f->upload, 128, 512, 4},
                        uneven = {f->upload, 256, 512, 12}, beyond = {f->upload, BUFFER_SIZE, 4, 4},
                        same = {f->device, 0, 1024, 4}, unwritable = {f->upload, 0, 1024, 4};
  const struct {
    gpu_bindings_info info;
    const char *breach;
  } rows[] = {
      {good, NULL},
      {WITH(good, constants[0], f->device), "bindings_write: constants are missing, or in no upload buffer"},
      {WITH(good, texture_views[0], NULL), "bindings_write: a texture is missing, or not made to be sampled"},
      {WITH(good, texture_views[0], f->levels[1]), "bindings_write: a texture is also written"},
      {WITH(good, texture_views[0], all_levels), "bindings_write: a texture is also written"},
      {WITH(good, store_images[0], NULL), "bindings_write: an image is missing, or not made to be stored to"},
      {WITH(elsewhere, store_images[0], all_levels), "bindings_write: stores go to one level"},
      {WITH(good, buffers[0], none), "bindings_write: a buffer is missing, or not made to be read"},
      {WITH(good, buffers[0], odd),
       "bindings_write: a part's offset is not a multiple of 256, or its size not one of 4"},
      {WITH(good, buffers[0], uneven),
       "bindings_write: a part's stride is not a multiple of 4, or divides its offset or size not"},
      {WITH(good, buffers[0], beyond), "bindings_write: a part beyond a buffer's end"},
      {WITH(good, buffers[0], same), "bindings_write: a buffer is also written"},
      {WITH(good, texel_buffers[0], NULL), "bindings_write: a texel buffer is missing, or not made to be one"},
      {WITH(good, texel_buffers[0], f->readback), "bindings_write: a texel buffer is missing, or not made to be one"},
      {WITH(good, texel_buffers[0], f->device), "bindings_write: a buffer is also written"},
      {WITH(good, store_buffers[0], raw), "bindings_write: a raw buffer that is written"},
      {WITH(good, store_buffers[0], unwritable), "bindings_write: a buffer is missing, or not made to be written"},
  };
  for (size_t i = 0; i < COUNT_OF(rows); i++) {
    gpu_bindings *bindings = NULL;
    gpu_bindings_create(f->g, &rows[i].info, &bindings);
    gpu_bindings_destroy(f->g, bindings);
    expect(f, rows[i].breach);
  }
  gpu_view_destroy(f->g, all_levels);
}

/* ---- what a device can do ---- */

void test_capabilities(void **state) {
  fixture *f = *state;
  gpu_device_info info;
  gpu_describe(f->g, &info);
  assert_int_equal(f->g.api->api, GPU_API_NULL);
  assert_int_equal(info.can.formats[GPU_FORMAT_NONE] | info.can.formats[GPU_FORMAT_RGB32_FLOAT], 0);
  assert_int_equal(info.can.formats[GPU_FORMAT_D16_UNORM], GPU_CAN_SAMPLE | GPU_CAN_DRAW);
  assert_true(info.can.formats[GPU_FORMAT_R32_UINT] & GPU_CAN_ATOMIC);
  assert_false(info.can.formats[GPU_FORMAT_R32_UINT] & GPU_CAN_FILTER);
  assert_true(info.can.compute && info.can.indirect && info.can.pixel_stores);
  const uint32_t bytes[GPU_FORMAT_COUNT] = {0, 4, 2, 1, 2, 4, 2, 4, 8, 4, 8, 12, 16, 4};
  for (gpu_format format = GPU_FORMAT_NONE; format < GPU_FORMAT_COUNT; format++)
    assert_int_equal(gpu_format_bytes(format), bytes[format]);
}
