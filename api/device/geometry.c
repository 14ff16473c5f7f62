#include "abi/context.h"

#include <string.h>

/*
 * Copied meshes lie in pages, which are large device buffers with a list of free places each: few buffers to bind, and
 * few device allocations, of which there is a limit. Data waits in staging buffers until the next recording copies it.
 * An engine's own buffers are taken in where they are.
 */
enum { page_smallest = 8 << 20, staging_smallest = 4 << 20, place_alignment = 16, position_bytes = 12, uv_bytes = 8 };

/* Where a mesh lies: a piece of a page, or an engine's buffers. Or a piece that is free. */
typedef struct geometry_place {
  retired retired;
  struct geometry_place *next; /* free ones: by offset, never two that touch */
  struct geometry_page *page;  /* NULL: an engine's */
  uint64_t offset, size;
  gpu_geometry engine;
  gpu_buffer *constants; /* of an alpha-tested mesh, with its bindings; else NULL */
  gpu_bindings *alpha_mask;
} geometry_place;

typedef struct geometry_page {
  struct geometry_page *next;
  gpu_buffer *buffer;
  uint64_t size;
  geometry_place *free;
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
  const geometry_place *to;
} geometry_upload;

/* ---- pages ---- */

static csm_result page_create(device *device, uint64_t size, geometry_page **out) {
  geometry_page *page = context_allocate(device->context, sizeof *page);
  geometry_place *whole = page ? context_allocate(device->context, sizeof *whole) : NULL;
  csm_result result = CSM_ERROR_OUT_OF_MEMORY;
  if (!whole)
    goto fail;
  page->size = size > page_smallest ? size : page_smallest;
  result = device_buffer(device, &(gpu_buffer_info){.name = "geometry", .kind = GPU_BUFFER_DEVICE, .size = page->size},
                         &page->buffer);
  if (result)
    goto fail;
  *whole = (geometry_place){.page = page, .size = page->size};
  page->free = whole;
  page->next = device->geometry.pages;
  device->geometry.pages = page;
  *out = page;
  return CSM_SUCCESS;
fail:
  context_release(device->context, whole);
  context_release(device->context, page);
  return result;
}

static geometry_place **find_free(geometry_page *page, uint64_t size) {
  geometry_place **link = &page->free;
  while (*link && (*link)->size < size)
    link = &(*link)->next;
  return link;
}

static csm_result place_create(device *device, uint64_t size, geometry_place **out) {
  geometry_page *page = device->geometry.pages;
  while (page && !*find_free(page, size))
    page = page->next;
  geometry_place *place = context_allocate(device->context, sizeof *place);
  if (!place)
    return CSM_ERROR_OUT_OF_MEMORY;
  const csm_result result = page ? CSM_SUCCESS : page_create(device, size, &page);
  if (result) {
    context_release(device->context, place);
    return result;
  }
  geometry_place **link = find_free(page, size), *free = *link;
  *place = (geometry_place){.page = page, .offset = free->offset, .size = size};
  free->offset += size;
  free->size -= size;
  if (!free->size) {
    *link = free->next;
    context_release(device->context, free);
  }
  *out = place;
  return CSM_SUCCESS;
}

/* Makes the place that follows a part of this one where the two touch. */
static void join(device *device, geometry_place *place) {
  geometry_place *next = place->next;
  if (!next || place->offset + place->size != next->offset)
    return;
  place->size += next->size;
  place->next = next->next;
  context_release(device->context, next);
}

static void return_to_page(device *device, geometry_place *place) {
  geometry_place *before = NULL;
  geometry_page *page = place->page;
  place->next = page->free;
  while (place->next && place->next->offset < place->offset) {
    before = place->next;
    place->next = before->next;
  }
  *(before ? &before->next : &page->free) = place;
  join(device, place);
  if (before)
    join(device, before);
}

static void alpha_mask_free(device *device, geometry_place *place) {
  if (place->alpha_mask)
    device->gpu.api->bindings_destroy(device->gpu.device, place->alpha_mask);
  device_buffer_free(device, place->constants, ALPHA_MASK_BLOCK);
  place->alpha_mask = NULL;
  place->constants = NULL;
}

static void place_free(device *device, retired *self) {
  geometry_place *place = (geometry_place *)self;
  const gpu_geometry *engine = &place->engine;
  alpha_mask_free(device, place);
  if (place->page) {
    return_to_page(device, place);
    return;
  }
  if (engine->indices != engine->vertices)
    device->gpu.api->buffer_destroy(device->gpu.device, engine->indices);
  device->gpu.api->buffer_destroy(device->gpu.device, engine->vertices);
  context_release(device->context, place);
}

/* ---- staging ---- */

static void staging_free(device *device, retired *self) {
  geometry_staging *staging = (geometry_staging *)self;
  device_buffer_free(device, staging->buffer, staging->size);
  context_release(device->context, staging);
}

static csm_result staging_reserve(device *device, uint64_t size, geometry_staging **out) {
  geometry_staging *staging = device->geometry.staging;
  if (!staging || staging->size - staging->used < size) {
    staging = context_allocate(device->context, sizeof *staging);
    if (!staging)
      return CSM_ERROR_OUT_OF_MEMORY;
    staging->size = size > staging_smallest ? size : staging_smallest;
    const gpu_buffer_info info = {.name = "geometry staging", .kind = GPU_BUFFER_UPLOAD, .size = staging->size};
    const csm_result result = device_buffer(device, &info, &staging->buffer);
    if (result) {
      context_release(device->context, staging);
      return result;
    }
    staging->next = device->geometry.staging;
    device->geometry.staging = staging;
  }
  *out = staging;
  return CSM_SUCCESS;
}

void geometry_record(device *device) {
  geometry *geometry = &device->geometry;
  while (geometry->uploads) {
    geometry_upload *upload = geometry->uploads;
    geometry->uploads = upload->next;
    device->gpu.api->copy_buffer(device->gpu.device, upload->to->page->buffer, upload->to->offset, upload->from->buffer,
                                 upload->from_offset, upload->to->size);
    context_release(device->context, upload);
  }
  while (geometry->staging) {
    geometry_staging *staging = geometry->staging;
    geometry->staging = staging->next;
    retire(device, &staging->retired, staging_free);
  }
}

static void drop_upload(device *device, const geometry_place *to) {
  geometry_upload **link = &device->geometry.uploads;
  while (*link && (*link)->to != to)
    link = &(*link)->next;
  geometry_upload *upload = *link;
  if (!upload)
    return;
  *link = upload->next;
  context_release(device->context, upload);
}

/* ---- meshes ---- */

csm_result geometry_reserve(device *device, uint32_t capacity) {
  geometry *geometry = &device->geometry;
  csm_context *context = device->context;
  if (capacity <= geometry->capacity)
    return CSM_SUCCESS;
  geometry_place **places = context_allocate(context, capacity * sizeof *places);
  pass_mesh *meshes = places ? context_allocate(context, capacity * sizeof *meshes) : NULL;
  if (!meshes) {
    context_release(context, places);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  if (geometry->capacity) {
    memcpy(places, geometry->places, geometry->capacity * sizeof *places);
    memcpy(meshes, geometry->meshes, geometry->capacity * sizeof *meshes);
  }
  context_release(context, geometry->places);
  context_release(context, geometry->meshes);
  geometry->places = places;
  geometry->meshes = meshes;
  geometry->capacity = capacity;
  return CSM_SUCCESS;
}

static uint64_t round_up(uint64_t size) {
  return (size + place_alignment - 1) / place_alignment * place_alignment;
}

static void pack(char *to, const char *from, uint32_t count, uint32_t stride, uint32_t bytes) {
  for (uint32_t i = 0; i < count; ++i, from += stride, to += bytes)
    memcpy(to, from, bytes);
}

/* Where the parts of a copied mesh begin: positions, then uvs, then indices. */
typedef struct layout {
  uint64_t uvs, indices, size;
} layout;

static layout lay_out(const csm_mesh_info *info) {
  layout out;
  out.uvs = round_up((uint64_t)info->vertex_count * position_bytes);
  out.indices = out.uvs + (info->alpha_mask ? round_up((uint64_t)info->vertex_count * uv_bytes) : 0);
  out.size = out.indices + round_up((uint64_t)info->index_count * info->index_size);
  return out;
}

static void fill_staging(const csm_mesh_info *info, const layout *layout, char *memory) {
  pack(memory, info->positions, info->vertex_count, info->position_stride, position_bytes);
  if (info->alpha_mask)
    pack(memory + layout->uvs, info->uvs, info->vertex_count, info->uv_stride, uv_bytes);
  memcpy(memory + layout->indices, info->indices, (size_t)info->index_count * info->index_size);
}

/* The constants and bindings of an alpha-tested mesh, on the programs that it is drawn with. */
static csm_result add_alpha_mask(device *device, const csm_mesh_info *info, geometry_place *place, pass_mesh *mesh) {
  const csm_context *context = device->context;
  const uint32_t slot = handles_find(&context->alpha_masks.handles, info->alpha_mask);
  const gpu_buffer_info constants = {.name = "alpha_mask constants", .kind = GPU_BUFFER_UPLOAD, .size = ALPHA_MASK_BLOCK};
  csm_result result = device_buffer(device, &constants, &place->constants);
  if (result)
    return result;
  alpha_mask_write(device->gpu.api->buffer_memory(place->constants), &context->alpha_masks.infos[slot], info->alpha_cutoff);
  const gpu_bindings_info reads =
      alpha_mask_inputs(device->programs.camera[0][mesh->programs], place->constants, alpha_mask_texture(device, slot));
  result = device_check(device, device->gpu.api->bindings_create(device->gpu.device, &reads, &place->alpha_mask),
                        "an alpha-tested mesh's bindings");
  mesh->alpha_mask = place->alpha_mask;
  return result;
}

static csm_result add_copied(device *device, const csm_mesh_info *info, geometry_place **out, pass_mesh *mesh) {
  geometry *geometry = &device->geometry;
  const layout layout = lay_out(info);
  geometry_place *place = NULL;
  geometry_staging *staging = NULL;
  geometry_upload *upload = context_allocate(device->context, sizeof *upload);
  csm_result result = upload ? place_create(device, layout.size, &place) : CSM_ERROR_OUT_OF_MEMORY;
  if (!result)
    result = staging_reserve(device, layout.size, &staging);
  if (result) {
    if (place)
      return_to_page(device, place);
    context_release(device->context, upload);
    return result;
  }
  fill_staging(info, &layout, (char *)device->gpu.api->buffer_memory(staging->buffer) + staging->used);
  *upload = (geometry_upload){.next = geometry->uploads, .from = staging, .from_offset = staging->used, .to = place};
  geometry->uploads = upload;
  staging->used += layout.size;
  *mesh = (pass_mesh){.vertices = place->page->buffer,
                      .indices = place->page->buffer,
                      .vertex_offset = place->offset,
                      .index_offset = place->offset + layout.indices,
                      .uv_offset = place->offset + layout.uvs,
                      .index_size = info->index_size};
  *out = place;
  return CSM_SUCCESS;
}

static csm_result add_engines(device *device, const csm_mesh_info *info, geometry_place **out, pass_mesh *mesh) {
  geometry_place *place = context_allocate(device->context, sizeof *place);
  if (!place)
    return CSM_ERROR_OUT_OF_MEMORY;
  const void *native = info->vulkan ? (const void *)info->vulkan : info->d3d12;
  csm_result result = device_check(device, device->gpu.api->geometry_import(device->gpu.device, native, &place->engine),
                                   "an engine's mesh");
  if (result) {
    context_release(device->context, place);
    return result;
  }
  const gpu_geometry *engine = &place->engine;
  *mesh = (pass_mesh){.vertices = engine->vertices,
                      .indices = engine->indices,
                      .vertex_offset = engine->vertex_offset,
                      .index_offset = engine->index_offset,
                      .uv_offset = engine->uv_offset,
                      .index_size = info->index_size};
  *out = place;
  return CSM_SUCCESS;
}

/* The programs for a mesh's vertices, and what an alpha-tested one reads. */
static csm_result add_shape(device *device, const csm_mesh_info *info, geometry_place *place, pass_mesh *mesh) {
  const bool engines = !place->page;
  const pass_vertices vertices = {.stride = engines ? place->engine.vertex_stride : position_bytes,
                                  .uv_stride = !info->alpha_mask ? 0
                                               : engines      ? place->engine.uv_stride
                                                              : uv_bytes};
  if (engines && info->alpha_mask && (vertices.uv_stride < uv_bytes || vertices.uv_stride % 4))
    return context_fail(device->context, CSM_ERROR_INVALID_VALUE, "the mesh's uv_stride is not allowed");
  const csm_result result = device_programs(device, vertices, &mesh->programs);
  return result || !info->alpha_mask ? result : add_alpha_mask(device, info, place, mesh);
}

csm_result geometry_add(device *device, uint32_t slot, const csm_mesh_info *info) {
  geometry *geometry = &device->geometry;
  pass_mesh mesh = {0};
  geometry_place *place = NULL;
  csm_result result =
      info->vulkan || info->d3d12 ? add_engines(device, info, &place, &mesh) : add_copied(device, info, &place, &mesh);
  if (result)
    return result;
  result = add_shape(device, info, place, &mesh);
  if (result) {
    drop_upload(device, place);
    place_free(device, &place->retired);
    return result;
  }
  mesh.index_count = info->index_count;
  mesh.two_sided = info->flags & CSM_MESH_TWO_SIDED;
  mesh.closed = info->flags & CSM_MESH_WATERTIGHT && !info->alpha_mask;
  geometry->meshes[slot] = mesh;
  geometry->places[slot] = place;
  geometry->bytes += place->size;
  return CSM_SUCCESS;
}

void geometry_remove(device *device, uint32_t slot) {
  geometry *geometry = &device->geometry;
  geometry_place *place = geometry->places[slot];
  geometry->places[slot] = NULL;
  geometry->bytes -= place->size;
  drop_upload(device, place);
  retire(device, &place->retired, place_free);
}

void geometry_destroy(device *device) {
  geometry *geometry = &device->geometry;
  csm_context *context = device->context;
  for (uint32_t i = 0; i < geometry->capacity; ++i)
    if (geometry->places[i])
      place_free(device, &geometry->places[i]->retired);
  while (geometry->uploads) {
    geometry_upload *upload = geometry->uploads;
    geometry->uploads = upload->next;
    context_release(context, upload);
  }
  while (geometry->staging) {
    geometry_staging *staging = geometry->staging;
    geometry->staging = staging->next;
    staging_free(device, &staging->retired);
  }
  while (geometry->pages) {
    geometry_page *page = geometry->pages;
    geometry->pages = page->next;
    device_buffer_free(device, page->buffer, page->size);
    context_release(context, page->free);
    context_release(context, page);
  }
  context_release(context, geometry->places);
  context_release(context, geometry->meshes);
}
