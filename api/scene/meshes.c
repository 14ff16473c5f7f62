#include "scene/mesh_check.h"
#include "scene/mesh_parts.h"

#include "scene/scene.h"
#include "structs.h"
#include <string.h>

enum { first_capacity = 64, position_bytes = 12, uv_bytes = 8 };

/* ---- the table ---- */

static csm_result grow(assets *assets) {
  host *host = assets->host;
  mesh_table *meshes = &assets->meshes;
  const uint32_t count = meshes->handles.count, capacity = handles_grown(&meshes->handles, first_capacity);
  const csm_result result = geometry_reserve(assets->device, capacity);
  if (result)
    return result;
  handle_place *places = host_allocate(host, capacity * sizeof *places);
  csm_mesh_info *infos = host_grown_copy(host, meshes->infos, count, capacity, sizeof *infos);
  void **copies = host_grown_copy(host, meshes->copies, count, capacity, sizeof *copies);
  mesh_tree **trees = host_grown_copy(host, meshes->trees, count, capacity, sizeof *trees);
  plan_bounds *bounds = host_grown_copy(host, meshes->bounds, count, capacity, sizeof *bounds);
  plan_parts *parts = host_grown_copy(host, meshes->parts, count, capacity, sizeof *parts);
  uint32_t *users = host_grown_copy(host, meshes->users, count, capacity, sizeof *users);
  uint64_t *revisions = host_grown_copy(host, meshes->revisions, count, capacity, sizeof *revisions);
  const bool made = places && infos && copies && trees && bounds && parts && users && revisions;
  host_release(host, made ? handles_grow(&meshes->handles, places, capacity) : places);
  host_release(host, made ? meshes->infos : infos);
  host_release(host, made ? meshes->copies : (void *)copies);
  host_release(host, made ? meshes->trees : (void *)trees);
  host_release(host, made ? meshes->bounds : bounds);
  host_release(host, made ? meshes->parts : parts);
  host_release(host, made ? meshes->users : users);
  host_release(host, made ? meshes->revisions : revisions);
  if (!made)
    return CSM_ERROR_OUT_OF_MEMORY;
  meshes->infos = infos;
  meshes->copies = copies;
  meshes->trees = trees;
  meshes->bounds = bounds;
  meshes->parts = parts;
  meshes->users = users;
  meshes->revisions = revisions;
  return CSM_SUCCESS;
}

/* Names a free place without taking it, so that what may still fail changes nothing. */
static csm_result find_place(assets *assets, uint32_t *index) {
  *index = handles_next(&assets->meshes.handles);
  return *index < assets->meshes.handles.capacity ? CSM_SUCCESS : grow(assets);
}

static csm_result find_mesh(const assets *assets, csm_mesh mesh, uint32_t *index) {
  *index = handles_find(&assets->meshes.handles, mesh);
  return *index != UINT32_MAX
             ? CSM_SUCCESS
             : host_fail(assets->host, CSM_ERROR_INVALID_HANDLE, "mesh %llx does not exist", (unsigned long long)mesh);
}

/* ---- copies in host memory ---- */

static void copy_packed(char *to, const void *from, uint32_t count, uint32_t stride, uint32_t bytes) {
  for (uint32_t i = 0; i < count; ++i)
    memcpy(to + (size_t)i * bytes, (const char *)from + (size_t)i * stride, bytes);
}

static size_t indices_at(const csm_mesh_info *info) {
  return (size_t)info->vertex_count * (position_bytes + (info->alpha_mask ? uv_bytes : 0));
}

/* Positions, uvs and indices, one after the other. */
static csm_result keep(const assets *assets, const csm_mesh_info *info, char **out) {
  *out = NULL;
  if (!assets->keep_geometry || !info->positions)
    return CSM_SUCCESS;
  const size_t index_bytes = (size_t)info->index_count * info->index_size;
  char *copy = host_allocate(assets->host, indices_at(info) + index_bytes);
  if (!copy)
    return CSM_ERROR_OUT_OF_MEMORY;
  copy_packed(copy, info->positions, info->vertex_count, info->position_stride, position_bytes);
  if (info->alpha_mask)
    copy_packed(copy + (size_t)info->vertex_count * position_bytes, info->uvs, info->vertex_count, info->uv_stride,
                uv_bytes);
  memcpy(copy + indices_at(info), info->indices, index_bytes);
  *out = copy;
  return CSM_SUCCESS;
}

/* What is kept of a mesh's description: all of it, with the data of the copy if there is one. */
static csm_mesh_info kept_info(const csm_mesh_info *info, const char *copy) {
  csm_mesh_info kept = *info;
  kept.positions = copy;
  kept.position_stride = position_bytes;
  kept.indices = copy ? copy + indices_at(info) : NULL;
  kept.uvs = copy && info->alpha_mask ? copy + (size_t)info->vertex_count * position_bytes : NULL;
  kept.uv_stride = uv_bytes;
  kept.name = NULL;
  kept.vulkan = NULL;
  kept.d3d12 = NULL;
  return kept;
}

/* ---- on a device ---- */

static mesh_cut_out find_cut_out(const assets *assets, const csm_mesh_info *info) {
  if (!info->alpha_mask)
    return (mesh_cut_out){0};
  const uint32_t index = handles_find(&assets->alpha_masks.handles, info->alpha_mask);
  return (mesh_cut_out){.mask = &assets->alpha_masks.infos[index], .index = index};
}

static mesh_traced traced_of(const mesh_tree *tree) {
  return tree ? (mesh_traced){.rays = &tree->rays, .bytes = tree->bytes} : (mesh_traced){0};
}

/* Its parts are those of the order that it is placed in; an engine's buffers have none. */
static csm_result place(const assets *assets, device *device, uint32_t index, const csm_mesh_info *info,
                        const plan_bounds *bounds, const mesh_tree *tree, plan_parts *parts) {
  const mesh_cut_out cut_out = find_cut_out(assets, info);
  const mesh_traced traced = traced_of(tree);
  geometry_order order = {0};
  *parts = (plan_parts){0};
  csm_result result = info->positions ? mesh_parts_make(assets->host, info, &order, parts) : CSM_SUCCESS;
  if (!result)
    result = geometry_add(device, index, info, bounds->offset, &order, &cut_out, &traced);
  host_release(assets->host, order.triangles);
  if (result)
    mesh_parts_free(parts, assets->host);
  return result;
}

/* NULL where no ray is to meet the mesh, or its positions lie in an engine's buffers. */
static csm_result grow_tree(const assets *assets, const csm_mesh_info *info, const plan_bounds *bounds,
                            mesh_tree **out) {
  *out = NULL;
  return assets->trees && info->positions ? mesh_tree_make(assets->host, info, bounds->offset, out) : CSM_SUCCESS;
}

/* Counts a mesh among the users of its alpha mask, or no longer. */
static void use_alpha_mask(assets *assets, const csm_mesh_info *info, int change) {
  if (info->alpha_mask)
    assets->alpha_masks.users[find_cut_out(assets, info).index] += (uint32_t)change;
}

/* A mesh has moved within its instances. */
static void change_bounds(assets *assets, uint32_t index, const plan_bounds *bounds) {
  assets->meshes.bounds[index] = *bounds;
  assets->meshes.revisions[index] = ++assets->meshes.revision;
  const instances_meshes meshes = assets_meshes(assets);
  for (csm_scene *scene = assets->scenes; scene; scene = scene->next)
    instances_mesh_changed(&scene->store, &meshes, index);
}

/* ---- the calls ---- */

csm_result mesh_create(assets *assets, const csm_mesh_info *info, csm_mesh *mesh) {
  host *host = assets->host;
  csm_mesh_info own;
  plan_bounds bounds;
  plan_parts parts;
  uint32_t index;
  char *copy = NULL;
  mesh_tree *tree = NULL;
  csm_result result = host_check_struct(host, struct_read(&own, sizeof own, info), "csm_mesh_info");
  if (!result && !mesh)
    result = host_fail(host, CSM_ERROR_NULL_POINTER, "mesh is NULL");
  if (!result)
    result = mesh_check(assets, assets->device, &own, &bounds);
  if (!result)
    result = find_place(assets, &index);
  if (!result)
    result = keep(assets, &own, &copy);
  if (!result)
    result = grow_tree(assets, &own, &bounds, &tree);
  if (!result)
    result = place(assets, assets->device, index, &own, &bounds, tree, &parts);
  if (result) {
    mesh_tree_free(tree, host);
    host_release(host, copy);
    return result;
  }
  mesh_table *meshes = &assets->meshes;
  meshes->copies[index] = copy;
  meshes->trees[index] = tree;
  meshes->infos[index] = kept_info(&own, copy);
  meshes->bounds[index] = bounds;
  meshes->parts[index] = parts;
  meshes->users[index] = 0;
  use_alpha_mask(assets, &own, 1);
  *mesh = handles_take(&meshes->handles);
  return CSM_SUCCESS;
}

/* Gives a traced mesh other positions, and its tree, or leaves both. */
static csm_result move_traced(const assets *assets, uint32_t index, const csm_mesh_update_info *info,
                              const double *offset) {
  mesh_tree *tree = assets->meshes.trees[index];
  const mesh_traced now = traced_of(tree);
  void *memory, *room = mesh_tree_room(tree, assets->host);
  csm_result result = room ? geometry_retrace(assets->device, index, &now, &memory) : CSM_ERROR_OUT_OF_MEMORY;
  if (!result)
    result = geometry_update(assets->device, index, info, &assets->meshes.infos[index], offset);
  if (!result) {
    mesh_tree_refit(tree, room, info, offset);
    memcpy(memory, tree->bytes.memory, tree->bytes.size);
    geometry_retraced(assets->device, index, &tree->rays);
  }
  host_release(assets->host, room);
  return result;
}

static csm_result move_vertices(const assets *assets, uint32_t index, const csm_mesh_update_info *info,
                                const double *offset) {
  return assets->meshes.trees[index]
             ? move_traced(assets, index, info, offset)
             : geometry_update(assets->device, index, info, &assets->meshes.infos[index], offset);
}

csm_result mesh_update(assets *assets, csm_mesh mesh, const csm_mesh_update_info *info) {
  mesh_table *meshes = &assets->meshes;
  csm_mesh_update_info own;
  plan_bounds bounds;
  uint32_t index;
  csm_result result = host_check_struct(assets->host, struct_read(&own, sizeof own, info), "csm_mesh_update_info");
  if (!result)
    result = find_mesh(assets, mesh, &index);
  if (!result)
    result = mesh_check_update(assets, index, &own, &bounds);
  const uint32_t count = result ? 0 : meshes->infos[index].vertex_count;
  if (!result && own.positions)
    result = move_vertices(assets, index, &own, bounds.offset);
  if (result)
    return result;
  if (meshes->copies[index])
    copy_packed(meshes->copies[index], own.positions, count, own.position_stride, position_bytes);
  mesh_parts_free(&meshes->parts[index], assets->host);
  change_bounds(assets, index, &bounds);
  return CSM_SUCCESS;
}

csm_result mesh_destroy(assets *assets, csm_mesh mesh) {
  mesh_table *meshes = &assets->meshes;
  uint32_t index;
  const csm_result result = find_mesh(assets, mesh, &index);
  if (result)
    return result;
  if (meshes->users[index])
    return host_fail(assets->host, CSM_ERROR_INVALID_STATE, "%u instances use mesh %llx still", meshes->users[index],
                     (unsigned long long)mesh);
  geometry_remove(assets->device, index);
  use_alpha_mask(assets, &meshes->infos[index], -1);
  host_release(assets->host, meshes->copies[index]);
  meshes->copies[index] = NULL;
  mesh_tree_free(meshes->trees[index], assets->host);
  meshes->trees[index] = NULL;
  mesh_parts_free(&meshes->parts[index], assets->host);
  meshes->revisions[index] = ++meshes->revision;
  handles_free(&meshes->handles, index);
  return CSM_SUCCESS;
}

double meshes_trees_ms(const assets *assets) {
  const mesh_table *meshes = &assets->meshes;
  double sum = 0.0;
  for (uint32_t i = 0; i < meshes->handles.count; ++i)
    sum += meshes->trees[i] ? meshes->trees[i]->build_ms : 0.0;
  return sum;
}

/* ---- moving to another device ---- */

static bool same_shape(const csm_mesh_info *a, const csm_mesh_info *b) {
  return a->vertex_count == b->vertex_count && a->index_count == b->index_count && a->index_size == b->index_size &&
         a->flags == b->flags && a->alpha_mask == b->alpha_mask;
}

/* What the engine's callback says is not trusted: `out` may be smaller than asked for, and hold anything. */
static csm_result supply(const assets *assets, uint32_t index, csm_mesh_info *out) {
  host *host = assets->host;
  const unsigned long long mesh = handles_at(&assets->meshes.handles, index);
  if (!assets->supply)
    return host_fail(host, CSM_ERROR_INVALID_STATE,
                     "mesh %llx has no copy (CSM_CREATE_KEEP_GEOMETRY) and there is no supply callback", mesh);
  csm_mesh_info given = {.struct_size = sizeof given};
  csm_result result = assets->supply(host->user, mesh, &given);
  if (result)
    return host_fail(host, CSM_ERROR_INVALID_STATE, "mesh %llx was not supplied: the callback returned %d (%s)", mesh,
                     result, csm_result_name(result));
  if (given.struct_size > sizeof given)
    return host_fail(host, CSM_ERROR_STRUCT_SIZE, "mesh %llx was supplied with a struct_size of %u, for %u bytes", mesh,
                     given.struct_size, (uint32_t)sizeof given);
  result = host_check_struct(host, struct_read(out, sizeof *out, &given), "csm_mesh_info of the supply callback");
  if (!result && !same_shape(out, &assets->meshes.infos[index]))
    result = host_fail(host, CSM_ERROR_INVALID_VALUE, "mesh %llx was supplied with another shape", mesh);
  return result;
}

/* Places a mesh on a device; what is supplied may lie elsewhere than before, and be stored less another offset. */
static csm_result move_mesh(const assets *assets, uint32_t index, device *to, moved_mesh *moved) {
  const mesh_tree *tree = assets->meshes.trees[index];
  csm_mesh_info info = assets->meshes.infos[index];
  csm_result result = CSM_SUCCESS;
  *moved = (moved_mesh){.bounds = assets->meshes.bounds[index]};
  if (!info.positions) {
    result = supply(assets, index, &info);
    if (!result)
      result = mesh_check(assets, to, &info, &moved->bounds);
    if (!result)
      result = grow_tree(assets, &info, &moved->bounds, &moved->tree);
    tree = moved->tree;
  }
  return result ? result : place(assets, to, index, &info, &moved->bounds, tree, &moved->parts);
}

csm_result meshes_move(assets *assets, device *to) {
  mesh_table *meshes = &assets->meshes;
  const uint32_t count = meshes->handles.count;
  csm_result result = geometry_reserve(to, meshes->handles.capacity);
  if (!result)
    meshes->moved = host_allocate(assets->host, (count + 1) * sizeof *meshes->moved);
  if (!result && !meshes->moved)
    result = CSM_ERROR_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < count && !result; ++i)
    if (handles_live(&meshes->handles, i))
      result = move_mesh(assets, i, to, &meshes->moved[i]);
  return result;
}

void meshes_stay(assets *assets) {
  mesh_table *meshes = &assets->meshes;
  for (uint32_t i = 0; meshes->moved && i < meshes->handles.count; ++i)
    mesh_tree_free(meshes->moved[i].tree, assets->host);
  for (uint32_t i = 0; meshes->moved && i < meshes->handles.count; ++i)
    mesh_parts_free(&meshes->moved[i].parts, assets->host);
  host_release(assets->host, meshes->moved);
  meshes->moved = NULL;
}

/* A mesh's parts are those of its order on the new device; what was whole stays so. */
static void take_parts(mesh_table *meshes, uint32_t index, host *host) {
  plan_parts *moved = &meshes->moved[index].parts;
  if (!meshes->parts[index].count)
    return;
  mesh_parts_free(&meshes->parts[index], host);
  meshes->parts[index] = *moved;
  *moved = (plan_parts){0};
}

void meshes_moved(assets *assets) {
  mesh_table *meshes = &assets->meshes;
  for (uint32_t i = 0; i < meshes->handles.count; ++i) {
    moved_mesh *moved = &meshes->moved[i];
    if (!handles_live(&meshes->handles, i))
      continue;
    if (memcmp(&moved->bounds, &meshes->bounds[i], sizeof moved->bounds) != 0)
      change_bounds(assets, i, &moved->bounds);
    take_parts(meshes, i, assets->host);
    if (!moved->tree)
      continue;
    mesh_tree_free(meshes->trees[i], assets->host);
    meshes->trees[i] = moved->tree;
    moved->tree = NULL;
  }
  meshes_stay(assets);
}

void meshes_end(assets *assets) {
  host *host = assets->host;
  mesh_table *meshes = &assets->meshes;
  for (uint32_t i = 0; i < meshes->handles.count; ++i)
    host_release(host, meshes->copies[i]);
  for (uint32_t i = 0; i < meshes->handles.count; ++i)
    mesh_tree_free(meshes->trees[i], host);
  for (uint32_t i = 0; i < meshes->handles.count; ++i)
    mesh_parts_free(&meshes->parts[i], host);
  host_release(host, meshes->parts);
  host_release(host, (void *)meshes->trees);
  host_release(host, meshes->handles.places);
  host_release(host, meshes->infos);
  host_release(host, (void *)meshes->copies);
  host_release(host, meshes->bounds);
  host_release(host, meshes->users);
  host_release(host, meshes->revisions);
}
