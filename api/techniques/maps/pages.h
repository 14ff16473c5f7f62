/* pages.h: draws maps that are made of pages. */
#ifndef TECHNIQUES_MAP_PAGES_H
#define TECHNIQUES_MAP_PAGES_H

#include "techniques/maps/map_image.h"
#include "techniques/maps/windows.h"

/* A rectangle that is copied, as the copy's program reads it. */
typedef struct page_rect {
  float corners[4]; /* in clip space: left, top, right, bottom */
  float layer;
} page_rect;

/* Rectangles of one map, in the ring. */
typedef struct page_rects {
  uint64_t offset;
  uint32_t count;
} page_rects;

/* Of the recording on its way: what is copied to the second layers, and from them. */
typedef struct page_copies {
  gpu_buffer *buffer;
  page_rects saved[CSM_MAX_CASCADES], copied[CSM_MAX_CASCADES];
} page_copies;

/* Whether the plan needs second layers. */
bool page_copies_any(const plan_frame *plan);
/* Bytes of the ring that the rectangles take. */
uint64_t page_copies_bytes(const plan_frame *plan);
void page_copies_write(page_copies *copies, const plan_frame *plan, const ring_range *ring);

/* What pages are drawn with. */
typedef struct page_drawing {
  const technique_run *run;
  map_image *image;
  const caster_programs *casters;
  const map_windows *windows;
  const page_copies *copies;
  float clear_depth;
} page_drawing;

/* Before any of a frame's pages are drawn: gives the second layers what they lack, and clears what is drawn. */
void pages_begin(const page_drawing *drawing);
void pages_draw(const page_drawing *drawing, uint32_t cascade);

#endif
