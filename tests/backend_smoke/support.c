/* support.c: objects to draw with, and drawing. */
#include "smoke.h"

#include <string.h>

/* ---- objects ---- */

/* Two triangles facing +z (counter-clockwise, y up) over [-1,1] squared, then the same with u16 indices. */
static const float quad_vertices[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
static const uint32_t quad_u32[6] = {0, 1, 2, 0, 2, 3};
static const uint16_t quad_u16[6] = {0, 1, 2, 0, 2, 3};

gpu_buffer *make_buffer(smoke *s, const char *name, gpu_buffer_kind kind, uint64_t size) {
  gpu_buffer *buffer = NULL;
  const csm_result result =
      s->gpu->buffer_create(s->device, &(gpu_buffer_info){.name = name, .kind = kind, .size = size}, &buffer);
  CHECK(s, result == CSM_SUCCESS && buffer, "%s: %d", name, result);
  return buffer;
}

gpu_image *make_image(smoke *s, gpu_image_info info) {
  gpu_image *image = NULL;
  const csm_result result = s->gpu->image_create(s->device, &info, &image);
  CHECK(s, result == CSM_SUCCESS && image, "%s: %d", info.name, result);
  return image;
}

gpu_target *make_target(smoke *s, gpu_target_info info) {
  gpu_target *target = NULL;
  const csm_result result = s->gpu->target_create(s->device, &info, &target);
  CHECK(s, result == CSM_SUCCESS && target, "%s: %d", info.name, result);
  return target;
}

gpu_program *make_program(smoke *s, gpu_program_info info) {
  gpu_program *program = NULL;
  const csm_result result = s->gpu->program_create(s->device, &info, &program);
  CHECK(s, result == CSM_SUCCESS && program, "%s: %d", info.name, result);
  return program;
}

gpu_program_info depth_program(gpu_format format) {
  return (gpu_program_info){.name = "depth",
                            .vertex = shader_depth_vs,
                            .stream_count = 2,
                            .streams = {{.stride = 12}, {.stride = 48, .per_instance = true}},
                            .attribute_count = 4,
                            .attributes = {{GPU_FORMAT_RGB32_FLOAT, 0, 0},
                                           {GPU_FORMAT_RGBA32_FLOAT, 1, 0},
                                           {GPU_FORMAT_RGBA32_FLOAT, 1, 16},
                                           {GPU_FORMAT_RGBA32_FLOAT, 1, 32}},
                            .depth_format = format,
                            .depth_compare = GPU_COMPARE_LESS};
}

gpu_program_info screen_program(const char *name, gpu_code pixel, gpu_format color) {
  return (gpu_program_info){.name = name,
                            .vertex = shader_screen_vs,
                            .pixel = pixel,
                            .constants_count = 2,
                            .constants_sizes = {16, 16},
                            .texture_count = 1,
                            .color_format = color};
}

static void make_programs(smoke *s) {
  gpu_program_info info = depth_program(GPU_FORMAT_D32_FLOAT);
  s->depth = make_program(s, info);
  info.cull = GPU_CULL_BACK;
  s->depth_back = make_program(s, info);
  info.cull = GPU_CULL_FRONT;
  s->depth_front = make_program(s, info);
  info.cull = GPU_CULL_NONE;
  info.depth_compare = GPU_COMPARE_GREATER;
  s->depth_greater = make_program(s, info);
  info.depth_compare = GPU_COMPARE_ALWAYS;
  s->depth_always = make_program(s, info);
  info.depth_compare = GPU_COMPARE_LESS;
  info.depth_clip = true;
  s->depth_clipped = make_program(s, info);
  s->depth16 = make_program(s, depth_program(GPU_FORMAT_D16_UNORM));
  info = screen_program("compare", shader_compare_ps, GPU_FORMAT_R8_UNORM);
  info.sampler_count = 1;
  info.samplers[0] = GPU_SAMPLER_COMPARE_LESS_EQUAL;
  s->compare = make_program(s, info);
  info.samplers[0] = GPU_SAMPLER_COMPARE_GREATER_EQUAL;
  s->compare_reversed = make_program(s, info);
}

static smoke_surface make_surface(smoke *s, const char *name, gpu_format format) {
  const uint32_t usage = GPU_IMAGE_TARGET | GPU_IMAGE_COPY_SOURCE;
  smoke_surface surface = {.format = format};
  surface.image = make_image(s, (gpu_image_info){name, format, usage, SIZE, SIZE, 1, false, 1});
  surface.target = make_target(s, (gpu_target_info){.name = name, .depth = surface.image});
  return surface;
}

static void free_surface(smoke *s, const smoke_surface *surface) {
  s->gpu->target_destroy(s->device, surface->target);
  s->gpu->image_destroy(s->device, surface->image);
}

void make_objects(smoke *s) {
  make_programs(s);
  const uint32_t all = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE;
  s->map = make_image(s, (gpu_image_info){"map", GPU_FORMAT_D32_FLOAT, all, SIZE, SIZE, LAYERS, true, 1});
  s->mask = make_image(s, (gpu_image_info){"mask", GPU_FORMAT_R8_UNORM, all, SIZE, SIZE, 1, false, 1});
  s->plain = make_surface(s, "plain", GPU_FORMAT_D32_FLOAT);
  s->plain16 = make_surface(s, "plain 16", GPU_FORMAT_D16_UNORM);
  CHECK(s, s->gpu->image_bytes(s->map) >= (uint64_t)LAYERS * LAYER_BYTES, "too few bytes");
  gpu_native_image native;
  s->gpu->image_native(s->device, s->map, &native);
  CHECK(s, native.image != 0, "no native handle");
  const bool samplers = native.sampler && native.sampler_reversed && native.sampler != native.sampler_reversed;
  CHECK(s, samplers == (s->gpu->api == GPU_API_VULKAN), "samplers %llx, %llx", (unsigned long long)native.sampler,
        (unsigned long long)native.sampler_reversed);
  for (uint32_t i = 0; i < LAYERS; i++)
    s->map_targets[i] = make_target(s, (gpu_target_info){.name = "map layer", .depth = s->map, .depth_layer = i});
  s->mask_target = make_target(s, (gpu_target_info){.name = "mask", .color = s->mask});

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

void free_objects(smoke *s) {
  const gpu_backend *gpu = s->gpu;
  for (uint32_t i = 0; i < SLOTS; i++) {
    gpu->bindings_destroy(s->device, s->slots[i].bindings);
    gpu->buffer_destroy(s->device, s->slots[i].upload);
    gpu->buffer_destroy(s->device, s->slots[i].readback);
  }
  free_surface(s, &s->plain);
  free_surface(s, &s->plain16);
  gpu->target_destroy(s->device, s->mask_target);
  for (uint32_t i = 0; i < LAYERS; i++)
    gpu->target_destroy(s->device, s->map_targets[i]);
  gpu->image_destroy(s->device, s->map);
  gpu->image_destroy(s->device, s->mask);
  gpu->image_destroy(s->device, NULL);
  gpu->buffer_destroy(s->device, s->geometry);
  gpu->buffer_destroy(s->device, s->staging);
  gpu_program *programs[] = {s->depth,   s->depth_back,   s->depth_front, s->depth_greater,    s->depth_clipped,
                             s->depth16, s->depth_always, s->compare,     s->compare_reversed, NULL};
  for (uint32_t i = 0; i < sizeof programs / sizeof *programs; i++)
    gpu->program_destroy(s->device, programs[i]);
}

/* ---- drawing ---- */

void write_rows(float *rows, quad q) {
  const float all[12] = {q.scale_x, 0, 0, q.x, 0, q.scale_y, 0, q.y, q.slope, 0, 0, q.z};
  memcpy(rows, all, sizeof all);
}

void draw_quads(smoke *s, gpu_buffer *rows, uint32_t first, uint32_t count, uint32_t index_size) {
  s->gpu->pass_draw(s->device, &(gpu_draw){.streams = {s->geometry, rows},
                                           .stream_offsets = {AT_VERTICES, AT_ROWS + first * 48},
                                           .indices = s->geometry,
                                           .index_offset = index_size == 2 ? AT_U16 : AT_U32,
                                           .index_size = index_size,
                                           .count = 6,
                                           .instance_count = count});
}

void draw_pass(smoke *s, gpu_target *target, gpu_program *program, gpu_buffer *rows, uint32_t first, uint32_t count,
               uint32_t index_size) {
  s->gpu->pass_begin(s->device, &(gpu_pass_info){.target = target});
  s->gpu->pass_program(s->device, program);
  draw_quads(s, rows, first, count, index_size);
  s->gpu->pass_end(s->device);
}

void begin(smoke *s, uint32_t slot) {
  const gpu_record_info info = {.slot = slot, .first = true, .native = smoke_begin(s)};
  const csm_result result = s->gpu->begin(s->device, &info);
  CHECK(s, result == CSM_SUCCESS, "begin: %d", result);
}

void end(smoke *s) {
  const csm_result result = s->gpu->end(s->device);
  CHECK(s, result == CSM_SUCCESS, "end: %d", result);
  smoke_end(s);
}

void end_and_wait(smoke *s, uint32_t slot) {
  end(s);
  const csm_result result = smoke_wait(s, slot);
  CHECK(s, result == CSM_SUCCESS, "wait: %d", result);
}

void copy_layer(smoke *s, gpu_buffer *to, uint64_t offset, gpu_image *image, gpu_format format, uint32_t layer) {
  s->gpu->copy_image(s->device, to, offset, SIZE * gpu_format_bytes(format), image,
                     &(gpu_region){.layer = layer, .width = SIZE, .height = SIZE});
}

const void *draw_surface(smoke *s, const smoke_surface *surface, gpu_program *program, float clear, const quad *quads,
                         uint32_t count, const gpu_rect *area) {
  const smoke_slot *slot = &s->slots[0];
  begin(s, 0);
  float *rows = s->gpu->buffer_memory(slot->upload);
  for (uint32_t i = 0; i < count; i++)
    write_rows(rows + i * 12, quads[i]);
  s->gpu->clear_depth(s->device, surface->image, clear);
  s->gpu->pass_begin(s->device, &(gpu_pass_info){.target = surface->target});
  if (area)
    s->gpu->pass_area(s->device, area);
  s->gpu->pass_program(s->device, program);
  draw_quads(s, slot->upload, 0, count, 4);
  s->gpu->pass_end(s->device);
  copy_layer(s, slot->readback, 0, surface->image, surface->format, 0);
  end_and_wait(s, 0);
  return s->gpu->buffer_memory(slot->readback);
}

const float *draw_plain(smoke *s, gpu_program *program, float clear, const quad *quads, uint32_t count) {
  return draw_surface(s, &s->plain, program, clear, quads, count, NULL);
}

uint32_t count_texels(const float *depth, float value) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < SIZE * SIZE; i++)
    count += depth[i] == value;
  return count;
}
