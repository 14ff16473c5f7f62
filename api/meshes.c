#include "context.h"

#include <math.h>
#include <string.h>

/* ---- the table ---- */

static void *grow_array(csm_context *context, const void *old, uint32_t count, uint32_t capacity, size_t size) {
  void *grown = context_allocate(context, capacity * size);
  if (grown && count)
    memcpy(grown, old, count * size);
  return grown;
}

static csm_result grow(csm_context *context) {
  mesh_table *meshes = &context->meshes;
  const uint32_t count = meshes->handles.count, capacity = handles_grown(&meshes->handles, 64);
  const csm_result result = geometry_reserve(context->device, capacity);
  if (result)
    return result;
  handle_place *places = context_allocate(context, capacity * sizeof *places);
  csm_mesh_info *infos = grow_array(context, meshes->infos, count, capacity, sizeof *infos);
  void **copies = grow_array(context, meshes->copies, count, capacity, sizeof *copies);
  plan_bounds *bounds = grow_array(context, meshes->bounds, count, capacity, sizeof *bounds);
  const bool made = places && infos && copies && bounds;
  context_release(context, made ? handles_grow(&meshes->handles, places, capacity) : places);
  context_release(context, made ? meshes->infos : infos);
  context_release(context, made ? meshes->copies : copies);
  context_release(context, made ? meshes->bounds : bounds);
  if (!made)
    return CSM_ERROR_OUT_OF_MEMORY;
  meshes->infos = infos;
  meshes->copies = copies;
  meshes->bounds = bounds;
  return CSM_SUCCESS;
}

/* Names a free place without taking it, so that what may still fail changes nothing. */
static csm_result find_place(csm_context *context, uint32_t *index) {
  *index = handles_next(&context->meshes.handles);
  return *index < context->meshes.handles.capacity ? CSM_SUCCESS : grow(context);
}

/* ---- checks ---- */

static csm_result copied_bounds(csm_context *context, const csm_mesh_info *info, float low[3], float high[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = INFINITY;
    high[axis] = -INFINITY;
  }
  const char *next = info->positions;
  for (uint32_t i = 0; i < info->vertex_count; ++i, next += info->position_stride) {
    float p[3];
    memcpy(p, next, sizeof p);
    for (int axis = 0; axis < 3; ++axis) {
      if (!isfinite(p[axis]))
        return context_fail(context, CSM_ERROR_NOT_FINITE, "position %u of the mesh is not finite", i);
      low[axis] = fminf(low[axis], p[axis]);
      high[axis] = fmaxf(high[axis], p[axis]);
    }
  }
  return CSM_SUCCESS;
}

static csm_result given_bounds(csm_context *context, const csm_mesh_info *info, float low[3], float high[3]) {
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = info->bounds_min[axis];
    high[axis] = info->bounds_max[axis];
    if (!isfinite(low[axis]) || !isfinite(high[axis]))
      return context_fail(context, CSM_ERROR_NOT_FINITE, "the mesh's bounds are not finite");
    if (low[axis] > high[axis])
      return context_fail(context, CSM_ERROR_INVALID_VALUE, "the mesh's bounds_min is above its bounds_max");
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

static csm_result check_engines(const device *device, const csm_mesh_info *info) {
  csm_context *context = device->context;
  const char *api = info->vulkan ? "vulkan" : "d3d12";
  if ((info->vulkan && info->d3d12) || info->positions || info->indices)
    return context_fail(context, CSM_ERROR_INVALID_VALUE,
                        "the mesh is given twice: as positions and indices, or in buffers of one API");
  if (device->own || device->gpu.api->api != (info->vulkan ? GPU_API_VULKAN : GPU_API_D3D12))
    return context_fail(context, CSM_ERROR_UNSUPPORTED, "the mesh lies in %s buffers, and the context's device is %s",
                        api, device->own ? "its own" : device->gpu.api->name);
  return CSM_SUCCESS;
}

static csm_result check_shape(csm_context *context, csm_mesh_info *info) {
  if (!info->position_stride)
    info->position_stride = 3 * sizeof(float);
  const char *wrong = info->flags & ~(uint32_t)(CSM_MESH_TWO_SIDED | CSM_MESH_CLOSED) ? "flags"
                      : info->position_stride % 4 || info->position_stride < 12       ? "position_stride"
                      : !info->vertex_count || info->vertex_count > INT32_MAX         ? "vertex_count"
                      : !info->index_count || info->index_count % 3                   ? "index_count"
                      : info->index_size != 2 && info->index_size != 4                ? "index_size"
                      : (uintptr_t)info->indices % info->index_size                   ? "indices' alignment"
                                                                                      : NULL;
  return wrong ? context_fail(context, CSM_ERROR_INVALID_VALUE, "the mesh's %s is not allowed", wrong) : CSM_SUCCESS;
}

static csm_result check_opacity(const device *device, csm_mesh_info *info, bool engines) {
  csm_context *context = device->context;
  if (!info->opacity)
    return CSM_SUCCESS;
  if (!info->uv_stride)
    info->uv_stride = 2 * sizeof(float);
  if (handles_find(&context->opacities.handles, info->opacity) == UINT32_MAX)
    return context_fail(context, CSM_ERROR_INVALID_HANDLE, "the mesh's opacity %llx does not exist",
                        (unsigned long long)info->opacity);
  if (!(info->alpha_cutoff > 0 && info->alpha_cutoff <= 1))
    return context_fail(context, isfinite(info->alpha_cutoff) ? CSM_ERROR_INVALID_VALUE : CSM_ERROR_NOT_FINITE,
                        "the mesh's alpha_cutoff is not above 0 and up to 1");
  if (engines)
    return CSM_SUCCESS;
  if (!info->uvs)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "the mesh's uvs is NULL, and it has an opacity");
  if (info->uv_stride % 4 || info->uv_stride < 8)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "the mesh's uv_stride is not allowed");
  const char *next = info->uvs;
  for (uint32_t i = 0; i < info->vertex_count; ++i, next += info->uv_stride) {
    float uv[2];
    memcpy(uv, next, sizeof uv);
    if (!isfinite(uv[0]) || !isfinite(uv[1]))
      return context_fail(context, CSM_ERROR_NOT_FINITE, "uv %u of the mesh is not finite", i);
  }
  return CSM_SUCCESS;
}

static csm_result check_mesh(const device *device, csm_mesh_info *info, plan_bounds *bounds) {
  csm_context *context = device->context;
  const bool engines = info->vulkan || info->d3d12;
  float low[3], high[3];
  if (!engines && (!info->positions || !info->indices))
    return context_fail(context, CSM_ERROR_NULL_POINTER, "the mesh's %s is NULL",
                        info->positions ? "indices" : "positions");
  csm_result result = engines ? check_engines(device, info) : CSM_SUCCESS;
  if (!result)
    result = check_shape(context, info);
  if (!result)
    result = engines ? given_bounds(context, info, low, high) : copied_bounds(context, info, low, high);
  if (!result && !engines)
    result = check_indices(context, info);
  if (!result)
    result = check_opacity(device, info, engines);
  for (int axis = 0; axis < 3 && !result; ++axis) {
    bounds->center[axis] = ((double)low[axis] + high[axis]) / 2;
    bounds->extent[axis] = ((double)high[axis] - low[axis]) / 2;
  }
  return result;
}

/* ---- copies in host memory ---- */

static size_t uv_bytes(const csm_mesh_info *info) {
  return info->opacity ? (size_t)info->vertex_count * 2 * sizeof(float) : 0;
}

static void copy_packed(char *to, const char *from, uint32_t count, uint32_t stride, uint32_t bytes) {
  for (uint32_t i = 0; i < count; ++i)
    memcpy(to + (size_t)i * bytes, from + (size_t)i * stride, bytes);
}

/* Positions, uvs and indices, one after the other. */
static csm_result keep(csm_context *context, const csm_mesh_info *info, char **out) {
  *out = NULL;
  if (!context->keep_geometry || !info->positions)
    return CSM_SUCCESS;
  const size_t position_bytes = (size_t)info->vertex_count * 12,
               index_bytes = (size_t)info->index_count * info->index_size;
  char *copy = context_allocate(context, position_bytes + uv_bytes(info) + index_bytes);
  if (!copy)
    return CSM_ERROR_OUT_OF_MEMORY;
  copy_packed(copy, info->positions, info->vertex_count, info->position_stride, 12);
  if (info->opacity)
    copy_packed(copy + position_bytes, info->uvs, info->vertex_count, info->uv_stride, 8);
  memcpy(copy + position_bytes + uv_bytes(info), info->indices, index_bytes);
  *out = copy;
  return CSM_SUCCESS;
}

/* What is kept of a mesh's description: its shape, and its data if there is a copy. */
static csm_mesh_info kept_info(const csm_mesh_info *info, const char *copy) {
  const size_t position_bytes = (size_t)info->vertex_count * 12;
  return (csm_mesh_info){.struct_size = sizeof *info,
                         .positions = copy,
                         .position_stride = 12,
                         .vertex_count = info->vertex_count,
                         .indices = copy ? copy + position_bytes + uv_bytes(info) : NULL,
                         .index_count = info->index_count,
                         .index_size = info->index_size,
                         .opacity = info->opacity,
                         .uvs = copy && info->opacity ? copy + position_bytes : NULL,
                         .uv_stride = 8,
                         .alpha_cutoff = info->alpha_cutoff};
}

/* Counts a mesh among the users of its opacity, or no longer. */
static void use_opacity(csm_context *context, const csm_mesh_info *info, int change) {
  if (info->opacity)
    context->opacities.users[handles_find(&context->opacities.handles, info->opacity)] += (uint32_t)change;
}

csm_result CSM_CALL csm_mesh_create(csm_context *context, const csm_mesh_info *info, csm_mesh *mesh) {
  if (mesh)
    *mesh = 0;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_mesh_info own;
  plan_bounds bounds;
  uint32_t index;
  char *copy = NULL;
  csm_result result = context_usable(context);
  if (!result)
    result = context_check_struct(context, struct_read(&own, sizeof own, info), "csm_mesh_info");
  if (!result && !mesh)
    result = context_fail(context, CSM_ERROR_NULL_POINTER, "mesh is NULL");
  if (!result)
    result = check_mesh(context->device, &own, &bounds);
  if (!result)
    result = find_place(context, &index);
  if (!result)
    result = keep(context, &own, &copy);
  if (!result)
    result = geometry_add(context->device, index, &own);
  if (result) {
    context_release(context, copy);
    return result;
  }
  mesh_table *meshes = &context->meshes;
  meshes->copies[index] = copy;
  meshes->infos[index] = kept_info(&own, copy);
  meshes->bounds[index] = bounds;
  use_opacity(context, &own, 1);
  *mesh = handles_take(&meshes->handles);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_mesh_destroy(csm_context *context, csm_mesh mesh) {
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  const csm_result result = context_usable(context);
  if (result)
    return result;
  mesh_table *meshes = &context->meshes;
  const uint32_t index = handles_find(&meshes->handles, mesh);
  if (index == UINT32_MAX)
    return context_fail(context, CSM_ERROR_INVALID_HANDLE, "mesh %llx does not exist", (unsigned long long)mesh);
  geometry_remove(context->device, index);
  use_opacity(context, &meshes->infos[index], -1);
  context_release(context, meshes->copies[index]);
  meshes->copies[index] = NULL;
  handles_free(&meshes->handles, index);
  return CSM_SUCCESS;
}

/* ---- moving to another device ---- */

static csm_result supply(csm_context *context, uint32_t index, csm_mesh_info *out) {
  const csm_mesh mesh = handles_at(&context->meshes.handles, index);
  const csm_mesh_info *kept = &context->meshes.infos[index];
  if (!context->supply)
    return context_fail(context, CSM_ERROR_INVALID_STATE,
                        "mesh %llx has no copy (CSM_CREATE_KEEP_GEOMETRY) and there is no supply callback",
                        (unsigned long long)mesh);
  *out = (csm_mesh_info){.struct_size = sizeof *out};
  csm_result result = context->supply(context->user, mesh, out);
  if (!result)
    result = struct_check(sizeof *out, out);
  if (result)
    return context_fail(context, result, "mesh %llx was not supplied: %s", (unsigned long long)mesh,
                        csm_result_name(result));
  if (out->vertex_count != kept->vertex_count || out->index_count != kept->index_count ||
      out->index_size != kept->index_size || out->opacity != kept->opacity)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "mesh %llx was supplied with another shape",
                        (unsigned long long)mesh);
  return CSM_SUCCESS;
}

csm_result meshes_move(csm_context *context, device *to) {
  const mesh_table *meshes = &context->meshes;
  csm_result result = geometry_reserve(to, meshes->handles.capacity);
  for (uint32_t i = 0; i < meshes->handles.count && !result; ++i) {
    if (!handles_live(&meshes->handles, i))
      continue;
    csm_mesh_info info = meshes->infos[i];
    plan_bounds bounds;
    if (!info.positions) {
      result = supply(context, i, &info);
      if (!result)
        result = check_mesh(to, &info, &bounds);
    }
    if (!result)
      result = geometry_add(to, i, &info);
  }
  return result;
}

void meshes_destroy(csm_context *context) {
  mesh_table *meshes = &context->meshes;
  for (uint32_t i = 0; i < meshes->handles.count; ++i)
    context_release(context, meshes->copies[i]);
  context_release(context, meshes->handles.places);
  context_release(context, meshes->infos);
  context_release(context, meshes->copies);
  context_release(context, meshes->bounds);
}
