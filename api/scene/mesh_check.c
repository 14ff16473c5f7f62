#include "scene/mesh_check.h"

#include <math.h>
#include <string.h>

/* ---- where it is ---- */

static csm_result find_bounds(host *host, const void *positions, uint32_t stride, uint32_t count, plan_bounds *bounds) {
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  const char *next = positions;
  for (uint32_t i = 0; i < count; ++i, next += stride) {
    float p[3];
    memcpy(p, next, sizeof p);
    for (int axis = 0; axis < 3; ++axis) {
      if (!plan_finite_floats(&p[axis], 1))
        return host_fail(host, CSM_ERROR_NOT_FINITE, "position %u of the mesh is not finite", i);
      low[axis] = fminf(low[axis], p[axis]);
      high[axis] = fmaxf(high[axis], p[axis]);
    }
  }
  plan_bounds_make(bounds, low, high);
  return CSM_SUCCESS;
}

static csm_result take_bounds(host *host, const float low[3], const float high[3], plan_bounds *bounds) {
  if (!plan_finite_floats(low, 3) || !plan_finite_floats(high, 3))
    return host_fail(host, CSM_ERROR_NOT_FINITE, "the mesh's bounds are not finite");
  for (int axis = 0; axis < 3; ++axis)
    if (low[axis] > high[axis])
      return host_fail(host, CSM_ERROR_INVALID_VALUE, "the mesh's bounds_min is above its bounds_max");
  plan_bounds_in_place(bounds, low, high);
  return CSM_SUCCESS;
}

/* ---- what it is ---- */

static csm_result check_indices(host *host, const csm_mesh_info *info) {
  for (uint32_t i = 0; i < info->index_count; ++i) {
    const uint32_t index =
        info->index_size == 2 ? ((const uint16_t *)info->indices)[i] : ((const uint32_t *)info->indices)[i];
    if (index >= info->vertex_count)
      return host_fail(host, CSM_ERROR_INVALID_INDEX, "index %u of the mesh is %u, of %u vertices", i, index,
                       info->vertex_count);
  }
  return CSM_SUCCESS;
}

static csm_result check_source(host *host, const device *device, const csm_mesh_info *info) {
  if (!info->vulkan && !info->d3d12) {
    if (info->positions && info->indices)
      return CSM_SUCCESS;
    return host_fail(host, CSM_ERROR_NULL_POINTER, "the mesh's %s is NULL", info->positions ? "indices" : "positions");
  }
  if ((info->vulkan && info->d3d12) || info->positions || info->indices)
    return host_fail(host, CSM_ERROR_INVALID_VALUE,
                     "the mesh is given twice: as positions and indices, or in buffers of one API");
  if (device->own || device->gpu.api->api != (info->vulkan ? GPU_API_VULKAN : GPU_API_D3D12))
    return host_fail(host, CSM_ERROR_UNSUPPORTED, "the mesh lies in %s buffers, and the context's device is %s",
                     info->vulkan ? "vulkan" : "d3d12", device->own ? "its own" : device->gpu.api->name);
  return CSM_SUCCESS;
}

static bool stride_allowed(uint32_t stride, uint32_t least) {
  return stride % 4 == 0 && stride >= least;
}

static csm_result check_shape(host *host, csm_mesh_info *info) {
  if (!info->position_stride)
    info->position_stride = 3 * sizeof(float);
  const char *wrong = info->flags & ~(uint32_t)(CSM_MESH_TWO_SIDED | CSM_MESH_WATERTIGHT) ? "flags"
                      : !stride_allowed(info->position_stride, 12)                        ? "position_stride"
                      : !info->vertex_count || info->vertex_count > INT32_MAX             ? "vertex_count"
                      : !info->index_count || info->index_count % 3                       ? "index_count"
                      : info->index_size != 2 && info->index_size != 4                    ? "index_size"
                      : (uintptr_t)info->indices % info->index_size                       ? "indices' alignment"
                                                                                          : NULL;
  return wrong ? host_fail(host, CSM_ERROR_INVALID_VALUE, "the mesh's %s is not allowed", wrong) : CSM_SUCCESS;
}

static csm_result check_uvs(host *host, const csm_mesh_info *info) {
  if (!info->uvs)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "the mesh's uvs is NULL, and it has an alpha mask");
  if (!stride_allowed(info->uv_stride, 8))
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "the mesh's uv_stride is not allowed");
  const char *next = info->uvs;
  for (uint32_t i = 0; i < info->vertex_count; ++i, next += info->uv_stride) {
    float uv[2];
    memcpy(uv, next, sizeof uv);
    if (!plan_finite_floats(uv, 2))
      return host_fail(host, CSM_ERROR_NOT_FINITE, "uv %u of the mesh is not finite", i);
  }
  return CSM_SUCCESS;
}

static csm_result check_cut_out(const assets *assets, csm_mesh_info *info) {
  if (!info->alpha_mask)
    return CSM_SUCCESS;
  if (!info->uv_stride)
    info->uv_stride = 2 * sizeof(float);
  if (handles_find(&assets->alpha_masks.handles, info->alpha_mask) == UINT32_MAX)
    return host_fail(assets->host, CSM_ERROR_INVALID_HANDLE, "the mesh's alpha mask %llx does not exist",
                     (unsigned long long)info->alpha_mask);
  const bool finite = plan_finite_floats(&info->alpha_cutoff, 1);
  if (!finite || info->alpha_cutoff <= 0 || info->alpha_cutoff > 1)
    return host_fail(assets->host, finite ? CSM_ERROR_INVALID_VALUE : CSM_ERROR_NOT_FINITE,
                     "the mesh's alpha_cutoff is not above 0 and up to 1");
  return info->positions ? check_uvs(assets->host, info) : CSM_SUCCESS; /* geometry_add checks an engine's own */
}

csm_result mesh_check(const assets *assets, const device *device, csm_mesh_info *info, plan_bounds *bounds) {
  host *host = assets->host;
  csm_result result = check_source(host, device, info);
  if (!result)
    result = check_shape(host, info);
  if (!result && info->positions)
    result = find_bounds(host, info->positions, info->position_stride, info->vertex_count, bounds);
  else if (!result)
    result = take_bounds(host, info->bounds_min, info->bounds_max, bounds);
  if (!result && info->positions)
    result = check_indices(host, info);
  return result ? result : check_cut_out(assets, info);
}

csm_result mesh_check_update(const assets *assets, uint32_t mesh, csm_mesh_update_info *info, plan_bounds *bounds) {
  const bool engines = geometry_is_engines(assets->device, mesh);
  if (!info->position_stride)
    info->position_stride = 3 * sizeof(float);
  if (info->flags || info->reserved || !stride_allowed(info->position_stride, 12))
    return host_fail(assets->host, CSM_ERROR_INVALID_VALUE, "csm_mesh_update_info: %s is not allowed",
                     info->flags      ? "flags"
                     : info->reserved ? "reserved"
                                      : "position_stride");
  if (engines && info->positions)
    return host_fail(assets->host, CSM_ERROR_INVALID_VALUE,
                     "csm_mesh_update_info: positions are given, and the mesh lies in an engine's buffers");
  if (engines)
    return take_bounds(assets->host, info->bounds_min, info->bounds_max, bounds);
  if (!info->positions)
    return host_fail(assets->host, CSM_ERROR_NULL_POINTER, "csm_mesh_update_info: positions is NULL");
  return find_bounds(assets->host, info->positions, info->position_stride, assets->meshes.infos[mesh].vertex_count,
                     bounds);
}
