/* frames.c: frames in flight. */
#include "smoke.h"

#include <string.h>

/* The depth of a layer's first quad in a frame; exact in float, different for each. */
static float layer_depth(uint32_t frame, uint32_t layer) {
  return 0.25f + (float)(layer * FRAMES + frame) / 128;
}

/* In two pieces. */
static void upload_geometry(smoke *s) {
  s->gpu->copy_buffer(s->device, s->geometry, AT_VERTICES, s->staging, AT_VERTICES, AT_U32 - AT_VERTICES);
  s->gpu->copy_buffer(s->device, s->geometry, AT_U32, s->staging, AT_U32, GEOMETRY_SIZE - AT_U32);
}

/*
 * Each layer gets a quad over its upper half (clip y > 0), another pass adds one over its right half that lies nearer,
 * so depth is kept between passes, and loses where it lies behind. Then each layer is compared to a mask.
 */
static void record_frame(smoke *s, uint32_t frame) {
  const gpu_backend *gpu = s->gpu;
  const uint32_t index = frame % SLOTS;
  const smoke_slot *slot = &s->slots[index];
  begin(s, index);

  char *upload = gpu->buffer_memory(slot->upload);
  for (uint32_t i = 0; i < LAYERS; i++) {
    const float z = layer_depth(frame, i);
    write_rows((float *)(upload + AT_ROWS + (2 * i) * 48), (quad){1, 0.5f, 0, 0.5f, 0, z});
    write_rows((float *)(upload + AT_ROWS + (2 * i + 1) * 48),
               (quad){0.5f, 1, 0.5f, 0, 0, i % 2 ? z - 0.125f : z + 0.125f});
    const float which[4] = {(float)i, z, 0, 0};
    memcpy(upload + AT_WHICH + i * BLOCK, which, sizeof which);
  }
  const float size[4] = {1.0f / SIZE, 1.0f / SIZE, 0, 0};
  memcpy(upload + AT_SIZE, size, sizeof size);

  if (frame % 4 == 0) /* earlier frames still read it */
    upload_geometry(s);
  gpu->timestamp(s->device, 0);
  gpu->marker_begin(s->device, "maps");
  gpu->clear_depth(s->device, s->map, 1);
  for (uint32_t i = 0; i < LAYERS; i++)
    draw_pass(s, s->map_targets[i], s->depth, slot->upload, 2 * i, 1, i % 2 ? 2 : 4);
  for (uint32_t i = 0; i < LAYERS; i++)
    draw_pass(s, s->map_targets[i], s->depth, slot->upload, 2 * i + 1, 1, i % 2 ? 4 : 2);
  gpu->marker_end(s->device);
  if (frame % 4 == 2) /* this frame has just read it */
    upload_geometry(s);
  gpu->timestamp(s->device, 1);
  gpu->make_readable(s->device, s->map, NULL);
  for (uint32_t i = 0; i < LAYERS; i++) {
    gpu->pass_begin(s->device, &(gpu_pass_info){.target = s->mask_target, .color_load = GPU_LOAD_DISCARD});
    gpu->pass_program(s->device, s->compare);
    const uint32_t offsets[] = {AT_WHICH + i * BLOCK, AT_SIZE};
    gpu->pass_bind(s->device, slot->bindings, offsets);
    gpu->pass_draw(s->device, &(gpu_draw){.count = 3, .instance_count = 1});
    gpu->pass_end(s->device);
    copy_layer(s, slot->readback, AT_MASKS + i * MASK_BYTES, s->mask, GPU_FORMAT_R8_UNORM, 0);
  }
  gpu->timestamp(s->device, 2);
  for (uint32_t i = 0; i < LAYERS; i++)
    copy_layer(s, slot->readback, i * LAYER_BYTES, s->map, GPU_FORMAT_D32_FLOAT, i);
  end(s);
}

static float expected_depth(uint32_t frame, uint32_t layer, uint32_t x, uint32_t y) {
  const float z = layer_depth(frame, layer);
  const float first = y < SIZE / 2 ? z : 1;
  const float second = x >= SIZE / 2 ? layer % 2 ? z - 0.125f : z + 0.125f : 1;
  return first < second ? first : second;
}

static void check_layer(smoke *s, uint32_t frame, uint32_t layer, const char *readback) {
  const float *depth = (const float *)(readback + layer * LAYER_BYTES);
  const uint8_t *mask = (const uint8_t *)readback + AT_MASKS + layer * MASK_BYTES;
  uint32_t wrong_depth = 0, wrong_mask = 0;
  for (uint32_t y = 0; y < SIZE; y++)
    for (uint32_t x = 0; x < SIZE; x++) {
      const float expected = expected_depth(frame, layer, x, y);
      wrong_depth += depth[y * SIZE + x] != expected;
      wrong_mask += mask[y * SIZE + x] != (layer_depth(frame, layer) <= expected ? 255 : 0);
    }
  CHECK(s, wrong_depth == 0, "frame %u, layer %u: %u texels", frame, layer, wrong_depth);
  CHECK(s, wrong_mask == 0, "frame %u, layer %u: %u pixels", frame, layer, wrong_mask);
}

static void check_frame(smoke *s, uint32_t frame) {
  const uint32_t index = frame % SLOTS;
  csm_result result = smoke_wait(s, index);
  CHECK(s, result == CSM_SUCCESS, "wait: %d", result);
  uint64_t times[3] = {0};
  result = s->gpu->timestamps(s->device, index, 0, 3, times);
  CHECK(s, result == CSM_SUCCESS, "timestamps: %d", result);
  CHECK(s, times[0] < times[1] && times[1] < times[2], "frame %u: %llu %llu %llu ns", frame,
        (unsigned long long)times[0], (unsigned long long)times[1], (unsigned long long)times[2]);
  CHECK(s, times[2] - times[0] < 60000000000ull, "no nanoseconds");
  for (uint32_t i = 0; i < LAYERS; i++)
    check_layer(s, frame, i, s->gpu->buffer_memory(s->slots[index].readback));
}

void test_frames(smoke *s) {
  for (uint32_t frame = 0; frame < FRAMES + SLOTS; frame++) {
    if (frame >= SLOTS)
      check_frame(s, frame - SLOTS);
    if (frame < FRAMES)
      record_frame(s, frame);
  }
}
