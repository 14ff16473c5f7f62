/* levels.c: mip levels and layers: one is read while another is written, and each is copied on its own. */
#include "smoke.h"

#include <string.h>

enum { LEVELS = 9, CHAIN_LAYERS = 2, LAYER = 1 };

/* The sum of x + y over a block of texels whose side is 2^level: whole numbers below 2^24, so exact. */
static float block_sum(uint32_t level, uint32_t x, uint32_t y) {
  const float side = (float)(1u << level);
  return side * side * (side * (float)(x + y) + side - 1);
}

static void upload_ramp(smoke *s, gpu_image *image, gpu_buffer *staging) {
  float *texels = gpu_buffer_memory(s->g, staging);
  for (uint32_t y = 0; y < SIZE; y++)
    for (uint32_t x = 0; x < SIZE; x++)
      texels[y * SIZE + x] = (float)(x + y);
  const gpu_region all = {.layer = LAYER, .width = SIZE, .height = SIZE};
  gpu_copy_to_image(s->g, image, &all, staging, 0, SIZE * 4);
}

static void check_chain(smoke *s, gpu_image *image, const char *how) {
  for (uint32_t level = 0; level < LEVELS; level++) {
    const uint32_t side = gpu_level_size(SIZE, level);
    uint32_t row_bytes, wrong = 0;
    const gpu_region all = {.layer = LAYER, .level = level, .width = side, .height = side};
    const uint8_t *rows = read_level(s, image, GPU_FORMAT_R32_FLOAT, all, &row_bytes);
    for (uint32_t y = 0; y < side; y++)
      for (uint32_t x = 0; x < side; x++)
        wrong += ((const float *)(rows + y * row_bytes))[x] != block_sum(level, x, y);
    CHECK(s, wrong == 0, "by %s, level %u: %u texels", how, level, wrong);
  }
}

static gpu_view *level_view(smoke *s, gpu_image *image, uint32_t level) {
  return scrap_view(s, (gpu_view_info){.name = "level", .image = image, .range = {LAYER, 1, level, 1}});
}

static gpu_program *sum_program(smoke *s, bool compute) {
  gpu_program_info info = screen_program("sum", shader_sum_ps, GPU_FORMAT_R32_FLOAT);
  info.constants_count = 0;
  if (compute)
    info = (gpu_program_info){.name = "sum",
                              .compute = shader_sum_cs,
                              .constants_count = 1,
                              .constants_sizes = {16},
                              .texture_count = 1,
                              .store_image_count = 1};
  return scrap_program(s, info);
}

static void pass_level(smoke *s, gpu_image *image, gpu_program *program, uint32_t level) {
  gpu_target *target =
      scrap_target(s, (gpu_target_info){.name = "level", .color = image, .color_layer = LAYER, .color_level = level});
  gpu_bindings *bindings = scrap_bindings(
      s, (gpu_bindings_info){.name = "level", .program = program, .texture_views = {level_view(s, image, level - 1)}});
  gpu_make_readable(s->g, image, &(gpu_range){LAYER, 1, level - 1, 1});
  draw_screen(s, &(gpu_pass_info){.target = target, .color_load = GPU_LOAD_DISCARD}, program, bindings, 0);
}

static void dispatch_level(smoke *s, gpu_image *image, gpu_program *program, uint32_t level) {
  const uint32_t side = gpu_level_size(SIZE, level), groups = (side + 7) / 8;
  const uint32_t offset = put_constants(s, level, (const float[4]){(float)side, (float)side});
  gpu_bindings *bindings = scrap_bindings(s, (gpu_bindings_info){.name = "level",
                                                                 .program = program,
                                                                 .constants = {s->slots[0].upload},
                                                                 .texture_views = {level_view(s, image, level - 1)},
                                                                 .store_images = {level_view(s, image, level)}});
  gpu_dispatch(s->g, &(gpu_dispatch_info){
                         .program = program, .bindings = bindings, .offsets = &offset, .groups = {groups, groups, 1}});
}

/* A chain of sums over all levels of one layer, in one recording. */
static void test_chain(smoke *s, bool compute) {
  const uint32_t usage = GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE | GPU_IMAGE_COPY_TARGET |
                         (compute ? GPU_IMAGE_STORED : GPU_IMAGE_TARGET);
  gpu_image *image =
      scrap_image(s, (gpu_image_info){"chain", GPU_FORMAT_R32_FLOAT, usage, SIZE, SIZE, CHAIN_LAYERS, true, LEVELS});
  gpu_buffer *staging =
      scrap_buffer(s, (gpu_buffer_info){.name = "ramp", .kind = GPU_BUFFER_UPLOAD, .size = LAYER_BYTES});
  gpu_program *program = sum_program(s, compute);
  CHECK(s, gpu_image_bytes(s->g, image) >= (uint64_t)CHAIN_LAYERS * LAYER_BYTES * 5 / 4, "too few bytes");
  begin(s, 0);
  upload_ramp(s, image, staging);
  for (uint32_t level = 1; level < LEVELS; level++) {
    if (compute)
      dispatch_level(s, image, program, level);
    else
      pass_level(s, image, program, level);
  }
  end_and_wait(s, 0);
  check_chain(s, image, compute ? "dispatches" : "passes");
  scrap_free(s);
}

void test_levels(smoke *s) {
  test_chain(s, false);
  if (s->can.compute)
    test_chain(s, true);
}

/* ---- copies ---- */

/* A piece of a level is written, and what lies around it is kept, as are the other levels. */
void test_level_copies(smoke *s) {
  enum { SIDE = SIZE / 2, AT_PIECE = 64 * 1024 };
  const gpu_region all = {.level = 1, .width = SIDE, .height = SIDE};
  const gpu_region piece = {.level = 1, .x = 5, .y = 100, .width = 70, .height = 3};
  const gpu_format format = GPU_FORMAT_R8_UNORM;
  const uint32_t usage = GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE | GPU_IMAGE_COPY_TARGET;
  gpu_image *image = scrap_image(s, (gpu_image_info){"levels", format, usage, SIZE, SIZE, 1, false, 2});
  gpu_buffer *staging =
      scrap_buffer(s, (gpu_buffer_info){.name = "texels", .kind = GPU_BUFFER_UPLOAD, .size = 2 * AT_PIECE});
  uint8_t *texels = gpu_buffer_memory(s->g, staging);
  memset(texels, 17, AT_PIECE);
  for (uint32_t i = 0; i < 3 * 256; i++)
    texels[AT_PIECE + i] = (uint8_t)(i % 256 + i / 256);
  begin(s, 0);
  gpu_copy_to_image(s->g, image, &(gpu_region){.width = SIZE, .height = SIZE}, staging, 0, SIZE);
  gpu_copy_to_image(s->g, image, &all, staging, 0, 256);
  gpu_copy_to_image(s->g, image, &piece, staging, AT_PIECE, 256);
  end_and_wait(s, 0);
  uint32_t row_bytes, wrong = 0;
  const uint8_t *rows = read_level(s, image, format, all, &row_bytes);
  for (uint32_t y = 0; y < SIDE; y++)
    for (uint32_t x = 0; x < SIDE; x++) {
      const uint32_t px = x - piece.x, py = y - piece.y;
      wrong += rows[y * row_bytes + x] != (px < piece.width && py < piece.height ? px + py : 17);
    }
  CHECK(s, wrong == 0, "level 1: %u texels", wrong);
  rows = read_level(s, image, format, (gpu_region){.width = SIZE, .height = SIZE}, &row_bytes);
  for (uint32_t i = 0; i < SIZE * SIZE; i++)
    wrong += rows[i] != 17;
  CHECK(s, wrong == 0, "level 0: %u texels", wrong);
  scrap_free(s);
}

/* ---- views ---- */

/* A shader's layer 0 is the first of the view. Layer k of the image holds k / 8. */
void test_layer_views(smoke *s) {
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  const uint32_t half = SIZE / 2;
  gpu_image *image =
      scrap_image(s, (gpu_image_info){"layers", GPU_FORMAT_D32_FLOAT, usage, SIZE, SIZE, LAYERS, true, 1});
  gpu_image *pairs = scrap_image(s, (gpu_image_info){"pairs", GPU_FORMAT_RG32_FLOAT, usage, half, half, 1, false, 1});
  gpu_target *target = scrap_target(s, (gpu_target_info){.name = "pairs", .color = pairs});
  gpu_program *program = scrap_program(s, screen_program("pairs", shader_pairs_ps, GPU_FORMAT_RG32_FLOAT));
  gpu_view *view = scrap_view(s, (gpu_view_info){.name = "last", .image = image, .range = {.first_layer = 2}});
  gpu_buffer *upload = s->slots[0].upload;
  gpu_bindings *bindings = scrap_bindings(
      s,
      (gpu_bindings_info){.name = "last", .program = program, .constants = {upload, upload}, .texture_views = {view}});
  for (uint32_t layer = 0; layer < 2; layer++) {
    begin(s, 0);
    const uint32_t offset = put_constants(s, 0, (const float[4]){(float)layer, 1});
    for (uint32_t i = 0; i < LAYERS; i++) {
      gpu_target *into = scrap_target(s, (gpu_target_info){.name = "layer", .depth = image, .depth_layer = i});
      gpu_pass_begin(s->g, &(gpu_pass_info){.target = into, .depth_load = GPU_LOAD_CLEAR, .clear_depth = (float)i / 8});
      gpu_pass_end(s->g);
    }
    gpu_make_readable(s->g, image, &(gpu_range){.first_layer = 2});
    gpu_pass_begin(s->g, &(gpu_pass_info){.target = target, .color_load = GPU_LOAD_DISCARD});
    gpu_pass_program(s->g, program);
    gpu_pass_bind(s->g, bindings, (const uint32_t[]){offset, offset});
    gpu_pass_draw(s->g, &(gpu_draw){.count = 3, .instance_count = 1});
    gpu_pass_end(s->g);
    end_and_wait(s, 0);
    uint32_t row_bytes;
    const gpu_region one = {.x = 7, .y = 9, .width = 1, .height = 1};
    const float *texel = (const float *)read_level(s, pairs, GPU_FORMAT_RG32_FLOAT, one, &row_bytes);
    CHECK(s, texel[0] == (float)(2 + layer) / 8, "layer %u: %g", layer, (double)texel[0]);
  }
  scrap_free(s);
}
