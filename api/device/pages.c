#include "device/pages.h"

enum { page_smallest = 8 << 20 };

static csm_result page_create(device *device, uint64_t size, page **out) {
  page *made = host_allocate(device->host, sizeof *made);
  page_piece *whole = made ? host_allocate(device->host, sizeof *whole) : NULL;
  csm_result result = CSM_ERROR_OUT_OF_MEMORY;
  if (!whole)
    goto fail;
  made->size = size > page_smallest ? size : page_smallest;
  result = device_buffer(device, &(gpu_buffer_info){.name = "geometry", .kind = GPU_BUFFER_DEVICE, .size = made->size},
                         &made->buffer);
  if (result)
    goto fail;
  *whole = (page_piece){.page = made, .size = made->size};
  made->free = whole;
  made->next = device->geometry.pages;
  device->geometry.pages = made;
  *out = made;
  return CSM_SUCCESS;
fail:
  host_release(device->host, whole);
  host_release(device->host, made);
  return result;
}

static page_piece **find_free(page *page, uint64_t size) {
  page_piece **link = &page->free;
  while (*link && (*link)->size < size)
    link = &(*link)->next;
  return link;
}

csm_result page_take(device *device, page *from, uint64_t size, page_piece **out) {
  page_piece **link = find_free(from, size), *free = *link;
  *out = NULL;
  if (!free)
    return CSM_SUCCESS;
  page_piece *piece = host_allocate(device->host, sizeof *piece);
  if (!piece)
    return CSM_ERROR_OUT_OF_MEMORY;
  *piece = (page_piece){.page = from, .offset = free->offset, .size = size};
  free->offset += size;
  free->size -= size;
  if (!free->size) {
    *link = free->next;
    host_release(device->host, free);
  }
  *out = piece;
  return CSM_SUCCESS;
}

csm_result pages_take(device *device, uint64_t size, page_piece **out) {
  retire_collect(device); /* what is free by now serves before a new page */
  page *from = device->geometry.pages;
  while (from && !*find_free(from, size))
    from = from->next;
  const csm_result result = from ? CSM_SUCCESS : page_create(device, size, &from);
  return result ? result : page_take(device, from, size, out);
}

/* Makes the piece that follows a part of this one where the two touch. */
static void join(device *device, page_piece *piece) {
  page_piece *next = piece->next;
  if (!next || piece->offset + piece->size != next->offset)
    return;
  piece->size += next->size;
  piece->next = next->next;
  host_release(device->host, next);
}

void pages_give_back(device *device, page_piece *piece) {
  page_piece *before = NULL;
  page *to = piece->page;
  piece->next = to->free;
  while (piece->next && piece->next->offset < piece->offset) {
    before = piece->next;
    piece->next = before->next;
  }
  *(before ? &before->next : &to->free) = piece;
  join(device, piece);
  if (before)
    join(device, before);
}

void pages_free_empty(device *device) {
  page **link = &device->geometry.pages;
  while (*link) {
    page *page = *link;
    if (!page->free || page->free->size < page->size) {
      link = &page->next;
      continue;
    }
    *link = page->next;
    device_buffer_free(device, page->buffer, page->size);
    host_release(device->host, page->free);
    host_release(device->host, page);
  }
}
