/* stores.c: what shaders write: buffers, images, atomics; from dispatches and from pixel shaders. */
#include "smoke.h"

#include <string.h>

/* ---- buffers ---- */

enum { COUNT = 1024, BYTES = COUNT * 4, PART = 256 };

static gpu_program *compute_program(smoke *s, gpu_program_info info, gpu_code code) {
  info.name = "compute";
  info.compute = code;
  return scrap_program(s, info);
}

static gpu_program *adding_program(smoke *s) {
  return compute_program(s,
                         (gpu_program_info){.constants_count = 1,
                                            .constants_sizes = {16},
                                            .buffer_count = 2,
                                            .texel_buffer_count = 1,
                                            .store_buffer_count = 1},
                         shader_buffers_cs);
}

/* out = in * factor + raw + texel + index: from an upload buffer, and from device buffers back and forth. */
void test_buffers(smoke *s) {
  if (!s->can.compute)
    return;
  gpu_program *program = adding_program(s);
  const gpu_buffer_info device = {"numbers", GPU_BUFFER_DEVICE, BYTES + PART, GPU_BUFFER_READ | GPU_BUFFER_WRITE};
  gpu_buffer *first =
      scrap_buffer(s, (gpu_buffer_info){"first", GPU_BUFFER_UPLOAD, BYTES, GPU_BUFFER_READ | GPU_BUFFER_TEXELS});
  gpu_buffer *raw = scrap_buffer(s, (gpu_buffer_info){"raw", GPU_BUFFER_DEVICE, BYTES, GPU_BUFFER_READ});
  gpu_buffer *steps[2] = {scrap_buffer(s, device), scrap_buffer(s, device)};
  uint32_t expected[COUNT];
  const float factors[3] = {3, 5, 1};
  for (uint32_t i = 0; i < COUNT; i++)
    expected[i] = ((uint32_t *)gpu_buffer_memory(s->g, first))[i] = i * 7 + 1;
  begin(s, 0);
  gpu_copy_buffer(s->g, raw, 0, first, 0, BYTES);
  for (uint32_t step = 0; step < 3; step++) { /* the last one reads what the second wrote, over what that read */
    const uint32_t offset = put_constants(s, step, (const float[4]){factors[step]});
    const gpu_buffer_part from = step ? (gpu_buffer_part){steps[(step + 1) % 2], PART, BYTES, 4}
                                      : (gpu_buffer_part){.buffer = first, .stride = 4};
    gpu_bindings *bindings =
        scrap_bindings(s, (gpu_bindings_info){.name = "step",
                                              .program = program,
                                              .constants = {s->slots[0].upload},
                                              .buffers = {from, {.buffer = raw}},
                                              .texel_buffers = {first},
                                              .store_buffers = {{steps[step % 2], PART, BYTES, 4}}});
    gpu_dispatch(s->g, &(gpu_dispatch_info){
                           .program = program, .bindings = bindings, .offsets = &offset, .groups = {COUNT / 64, 1, 1}});
    for (uint32_t i = 0; i < COUNT; i++)
      expected[i] = expected[i] * (uint32_t)factors[step] + 2 * (i * 7 + 1) + i;
  }
  end_and_wait(s, 0);
  const uint32_t *read = read_buffer(s, steps[0], BYTES + PART);
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < COUNT; i++)
    wrong += read[PART / 4 + i] != expected[i];
  CHECK(s, wrong == 0, "%u numbers", wrong);
  scrap_free(s);
}

/* ---- atomics ---- */

static void clear_buffer(smoke *s, gpu_buffer *buffer, uint64_t size) {
  gpu_buffer *zeros = scrap_buffer(s, (gpu_buffer_info){.name = "zeros", .kind = GPU_BUFFER_UPLOAD, .size = size});
  memset(gpu_buffer_memory(s->g, zeros), 0, size);
  gpu_copy_buffer(s->g, buffer, 0, zeros, 0, size);
}

/* 256 squares modulo 8 are 0, 1, 4: 64, 128 and 64 of them. Twice, so that what the first dispatch wrote counts. */
void test_atomics(smoke *s) {
  const uint32_t squares[9] = {64, 128, 0, 0, 64, 0, 0, 0, 255 * 256 / 2 * 511 / 3};
  const bool can = s->can.formats[GPU_FORMAT_R32_UINT] & GPU_CAN_ATOMIC;
  CHECK(s, can || !s->can.compute, "no atomics on an R32_UINT");
  if (!can)
    return;
  const uint32_t usage = GPU_IMAGE_STORED | GPU_IMAGE_COPY_SOURCE | GPU_IMAGE_TARGET;
  gpu_program *program =
      compute_program(s, (gpu_program_info){.store_image_count = 1, .store_buffer_count = 1}, shader_atomics_cs);
  gpu_buffer *counts = scrap_buffer(s, (gpu_buffer_info){"counts", GPU_BUFFER_DEVICE, 36, GPU_BUFFER_WRITE});
  gpu_image *image = scrap_image(s, (gpu_image_info){"histogram", GPU_FORMAT_R32_UINT, usage, 8, 1, 1, false, 1});
  gpu_target *target = scrap_target(s, (gpu_target_info){.name = "histogram", .color = image});
  gpu_view *view = scrap_view(s, (gpu_view_info){.name = "histogram", .image = image});
  gpu_bindings *bindings = scrap_bindings(
      s, (gpu_bindings_info){
             .name = "histogram", .program = program, .store_images = {view}, .store_buffers = {{counts, 0, 0, 4}}});
  begin(s, 0);
  clear_buffer(s, counts, 36);
  gpu_pass_begin(s->g, &(gpu_pass_info){.target = target, .color_load = GPU_LOAD_CLEAR});
  gpu_pass_end(s->g);
  for (uint32_t i = 0; i < 2; i++)
    gpu_dispatch(s->g, &(gpu_dispatch_info){.program = program, .bindings = bindings, .groups = {4, 1, 1}});
  end_and_wait(s, 0);
  const uint32_t *read = read_buffer(s, counts, 36);
  for (uint32_t i = 0; i < 9; i++)
    CHECK(s, read[i] == 2 * squares[i], "buffer, %u: %u", i, read[i]);
  uint32_t row_bytes;
  read = (const uint32_t *)read_level(s, image, GPU_FORMAT_R32_UINT, (gpu_region){.width = 8, .height = 1}, &row_bytes);
  for (uint32_t i = 0; i < 8; i++)
    CHECK(s, read[i] == 2 * squares[i], "image, %u: %u", i, read[i]);
  scrap_free(s);
}

/* ---- images ---- */

static gpu_image *store(smoke *s, gpu_code code, gpu_image_info info, uint32_t layer_groups) {
  gpu_program *program = compute_program(s, (gpu_program_info){.store_image_count = 1}, code);
  gpu_image *image = scrap_image(s, info);
  gpu_view *view = scrap_view(s, (gpu_view_info){.name = "stored", .image = image});
  gpu_bindings *bindings =
      scrap_bindings(s, (gpu_bindings_info){.name = "stored", .program = program, .store_images = {view}});
  begin(s, 0);
  gpu_dispatch(s->g, &(gpu_dispatch_info){.program = program, .bindings = bindings, .groups = {2, 2, layer_groups}});
  end_and_wait(s, 0);
  return image;
}

void test_stored_images(smoke *s) {
  enum { SIDE = 16 };
  const uint32_t usage = GPU_IMAGE_STORED | GPU_IMAGE_COPY_SOURCE | GPU_IMAGE_SAMPLED;
  uint32_t row_bytes, wrong = 0;
  if (s->can.formats[GPU_FORMAT_RG32_FLOAT] & GPU_CAN_STORE && s->can.compute) {
    gpu_image *image = store(s, shader_stored_pair_cs,
                             (gpu_image_info){"pairs", GPU_FORMAT_RG32_FLOAT, usage, SIDE, SIDE, 4, true, 1}, 2);
    const gpu_region last = {.layer = 3, .width = SIDE, .height = SIDE};
    const float *texels = (const float *)read_level(s, image, GPU_FORMAT_RG32_FLOAT, last, &row_bytes);
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
      const float *texel = texels + i / SIDE * (row_bytes / 4) + i % SIDE * 2;
      wrong += texel[0] != (float)(i % SIDE + 1000 * (i / SIDE)) || texel[1] != 3;
    }
    CHECK(s, wrong == 0, "pairs: %u texels", wrong);
  }
  if (s->can.formats[GPU_FORMAT_RGBA16_FLOAT] & GPU_CAN_STORE && s->can.compute) {
    gpu_image *image = store(s, shader_stored_half_cs,
                             (gpu_image_info){"halves", GPU_FORMAT_RGBA16_FLOAT, usage, SIDE, SIDE, 1, false, 1}, 1);
    const gpu_region one = {.x = 3, .y = 2, .width = 1, .height = 1};
    const uint16_t expected[4] = {0x4200, 0x4000, 0x3800, 0xc000};
    CHECK(s, !memcmp(read_level(s, image, GPU_FORMAT_RGBA16_FLOAT, one, &row_bytes), expected, sizeof expected),
          "halves");
  }
  scrap_free(s);
}

/* ---- pixel shaders ---- */

/* An area is drawn twice, in two passes, and each pixel counts itself; a dispatch reads the counts. */
void test_pixel_stores(smoke *s) {
  const gpu_rect area = {100, 50, 60, 20};
  if (!s->can.pixel_stores || !s->can.compute)
    return;
  gpu_program_info info = screen_program("count", shader_count_ps, GPU_FORMAT_R8_UNORM);
  info.constants_count = 0;
  info.texture_count = 0;
  info.store_buffer_count = 1;
  gpu_program *program = scrap_program(s, info);
  gpu_program *adds = adding_program(s);
  const gpu_buffer_info numbers = {"counts", GPU_BUFFER_DEVICE, 256,
                                   GPU_BUFFER_READ | GPU_BUFFER_WRITE | GPU_BUFFER_TEXELS};
  gpu_buffer *counts = scrap_buffer(s, numbers), *sums = scrap_buffer(s, numbers);
  gpu_bindings *bindings =
      scrap_bindings(s, (gpu_bindings_info){.name = "count", .program = program, .store_buffers = {{counts, 0, 0, 4}}});
  gpu_bindings *reads =
      scrap_bindings(s, (gpu_bindings_info){.name = "add",
                                            .program = adds,
                                            .constants = {s->slots[0].upload},
                                            .buffers = {{.buffer = counts, .stride = 4}, {.buffer = counts}},
                                            .texel_buffers = {counts},
                                            .store_buffers = {{sums, 0, 0, 4}}});
  begin(s, 0);
  const uint32_t offset = put_constants(s, 0, (const float[4]){1});
  clear_buffer(s, counts, 256);
  for (uint32_t i = 0; i < 2; i++)
    draw_screen(s,
                &(gpu_pass_info){.target = s->mask_target,
                                 .color_load = i ? GPU_LOAD_KEEP : GPU_LOAD_CLEAR,
                                 .area = area,
                                 .stores = bindings},
                program, bindings, 0);
  gpu_dispatch(s->g, &(gpu_dispatch_info){.program = adds, .bindings = reads, .offsets = &offset, .groups = {1, 1, 1}});
  end_and_wait(s, 0);
  const uint32_t *read = read_buffer(s, sums, 256);
  CHECK(s, read[0] == 3 * 2 * area.width * area.height, "%u pixels", read[0]);
  CHECK(s, read[1] == 3 * 2 * 28 * area.height + 1, "%u pixels on the left", read[1]);
  scrap_free(s);
}

/* An area of a depth target is drawn by a program that writes an image, and no colour; the rest of it is kept. */
void test_pixel_images(smoke *s) {
  const uint32_t usage = GPU_IMAGE_STORED | GPU_IMAGE_TARGET | GPU_IMAGE_COPY_SOURCE | GPU_IMAGE_SAMPLED;
  const gpu_rect area = {30, 40, 50, 60};
  if (!s->can.pixel_stores || !(s->can.formats[GPU_FORMAT_R32_UINT] & GPU_CAN_STORE))
    return;
  gpu_program *program = scrap_program(s, (gpu_program_info){.name = "store",
                                                             .vertex = shader_screen_vs,
                                                             .pixel = shader_store_ps,
                                                             .store_image_count = 1,
                                                             .depth_format = GPU_FORMAT_D32_FLOAT});
  gpu_image *image = scrap_image(s, (gpu_image_info){"places", GPU_FORMAT_R32_UINT, usage, SIZE, SIZE, 1, false, 1});
  gpu_target *target = scrap_target(s, (gpu_target_info){.name = "places", .color = image});
  gpu_view *view = scrap_view(s, (gpu_view_info){.name = "places", .image = image});
  gpu_bindings *bindings =
      scrap_bindings(s, (gpu_bindings_info){.name = "places", .program = program, .store_images = {view}});
  begin(s, 0);
  gpu_pass_begin(s->g, &(gpu_pass_info){.target = target, .color_load = GPU_LOAD_CLEAR, .clear_color = {5}});
  gpu_pass_end(s->g);
  draw_screen(
      s, &(gpu_pass_info){.target = s->plain.target, .depth_load = GPU_LOAD_CLEAR, .area = area, .stores = bindings},
      program, bindings, 0);
  end_and_wait(s, 0);
  uint32_t row_bytes, wrong = 0;
  const gpu_region all = {.width = SIZE, .height = SIZE};
  const uint32_t *places = (const uint32_t *)read_level(s, image, GPU_FORMAT_R32_UINT, all, &row_bytes);
  for (uint32_t y = 0; y < SIZE; y++)
    for (uint32_t x = 0; x < SIZE; x++) {
      const bool drawn = x - area.x < area.width && y - area.y < area.height;
      wrong += places[y * SIZE + x] != (drawn ? x + 1000 * y : 5);
    }
  CHECK(s, wrong == 0, "%u pixels", wrong);
  scrap_free(s);
}
