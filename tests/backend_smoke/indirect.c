/* indirect.c: arguments that the GPU writes itself, and vertices that a shader fetches. */
#include "smoke.h"

#include <string.h>

enum { ARGUMENTS_SIZE = 256, AT_DRAW = 32, AT_DISPATCH = 64 };

static gpu_program *arguments_program(smoke *s) {
  return scrap_program(s, (gpu_program_info){.name = "arguments",
                                             .compute = shader_arguments_cs,
                                             .constants_count = 1,
                                             .constants_sizes = {16},
                                             .store_buffer_count = 1});
}

/* A triangle over everything, whose corners lie in a structured buffer. */
void test_fetched_vertices(smoke *s) {
  const float corners[3][4] = {{-1, -1, 0.375f, 1}, {3, -1, 0.375f, 1}, {-1, 3, 0.375f, 1}};
  gpu_program *program = scrap_program(s, (gpu_program_info){.name = "fetched",
                                                             .vertex = shader_fetched_vs,
                                                             .buffer_count = 1,
                                                             .depth_format = GPU_FORMAT_D32_FLOAT,
                                                             .depth_compare = GPU_COMPARE_LESS});
  gpu_buffer *staging =
      scrap_buffer(s, (gpu_buffer_info){.name = "corners", .kind = GPU_BUFFER_UPLOAD, .size = sizeof corners});
  gpu_buffer *device =
      scrap_buffer(s, (gpu_buffer_info){"corners", GPU_BUFFER_DEVICE, sizeof corners, GPU_BUFFER_READ});
  gpu_bindings *bindings =
      scrap_bindings(s, (gpu_bindings_info){.name = "corners", .program = program, .buffers = {{device, 0, 0, 16}}});
  memcpy(gpu_buffer_memory(s->g, staging), corners, sizeof corners);
  begin(s, 0);
  gpu_copy_buffer(s->g, device, 0, staging, 0, sizeof corners);
  draw_screen(s, &(gpu_pass_info){.target = s->plain.target, .depth_load = GPU_LOAD_CLEAR, .clear_depth = 1}, program,
              bindings, 0);
  copy_layer(s, s->slots[0].readback, 0, s->plain.image, GPU_FORMAT_D32_FLOAT, 0);
  end_and_wait(s, 0);
  const float *depth = gpu_buffer_memory(s->g, s->slots[0].readback);
  CHECK(s, count_texels(depth, 0.375f) == SIZE * SIZE, "%g", (double)depth[0]);
  scrap_free(s);
}

/* Two of three quads are drawn by indices, then the first triangle of one without. */
static void draw_indirect(smoke *s, gpu_buffer *arguments) {
  gpu_buffer *rows = s->slots[0].upload;
  gpu_pass_begin(s->g, &(gpu_pass_info){.target = s->plain.target, .depth_load = GPU_LOAD_CLEAR, .clear_depth = 1});
  gpu_pass_program(s->g, s->depth);
  gpu_pass_draw(s->g, &(gpu_draw){.streams = {s->geometry, rows},
                                  .stream_offsets = {AT_VERTICES, AT_ROWS},
                                  .indices = s->geometry,
                                  .index_size = 2,
                                  .arguments = arguments});
  gpu_pass_draw(s->g, &(gpu_draw){.streams = {s->geometry, rows},
                                  .stream_offsets = {AT_VERTICES, AT_ROWS + 3 * 48},
                                  .arguments = arguments,
                                  .arguments_offset = AT_DRAW});
  gpu_pass_end(s->g);
}

/* A dispatch of as many groups as another wrote down. */
static gpu_buffer *dispatch_indirect(smoke *s, gpu_buffer *arguments, uint32_t offset) {
  gpu_program *program = scrap_program(s, (gpu_program_info){.name = "groups",
                                                             .compute = shader_buffers_cs,
                                                             .constants_count = 1,
                                                             .constants_sizes = {16},
                                                             .buffer_count = 2,
                                                             .texel_buffer_count = 1,
                                                             .store_buffer_count = 1});
  gpu_buffer *zeros =
      scrap_buffer(s, (gpu_buffer_info){"zeros", GPU_BUFFER_UPLOAD, 1024, GPU_BUFFER_READ | GPU_BUFFER_TEXELS});
  gpu_buffer *out =
      scrap_buffer(s, (gpu_buffer_info){"groups", GPU_BUFFER_DEVICE, 1024, GPU_BUFFER_READ | GPU_BUFFER_WRITE});
  gpu_bindings *bindings =
      scrap_bindings(s, (gpu_bindings_info){.name = "groups",
                                            .program = program,
                                            .constants = {s->slots[0].upload},
                                            .buffers = {{.buffer = zeros, .stride = 4}, {.buffer = zeros}},
                                            .texel_buffers = {zeros},
                                            .store_buffers = {{out, 0, 0, 4}}});
  memset(gpu_buffer_memory(s->g, zeros), 0, 1024);
  gpu_copy_buffer(s->g, out, 0, zeros, 0, 1024);
  gpu_dispatch(s->g, &(gpu_dispatch_info){.program = program,
                                          .bindings = bindings,
                                          .offsets = &offset,
                                          .arguments = arguments,
                                          .arguments_offset = AT_DISPATCH});
  return out;
}

void test_indirect(smoke *s) {
  const quad quads[4] = {{0.5f, 0.5f, -0.5f, 0.5f, 0, 0.25f},
                         {0.5f, 0.5f, 0.5f, 0.5f, 0, 0.5f},
                         {1, 1, 0, 0, 0, 0.125f},
                         {1, 1, 0, 0, 0, 0.75f}};
  if (!s->can.compute || !s->can.indirect)
    return;
  gpu_program *program = arguments_program(s);
  gpu_buffer *arguments = scrap_buffer(
      s, (gpu_buffer_info){"arguments", GPU_BUFFER_DEVICE, ARGUMENTS_SIZE, GPU_BUFFER_WRITE | GPU_BUFFER_INDIRECT});
  gpu_bindings *bindings = scrap_bindings(s, (gpu_bindings_info){.name = "arguments",
                                                                 .program = program,
                                                                 .constants = {s->slots[0].upload},
                                                                 .store_buffers = {{arguments, 0, 0, 4}}});
  begin(s, 0);
  for (uint32_t i = 0; i < 4; i++)
    write_rows((float *)gpu_buffer_memory(s->g, s->slots[0].upload) + i * 12, quads[i]);
  const uint32_t offset = put_constants(s, 0, (const float[4]){2, 3, 2, AT_U16 / 2});
  const uint32_t factor = put_constants(s, 1, (const float[4]){1});
  gpu_dispatch(s->g,
               &(gpu_dispatch_info){.program = program, .bindings = bindings, .offsets = &offset, .groups = {1, 1, 1}});
  draw_indirect(s, arguments);
  copy_layer(s, s->slots[0].readback, 0, s->plain.image, GPU_FORMAT_D32_FLOAT, 0);
  gpu_buffer *out = dispatch_indirect(s, arguments, factor);
  end_and_wait(s, 0);
  const float *depth = gpu_buffer_memory(s->g, s->slots[0].readback);
  const uint32_t quarter = SIZE / 2 * SIZE / 2;
  CHECK(s, count_texels(depth, 0.25f) == quarter && count_texels(depth, 0.5f) == quarter, "indices: %u, %u texels",
        count_texels(depth, 0.25f), count_texels(depth, 0.5f));
  /* The triangle below the diagonal: all of the lower right quarter, half of the lower left one. */
  const uint32_t left = count_texels(depth, 0.75f) - quarter;
  CHECK(s, left > quarter / 2 - SIZE && left < quarter / 2 + SIZE, "no indices: %u texels", left);
  CHECK(s, count_texels(depth, 0.125f) == 0, "an instance too many");
  const uint32_t *numbers = read_buffer(s, out, 1024);
  for (uint32_t i = 0; i < 256; i++)
    CHECK(s, numbers[i] == (i < 128 ? i : 0), "group %u, %u: %u", i / 64, i, numbers[i]);
  scrap_free(s);
}
