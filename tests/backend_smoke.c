/*
 * backend_smoke.c: one backend alone, through gpu.h, against results known by analysis.
 *
 *   backend_smoke BACKEND [DEVICE]
 *
 * BACKEND is a backend's library. Exits with 0 if all holds, with 1 and a list of what does not otherwise, with 3
 * without a device.
 */
#include "gpu.h"
#include "smoke_code.h"

#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
  SIZE = 256,
  LAYERS = 4,
  SLOTS = 3,
  FRAMES = 9,
  BLOCK = 256,
  ROW_BYTES = SIZE * 4,
  LAYER_BYTES = SIZE * ROW_BYTES
};

/* Where things lie in a slot's upload buffer */
enum { AT_ROWS = 0, AT_WHICH = 1024, AT_SIZE = AT_WHICH + LAYERS * BLOCK, UPLOAD_SIZE = AT_SIZE + BLOCK };
/* and in its readback buffer: depth layers, then a mask for each layer */
enum { AT_MASKS = LAYERS * LAYER_BYTES, MASK_BYTES = SIZE * SIZE, READBACK_SIZE = AT_MASKS + LAYERS * MASK_BYTES };

typedef struct smoke_slot {
  gpu_buffer *upload, *readback;
  gpu_bindings *bindings;
} smoke_slot;

typedef struct smoke {
  const gpu_backend *gpu;
  gpu_device *device;
  gpu_host host;
  uint32_t failures, messages;
  int64_t live_allocations;
  gpu_buffer *staging, *geometry;
  gpu_image *map, *mask, *plain;
  gpu_target *map_targets[LAYERS], *mask_target, *plain_target;
  gpu_program *depth, *depth_back, *depth_front, *depth_greater, *depth_clipped, *compare;
  smoke_slot slots[SLOTS];
} smoke;

#define CHECK(s, condition, ...)                                                                                       \
  do {                                                                                                                 \
    if (!(condition)) {                                                                                                \
      (s)->failures++;                                                                                                 \
      fprintf(stderr, "%s:%d: %s: ", __FILE__, __LINE__, #condition);                                                  \
      fprintf(stderr, __VA_ARGS__);                                                                                    \
      fputc('\n', stderr);                                                                                             \
    }                                                                                                                  \
  } while (0)

/* ---- the host's side ---- */

static void *CSM_CALL count_allocate(void *user, size_t size, size_t alignment) {
  ((smoke *)user)->live_allocations++;
  void *memory = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  return memory ? memset(memory, 0xcd, size) : NULL;
}

static void CSM_CALL count_release(void *user, void *memory) {
  ((smoke *)user)->live_allocations--;
  free(memory);
}

static void CSM_CALL count_message(void *user, int32_t level, const char *message) {
  if (level <= CSM_LOG_WARNING)
    ((smoke *)user)->messages++;
  fprintf(stderr, "log %d: %s\n", level, message);
}

/* ---- objects ---- */

/* Two triangles facing +z (counter-clockwise, y up) over [-1,1] squared, then the same with u16 indices. */
static const float quad_vertices[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
static const uint32_t quad_u32[6] = {0, 1, 2, 0, 2, 3};
static const uint16_t quad_u16[6] = {0, 1, 2, 0, 2, 3};
enum { AT_VERTICES = 256, AT_U32 = 512, AT_U16 = 768, GEOMETRY_SIZE = 1024 };

static gpu_buffer *make_buffer(smoke *s, const char *name, gpu_buffer_kind kind, uint64_t size) {
  gpu_buffer *buffer = NULL;
  const csm_result result =
      s->gpu->buffer_create(s->device, &(gpu_buffer_info){.name = name, .kind = kind, .size = size}, &buffer);
  CHECK(s, result == CSM_SUCCESS && buffer, "%s: %d", name, result);
  return buffer;
}

static gpu_image *make_image(smoke *s, gpu_image_info info) {
  gpu_image *image = NULL;
  const csm_result result = s->gpu->image_create(s->device, &info, &image);
  CHECK(s, result == CSM_SUCCESS && image, "%s: %d", info.name, result);
  return image;
}

static gpu_target *make_target(smoke *s, gpu_target_info info) {
  gpu_target *target = NULL;
  const csm_result result = s->gpu->target_create(s->device, &info, &target);
  CHECK(s, result == CSM_SUCCESS && target, "%s: %d", info.name, result);
  return target;
}

static gpu_program *make_program(smoke *s, gpu_program_info info) {
  gpu_program *program = NULL;
  const csm_result result = s->gpu->program_create(s->device, &info, &program);
  CHECK(s, result == CSM_SUCCESS && program, "%s: %d", info.name, result);
  return program;
}

static void make_programs(smoke *s) {
  gpu_program_info info = {.name = "depth",
                           .vertex = shader_depth_vs,
                           .stream_count = 2,
                           .streams = {{.stride = 12}, {.stride = 48, .per_instance = true}},
                           .attribute_count = 4,
                           .attributes = {{GPU_FORMAT_RGB32_FLOAT, 0, 0},
                                          {GPU_FORMAT_RGBA32_FLOAT, 1, 0},
                                          {GPU_FORMAT_RGBA32_FLOAT, 1, 16},
                                          {GPU_FORMAT_RGBA32_FLOAT, 1, 32}},
                           .depth_format = GPU_FORMAT_D32_FLOAT,
                           .depth_compare = GPU_COMPARE_LESS};
  s->depth = make_program(s, info);
  info.cull = GPU_CULL_BACK;
  s->depth_back = make_program(s, info);
  info.cull = GPU_CULL_FRONT;
  s->depth_front = make_program(s, info);
  info.cull = GPU_CULL_NONE;
  info.depth_compare = GPU_COMPARE_GREATER;
  s->depth_greater = make_program(s, info);
  info.depth_compare = GPU_COMPARE_LESS;
  info.depth_clip = true;
  s->depth_clipped = make_program(s, info);
  s->compare = make_program(s, (gpu_program_info){.name = "compare",
                                                  .vertex = shader_screen_vs,
                                                  .pixel = shader_compare_ps,
                                                  .constants_count = 2,
                                                  .constants_sizes = {16, 16},
                                                  .texture_count = 1,
                                                  .sampler_count = 1,
                                                  .samplers = {GPU_SAMPLER_COMPARE_LESS_EQUAL},
                                                  .color_format = GPU_FORMAT_R8_UNORM});
}

static void make_objects(smoke *s) {
  make_programs(s);
  const uint32_t all = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  s->map = make_image(s, (gpu_image_info){"map", GPU_FORMAT_D32_FLOAT, all, SIZE, SIZE, LAYERS, true});
  s->mask = make_image(s, (gpu_image_info){"mask", GPU_FORMAT_R8_UNORM, all, SIZE, SIZE, 1, false});
  s->plain = make_image(s, (gpu_image_info){"plain", GPU_FORMAT_D32_FLOAT, GPU_IMAGE_TARGET | GPU_IMAGE_COPY_SOURCE,
                                            SIZE, SIZE, 1, false});
  CHECK(s, s->gpu->image_bytes(s->map) >= (uint64_t)LAYERS * LAYER_BYTES, "too few bytes");
  gpu_native_image native;
  s->gpu->image_native(s->device, s->map, &native);
  CHECK(s, native.image != 0, "no native handle");
  for (uint32_t i = 0; i < LAYERS; i++)
    s->map_targets[i] = make_target(s, (gpu_target_info){.name = "map layer", .depth = s->map, .depth_layer = i});
  s->mask_target = make_target(s, (gpu_target_info){.name = "mask", .color = s->mask});
  s->plain_target = make_target(s, (gpu_target_info){.name = "plain", .depth = s->plain});

  s->staging = make_buffer(s, "staging", GPU_BUFFER_UPLOAD, GEOMETRY_SIZE);
  s->geometry = make_buffer(s, "geometry", GPU_BUFFER_DEVICE, GEOMETRY_SIZE);
  char *staging = s->gpu->buffer_memory(s->staging);
  memcpy(staging + AT_VERTICES, quad_vertices, sizeof quad_vertices);
  memcpy(staging + AT_U32, quad_u32, sizeof quad_u32);
  memcpy(staging + AT_U16, quad_u16, sizeof quad_u16);
  for (uint32_t i = 0; i < SLOTS; i++) {
    smoke_slot *slot = &s->slots[i];
    slot->upload = make_buffer(s, "upload", GPU_BUFFER_UPLOAD, UPLOAD_SIZE);
    slot->readback = make_buffer(s, "readback", GPU_BUFFER_READBACK, READBACK_SIZE);
    const csm_result result = s->gpu->bindings_create(
        s->device,
        &(gpu_bindings_info){
            .name = "compare", .program = s->compare, .constants = {slot->upload, slot->upload}, .textures = {s->map}},
        &slot->bindings);
    CHECK(s, result == CSM_SUCCESS && slot->bindings, "bindings: %d", result);
  }
}

static void free_objects(smoke *s) {
  const gpu_backend *gpu = s->gpu;
  for (uint32_t i = 0; i < SLOTS; i++) {
    gpu->bindings_destroy(s->device, s->slots[i].bindings);
    gpu->buffer_destroy(s->device, s->slots[i].upload);
    gpu->buffer_destroy(s->device, s->slots[i].readback);
  }
  gpu->target_destroy(s->device, s->plain_target);
  gpu->target_destroy(s->device, s->mask_target);
  for (uint32_t i = 0; i < LAYERS; i++)
    gpu->target_destroy(s->device, s->map_targets[i]);
  gpu->image_destroy(s->device, s->map);
  gpu->image_destroy(s->device, s->mask);
  gpu->image_destroy(s->device, s->plain);
  gpu->image_destroy(s->device, NULL);
  gpu->buffer_destroy(s->device, s->geometry);
  gpu->buffer_destroy(s->device, s->staging);
  gpu_program *programs[] = {s->depth,   s->depth_back, s->depth_front, s->depth_greater, s->depth_clipped,
                             s->compare, NULL};
  for (uint32_t i = 0; i < sizeof programs / sizeof *programs; i++)
    gpu->program_destroy(s->device, programs[i]);
}

/* ---- drawing ---- */

/* A scaled and moved quad whose depth is slope * x + z, x being the quad's own. */
typedef struct quad {
  float scale_x, scale_y, x, y, slope, z;
} quad;

static void write_rows(float *rows, quad q) {
  const float all[12] = {q.scale_x, 0, 0, q.x, 0, q.scale_y, 0, q.y, q.slope, 0, 0, q.z};
  memcpy(rows, all, sizeof all);
}

static void draw_quads(smoke *s, gpu_buffer *rows, uint32_t first, uint32_t count, uint32_t index_size) {
  s->gpu->pass_draw(s->device, &(gpu_draw){.streams = {s->geometry, rows},
                                           .stream_offsets = {AT_VERTICES, AT_ROWS + first * 48},
                                           .indices = s->geometry,
                                           .index_offset = index_size == 2 ? AT_U16 : AT_U32,
                                           .index_size = index_size,
                                           .count = 6,
                                           .instance_count = count});
}

static void draw_pass(smoke *s, gpu_target *target, gpu_program *program, gpu_buffer *rows, uint32_t first,
                      uint32_t count, uint32_t index_size) {
  s->gpu->pass_begin(s->device, target);
  s->gpu->pass_program(s->device, program);
  draw_quads(s, rows, first, count, index_size);
  s->gpu->pass_end(s->device);
}

static void begin(smoke *s, uint32_t slot) {
  const csm_result result = s->gpu->begin(s->device, &(gpu_record_info){.slot = slot, .first = true});
  CHECK(s, result == CSM_SUCCESS, "begin: %d", result);
}

static void end(smoke *s) {
  const csm_result result = s->gpu->end(s->device);
  CHECK(s, result == CSM_SUCCESS, "end: %d", result);
}

static void end_and_wait(smoke *s, uint32_t slot) {
  end(s);
  const csm_result result = s->gpu->wait(s->device, slot);
  CHECK(s, result == CSM_SUCCESS, "wait: %d", result);
}

/* ---- frames in flight ---- */

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
  gpu->make_readable(s->device, s->map);
  for (uint32_t i = 0; i < LAYERS; i++) {
    gpu->pass_begin(s->device, s->mask_target);
    gpu->pass_program(s->device, s->compare);
    const uint32_t offsets[] = {AT_WHICH + i * BLOCK, AT_SIZE};
    gpu->pass_bind(s->device, slot->bindings, offsets);
    gpu->pass_draw(s->device, &(gpu_draw){.count = 3, .instance_count = 1});
    gpu->pass_end(s->device);
    gpu->copy_image(s->device, slot->readback, AT_MASKS + i * MASK_BYTES, SIZE, s->mask,
                    &(gpu_region){.width = SIZE, .height = SIZE});
  }
  gpu->timestamp(s->device, 2);
  for (uint32_t i = 0; i < LAYERS; i++)
    gpu->copy_image(s->device, slot->readback, i * LAYER_BYTES, ROW_BYTES, s->map,
                    &(gpu_region){.layer = i, .width = SIZE, .height = SIZE});
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
  csm_result result = s->gpu->wait(s->device, index);
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

static void test_frames(smoke *s) {
  for (uint32_t frame = 0; frame < FRAMES + SLOTS; frame++) {
    if (frame >= SLOTS)
      check_frame(s, frame - SLOTS);
    if (frame < FRAMES)
      record_frame(s, frame);
  }
}

/* ---- one pass at a time, into an image that shaders cannot read ---- */

static const float *draw_plain(smoke *s, gpu_program *program, float clear, const quad *quads, uint32_t count) {
  const smoke_slot *slot = &s->slots[0];
  begin(s, 0);
  float *rows = s->gpu->buffer_memory(slot->upload);
  for (uint32_t i = 0; i < count; i++)
    write_rows(rows + i * 12, quads[i]);
  s->gpu->clear_depth(s->device, s->plain, clear);
  draw_pass(s, s->plain_target, program, slot->upload, 0, count, 4);
  s->gpu->copy_image(s->device, slot->readback, 0, ROW_BYTES, s->plain, &(gpu_region){.width = SIZE, .height = SIZE});
  end_and_wait(s, 0);
  return s->gpu->buffer_memory(slot->readback);
}

static uint32_t count_texels(const float *depth, float value) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < SIZE * SIZE; i++)
    count += depth[i] == value;
  return count;
}

static void test_culling(smoke *s) {
  const quad front = {1, 1, 0, 0, 0, 0.5f}, back = {-1, 1, 0, 0, 0, 0.5f};
  const uint32_t all = SIZE * SIZE;
  CHECK(s, count_texels(draw_plain(s, s->depth, 1, &front, 1), 0.5f) == all, "not culled, front");
  CHECK(s, count_texels(draw_plain(s, s->depth, 1, &back, 1), 0.5f) == all, "not culled, back");
  CHECK(s, count_texels(draw_plain(s, s->depth_back, 1, &front, 1), 0.5f) == all, "back culled, front");
  CHECK(s, count_texels(draw_plain(s, s->depth_back, 1, &back, 1), 1) == all, "back culled, back");
  CHECK(s, count_texels(draw_plain(s, s->depth_front, 1, &front, 1), 1) == all, "front culled, front");
  CHECK(s, count_texels(draw_plain(s, s->depth_front, 1, &back, 1), 0.5f) == all, "front culled, back");
}

/* Depth outside [0,1] is clamped, or clipped where the program says so, and instances follow each other in their
 * stream. */
static void test_clamping(smoke *s) {
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
static void test_slope(smoke *s) {
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

/* ---- memory ---- */

/* Many small buffers, freed and made anew in another order, keep apart; large ones too. */
static void test_memory(smoke *s) {
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
static void test_copies(smoke *s) {
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

/* ---- opening ---- */

static void test_refusals(smoke *s) {
  char error[256] = "";
  gpu_device *device = NULL;
  gpu_open_info info = {
      .host = &s->host, .device_name = "no such device", .slots = SLOTS, .error = error, .error_size = sizeof error};
  csm_result result = s->gpu->open(&info, &device);
  CHECK(s, result == CSM_ERROR_NO_DEVICE && !device && error[0], "an unknown name: %d", result);
  error[0] = 0;
  info.device_name = NULL;
  info.native = &(uint32_t){0};
  result = s->gpu->open(&info, &device);
  CHECK(s, result == CSM_ERROR_STRUCT_SIZE && !device && error[0], "an engine's device without struct_size: %d",
        result);
}

static void check_info(smoke *s, const gpu_open_info *open) {
  gpu_device_info info, queried;
  memset(&info, 0, sizeof info);
  memset(&queried, 0, sizeof queried);
  s->gpu->describe(s->device, &info);
  CHECK(s, s->gpu->query(open, &queried) == CSM_SUCCESS, "query");
  CHECK(s, strcmp(info.name, queried.name) == 0 && info.max_image_size == queried.max_image_size, "%s, %s", info.name,
        queried.name);
  CHECK(s, info.name[0] && info.driver[0] && info.required && info.optional, "texts");
  CHECK(s, info.max_image_size >= 4096 && info.max_image_layers >= 256, "%u, %u", info.max_image_size,
        info.max_image_layers);
  CHECK(s, info.max_allocation_size >= 1 << 27 && info.max_allocation_size <= info.memory_size, "%llu of %llu",
        (unsigned long long)info.max_allocation_size, (unsigned long long)info.memory_size);
  CHECK(s, info.max_buffer_size >= 1 << 27, "%llu", (unsigned long long)info.max_buffer_size);
  printf("%s: %s; %s; images to %u, %u layers; allocations to %.2f GiB of %.2f\n", s->gpu->name, info.name, info.driver,
         info.max_image_size, info.max_image_layers, (double)info.max_allocation_size / (1 << 30),
         (double)info.memory_size / (1 << 30));
}

static bool load(smoke *s, const char *path) {
  void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
  void *symbol = library ? dlsym(library, GPU_HANDSHAKE_SYMBOL) : NULL;
  CHECK(s, symbol, "%s", dlerror());
  if (!symbol)
    return false;
  gpu_handshake_function handshake;
  memcpy(&handshake, &symbol, sizeof symbol);
  gpu_handshake hello = {.front_oldest = GPU_INTERFACE_VERSION + 1, .front_newest = GPU_INTERFACE_VERSION + 2};
  handshake(&hello);
  CHECK(s, !hello.backend && hello.backend_oldest <= hello.backend_newest, "no common version");
  hello = (gpu_handshake){.front_oldest = GPU_INTERFACE_VERSION, .front_newest = GPU_INTERFACE_VERSION};
  handshake(&hello);
  CHECK(s, hello.backend, "versions %u to %u", hello.backend_oldest, hello.backend_newest);
  s->gpu = hello.backend;
  return hello.backend;
}

int main(int count, char **arguments) {
  if (count < 2) {
    fprintf(stderr, "usage: backend_smoke BACKEND [DEVICE]\n");
    return 2;
  }
  smoke s = {0};
  s.host = (gpu_host){.user = &s, .allocate = count_allocate, .release = count_release, .log = count_message};
  if (!load(&s, arguments[1]))
    return 1;
  char error[256] = "";
  const gpu_open_info info = {.host = &s.host,
                              .device_name = count > 2 ? arguments[2] : NULL,
                              .validate = true,
                              .slots = SLOTS,
                              .error = error,
                              .error_size = sizeof error};
  const csm_result result = s.gpu->open(&info, &s.device);
  if (result != CSM_SUCCESS) {
    fprintf(stderr, "open: %d: %s\n", result, error);
    return result == CSM_ERROR_NO_DEVICE ? 3 : 1;
  }
  check_info(&s, &info);
  CHECK(&s, s.gpu->wait(s.device, 2) == CSM_SUCCESS, "a slot that was never used");
  make_objects(&s);
  if (s.failures)
    return 1;
  test_frames(&s);
  test_culling(&s);
  test_clamping(&s);
  test_slope(&s);
  test_memory(&s);
  test_copies(&s);
  free_objects(&s);
  s.gpu->close(s.device);
  CHECK(&s, s.messages == 0, "%u messages", s.messages);
  test_refusals(&s);
  CHECK(&s, s.live_allocations == 0, "%lld allocations are left", (long long)s.live_allocations);
  printf("%u failures\n", s.failures);
  return s.failures != 0;
}
