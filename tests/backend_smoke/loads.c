/* loads.c: what a pass does with what its target holds, in every format that is drawn into. */
#include "smoke.h"

#include <math.h>
#include <string.h>

/* ---- texels ---- */

static uint32_t channels_of(gpu_format format) {
  switch (format) {
  case GPU_FORMAT_RG16_UNORM:
  case GPU_FORMAT_RG16_FLOAT:
  case GPU_FORMAT_RG32_FLOAT:
    return 2;
  case GPU_FORMAT_RGBA16_FLOAT:
  case GPU_FORMAT_RGBA32_FLOAT:
    return 4;
  default:
    return 1;
  }
}

/* Of numbers that a half holds, not denormal ones. */
static float half_value(uint16_t bits) {
  const int exponent = bits >> 10 & 31;
  const float magnitude = exponent ? ldexpf((float)(1024 + (bits & 1023)), exponent - 25) : 0;
  return bits & 0x8000 ? -magnitude : magnitude;
}

static float channel_value(gpu_format format, const uint8_t *texel, uint32_t channel) {
  uint16_t word;
  uint32_t whole;
  float value;
  switch (format) {
  case GPU_FORMAT_R8_UNORM:
    return (float)texel[channel] / 255;
  case GPU_FORMAT_R16_UNORM:
  case GPU_FORMAT_RG16_UNORM:
    memcpy(&word, texel + 2 * channel, sizeof word);
    return (float)word / 65535;
  case GPU_FORMAT_R16_FLOAT:
  case GPU_FORMAT_RG16_FLOAT:
  case GPU_FORMAT_RGBA16_FLOAT:
    memcpy(&word, texel + 2 * channel, sizeof word);
    return half_value(word);
  case GPU_FORMAT_R32_UINT:
    memcpy(&whole, texel, sizeof whole);
    return (float)whole;
  default:
    memcpy(&value, texel + 4 * channel, sizeof value);
    return value;
  }
}

/* What a channel may be off: half a step of a normalised integer. Halves and floats hold what is drawn here. */
static float slack_of(gpu_format format) {
  if (format == GPU_FORMAT_R8_UNORM)
    return 0.501f / 255;
  return format == GPU_FORMAT_R16_UNORM || format == GPU_FORMAT_RG16_UNORM ? 0.501f / 65535 : 0;
}

/* ---- colours ---- */

static const gpu_rect cleared = {10, 20, 100, 60}, drawn = {60, 40, 150, 33};

static bool lies_in(const gpu_rect *area, uint32_t x, uint32_t y) {
  return x - area->x < area->width && y - area->y < area->height;
}

static uint32_t wrong_texels(const uint8_t *rows, uint32_t row_bytes, gpu_format format, const float colors[3][4]) {
  uint32_t wrong = 0;
  for (uint32_t y = 0; y < SIZE; y++)
    for (uint32_t x = 0; x < SIZE; x++) {
      const float *expected = colors[lies_in(&drawn, x, y) ? 2 : lies_in(&cleared, x, y) ? 1 : 0];
      const uint8_t *texel = rows + y * row_bytes + x * gpu_format_bytes(format);
      for (uint32_t c = 0; c < channels_of(format); c++)
        wrong += !(fabsf(channel_value(format, texel, c) - expected[c]) <= slack_of(format));
    }
  return wrong;
}

/* All is cleared, then an area of it, then another is drawn over and the rest kept: each in a pass of its own. */
static void check_color(smoke *s, gpu_format format, const float colors[3][4]) {
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  gpu_image *image = scrap_image(s, (gpu_image_info){"colour", format, usage, SIZE, SIZE, 1, false, 1});
  gpu_target *target = scrap_target(s, (gpu_target_info){.name = "colour", .color = image});
  const bool whole = format == GPU_FORMAT_R32_UINT;
  gpu_program_info info = screen_program("flat", whole ? shader_flat_uint_ps : shader_flat_ps, format);
  info.constants_count = 1;
  info.texture_count = 0;
  gpu_program *program = scrap_program(s, info);
  gpu_bindings *bindings =
      scrap_bindings(s, (gpu_bindings_info){.name = "flat", .program = program, .constants = {s->slots[0].upload}});
  begin(s, 0);
  const uint32_t offset = put_constants(s, 0, colors[2]);
  gpu_pass_info pass = {.target = target, .color_load = GPU_LOAD_CLEAR};
  memcpy(pass.clear_color, colors[0], sizeof pass.clear_color);
  gpu_pass_begin(s->g, &pass);
  gpu_pass_end(s->g);
  memcpy(pass.clear_color, colors[1], sizeof pass.clear_color);
  pass.area = cleared;
  gpu_pass_begin(s->g, &pass);
  gpu_pass_end(s->g);
  draw_screen(s, &(gpu_pass_info){.target = target, .area = drawn}, program, bindings, offset);
  end_and_wait(s, 0);
  uint32_t row_bytes;
  const uint8_t *rows = read_level(s, image, format, (gpu_region){.width = SIZE, .height = SIZE}, &row_bytes);
  const uint32_t wrong = wrong_texels(rows, row_bytes, format, colors);
  CHECK(s, wrong == 0, "format %d: %u channels", (int)format, wrong);
  scrap_free(s);
}

void test_loads(smoke *s) {
  const float colors[3][4] = {{0.25f, 0.5f, 0.75f, 1}, {1, 0, 0.125f, 0.5f}, {0.5f, 0.75f, 1, 0.25f}};
  const float numbers[3][4] = {{7}, {16777215}, {65536}};
  const float signs[3][4] = {{-0.25f, 40, -1024, 3}, {6.5f, -2, 0, 1000}, {-3, 0.5f, 60000, -1}};
  for (gpu_format format = GPU_FORMAT_R8_UNORM; format < GPU_FORMAT_COUNT; format++) {
    const bool image = format != GPU_FORMAT_RGB32_FLOAT;
    CHECK(s, image == !!(s->can.formats[format] & GPU_CAN_DRAW), "format %d: can %x", (int)format,
          s->can.formats[format]);
    if (!image)
      continue;
    check_color(s, format, format == GPU_FORMAT_R32_UINT ? numbers : colors);
    if (format >= GPU_FORMAT_R16_FLOAT && format != GPU_FORMAT_R32_UINT)
      check_color(s, format, signs);
  }
}

/* ---- depth ---- */

/* The quad lies in the cleared area, from a column on. */
static uint32_t wrong_depths(const float *depth, uint32_t from, float inside, float quad_depth) {
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < SIZE * SIZE; i++) {
    const bool in_area = lies_in(&cleared, i % SIZE, i / SIZE);
    wrong += depth[i] != (!in_area ? 0.75f : i % SIZE < from ? inside : quad_depth);
  }
  return wrong;
}

/* A part of a pass's area is drawn over, all of it where the rest is discarded. What lies around the area is kept. */
void test_depth_loads(smoke *s) {
  const quad all = {1, 1, 0, 0, 0, 0.25f}, right = {0.5f, 1, 0.5f, 0, 0, 0.25f};
  const smoke_slot *slot = &s->slots[0];
  for (gpu_load load = GPU_LOAD_KEEP; load <= GPU_LOAD_CLEAR; load++) {
    const bool discards = load == GPU_LOAD_DISCARD;
    begin(s, 0);
    write_rows(gpu_buffer_memory(s->g, slot->upload), discards ? all : right);
    gpu_clear_depth(s->g, s->plain.image, 0.75f);
    gpu_pass_begin(
        s->g, &(gpu_pass_info){.target = s->plain.target, .depth_load = load, .clear_depth = 0.5f, .area = cleared});
    gpu_pass_program(s->g, discards ? s->depth_always : s->depth);
    draw_quads(s, slot->upload, 0, 1, 4);
    gpu_pass_end(s->g);
    copy_layer(s, slot->readback, 0, s->plain.image, GPU_FORMAT_D32_FLOAT, 0);
    end_and_wait(s, 0);
    const uint32_t wrong =
        wrong_depths(gpu_buffer_memory(s->g, slot->readback), cleared.x + (discards ? 0 : cleared.width / 2),
                     load == GPU_LOAD_CLEAR ? 0.5f : 0.75f, 0.25f);
    CHECK(s, wrong == 0, "load %d: %u texels", (int)load, wrong);
  }
}

/* The last quad wins, whether it is nearer or farther. */
void test_always(smoke *s) {
  const quad two[2] = {{1, 1, 0, 0, 0, 0.25f}, {0.5f, 1, 0.5f, 0, 0, 0.75f}};
  const float *depth = draw_plain(s, s->depth_always, 0.5f, two, 2);
  CHECK(s, count_texels(depth, 0.25f) == SIZE * SIZE / 2, "the first quad");
  CHECK(s, count_texels(depth, 0.75f) == SIZE * SIZE / 2, "the farther quad");
}

/* Depth and colour together: colour is drawn where the depth test passes, into one {layer, level} of each. */
void test_both_targets(smoke *s) {
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_COPY_SOURCE;
  gpu_image *depth = scrap_image(s, (gpu_image_info){"both", GPU_FORMAT_D32_FLOAT, usage, SIZE, SIZE, 2, true, 1});
  gpu_image *color =
      scrap_image(s, (gpu_image_info){"both", GPU_FORMAT_R8_UNORM, usage, 2 * SIZE, 2 * SIZE, 1, false, 2});
  gpu_target *target = scrap_target(
      s, (gpu_target_info){.name = "both", .depth = depth, .depth_layer = 1, .color = color, .color_level = 1});
  gpu_program_info info = depth_program(GPU_FORMAT_D32_FLOAT);
  info.pixel = shader_flat_ps;
  info.color_format = GPU_FORMAT_R8_UNORM;
  info.constants_count = 1;
  info.constants_sizes[0] = 16;
  gpu_program *program = scrap_program(s, info);
  gpu_bindings *bindings =
      scrap_bindings(s, (gpu_bindings_info){.name = "both", .program = program, .constants = {s->slots[0].upload}});
  const quad slope = {1, 1, 0, 0, 0.5f, 0.5f};
  begin(s, 0);
  const uint32_t offset = put_constants(s, 0, (const float[4]){1, 1, 1, 1});
  write_rows(gpu_buffer_memory(s->g, s->slots[0].upload), slope);
  gpu_pass_begin(
      s->g, &(gpu_pass_info){
                .target = target, .depth_load = GPU_LOAD_CLEAR, .clear_depth = 0.25f, .color_load = GPU_LOAD_CLEAR});
  gpu_pass_program(s->g, program);
  gpu_pass_bind(s->g, bindings, &offset);
  draw_quads(s, s->slots[0].upload, 0, 1, 4);
  gpu_pass_end(s->g);
  end_and_wait(s, 0);
  uint32_t row_bytes, wrong = 0;
  const gpu_region at = {.level = 1, .width = SIZE, .height = SIZE};
  const uint8_t *mask = read_level(s, color, GPU_FORMAT_R8_UNORM, at, &row_bytes);
  for (uint32_t i = 0; i < SIZE * SIZE; i++)
    wrong += mask[i] != (i % SIZE < SIZE / 4 ? 255 : 0);
  CHECK(s, wrong == 0, "colour: %u texels", wrong);
  const gpu_region layer = {.layer = 1, .width = SIZE, .height = SIZE};
  const float *depths = (const float *)read_level(s, depth, GPU_FORMAT_D32_FLOAT, layer, &row_bytes);
  CHECK(s, count_texels(depths, 0.25f) == SIZE * SIZE * 3 / 4, "depth: %u texels", count_texels(depths, 0.25f));
  scrap_free(s);
}
