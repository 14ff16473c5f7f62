#include "device/geometry.h"

#include "device/tree_pool.h"
#include "device/uploads.h"

#include <math.h>
#include <string.h>

enum { part_alignment = 16, position_bytes = 12, uv_bytes = 8 };

/* Where a mesh lies. */
typedef struct geometry_place {
  retired retired;
  page_piece *piece;     /* of a copied one; NULL: an engine's buffers */
  gpu_geometry engine;   /* else */
  gpu_buffer *constants; /* of an alpha-tested mesh, with its bindings; else NULL */
  gpu_bindings *alpha_mask;
  page_piece *tree; /* NULL: it cannot be traced */
  mesh_rays rays;
} geometry_place;

static void place_free(device *device, retired *self) {
  geometry_place *place = (geometry_place *)self;
  const gpu_geometry *engine = &place->engine;
  gpu_bindings_destroy(device->gpu, place->alpha_mask);
  device_buffer_free(device, place->constants, ALPHA_MASK_BLOCK);
  tree_pool_remove(device, place->tree);
  if (place->piece) {
    uploads_drop(device, place->piece);
    pages_give_back(device, place->piece);
  }
  if (engine->indices != engine->vertices)
    gpu_buffer_destroy(device->gpu, engine->indices);
  gpu_buffer_destroy(device->gpu, engine->vertices);
  host_release(device->host, place);
}

/* ---- copied meshes ---- */

static uint64_t round_up(uint64_t size) {
  return (size + part_alignment - 1) / part_alignment * part_alignment;
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

void geometry_positions(float *to, const void *positions, uint32_t stride, uint32_t count, const double *offset) {
  const char *from = positions;
  for (uint32_t i = 0; i < count; ++i, from += stride, to += 3) {
    memcpy(to, from, position_bytes);
    for (int axis = 0; axis < 3; ++axis)
      to[axis] = (float)(to[axis] - offset[axis]);
  }
}

uint32_t geometry_index(const csm_mesh_info *info, uint32_t corner) {
  const char *at = (const char *)info->indices + (size_t)corner * info->index_size;
  uint32_t wide;
  uint16_t narrow;
  memcpy(&wide, at, info->index_size == 4 ? sizeof wide : 0);
  memcpy(&narrow, at, sizeof narrow);
  return info->index_size == 4 ? wide : narrow;
}

static void write_indices(char *to, const csm_mesh_info *info, const geometry_order *order) {
  const size_t bytes = 3 * (size_t)info->index_size;
  for (uint32_t i = 0; i < info->index_count / 3; ++i)
    memcpy(to + i * bytes, (const char *)info->indices + order->triangles[i] * bytes, bytes);
}

static void write_mesh(char *memory, const csm_mesh_info *info, const layout *layout, const double *offset,
                       const geometry_order *order) {
  geometry_positions((float *)memory, info->positions, info->position_stride, info->vertex_count, offset);
  for (uint32_t i = 0; i < info->vertex_count && info->alpha_mask; ++i)
    memcpy(memory + layout->uvs + (size_t)i * uv_bytes, (const char *)info->uvs + (size_t)i * info->uv_stride,
           uv_bytes);
  write_indices(memory + layout->indices, info, order);
}

static csm_result add_copied(device *device, const csm_mesh_info *info, const double *offset,
                             const geometry_order *order, geometry_place *place, mesh_place *mesh) {
  const layout layout = lay_out(info);
  void *memory;
  csm_result result = pages_take(device, layout.size, &place->piece);
  if (!result)
    result = uploads_write(device, place->piece, layout.size, &memory);
  if (result)
    return result;
  write_mesh(memory, info, &layout, offset, order);
  const page_piece *piece = place->piece;
  *mesh = (mesh_place){.vertices = piece->page->buffer,
                       .indices = piece->page->buffer,
                       .vertex_offset = piece->offset,
                       .index_offset = piece->offset + layout.indices,
                       .uv_offset = piece->offset + layout.uvs,
                       .index_count = 3 * order->drawn};
  return CSM_SUCCESS;
}

/* ---- an engine's own buffers ---- */

static csm_result add_engines(device *device, const csm_mesh_info *info, geometry_place *place, mesh_place *mesh) {
  const void *native = info->vulkan ? (const void *)info->vulkan : info->d3d12;
  gpu_geometry *engine = &place->engine;
  const csm_result result = device_check(device, gpu_geometry_import(device->gpu, native, engine), "an engine's mesh");
  if (result)
    return result;
  const bool strides =
      engine->uv_stride >= uv_bytes && engine->uv_stride % 4 == 0 && engine->uv_stride <= engine->largest_stride;
  const bool begins =
      engine->uv_offset % 4 == 0 && (!engine->vertices_size || engine->uv_offset < engine->vertices_size);
  const char *wrong = !info->alpha_mask ? NULL : !strides ? "uv_stride" : !begins ? "uv_offset" : NULL;
  if (wrong)
    return host_fail(device->host, CSM_ERROR_INVALID_VALUE, "the engine's mesh: %s is not allowed", wrong);
  *mesh = (mesh_place){.vertices = engine->vertices,
                       .indices = engine->indices,
                       .vertex_offset = engine->vertex_offset,
                       .index_offset = engine->index_offset,
                       .uv_offset = engine->uv_offset,
                       .index_count = info->index_count};
  return CSM_SUCCESS;
}

/* ---- meshes ---- */

csm_result geometry_reserve(device *device, uint32_t capacity) {
  geometry *geometry = &device->geometry;
  host *host = device->host;
  if (capacity <= geometry->capacity)
    return CSM_SUCCESS;
  geometry_place **places = host_grown_copy(host, geometry->places, geometry->capacity, capacity, sizeof *places);
  mesh_place *meshes =
      places ? host_grown_copy(host, geometry->meshes, geometry->capacity, capacity, sizeof *meshes) : NULL;
  if (!meshes) {
    host_release(host, places);
    return CSM_ERROR_OUT_OF_MEMORY;
  }
  host_release(host, geometry->places);
  host_release(host, geometry->meshes);
  geometry->places = places;
  geometry->meshes = meshes;
  geometry->capacity = capacity;
  return CSM_SUCCESS;
}

/* The constants and bindings of an alpha-tested mesh. */
static csm_result add_cut_out(device *device, const mesh_cut_out *cut_out, float cutoff, geometry_place *place) {
  const gpu_buffer_info info = {.name = "alpha mask constants", .kind = GPU_BUFFER_UPLOAD, .size = ALPHA_MASK_BLOCK};
  const csm_result result = device_buffer(device, &info, &place->constants);
  if (result)
    return result;
  alpha_mask_write(gpu_buffer_memory(device->gpu, place->constants), cut_out->mask, cutoff);
  return alpha_mask_bindings(device, place->constants, alpha_images_texture(device, cut_out->index),
                             &place->alpha_mask);
}

/* What draws of the mesh need to know besides where it lies. */
static csm_result add_shape(device *device, const csm_mesh_info *info, const mesh_cut_out *cut_out,
                            geometry_place *place, mesh_place *mesh) {
  mesh_vertices vertices = {.stride = place->piece ? position_bytes : place->engine.vertex_stride};
  if (cut_out->mask)
    vertices.uv_stride = place->piece ? uv_bytes : place->engine.uv_stride;
  csm_result result = cut_out->mask ? add_cut_out(device, cut_out, info->alpha_cutoff, place) : CSM_SUCCESS;
  if (!result) /* last: a shape never goes */
    result = device_shape(device, vertices, &mesh->shape);
  mesh->index_size = info->index_size;
  mesh->two_sided = info->flags & CSM_MESH_TWO_SIDED;
  mesh->watertight = info->flags & CSM_MESH_WATERTIGHT && !cut_out->mask;
  mesh->alpha_mask = place->alpha_mask;
  return result;
}

/* Rows from the first one of a piece on become rows of the pool. */
static void place_rays(mesh_rays *to, const mesh_rays *from, const page_piece *tree) {
  const uint32_t first = tree_pool_row(tree);
  const mesh_rays before = *to;
  *to = *from;
  to->node_row = first;
  to->triangle_row += first;
  to->uv_row = from->uv_row == MESH_RAYS_NONE ? MESH_RAYS_NONE : from->uv_row + first;
  to->alpha_row = before.alpha_row;
  to->alpha_cutoff = before.alpha_cutoff;
  memcpy(to->alpha_size, before.alpha_size, sizeof to->alpha_size);
  memcpy(to->alpha_wrap, before.alpha_wrap, sizeof to->alpha_wrap);
}

static csm_result add_tree(device *device, const csm_mesh_info *info, const mesh_cut_out *cut_out,
                           const mesh_traced *traced, geometry_place *place) {
  if (!traced->rays)
    return CSM_SUCCESS;
  const csm_result result = tree_pool_add(device, &traced->bytes, &place->tree);
  if (result)
    return result;
  if (cut_out->mask)
    place->rays = (mesh_rays){.alpha_row = alpha_images_row(device, cut_out->index),
                              .alpha_size = {cut_out->mask->width, cut_out->mask->height},
                              .alpha_wrap = {cut_out->mask->wrap_u, cut_out->mask->wrap_v},
                              .alpha_cutoff = info->alpha_cutoff};
  place_rays(&place->rays, traced->rays, place->tree);
  return CSM_SUCCESS;
}

csm_result geometry_add(device *device, uint32_t index, const csm_mesh_info *info, const double *offset,
                        const geometry_order *order, const mesh_cut_out *cut_out, const mesh_traced *traced) {
  geometry *geometry = &device->geometry;
  mesh_place mesh = {0};
  geometry_place *place = host_allocate(device->host, sizeof *place);
  if (!place)
    return CSM_ERROR_OUT_OF_MEMORY;
  csm_result result = info->vulkan || info->d3d12 ? add_engines(device, info, place, &mesh)
                                                  : add_copied(device, info, offset, order, place, &mesh);
  if (!result)
    result = add_tree(device, info, cut_out, traced, place);
  if (!result)
    result = add_shape(device, info, cut_out, place, &mesh);
  if (result) {
    place_free(device, &place->retired);
    return result;
  }
  mesh.rays = place->tree ? &place->rays : NULL;
  geometry->meshes[index] = mesh;
  geometry->places[index] = place;
  geometry->bytes += place->piece ? place->piece->size : 0;
  return CSM_SUCCESS;
}

csm_result geometry_update(device *device, uint32_t index, const csm_mesh_update_info *info, const csm_mesh_info *shape,
                           const double *offset) {
  const uint64_t size = (uint64_t)shape->vertex_count * position_bytes;
  void *memory;
  const csm_result result = uploads_write(device, device->geometry.places[index]->piece, size, &memory);
  if (result)
    return result;
  geometry_positions(memory, info->positions, info->position_stride, shape->vertex_count, offset);
  device->geometry.meshes[index].index_count = shape->index_count; /* what had no area may have one now */
  return CSM_SUCCESS;
}

csm_result geometry_retrace(device *device, uint32_t index, const mesh_traced *now, void **memory) {
  const csm_result result = tree_pool_rewrite(device, device->geometry.places[index]->tree, memory);
  if (!result)
    memcpy(*memory, now->bytes.memory, now->bytes.size);
  return result;
}

void geometry_retraced(device *device, uint32_t index, const mesh_rays *rays) {
  geometry_place *place = device->geometry.places[index];
  place_rays(&place->rays, rays, place->tree);
}

bool geometry_is_engines(const device *device, uint32_t index) {
  return !device->geometry.places[index]->piece;
}

void geometry_remove(device *device, uint32_t index) {
  geometry *geometry = &device->geometry;
  geometry_place *place = geometry->places[index];
  geometry->places[index] = NULL;
  if (place->piece) {
    geometry->bytes -= place->piece->size;
    uploads_drop(device, place->piece);
  }
  retire(device, &place->retired, place_free);
}

void geometry_record(device *device) {
  tree_pool_record(device);
  uploads_record(device);
}

void geometry_destroy(device *device) {
  geometry *geometry = &device->geometry;
  for (uint32_t i = 0; i < geometry->capacity; ++i)
    if (geometry->places[i])
      place_free(device, &geometry->places[i]->retired);
  uploads_destroy(device);
  pages_free_empty(device); /* all of them */
  host_release(device->host, geometry->places);
  host_release(device->host, geometry->meshes);
}
