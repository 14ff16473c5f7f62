#include "techniques/maps/pages.h"

#include <string.h>

/* ---- rectangles ---- */

static uint32_t count_rects(const uint64_t slots[PLAN_CELLS]) {
  uint64_t left[PLAN_CELLS];
  uint32_t rect[4], count = 0;
  memcpy(left, slots, sizeof left);
  while (plan_next_slots(rect, left))
    ++count;
  return count;
}

bool page_copies_any(const plan_frame *plan) {
  uint64_t any = 0;
  for (uint32_t i = 0; i < plan->cascade_count && plan->pages; ++i)
    for (uint32_t row = 0; row < PLAN_CELLS; ++row)
      any |= plan->cascades[i].copied[row];
  return any != 0;
}

uint64_t page_copies_bytes(const plan_frame *plan) {
  uint64_t rects = 0;
  for (uint32_t i = 0; i < plan->cascade_count; ++i)
    rects += count_rects(plan->cascades[i].saved) + count_rects(plan->cascades[i].copied);
  return rects * sizeof(page_rect);
}

static page_rects write_rects(const ring_range *ring, uint64_t *at, const uint64_t slots[PLAN_CELLS], uint32_t layer) {
  const float slot = 2.0f / PLAN_CELLS; /* exact, as the corners are */
  uint64_t left[PLAN_CELLS];
  uint32_t rect[4];
  page_rects rects = {.offset = ring->offset + *at};
  memcpy(left, slots, sizeof left);
  for (; plan_next_slots(rect, left); *at += sizeof(page_rect), ++rects.count) {
    const page_rect out = {.corners = {(float)rect[0] * slot - 1.0f, 1.0f - (float)rect[1] * slot,
                                       (float)(rect[0] + rect[2]) * slot - 1.0f,
                                       1.0f - (float)(rect[1] + rect[3]) * slot},
                           .layer = (float)layer};
    memcpy((char *)ring->memory + *at, &out, sizeof out);
  }
  return rects;
}

void page_copies_write(page_copies *copies, const plan_frame *plan, const ring_range *ring) {
  uint64_t at = 0;
  *copies = (page_copies){.buffer = ring->buffer};
  for (uint32_t i = 0; i < plan->cascade_count; ++i) {
    copies->saved[i] = write_rects(ring, &at, plan->cascades[i].saved, i);
    copies->copied[i] = write_rects(ring, &at, plan->cascades[i].copied, i);
  }
}

/* ---- passes ---- */

/* Slots of a layer, in texels. */
static gpu_rect texels_of(const map_image *image, const uint32_t slots[4]) {
  const uint32_t page = image->layout.width / PLAN_CELLS;
  return (gpu_rect){slots[0] * page, slots[1] * page, slots[2] * page, slots[3] * page};
}

static void copy(const page_drawing *d, gpu_target *to, gpu_bindings *from, const page_rects *rects) {
  const gpu gpu = d->run->device->gpu;
  if (!rects->count)
    return;
  gpu_pass_begin(gpu, &(gpu_pass_info){.target = to});
  gpu_pass_program(gpu, d->image->second.copy);
  gpu_pass_bind(gpu, from, NULL);
  gpu_pass_draw(gpu, &(gpu_draw){.streams = {d->copies->buffer},
                                 .stream_offsets = {rects->offset},
                                 .count = 6, /* two triangles */
                                 .instance_count = rects->count});
  gpu_pass_end(gpu);
}

/* One rectangle after the other. */
static void clear(const page_drawing *d, gpu_target *target, const uint64_t slots[PLAN_CELLS]) {
  uint64_t left[PLAN_CELLS];
  uint32_t rect[4];
  memcpy(left, slots, sizeof left);
  while (plan_next_slots(rect, left)) {
    gpu_pass_begin(d->run->device->gpu, &(gpu_pass_info){.target = target,
                                                         .area = texels_of(d->image, rect),
                                                         .depth_load = GPU_LOAD_CLEAR,
                                                         .clear_depth = d->clear_depth});
    gpu_pass_end(d->run->device->gpu);
  }
}

/* Those that are drawn, not copied. */
static void clear_due(const page_drawing *d, uint32_t cascade) {
  const plan_cascade *of = &d->run->plan->cascades[cascade];
  uint64_t drawn[PLAN_CELLS];
  for (uint32_t row = 0; row < PLAN_CELLS; ++row)
    drawn[row] = of->due[row] & ~of->copied[row];
  clear(d, d->image->targets[cascade], drawn);
}

/*
 * A cascade's windows of a kind. What else lies in their rectangles is drawn over by some of what it holds, at the same
 * depths, so it stays as it is.
 */
static void draw_windows(const page_drawing *d, uint32_t cascade, plan_window_kind kind, gpu_target *target) {
  const gpu gpu = d->run->device->gpu;
  for (uint32_t i = 0; i < d->run->plan->window_count; ++i) {
    const plan_window *window = &d->run->plan->windows[i];
    if (window->cascade != cascade || window->kind != kind || !window->list.draw_count)
      continue;
    gpu_pass_begin(gpu, &(gpu_pass_info){.target = target,
                                         .area = texels_of(d->image, window->slots),
                                         .clip_space = {0, 0, d->image->layout.width, d->image->layout.height}});
    map_windows_draw(d->windows, d->run, d->casters, i);
    gpu_pass_end(gpu);
  }
}

/* A copy's shader sees all layers, so none is a target then. */
static void make_second(const page_drawing *d) {
  const gpu gpu = d->run->device->gpu;
  map_second *second = &d->image->second;
  const uint32_t count = d->run->plan->cascade_count;
  if (!second->written)
    gpu_clear_depth(gpu, second->image, d->clear_depth);
  second->written = true;
  for (uint32_t i = 0; i < count; ++i)
    copy(d, second->targets[i], second->from_maps, &d->copies->saved[i]);
  for (uint32_t i = 0; i < count; ++i) {
    clear(d, second->targets[i], d->run->plan->cascades[i].still_due);
    draw_windows(d, i, PLAN_WINDOW_STILL, second->targets[i]);
  }
  gpu_make_readable(gpu, second->image, NULL);
}

void pages_begin(const page_drawing *d) {
  if (page_copies_any(d->run->plan))
    make_second(d);
  if (!d->image->written) { /* nothing is kept, and to clear all of it is cheapest */
    gpu_clear_depth(d->run->device->gpu, d->image->image, d->clear_depth);
    return;
  }
  for (uint32_t i = 0; i < d->run->plan->cascade_count; ++i)
    clear_due(d, i);
}

void pages_draw(const page_drawing *d, uint32_t cascade) {
  gpu_target *target = d->image->targets[cascade];
  draw_windows(d, cascade, PLAN_WINDOW_ALL, target);
  copy(d, target, d->image->second.from_here, &d->copies->copied[cascade]);
  draw_windows(d, cascade, PLAN_WINDOW_MOVING, target);
}
