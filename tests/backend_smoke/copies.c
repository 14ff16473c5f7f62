/* copies.c: memory, and copies out of it. */
#include "smoke.h"

#include <string.h>

/* Many small buffers, freed and made anew in another order, keep apart; large ones too. */
void test_memory(smoke *s) {
  enum { COUNT = 96 };
  gpu_buffer *buffers[COUNT] = {NULL};
  uint64_t sizes[COUNT] = {0};
  for (uint32_t round = 0; round < 3; round++) {
    for (uint32_t i = 0; i < COUNT; i++) {
      const uint32_t k = (i * 37 + round * 11) % COUNT;
      if (round && k % 3 == round % 3)
        continue;
      s->gpu->buffer_destroy(s->device, buffers[k]);
      sizes[k] = 1 + (k * 7919 + round * 104729) % (k % 16 ? 300000 : 6000000);
      buffers[k] = make_buffer(s, "piece", k % 2 ? GPU_BUFFER_UPLOAD : GPU_BUFFER_READBACK, sizes[k]);
      memset(s->gpu->buffer_memory(buffers[k]), (int)k, sizes[k]);
    }
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
      const uint8_t *bytes = s->gpu->buffer_memory(buffers[i]);
      for (uint64_t b = 0; b < sizes[i]; b++)
        wrong += bytes[b] != i;
    }
    CHECK(s, wrong == 0, "round %u: %u bytes", round, wrong);
  }
  for (uint32_t i = 0; i < COUNT; i++)
    s->gpu->buffer_destroy(s->device, buffers[i]);
}

/* Copies in one recording that read and overwrite what copies before them wrote. */
void test_copies(smoke *s) {
  gpu_buffer *upload = make_buffer(s, "from", GPU_BUFFER_UPLOAD, 1024);
  gpu_buffer *middle = make_buffer(s, "middle", GPU_BUFFER_DEVICE, 1024);
  gpu_buffer *readback = make_buffer(s, "to", GPU_BUFFER_READBACK, 1024);
  uint8_t *bytes = s->gpu->buffer_memory(upload);
  for (uint32_t i = 0; i < 1024; i++)
    bytes[i] = (uint8_t)(i / 256);
  begin(s, 1);
  s->gpu->copy_buffer(s->device, middle, 0, upload, 0, 1024);
  s->gpu->copy_buffer(s->device, middle, 256, upload, 512, 256);
  s->gpu->copy_buffer(s->device, readback, 0, middle, 0, 1024);
  s->gpu->copy_buffer(s->device, middle, 0, upload, 256, 256);
  s->gpu->copy_buffer(s->device, readback, 768, middle, 0, 256);
  end_and_wait(s, 1);
  const uint8_t *read = s->gpu->buffer_memory(readback);
  const uint8_t expected[4] = {0, 2, 2, 1};
  for (uint32_t i = 0; i < 1024; i++)
    CHECK(s, read[i] == expected[i / 256], "byte %u: %u", i, read[i]);
  s->gpu->buffer_destroy(s->device, upload);
  s->gpu->buffer_destroy(s->device, middle);
  s->gpu->buffer_destroy(s->device, readback);
}

/* Vertices that each frame moves by copy_buffer while the frames before it are in flight. */
void test_updates(smoke *s) {
  gpu_buffer *vertices = scrap_buffer(
      s, (gpu_buffer_info){.name = "moving", .kind = GPU_BUFFER_DEVICE, .size = 48, .usage = GPU_BUFFER_READ});
  gpu_buffer *staging[SLOTS];
  for (uint32_t frame = 0; frame < SLOTS; frame++) {
    const smoke_slot *slot = &s->slots[frame];
    const float z = 0.25f + (float)frame / 8;
    const float corners[12] = {-1, -1, 0, 3, -1, 0, -1, 3, 0, -1, -1, 0};
    staging[frame] = scrap_buffer(s, (gpu_buffer_info){.name = "moves", .kind = GPU_BUFFER_UPLOAD, .size = 48});
    float *moved = gpu_buffer_memory(s->g, staging[frame]);
    for (uint32_t i = 0; i < 12; i++)
      moved[i] = i % 3 == 2 ? z : corners[i];
    begin(s, frame);
    const float rows[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    memcpy(gpu_buffer_memory(s->g, slot->upload), rows, sizeof rows);
    gpu_copy_buffer(s->g, vertices, 0, staging[frame], 0, 48);
    gpu_pass_begin(s->g, &(gpu_pass_info){.target = s->plain.target, .depth_load = GPU_LOAD_CLEAR, .clear_depth = 1});
    gpu_pass_program(s->g, s->depth);
    gpu_pass_draw(s->g, &(gpu_draw){.streams = {vertices, slot->upload}, .count = 3, .instance_count = 1});
    gpu_pass_end(s->g);
    copy_layer(s, slot->readback, 0, s->plain.image, GPU_FORMAT_D32_FLOAT, 0);
    end(s);
  }
  for (uint32_t frame = 0; frame < SLOTS; frame++) {
    const csm_result result = smoke_wait(s, frame);
    CHECK(s, result == CSM_SUCCESS, "wait: %d", result);
    const uint32_t count = count_texels(gpu_buffer_memory(s->g, s->slots[frame].readback), 0.25f + (float)frame / 8);
    CHECK(s, count == SIZE * SIZE, "frame %u: %u texels", frame, count);
  }
  scrap_free(s);
}

/* ---- regions ---- */

/* A piece of the mask lands where it should, and nothing else of the buffer is written. */
static void test_region(smoke *s, gpu_region from, uint64_t offset, uint32_t row_bytes) {
  const smoke_slot *slot = &s->slots[0];
  uint8_t *whole = s->gpu->buffer_memory(slot->readback);
  const uint32_t piece = MASK_BYTES, end_of_piece = piece + MASK_BYTES;
  memset(whole, 0xab, end_of_piece);
  begin(s, 0);
  copy_layer(s, slot->readback, 0, s->mask, GPU_FORMAT_R8_UNORM, 0);
  s->gpu->copy_image(s->device, slot->readback, piece + offset, row_bytes, s->mask, &from);
  end_and_wait(s, 0);
  uint32_t wrong = 0;
  for (uint32_t at = 0; at < MASK_BYTES; at++) {
    const uint64_t row = at < offset ? UINT64_MAX : (at - offset) / row_bytes, x = (at - offset) % row_bytes;
    const bool copied = row < from.height && x < from.width;
    wrong += whole[piece + at] != (copied ? whole[(from.y + row) * SIZE + from.x + x] : 0xab);
  }
  CHECK(s, wrong == 0, "%u x %u at %u, %u: %u bytes", from.width, from.height, from.x, from.y, wrong);
}

/* Draws what a comparison with a sloping map gives: a mask whose left part is black, under an edge that is not upright.
 */
static void draw_mask(smoke *s) {
  const smoke_slot *slot = &s->slots[0];
  const quad quads[2] = {{1, 0.5f, 0, 0.5f, 0.25f, 0.5f}, {1, 0.5f, 0, -0.5f, -0.5f, 0.5f}};
  begin(s, 0);
  char *upload = s->gpu->buffer_memory(slot->upload);
  for (uint32_t i = 0; i < 2; i++)
    write_rows((float *)upload + i * 12, quads[i]);
  memcpy(upload + AT_WHICH, (const float[4]){0, 0.5625f}, 16);
  memcpy(upload + AT_SIZE, (const float[4]){1.0f / SIZE, 1.0f / SIZE}, 16);
  s->gpu->clear_depth(s->device, s->map, 1);
  draw_pass(s, s->map_targets[0], s->depth, slot->upload, 0, 2, 4);
  s->gpu->make_readable(s->device, s->map, NULL);
  s->gpu->pass_begin(s->device, &(gpu_pass_info){.target = s->mask_target, .color_load = GPU_LOAD_DISCARD});
  s->gpu->pass_program(s->device, s->compare);
  s->gpu->pass_bind(s->device, slot->bindings, (const uint32_t[]){AT_WHICH, AT_SIZE});
  s->gpu->pass_draw(s->device, &(gpu_draw){.count = 3, .instance_count = 1});
  s->gpu->pass_end(s->device);
  end_and_wait(s, 0);
}

void test_regions(smoke *s) {
  draw_mask(s);
  test_region(s, (gpu_region){0, 0, 0, SIZE, SIZE, 0}, 0, SIZE);
  test_region(s, (gpu_region){0, 100, 120, 70, 33, 0}, 1024, 256);
  test_region(s, (gpu_region){0, 0, 127, SIZE, 2, 0}, 512, 512);
  test_region(s, (gpu_region){0, SIZE - 1, SIZE - 1, 1, 1, 0}, 0, 256);
}
