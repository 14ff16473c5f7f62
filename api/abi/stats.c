#include "abi/budget.h"
#include "abi/view.h"

/* Of everything that the last plan holds; 0 if its instances, or meshes, have changed since. */
static uint64_t hash_of(const csm_cascades *cascades) {
  const planned *planned = cascades_planned(cascades);
  if (!cascades->drawn || !planned_current(cascades))
    return 0;
  const instances *store = planned->scene ? &planned->scene->store : &planned->list;
  const plan_scene scene = scene_of(&cascades->context->assets, store);
  return plan_hash(&planned->frame, &cascades->config, &scene);
}

csm_result CSM_CALL csm_get_stats(csm_cascades *cascades, csm_stats *out) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  device *device = context_device(context);
  result = host_check_struct(&context->host, struct_check(sizeof *out, out), "csm_stats");
  if (!result)
    result = recording_finish(device);
  if (result)
    return result;
  csm_stats stats = {.cascade_count = cascades->config.cascade_count,
                     .plan_hash = hash_of(cascades),
                     .geometry_bytes = device->geometry.bytes,
                     .frame_bytes = ring_bytes(device),
                     .mesh_trees_ms = meshes_trees_ms(&context->assets)};
  if (cascades->drawn) {
    stats.plan_ms = cascades->plan_ms;
    stats.record_ms = cascades->record_ms;
    stats.instances = cascades_planned(cascades)->instances;
    stats.instances_changed = cascades_planned(cascades)->changed;
    stats.cells_by = cascades_planned(cascades)->frame.cells_by;
    stats.cells_read = cascades_planned(cascades)->frame.cells_read;
  }
  technique_set_tell(&cascades->techniques, device, &stats);
  budget_tell(cascades, &stats);
  struct_write(out, sizeof stats, &stats);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_get_view_stats(csm_view *view, csm_view_stats *out) {
  if (!view)
    return CSM_ERROR_NULL_POINTER;
  csm_context *context = view->context;
  device *device = context_device(context);
  csm_result result = context_usable(context);
  if (!result)
    result = host_check_struct(&context->host, struct_check(sizeof *out, out), "csm_view_stats");
  if (!result)
    result = recording_finish(device);
  if (result)
    return result;
  csm_view_stats stats = {0};
  technique_set_tell_view(&view->techniques, device, &stats);
  struct_write(out, sizeof stats, &stats);
  return CSM_SUCCESS;
}

/* ---- casters ---- */

static csm_result casters_of_scene(csm_cascades *cascades, uint32_t count, const csm_instance_id *ids, uint8_t *drawn) {
  host *host = &cascades->context->host;
  const planned *planned = cascades_planned(cascades);
  if (!planned_current(cascades))
    return host_fail(host, CSM_ERROR_INVALID_STATE, "the scene has changed since its last frame");
  const instances *store = &planned->scene->store;
  for (uint32_t i = 0; i < count; ++i)
    if (instances_find(store, ids[i]) == UINT32_MAX)
      return host_fail(host, CSM_ERROR_INVALID_HANDLE, "id %u: instance %llx does not exist", i,
                       (unsigned long long)ids[i]);
  for (uint32_t i = 0; i < count; ++i)
    drawn[i] = (uint8_t)plan_drawn_by(&planned->frame, instances_find(store, ids[i]));
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_get_casters(csm_cascades *cascades, uint32_t count, const csm_instance_id *ids,
                                    uint8_t *drawn) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  host *host = &cascades->context->host;
  const planned *planned = cascades_planned(cascades);
  result = cascades_drawn(cascades);
  if (result)
    return result;
  const bool of_scene = planned->scene || planned->scene_gone;
  if (count && !drawn)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "drawn is NULL");
  if (of_scene != (ids != NULL) && (count || !of_scene))
    return host_fail(host, CSM_ERROR_INVALID_VALUE,
                     of_scene ? "ids is NULL, and the frame had a scene" : "ids are given, and the frame had no scene");
  if (of_scene)
    return casters_of_scene(cascades, count, ids, drawn);
  if (count != planned->instances)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "count is %u, and the frame had %u instances", count,
                     planned->instances);
  for (uint32_t i = 0; i < count; ++i)
    drawn[i] = (uint8_t)plan_drawn_by(&planned->frame, i);
  return CSM_SUCCESS;
}
