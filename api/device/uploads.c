#include "device/uploads.h"

enum { staging_smallest = 4 << 20, first_uploads = 64 };
/* Staging that was not wanted in so many frames goes. On an own device each recording is one. */
enum { idle_frames = 32 };

struct staging {
  retired retired;
  struct staging *next;
  gpu_buffer *buffer;
  uint64_t size, used;
  uint32_t uploads;    /* that lie in it and wait */
  uint64_t idle_since; /* in frames */
};

struct upload {
  page_piece *to;
  struct staging *from;
  uint64_t offset, size;
};

/* ---- staging ---- */

static void staging_free(device *device, struct staging *staging) {
  device_buffer_free(device, staging->buffer, staging->size);
  host_release(device->host, staging);
}

/* Meshes that change in every frame find staging that earlier frames are done with. */
static void staging_done(device *device, retired *self) {
  struct staging *staging = (struct staging *)self;
  uploads *uploads = &device->geometry.uploads;
  staging->used = 0;
  staging->uploads = 0;
  staging->idle_since = uploads->frames;
  staging->next = uploads->idle;
  uploads->idle = staging;
}

static void free_old_staging(device *device) {
  uploads *uploads = &device->geometry.uploads;
  struct staging **link = &uploads->idle;
  while (*link) {
    struct staging *staging = *link;
    if (uploads->frames - staging->idle_since <= idle_frames) {
      link = &staging->next;
      continue;
    }
    *link = staging->next;
    staging_free(device, staging);
  }
}

/* Takes the smallest idle staging that holds so much; NULL: there is none. */
static struct staging *take_idle(uploads *uploads, uint64_t size) {
  struct staging **best = NULL;
  for (struct staging **link = &uploads->idle; *link; link = &(*link)->next)
    if ((*link)->size >= size && (!best || (*link)->size < (*best)->size))
      best = link;
  struct staging *found = best ? *best : NULL;
  if (found)
    *best = found->next;
  return found;
}

static csm_result staging_create(device *device, uint64_t size, struct staging **out) {
  struct staging *staging = host_allocate(device->host, sizeof *staging);
  if (!staging)
    return CSM_ERROR_OUT_OF_MEMORY;
  staging->size = size > staging_smallest ? size : staging_smallest;
  const gpu_buffer_info info = {.name = "geometry staging", .kind = GPU_BUFFER_UPLOAD, .size = staging->size};
  const csm_result result = device_buffer(device, &info, &staging->buffer);
  if (result) {
    host_release(device->host, staging);
    return result;
  }
  *out = staging;
  return CSM_SUCCESS;
}

static csm_result staging_reserve(device *device, uint64_t size, struct staging **out) {
  uploads *uploads = &device->geometry.uploads;
  struct staging *staging = uploads->filling;
  if (!staging || staging->size - staging->used < size) {
    staging = take_idle(uploads, size);
    const csm_result result = staging ? CSM_SUCCESS : staging_create(device, size, &staging);
    if (result)
      return result;
    staging->next = uploads->filling;
    uploads->filling = staging;
  }
  *out = staging;
  return CSM_SUCCESS;
}

static void free_list(device *device, struct staging **list) {
  while (*list) {
    struct staging *first = *list;
    *list = first->next;
    staging_free(device, first);
  }
}

/* ---- uploads ---- */

static csm_result reserve_item(device *device) {
  uploads *uploads = &device->geometry.uploads;
  if (uploads->count < uploads->capacity)
    return CSM_SUCCESS;
  const uint32_t capacity = uploads->capacity ? uploads->capacity * 2 : first_uploads;
  struct upload *items =
      host_grown_copy(device->host, uploads->items, uploads->count, capacity, sizeof *uploads->items);
  if (!items)
    return CSM_ERROR_OUT_OF_MEMORY;
  host_release(device->host, uploads->items);
  uploads->items = items;
  uploads->capacity = capacity;
  return CSM_SUCCESS;
}

static void *upload_memory(device *device, const struct upload *upload) {
  return (char *)gpu_buffer_memory(device->gpu, upload->from->buffer) + upload->offset;
}

csm_result uploads_write(device *device, page_piece *to, uint64_t size, void **memory) {
  uploads *uploads = &device->geometry.uploads;
  if (!to->upload) {
    struct staging *from;
    csm_result result = reserve_item(device);
    if (!result)
      result = staging_reserve(device, size, &from);
    if (result)
      return result;
    uploads->items[uploads->count] = (struct upload){.to = to, .from = from, .offset = from->used, .size = size};
    to->upload = ++uploads->count;
    from->used += size;
    ++from->uploads;
  }
  *memory = upload_memory(device, &uploads->items[to->upload - 1]);
  return CSM_SUCCESS;
}

void uploads_drop(device *device, page_piece *to) {
  uploads *uploads = &device->geometry.uploads;
  if (!to->upload)
    return;
  struct upload *gone = &uploads->items[to->upload - 1];
  struct staging *from = gone->from, **link = &uploads->filling;
  *gone = uploads->items[--uploads->count];
  gone->to->upload = to->upload;
  to->upload = 0;
  if (--from->uploads)
    return;
  while (*link != from)
    link = &(*link)->next;
  *link = from->next; /* no recording has seen this staging */
  staging_free(device, from);
}

void uploads_record(device *device) {
  uploads *uploads = &device->geometry.uploads;
  for (uint32_t i = 0; i < uploads->count; ++i) {
    const struct upload *upload = &uploads->items[i];
    gpu_copy_buffer(device->gpu, upload->to->page->buffer, upload->to->offset, upload->from->buffer, upload->offset,
                    upload->size);
    upload->to->upload = 0;
  }
  uploads->count = 0;
  while (uploads->filling) {
    struct staging *staging = uploads->filling;
    uploads->filling = staging->next;
    retire(device, &staging->retired, staging_done);
  }
  uploads->frames += device->prepared.fresh;
  free_old_staging(device);
}

void uploads_destroy(device *device) {
  uploads *uploads = &device->geometry.uploads;
  free_list(device, &uploads->filling);
  free_list(device, &uploads->idle);
  host_release(device->host, uploads->items);
}
