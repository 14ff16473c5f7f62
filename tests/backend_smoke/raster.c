/* raster.c: what the rasterizer does, in one pass at a time into images that shaders cannot read. */
#include "smoke.h"

#include <math.h>

void test_culling(smoke *s) {
  const quad front = {1, 1, 0, 0, 0, 0.5f}, back = {-1, 1, 0, 0, 0, 0.5f};
  const uint32_t all = SIZE * SIZE;
  CHECK(s, count_texels(draw_plain(s, s->depth, 1, &front, 1), 0.5f) == all, "not culled, front");
  CHECK(s, count_texels(draw_plain(s, s->depth, 1, &back, 1), 0.5f) == all, "not culled, back");
  CHECK(s, count_texels(draw_plain(s, s->depth_back, 1, &front, 1), 0.5f) == all, "back culled, front");
  CHECK(s, count_texels(draw_plain(s, s->depth_back, 1, &back, 1), 1) == all, "back culled, back");
  CHECK(s, count_texels(draw_plain(s, s->depth_front, 1, &front, 1), 1) == all, "front culled, front");
  CHECK(s, count_texels(draw_plain(s, s->depth_front, 1, &back, 1), 0.5f) == all, "front culled, back");
  const gpu_rect part = {8, 16, 64, 32};
  const uint32_t some = part.width * part.height;
  CHECK(s, count_texels(draw_surface(s, &s->plain, s->depth_back, 1, &front, 1, &part), 0.5f) == some, "in an area");
  CHECK(s, count_texels(draw_surface(s, &s->plain, s->depth_front, 1, &front, 1, &part), 1) == all, "in an area");
}

/* Depth outside [0,1] is clamped, or clipped where the program says so, and instances follow each other in their
 * stream. */
void test_clamping(smoke *s) {
  const quad nearer = {1, 1, 0, 0, 0, -3}, farther = {1, 1, 0, 0, 0, 7};
  CHECK(s, count_texels(draw_plain(s, s->depth, 1, &nearer, 1), 0) == SIZE * SIZE, "nearer than the near plane");
  CHECK(s, count_texels(draw_plain(s, s->depth_greater, 0, &farther, 1), 1) == SIZE * SIZE, "beyond the far plane");
  const quad steep = {1, 1, 0, 0, -1, 0.5f}; /* from 1.5 on the left to -0.5 on the right */
  const float *clipped = draw_plain(s, s->depth_clipped, 1, &steep, 1);
  CHECK(s, count_texels(clipped, 1) == SIZE * SIZE / 2, "clipped at both ends");
  const quad corners[] = {{0.25f, 0.25f, -0.75f, 0.75f, 0, 0.125f},
                          {0.25f, 0.25f, 0.75f, 0.75f, 0, 0.25f},
                          {0.25f, 0.25f, -0.75f, -0.75f, 0, 0.375f}};
  const float *depth = draw_plain(s, s->depth, 1, corners, 3);
  CHECK(s, depth[0] == 0.125f, "left top: %g", depth[0]);
  CHECK(s, depth[SIZE - 1] == 0.25f, "right top: %g", depth[SIZE - 1]);
  CHECK(s, depth[SIZE * (SIZE - 1)] == 0.375f, "left bottom: %g", depth[SIZE * (SIZE - 1)]);
  CHECK(s, depth[SIZE * SIZE - 1] == 1, "right bottom: %g", depth[SIZE * SIZE - 1]);
  for (uint32_t i = 0; i < 3; i++)
    CHECK(s, count_texels(depth, corners[i].z) == SIZE / 4 * SIZE / 4, "corner %u", i);
}

/* Depth is sampled at texel centres: a slope of 0.25 over x in [-1,1]. */
void test_slope(smoke *s) {
  const quad slope = {1, 1, 0, 0, 0.25f, 0.5f};
  const float *depth = draw_plain(s, s->depth, 1, &slope, 1);
  double worst = 0;
  for (uint32_t y = 0; y < SIZE; y++)
    for (uint32_t x = 0; x < SIZE; x++) {
      const double expected = 0.5 + 0.25 * ((x + 0.5) / SIZE * 2 - 1);
      worst = fmax(worst, fabs(depth[y * SIZE + x] - expected));
    }
  CHECK(s, worst <= 1.2e-7, "off by %g", worst);
}

/* ---- bias ---- */

/* The most that a surface's depth is off from slope * x + z + bias, x being the clip space's. */
static double worst_depth(const smoke_surface *surface, const void *texels, quad q, double bias) {
  double worst = 0;
  for (uint32_t i = 0; i < SIZE * SIZE; i++) {
    const double x = (i % SIZE + 0.5) / SIZE * 2 - 1;
    const double depth = surface->format == GPU_FORMAT_D16_UNORM ? ((const uint16_t *)texels)[i] / 65535.0
                                                                 : (double)((const float *)texels)[i];
    worst = fmax(worst, fabs(depth - ((double)q.slope * x + (double)q.z + bias)));
  }
  return worst;
}

static void check_bias(smoke *s, const smoke_surface *surface, gpu_raster_bias bias, quad q, double expected,
                       double tolerance) {
  gpu_program_info info = depth_program(surface->format);
  info.raster_bias = bias;
  gpu_program *program = make_program(s, info);
  const double worst = worst_depth(surface, draw_surface(s, surface, program, 1, &q, 1, NULL), q, expected);
  CHECK(s, worst <= tolerance, "%d + %g, at most %g: off by %g", bias.constant, (double)bias.slope, (double)bias.clamp,
        worst);
  s->gpu->program_destroy(s->device, program);
}

/* What a constant of 1 adds to a D16, in its units: Vulkan lets it be two. */
static double unit_bias(smoke *s) {
  gpu_program_info info = depth_program(GPU_FORMAT_D16_UNORM);
  info.raster_bias.constant = 1;
  gpu_program *program = make_program(s, info);
  const quad flat = {1, 1, 0, 0, 0, 1000 / 65535.0f};
  const int added = *(const uint16_t *)draw_surface(s, &s->plain16, program, 1, &flat, 1, NULL) - 1000;
  CHECK(s, added == 1 || added == 2, "%d units", added);
  s->gpu->program_destroy(s->device, program);
  return added / 65535.0;
}

/* A constant is in units of a D16, or of the last place of a D32: exact. A slope of 0.25 over half of SIZE texels is
   m = 2^-9 from one to the next. */
void test_bias(smoke *s) {
  const smoke_surface *d32 = &s->plain, *d16 = &s->plain16;
  const quad half = {1, 1, 0, 0, 0, 0.5f}, quarter = {1, 1, 0, 0, 0, 0.25f}, slope = {1, 1, 0, 0, 0.25f, 0.5f};
  const quad unit = {1, 1, 0, 0, 0, 1000 / 65535.0f};
  const double last = 0x1p-24, m = 0x1p-9, rounded = 1.2e-7, half_unit = 0.501 / 65535;
  check_bias(s, d32, (gpu_raster_bias){.constant = 5}, half, 5 * last, 0);
  check_bias(s, d32, (gpu_raster_bias){.constant = -3}, half, -3 * last, 0);
  check_bias(s, d32, (gpu_raster_bias){.constant = 1000}, quarter, 500 * last, 0);
  check_bias(s, d16, (gpu_raster_bias){.constant = 7}, unit, 7 * unit_bias(s), 1e-9);
  check_bias(s, d16, (gpu_raster_bias){.constant = -7}, unit, -7 * unit_bias(s), 1e-9);
  check_bias(s, d32, (gpu_raster_bias){.slope = 2}, half, 0, 0);
  check_bias(s, d32, (gpu_raster_bias){.slope = 2}, slope, 2 * m, rounded);
  check_bias(s, d32, (gpu_raster_bias){.slope = -2}, slope, -2 * m, rounded);
  check_bias(s, d32, (gpu_raster_bias){.constant = 4, .slope = 2}, slope, 2 * m + 4 * last, rounded);
  check_bias(s, d16, (gpu_raster_bias){.slope = 2}, slope, 2 * m, half_unit);
  if (!s->can.bias_clamp)
    return;
  check_bias(s, d32, (gpu_raster_bias){.slope = 2, .clamp = 0x1p-10f}, slope, m / 2, rounded);
  check_bias(s, d32, (gpu_raster_bias){.slope = -2, .clamp = -0x1p-10f}, slope, -m / 2, rounded);
  check_bias(s, d32, (gpu_raster_bias){.slope = 2, .clamp = 0.5f}, slope, 2 * m, rounded);
}

/* ---- areas ---- */

static bool lies_in(const gpu_rect *area, uint32_t x, uint32_t y) {
  return x >= area->x && x < area->x + area->width && y >= area->y && y < area->y + area->height;
}

/* A sloping quad over the upper half of an area's clip space, and far beyond its left and right. */
static void test_one_area(smoke *s, gpu_rect area) {
  const quad upper = {2, 0.5f, 0, 0.5f, 0.25f, 0.5f};
  const float *depth = draw_surface(s, &s->plain, s->depth, 1, &upper, 1, &area);
  uint32_t outside = 0;
  double worst = 0;
  for (uint32_t y = 0; y < SIZE; y++)
    for (uint32_t x = 0; x < SIZE; x++) {
      const bool drawn = lies_in(&area, x, y) && y - area.y < area.height / 2;
      const double across = (x - area.x + 0.5) / area.width * 2 - 1;
      const double expected = drawn ? 0.5 + 0.125 * across : 1;
      outside += !drawn && depth[y * SIZE + x] != 1;
      worst = fmax(worst, fabs((double)depth[y * SIZE + x] - expected));
    }
  CHECK(s, outside == 0, "area %u, %u: %u texels outside", area.x, area.y, outside);
  CHECK(s, worst <= 1.2e-7, "area %u, %u: off by %g", area.x, area.y, worst);
}

/* One area after another in one pass, and the whole target again in the next. */
static void test_successive_areas(smoke *s) {
  const smoke_slot *slot = &s->slots[0];
  const gpu_rect areas[2] = {{3, 5, 100, 40}, {120, 60, 31, 77}};
  const quad all[3] = {{1, 1, 0, 0, 0, 0.25f}, {1, 1, 0, 0, 0, 0.5f}, {1, 1, 0, 0, 0, 0.75f}};
  begin(s, 0);
  float *rows = s->gpu->buffer_memory(slot->upload);
  for (uint32_t i = 0; i < 3; i++)
    write_rows(rows + i * 12, all[i]);
  s->gpu->clear_depth(s->device, s->plain.image, 1);
  s->gpu->pass_begin(s->device, &(gpu_pass_info){.target = s->plain.target});
  s->gpu->pass_program(s->device, s->depth);
  for (uint32_t i = 0; i < 2; i++) {
    s->gpu->pass_area(s->device, &areas[i]);
    draw_quads(s, slot->upload, i, 1, 4);
  }
  s->gpu->pass_end(s->device);
  draw_pass(s, s->plain.target, s->depth, slot->upload, 2, 1, 4);
  copy_layer(s, slot->readback, 0, s->plain.image, GPU_FORMAT_D32_FLOAT, 0);
  end_and_wait(s, 0);
  const float *depth = s->gpu->buffer_memory(slot->readback);
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < SIZE * SIZE; i++) {
    const uint32_t x = i % SIZE, y = i / SIZE;
    wrong += depth[i] != (lies_in(&areas[0], x, y) ? 0.25f : lies_in(&areas[1], x, y) ? 0.5f : 0.75f);
  }
  CHECK(s, wrong == 0, "%u texels", wrong);
}

void test_areas(smoke *s) {
  test_one_area(s, (gpu_rect){37, 50, 100, 62});
  test_one_area(s, (gpu_rect){0, 0, SIZE, SIZE});
  test_one_area(s, (gpu_rect){SIZE - 1, SIZE - 2, 1, 2});
  test_successive_areas(s);
}
