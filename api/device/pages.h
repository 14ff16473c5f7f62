/*
 * pages.h: pieces of large device buffers, for meshes: few buffers to bind, and few device allocations, of which there
 * is a limit.
 */
#ifndef DEVICE_PAGES_H
#define DEVICE_PAGES_H

#include "device/device.h"

/* A piece of a page that is taken, or one that is free. */
typedef struct page_piece {
  struct page_piece *next; /* free ones: by offset, never two that touch */
  struct page *page;
  uint64_t offset, size;
  uint32_t upload; /* in uploads, counted from 1; 0: none waits */
} page_piece;

/* Takes a piece of one page; *out is NULL if there is no room. Errors: OUT_OF_MEMORY. */
csm_result page_take(device *device, page *from, uint64_t size, page_piece **out);
/* Errors: those of device_buffer, OUT_OF_MEMORY. */
csm_result pages_take(device *device, uint64_t size, page_piece **out);
/* The GPU is done with it. */
void pages_give_back(device *device, page_piece *piece);
/* Frees pages of which every piece has been given back. */
void pages_free_empty(device *device);

#endif
