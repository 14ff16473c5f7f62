/* scrap.c: objects of one test, and small recordings. */
#include "smoke.h"

#include <string.h>

/* ---- objects ---- */

static void keep(smoke *s, smoke_kind kind, void *object) {
  smoke_scrap *scrap = &s->scrap[kind];
  CHECK(s, scrap->count < SCRAP_MOST, "too much scrap");
  scrap->items[scrap->count++] = object;
}

gpu_buffer *scrap_buffer(smoke *s, gpu_buffer_info info) {
  gpu_buffer *buffer = NULL;
  const csm_result result = gpu_buffer_create(s->g, &info, &buffer);
  CHECK(s, result == CSM_SUCCESS && buffer, "%s: %d", info.name, result);
  keep(s, SCRAP_BUFFERS, buffer);
  return buffer;
}

gpu_image *scrap_image(smoke *s, gpu_image_info info) {
  gpu_image *image = make_image(s, info);
  keep(s, SCRAP_IMAGES, image);
  return image;
}

gpu_view *scrap_view(smoke *s, gpu_view_info info) {
  gpu_view *view = NULL;
  const csm_result result = gpu_view_create(s->g, &info, &view);
  CHECK(s, result == CSM_SUCCESS && view, "%s: %d", info.name, result);
  keep(s, SCRAP_VIEWS, view);
  return view;
}

gpu_target *scrap_target(smoke *s, gpu_target_info info) {
  gpu_target *target = make_target(s, info);
  keep(s, SCRAP_TARGETS, target);
  return target;
}

gpu_program *scrap_program(smoke *s, gpu_program_info info) {
  gpu_program *program = make_program(s, info);
  keep(s, SCRAP_PROGRAMS, program);
  return program;
}

gpu_bindings *scrap_bindings(smoke *s, gpu_bindings_info info) {
  gpu_bindings *bindings = NULL;
  const csm_result result = gpu_bindings_create(s->g, &info, &bindings);
  CHECK(s, result == CSM_SUCCESS && bindings, "%s: %d", info.name, result);
  keep(s, SCRAP_BINDINGS, bindings);
  return bindings;
}

static void destroy(smoke *s, smoke_kind kind, void *object) {
  switch (kind) {
  case SCRAP_BINDINGS:
    gpu_bindings_destroy(s->g, object);
    return;
  case SCRAP_PROGRAMS:
    gpu_program_destroy(s->g, object);
    return;
  case SCRAP_TARGETS:
    gpu_target_destroy(s->g, object);
    return;
  case SCRAP_VIEWS:
    gpu_view_destroy(s->g, object);
    return;
  case SCRAP_IMAGES:
    gpu_image_destroy(s->g, object);
    return;
  default:
    gpu_buffer_destroy(s->g, object);
  }
}

void scrap_free(smoke *s) {
  for (smoke_kind kind = SCRAP_BINDINGS; kind < SCRAP_KINDS; kind++)
    while (s->scrap[kind].count)
      destroy(s, kind, s->scrap[kind].items[--s->scrap[kind].count]);
}

/* ---- recordings ---- */

uint32_t put_constants(smoke *s, uint32_t index, const float values[4]) {
  const uint32_t offset = CONSTANTS_AT + index * BLOCK;
  memcpy((char *)gpu_buffer_memory(s->g, s->slots[0].upload) + offset, values, 4 * sizeof *values);
  return offset;
}

void draw_screen(smoke *s, const gpu_pass_info *pass, gpu_program *program, gpu_bindings *bindings, uint32_t offset) {
  gpu_pass_begin(s->g, pass);
  gpu_pass_program(s->g, program);
  gpu_pass_bind(s->g, bindings, &offset);
  gpu_pass_draw(s->g, &(gpu_draw){.count = 3, .instance_count = 1});
  gpu_pass_end(s->g);
}

const uint8_t *read_level(smoke *s, gpu_image *image, gpu_format format, gpu_region region, uint32_t *row_bytes) {
  gpu_buffer *readback = s->slots[0].readback;
  *row_bytes = (region.width * gpu_format_bytes(format) + 255) / 256 * 256;
  CHECK(s, (uint64_t)*row_bytes * region.height <= READBACK_SIZE, "more than can be read back");
  begin(s, 0);
  gpu_copy_image(s->g, readback, 0, *row_bytes, image, &region);
  end_and_wait(s, 0);
  return gpu_buffer_memory(s->g, readback);
}

const uint32_t *read_buffer(smoke *s, gpu_buffer *buffer, uint64_t size) {
  gpu_buffer *readback = s->slots[0].readback;
  begin(s, 0);
  gpu_copy_buffer(s->g, readback, 0, buffer, 0, size);
  end_and_wait(s, 0);
  return gpu_buffer_memory(s->g, readback);
}
