/* formats.c: depths of 16 bits, clears, comparisons, and pairs of floats. */
#include "smoke.h"

#include <math.h>
#include <string.h>

/* ---- depths of 16 bits ---- */

static uint32_t count_units(const uint16_t *depth, uint16_t value) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < SIZE * SIZE; i++)
    count += depth[i] == value;
  return count;
}

/* Every unit is kept, a slope comes out rounded to the nearest, and a nearer quad wins. */
void test_d16(smoke *s) {
  const uint16_t units[] = {0, 1, 2, 255, 256, 32767, 32768, 65533, 65534};
  for (uint32_t i = 0; i < sizeof units / sizeof *units; i++) {
    const quad flat = {1, 1, 0, 0, 0, (float)(units[i] / 65535.0)};
    const uint16_t *depth = draw_surface(s, &s->plain16, s->depth16, 1, &flat, 1, NULL);
    CHECK(s, count_units(depth, units[i]) == SIZE * SIZE, "unit %u: %u", units[i], depth[0]);
  }
  const quad slope = {1, 1, 0, 0, 0.25f, 0.5f};
  const uint16_t *depth = draw_surface(s, &s->plain16, s->depth16, 1, &slope, 1, NULL);
  double worst = 0;
  for (uint32_t i = 0; i < SIZE * SIZE; i++)
    worst = fmax(worst, fabs(depth[i] - 65535 * (0.5 + 0.25 * ((i % SIZE + 0.5) / SIZE * 2 - 1))));
  CHECK(s, worst <= 0.51, "off by %g units", worst);
  const quad two[2] = {{0.5f, 1, 0.5f, 0, 0, 100 / 65535.0f}, {1, 1, 0, 0, 0, 101 / 65535.0f}};
  depth = draw_surface(s, &s->plain16, s->depth16, 1, two, 2, NULL);
  CHECK(s, count_units(depth, 100) == SIZE * SIZE / 2 && count_units(depth, 101) == SIZE * SIZE / 2, "nearer by one");
}

static bool same_native(const gpu_native_target *a, const gpu_native_target *b) {
  return a->depth_format == b->depth_format && a->color_format == b->color_format && a->render_pass == b->render_pass &&
         a->dynamic_rendering == b->dynamic_rendering;
}

/* What an engine is told that it draws into, before and in the pass: numbers of VkFormat, or of DXGI_FORMAT. */
void test_native(smoke *s) {
  const bool vulkan = s->gpu->api == GPU_API_VULKAN;
  const smoke_surface *surfaces[] = {&s->plain, &s->plain16};
  const uint32_t formats[] = {vulkan ? 126 : 40, vulkan ? 124 : 55};
  gpu_device_info info;
  s->gpu->describe(s->device, &info);
  begin(s, 0);
  for (uint32_t i = 0; i < 2; i++) {
    gpu_native_pass native = {0};
    s->gpu->clear_depth(s->device, surfaces[i]->image, 1);
    s->gpu->pass_begin(s->device, &(gpu_pass_info){.target = surfaces[i]->target});
    s->gpu->pass_native(s->device, &native);
    s->gpu->pass_end(s->device);
    gpu_native_target told = {0};
    const csm_result result = s->gpu->target_native(s->device, surfaces[i]->format, GPU_FORMAT_NONE, &told);
    CHECK(s, result == CSM_SUCCESS, "target_native: %d", result);
    CHECK(s, told.depth_format == formats[i] && !told.color_format, "format %u, not %u", told.depth_format, formats[i]);
    CHECK(s, same_native(&told, &native.target), "not what was told beforehand");
    CHECK(s, vulkan == (told.render_pass || told.dynamic_rendering), "neither a render pass nor dynamic rendering");
    CHECK(s, told.dynamic_rendering == info.can.dynamic_rendering, "dynamic rendering, or not");
  }
  end_and_wait(s, 0);
}

/* ---- clears ---- */

/* All layers of an image that is larger than what is copied into it at once, where a clear is copies. */
static void check_clear(smoke *s, gpu_image *image, gpu_format format, float depth) {
  enum { WIDTH = 100, HEIGHT = 600, LAYER = 2 };
  const smoke_slot *slot = &s->slots[0];
  const uint32_t row_bytes = 512;
  begin(s, 0);
  s->gpu->clear_depth(s->device, image, depth);
  for (uint32_t i = 0; i < LAYER; i++)
    s->gpu->copy_image(s->device, slot->readback, i * HEIGHT * row_bytes, row_bytes, image,
                       &(gpu_region){.layer = i, .width = WIDTH, .height = HEIGHT});
  end_and_wait(s, 0);
  const char *bytes = s->gpu->buffer_memory(slot->readback);
  uint32_t wrong = 0;
  for (uint32_t row = 0; row < LAYER * HEIGHT; row++)
    for (uint32_t x = 0; x < WIDTH; x++) {
      const char *texels = bytes + row * row_bytes;
      wrong += format == GPU_FORMAT_D16_UNORM ? ((const uint16_t *)texels)[x] != (uint16_t)lroundf(depth * 65535)
                                              : ((const float *)texels)[x] != depth;
    }
  CHECK(s, wrong == 0, "%u-byte texels cleared to %g: %u", gpu_format_bytes(format), (double)depth, wrong);
}

void test_clears(smoke *s) {
  const gpu_format formats[] = {GPU_FORMAT_D32_FLOAT, GPU_FORMAT_D16_UNORM};
  const float depths[] = {0, 1, 0.3f, 1, 0};
  for (uint32_t f = 0; f < 2; f++) {
    gpu_image *image = make_image(
        s, (gpu_image_info){"cleared", formats[f], GPU_IMAGE_TARGET | GPU_IMAGE_COPY_SOURCE, 100, 600, 2, true, 1});
    for (uint32_t i = 0; i < sizeof depths / sizeof *depths; i++)
      check_clear(s, image, formats[f], depths[i]);
    s->gpu->image_destroy(s->device, image);
  }
}

/* ---- maps that shaders read ---- */

enum { MAP_LAYERS = 2, MAP_LAYER = 1, HALF = SIZE / 2, PAIR_ROW = HALF * 8 };
/* Where things lie in a readback buffer: all pairs, then the map, then a piece of the pairs. */
enum { AT_MAP = HALF * PAIR_ROW, AT_PIECE = AT_MAP + LAYER_BYTES };

typedef struct smoke_map {
  gpu_format format;
  gpu_image *image;
  gpu_target *target; /* of MAP_LAYER */
  gpu_program *draw;
} smoke_map;

static smoke_map make_map(smoke *s, gpu_format format) {
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  smoke_map map = {.format = format, .draw = format == GPU_FORMAT_D16_UNORM ? s->depth16 : s->depth};
  map.image = make_image(s, (gpu_image_info){"map", format, usage, SIZE, SIZE, MAP_LAYERS, true, 1});
  CHECK(s, s->gpu->image_bytes(map.image) >= MAP_LAYERS * SIZE * SIZE * gpu_format_bytes(format), "too few bytes");
  map.target = make_target(s, (gpu_target_info){.name = "map", .depth = map.image, .depth_layer = MAP_LAYER});
  return map;
}

static void free_map(smoke *s, const smoke_map *map) {
  s->gpu->target_destroy(s->device, map->target);
  s->gpu->image_destroy(s->device, map->image);
}

static gpu_bindings *bind_map(smoke *s, const gpu_program *program, const smoke_map *map) {
  gpu_buffer *upload = s->slots[0].upload;
  gpu_bindings *bindings = NULL;
  const csm_result result = s->gpu->bindings_create(
      s->device,
      &(gpu_bindings_info){.name = "map", .program = program, .constants = {upload, upload}, .textures = {map->image}},
      &bindings);
  CHECK(s, result == CSM_SUCCESS && bindings, "bindings: %d", result);
  return bindings;
}

/* Records the map, drawn, then a pass over a whole target that reads it. */
static void record_read(smoke *s, const smoke_map *map, const quad *quads, uint32_t count, gpu_target *target,
                        gpu_program *program, gpu_bindings *bindings, const float constants[4]) {
  char *upload = s->gpu->buffer_memory(s->slots[0].upload);
  for (uint32_t i = 0; i < count; i++)
    write_rows((float *)(upload + AT_ROWS) + i * 12, quads[i]);
  memcpy(upload + AT_WHICH, constants, 16);
  memcpy(upload + AT_SIZE, (const float[4]){1.0f / SIZE, 1.0f / SIZE}, 16);
  s->gpu->clear_depth(s->device, map->image, 1);
  draw_pass(s, map->target, map->draw, s->slots[0].upload, 0, count, 4);
  s->gpu->make_readable(s->device, map->image, NULL);
  s->gpu->pass_begin(s->device, &(gpu_pass_info){.target = target, .color_load = GPU_LOAD_DISCARD});
  s->gpu->pass_program(s->device, program);
  s->gpu->pass_bind(s->device, bindings, (const uint32_t[]){AT_WHICH, AT_SIZE});
  s->gpu->pass_draw(s->device, &(gpu_draw){.count = 3, .instance_count = 1});
  s->gpu->pass_end(s->device);
}

/* ---- comparisons ---- */

/* The map is `near` on the left and `far` on the right. */
static void check_compare(smoke *s, const smoke_map *map, bool reversed, float near, float far, float reference) {
  gpu_program *program = reversed ? s->compare_reversed : s->compare;
  gpu_bindings *bindings = bind_map(s, program, map);
  const quad sides[2] = {{0.5f, 1, -0.5f, 0, 0, near}, {0.5f, 1, 0.5f, 0, 0, far}};
  begin(s, 0);
  record_read(s, map, sides, 2, s->mask_target, program, bindings, (const float[4]){MAP_LAYER, reference});
  copy_layer(s, s->slots[0].readback, 0, s->mask, GPU_FORMAT_R8_UNORM, 0);
  end_and_wait(s, 0);
  const uint8_t *mask = s->gpu->buffer_memory(s->slots[0].readback);
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < SIZE * SIZE; i++) {
    const float texel = i % SIZE < SIZE / 2 ? near : far;
    wrong += mask[i] != ((reversed ? reference >= texel : reference <= texel) ? 255 : 0);
  }
  CHECK(s, wrong == 0, "%s, %u-byte texels, %g: %u pixels", reversed ? "reversed" : "as is",
        gpu_format_bytes(map->format), (double)reference, wrong);
  s->gpu->bindings_destroy(s->device, bindings);
}

/* Equal passes both ways; what a D16's unit is as a float is the device's to round, so there it is half a unit off. */
void test_compares(smoke *s) {
  const float exact[] = {0, 0.25f, 0.5f, 0.75f, 1};
  const float units[] = {0, 999.5f / 65535, 1000.5f / 65535, 49999.5f / 65535, 50000.5f / 65535, 1};
  const smoke_map map = make_map(s, GPU_FORMAT_D32_FLOAT), map16 = make_map(s, GPU_FORMAT_D16_UNORM);
  for (uint32_t reversed = 0; reversed < 2; reversed++) {
    for (uint32_t i = 0; i < sizeof exact / sizeof *exact; i++)
      check_compare(s, &map, reversed, 0.25f, 0.75f, exact[i]);
    for (uint32_t i = 0; i < sizeof units / sizeof *units; i++)
      check_compare(s, &map16, reversed, 1000 / 65535.0f, 50000 / 65535.0f, units[i]);
  }
  free_map(s, &map);
  free_map(s, &map16);
}

/* ---- pairs of floats ---- */

static float map_texel(const smoke_map *map, const void *texels, uint32_t x, uint32_t y) {
  const uint32_t i = y * SIZE + x;
  return map->format == GPU_FORMAT_D16_UNORM ? ((const uint16_t *)texels)[i] / 65535.0f : ((const float *)texels)[i];
}

/* How many pairs are not the least and the largest of four texels, scaled. `slack`: what a D16's float may be off. */
static uint32_t wrong_pairs(const smoke_map *map, const void *texels, const float *pairs, float scale, float slack) {
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < HALF * HALF; i++) {
    const uint32_t x = i % HALF * 2, y = i / HALF * 2;
    const float a = map_texel(map, texels, x, y), b = map_texel(map, texels, x + 1, y);
    const float c = map_texel(map, texels, x, y + 1), d = map_texel(map, texels, x + 1, y + 1);
    wrong += !(fabsf(pairs[2 * i] - scale * fminf(fminf(a, b), fminf(c, d))) <= slack);
    wrong += !(fabsf(pairs[2 * i + 1] - scale * fmaxf(fmaxf(a, b), fmaxf(c, d))) <= slack);
  }
  return wrong;
}

/* Beyond [0,1] and below 0, so that nothing but floats holds it; by a power of two, which loses no bits. */
static void check_pairs(smoke *s, const smoke_surface *pairs, gpu_program *program, gpu_format format) {
  const float scale = -4, slack = format == GPU_FORMAT_D16_UNORM ? 1e-6f : 0;
  const smoke_map map = make_map(s, format);
  gpu_bindings *bindings = bind_map(s, program, &map);
  gpu_buffer *readback = s->slots[0].readback;
  const quad quads[2] = {{1, 1, 0, 0, 0.25f, 0.5f}, {0.75f, 0.51f, 0.1f, 0.2f, -0.3f, 0.4f}};
  begin(s, 0);
  record_read(s, &map, quads, 2, pairs->target, program, bindings, (const float[4]){MAP_LAYER, scale});
  copy_layer(s, readback, AT_MAP, map.image, format, MAP_LAYER);
  s->gpu->copy_image(s->device, readback, 0, PAIR_ROW, pairs->image, &(gpu_region){.width = HALF, .height = HALF});
  s->gpu->copy_image(s->device, readback, AT_PIECE, 256, pairs->image, &(gpu_region){0, 9, 5, 30, 7, 0});
  end_and_wait(s, 0);
  const char *bytes = s->gpu->buffer_memory(readback);
  const uint32_t wrong = wrong_pairs(&map, bytes + AT_MAP, (const float *)bytes, scale, slack);
  CHECK(s, wrong == 0, "%u-byte texels: %u", gpu_format_bytes(format), wrong);
  for (uint32_t y = 0; y < 7; y++)
    CHECK(s, !memcmp(bytes + AT_PIECE + y * 256, bytes + (5 + y) * PAIR_ROW + 9 * 8, 30 * 8), "row %u", y);
  s->gpu->bindings_destroy(s->device, bindings);
  free_map(s, &map);
}

void test_pairs(smoke *s) {
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  gpu_program *program = make_program(s, screen_program("pairs", shader_pairs_ps, GPU_FORMAT_RG32_FLOAT));
  smoke_surface pairs = {.format = GPU_FORMAT_RG32_FLOAT};
  pairs.image = make_image(s, (gpu_image_info){"pairs", pairs.format, usage, HALF, HALF, 1, false, 1});
  pairs.target = make_target(s, (gpu_target_info){.name = "pairs", .color = pairs.image});
  check_pairs(s, &pairs, program, GPU_FORMAT_D32_FLOAT);
  check_pairs(s, &pairs, program, GPU_FORMAT_D16_UNORM);
  s->gpu->target_destroy(s->device, pairs.target);
  s->gpu->image_destroy(s->device, pairs.image);
  s->gpu->program_destroy(s->device, program);
}
