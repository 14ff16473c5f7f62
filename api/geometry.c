#include "context.h"

#include <math.h>
#include <string.h>

/*
 * Meshes lie in pages, which are large device buffers with a list of free ranges each: few buffers to bind, and few
 * device allocations, of which there is a limit. Data waits in staging buffers until the next recording copies it.
 */
enum { page_smallest = 8 << 20, staging_smallest = 4 << 20, range_alignment = 16 };

/* A piece of a page: of a mesh, or free. */
typedef struct geometry_range {
  retired retired;
  struct geometry_range *next; /* free ones: by offset, never two that touch */
  struct geometry_page *page;
  uint64_t offset, size;
} geometry_range;

typedef struct geometry_page {
  struct geometry_page *next;
  gpu_buffer *buffer;
  uint64_t size;
  geometry_range *free;
} geometry_page;

typedef struct geometry_staging {
  retired retired;
  struct geometry_staging *next;
  gpu_buffer *buffer;
  uint64_t size, used;
} geometry_staging;

typedef struct geometry_upload {
  struct geometry_upload *next;
  const geometry_staging *from;
  uint64_t from_offset;
  const geometry_range *to;
} geometry_upload;

/* ---- pages ---- */

static csm_result page_create(csm_context *context, uint64_t size, geometry_page **out) {
  geometry_page *page = context_allocate(context, sizeof *page);
  geometry_range *whole = page ? context_allocate(context, sizeof *whole) : NULL;
  csm_result result = CSM_ERROR_OUT_OF_MEMORY;
  if (!whole)
    goto fail;
  page->size = size > page_smallest ? size : page_smallest;
  result = context_buffer(
      context, &(gpu_buffer_info){.name = "geometry", .kind = GPU_BUFFER_DEVICE, .size = page->size}, &page->buffer);
  if (result)
    goto fail;
  *whole = (geometry_range){.page = page, .size = page->size};
  page->free = whole;
  page->next = context->geometry.pages;
  context->geometry.pages = page;
  *out = page;
  return CSM_SUCCESS;
fail:
  context_release(context, whole);
  context_release(context, page);
  return result;
}

static geometry_range **find_free(geometry_page *page, uint64_t size) {
  geometry_range **link = &page->free;
  while (*link && (*link)->size < size)
    link = &(*link)->next;
  return link;
}

static csm_result range_create(csm_context *context, uint64_t size, geometry_range **out) {
  geometry_page *page = context->geometry.pages;
  while (page && !*find_free(page, size))
    page = page->next;
  geometry_range *range = context_allocate(context, sizeof *range);
  if (!range)
    return CSM_ERROR_OUT_OF_MEMORY;
  const csm_result result = page ? CSM_SUCCESS : page_create(context, size, &page);
  if (result) {
    context_release(context, range);
    return result;
  }
  geometry_range **link = find_free(page, size), *free = *link;
  *range = (geometry_range){.page = page, .offset = free->offset, .size = size};
  free->offset += size;
  free->size -= size;
  if (!free->size) {
    *link = free->next;
    context_release(context, free);
  }
  *out = range;
  return CSM_SUCCESS;
}

/* Makes `next`, which follows `range`, a part of it where the two touch. */
static void join(csm_context *context, geometry_range *range) {
  geometry_range *next = range->next;
  if (!next || range->offset + range->size != next->offset)
    return;
  range->size += next->size;
  range->next = next->next;
  context_release(context, next);
}

static void range_free(csm_context *context, retired *self) {
  geometry_range *range = (geometry_range *)self, *before = NULL;
  geometry_page *page = range->page;
  range->next = page->free;
  while (range->next && range->next->offset < range->offset) {
    before = range->next;
    range->next = before->next;
  }
  *(before ? &before->next : &page->free) = range;
  join(context, range);
  if (before)
    join(context, before);
}

/* ---- staging ---- */

static void staging_free(csm_context *context, retired *self) {
  geometry_staging *staging = (geometry_staging *)self;
  context_buffer_free(context, staging->buffer, staging->size);
  context_release(context, staging);
}

static csm_result staging_reserve(csm_context *context, uint64_t size, geometry_staging **out) {
  geometry_staging *staging = context->geometry.staging;
  if (!staging || staging->size - staging->used < size) {
    staging = context_allocate(context, sizeof *staging);
    if (!staging)
      return CSM_ERROR_OUT_OF_MEMORY;
    staging->size = size > staging_smallest ? size : staging_smallest;
    const gpu_buffer_info info = {.name = "geometry staging", .kind = GPU_BUFFER_UPLOAD, .size = staging->size};
    const csm_result result = context_buffer(context, &info, &staging->buffer);
    if (result) {
      context_release(context, staging);
      return result;
    }
    staging->next = context->geometry.staging;
    context->geometry.staging = staging;
  }
  *out = staging;
  return CSM_SUCCESS;
}

void geometry_record(csm_context *context) {
  geometry *geometry = &context->geometry;
  while (geometry->uploads) {
    geometry_upload *upload = geometry->uploads;
    geometry->uploads = upload->next;
    context->gpu.api->copy_buffer(context->gpu.device, upload->to->page->buffer, upload->to->offset,
                                  upload->from->buffer, upload->from_offset, upload->to->size);
    context_release(context, upload);
  }
  while (geometry->staging) {
    geometry_staging *staging = geometry->staging;
    geometry->staging = staging->next;
    retire(context, &staging->retired, staging_free);
  }
}

static void drop_upload(csm_context *context, const geometry_range *to) {
  geometry_upload **link = &context->geometry.uploads;
  while (*link && (*link)->to != to)
    link = &(*link)->next;
  geometry_upload *upload = *link;
  if (!upload)
    return;
  *link = upload->next;
  context_release(context, upload);
}

/* ---- handles ---- */

uint32_t geometry_find(const geometry *geometry, csm_mesh mesh) {
  const uint32_t slot = (uint32_t)mesh - 1;
  return slot < geometry->slot_count && geometry->slots[slot].generation == mesh >> 32 ? slot : UINT32_MAX;
}

static csm_result slots_grow(csm_context *context) {
  geometry *geometry = &context->geometry;
  const uint32_t capacity = geometry->slot_capacity ? geometry->slot_capacity * 2 : 64;
  mesh_slot *slots = context_allocate(context, capacity * sizeof *slots);
  pass_mesh *meshes = context_allocate(context, capacity * sizeof *meshes);
  plan_bounds *bounds = context_allocate(context, capacity * sizeof *bounds);
  if (!slots || !meshes || !bounds) {
    context_release(context, slots);
    context_release(context, meshes);
    context_release(context, bounds);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  if (geometry->slot_count) {
    memcpy(slots, geometry->slots, geometry->slot_count * sizeof *slots);
    memcpy(meshes, geometry->meshes, geometry->slot_count * sizeof *meshes);
    memcpy(bounds, geometry->bounds, geometry->slot_count * sizeof *bounds);
  }
  context_release(context, geometry->slots);
  context_release(context, geometry->meshes);
  context_release(context, geometry->bounds);
  geometry->slots = slots;
  geometry->meshes = meshes;
  geometry->bounds = bounds;
  geometry->slot_capacity = capacity;
  return CSM_SUCCESS;
}

static csm_result slot_reserve(csm_context *context, uint32_t *slot) {
  geometry *geometry = &context->geometry;
  *slot = geometry->first_free;
  if (*slot)
    return CSM_SUCCESS;
  *slot = geometry->slot_count + 1;
  return geometry->slot_count < geometry->slot_capacity ? CSM_SUCCESS : slots_grow(context);
}

/* Takes the slot that slot_reserve named (counted from 1, so that 0 can stand for none). */
static mesh_slot *slot_take(geometry *geometry, uint32_t slot) {
  mesh_slot *taken = &geometry->slots[slot - 1];
  if (slot == geometry->first_free)
    geometry->first_free = taken->next_free;
  else
    ++geometry->slot_count;
  ++taken->generation;
  return taken;
}

/* ---- meshes ---- */

static const float *vertex(const csm_mesh_info *info, uint32_t index) {
  return (const float *)((const char *)info->positions + (size_t)index * info->position_stride);
}

static csm_result check_positions(csm_context *context, const csm_mesh_info *info, plan_bounds *bounds) {
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (uint32_t i = 0; i < info->vertex_count; ++i) {
    float p[3];
    memcpy(p, vertex(info, i), sizeof p);
    for (int axis = 0; axis < 3; ++axis) {
      if (!isfinite(p[axis]))
        return context_fail(context, CSM_ERROR_NOT_FINITE, "position %u of the mesh is not finite", i);
      low[axis] = fminf(low[axis], p[axis]);
      high[axis] = fmaxf(high[axis], p[axis]);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    bounds->center[axis] = ((double)low[axis] + high[axis]) / 2;
    bounds->extent[axis] = ((double)high[axis] - low[axis]) / 2;
  }
  return CSM_SUCCESS;
}

static csm_result check_indices(csm_context *context, const csm_mesh_info *info) {
  for (uint32_t i = 0; i < info->index_count; ++i) {
    const uint32_t index =
        info->index_size == 2 ? ((const uint16_t *)info->indices)[i] : ((const uint32_t *)info->indices)[i];
    if (index >= info->vertex_count)
      return context_fail(context, CSM_ERROR_INVALID_INDEX, "index %u of the mesh is %u, of %u vertices", i, index,
                          info->vertex_count);
  }
  return CSM_SUCCESS;
}

static csm_result check_mesh(csm_context *context, csm_mesh_info *info, plan_bounds *bounds) {
  if (!info->positions || !info->indices)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "the mesh's %s is NULL",
                        info->positions ? "indices" : "positions");
  if (!info->position_stride)
    info->position_stride = 3 * sizeof(float);
  const char *wrong = info->flags                                               ? "flags"
                      : info->position_stride % 4 || info->position_stride < 12 ? "position_stride"
                      : !info->vertex_count || info->vertex_count > INT32_MAX   ? "vertex_count"
                      : !info->index_count || info->index_count % 3             ? "index_count"
                      : info->index_size != 2 && info->index_size != 4          ? "index_size"
                      : info->index_size == 2 && (uintptr_t)info->indices % 2   ? "indices' alignment"
                      : info->index_size == 4 && (uintptr_t)info->indices % 4   ? "indices' alignment"
                                                                                : NULL;
  if (wrong)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "the mesh's %s is not allowed", wrong);
  const csm_result result = check_positions(context, info, bounds);
  return result ? result : check_indices(context, info);
}

static uint64_t round_up(uint64_t size) {
  return (size + range_alignment - 1) / range_alignment * range_alignment;
}

static void fill_staging(const csm_mesh_info *info, void *memory, uint64_t index_offset) {
  float *positions = memory;
  for (uint32_t i = 0; i < info->vertex_count; ++i)
    memcpy(positions + 3 * (size_t)i, vertex(info, i), 3 * sizeof(float));
  memcpy((char *)memory + index_offset, info->indices, (size_t)info->index_count * info->index_size);
}

static csm_result mesh_make(csm_context *context, const csm_mesh_info *info, const plan_bounds *bounds,
                            csm_mesh *mesh) {
  geometry *geometry = &context->geometry;
  const uint64_t vertex_bytes = round_up((uint64_t)info->vertex_count * 3 * sizeof(float));
  const uint64_t size = vertex_bytes + round_up((uint64_t)info->index_count * info->index_size);
  geometry_upload *upload = NULL;
  geometry_range *range = NULL;
  geometry_staging *staging = NULL;
  uint32_t slot = 0;
  csm_result result = slot_reserve(context, &slot);
  if (!result && !(upload = context_allocate(context, sizeof *upload)))
    result = CSM_ERROR_OUT_OF_MEMORY;
  if (!result)
    result = range_create(context, size, &range);
  if (!result)
    result = staging_reserve(context, size, &staging);
  if (result)
    goto fail;

  fill_staging(info, (char *)context->gpu.api->buffer_memory(staging->buffer) + staging->used, vertex_bytes);
  *upload = (geometry_upload){.next = geometry->uploads, .from = staging, .from_offset = staging->used, .to = range};
  geometry->uploads = upload;
  staging->used += size;
  geometry->bytes += size;

  mesh_slot *taken = slot_take(geometry, slot);
  taken->range = range;
  geometry->bounds[slot - 1] = *bounds;
  geometry->meshes[slot - 1] = (pass_mesh){.buffer = range->page->buffer,
                                           .vertices = range->offset,
                                           .indices = range->offset + vertex_bytes,
                                           .index_count = info->index_count,
                                           .index_size = info->index_size};
  *mesh = (uint64_t)taken->generation << 32 | slot;
  return CSM_SUCCESS;
fail:
  if (range)
    range_free(context, &range->retired);
  context_release(context, upload);
  return result;
}

csm_result CSM_CALL csm_mesh_create(csm_context *context, const csm_mesh_info *info, csm_mesh *mesh) {
  if (mesh)
    *mesh = 0;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_mesh_info own;
  plan_bounds bounds;
  csm_result result = context_usable(context);
  if (!result)
    result = context_check_struct(context, struct_read(&own, sizeof own, info), "csm_mesh_info");
  if (!result && !mesh)
    result = context_fail(context, CSM_ERROR_NULL_POINTER, "mesh is NULL");
  if (!result)
    result = check_mesh(context, &own, &bounds);
  return result ? result : mesh_make(context, &own, &bounds, mesh);
}

csm_result CSM_CALL csm_mesh_destroy(csm_context *context, csm_mesh mesh) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  const csm_result result = context_usable(context);
  if (result)
    return result;
  geometry *geometry = &context->geometry;
  const uint32_t index = geometry_find(geometry, mesh);
  if (index == UINT32_MAX)
    return context_fail(context, CSM_ERROR_INVALID_HANDLE, "mesh %llx does not exist", (unsigned long long)mesh);
  mesh_slot *slot = &geometry->slots[index];
  geometry_range *range = slot->range;
  drop_upload(context, range);
  geometry->bytes -= range->size;
  retire(context, &range->retired, range_free);
  ++slot->generation;
  slot->next_free = geometry->first_free;
  geometry->first_free = index + 1;
  return CSM_SUCCESS;
}

void geometry_destroy(csm_context *context) {
  geometry *geometry = &context->geometry;
  for (uint32_t i = 0; i < geometry->slot_count; ++i)
    if (geometry->slots[i].generation % 2)
      range_free(context, &geometry->slots[i].range->retired);
  while (geometry->uploads) {
    geometry_upload *upload = geometry->uploads;
    geometry->uploads = upload->next;
    context_release(context, upload);
  }
  while (geometry->staging) {
    geometry_staging *staging = geometry->staging;
    geometry->staging = staging->next;
    staging_free(context, &staging->retired);
  }
  while (geometry->pages) {
    geometry_page *page = geometry->pages;
    geometry->pages = page->next;
    context_buffer_free(context, page->buffer, page->size);
    context_release(context, page->free);
    context_release(context, page);
  }
  context_release(context, geometry->slots);
  context_release(context, geometry->meshes);
  context_release(context, geometry->bounds);
}
