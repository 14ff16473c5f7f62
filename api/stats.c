#include "cascades.h"

#include <string.h>

void cascades_expect_timing(csm_cascades *cascades, uint32_t count, bool mask) {
  csm_context *context = cascades->context;
  context->timing[recording_slot(context)] = (slot_timing){.cascades = cascades, .count = count, .mask = mask};
}

static double between_ms(const uint64_t *stamps, uint32_t first) {
  return (double)(stamps[first + 1] - stamps[first]) * 1e-6;
}

void cascades_take_timing(csm_cascades *cascades, const slot_timing *timing, const uint64_t *stamps) {
  csm_stats *stats = &cascades->stats;
  if (timing->mask) {
    stats->camera_depth_gpu_ms = between_ms(stamps, 0);
    stats->mask_gpu_ms = between_ms(stamps, 1);
    return;
  }
  stats->clear_gpu_ms = between_ms(stamps, 0);
  for (uint32_t i = 0; i + 2 < timing->count; ++i)
    stats->cascades[i].gpu_ms = between_ms(stamps, 1 + i);
}

csm_result CSM_CALL csm_get_stats(csm_cascades *cascades, csm_stats *out) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  result = context_check_struct(context, struct_check(sizeof *out, out), "csm_stats");
  if (!result)
    result = recording_finish(context);
  if (result)
    return result;
  csm_stats stats = cascades->stats;
  const planned *planned = &cascades->plans[cascades->current];
  if (cascades->drawn)
    stats.plan_hash = plan_hash(&planned->frame, &cascades->config, &planned->scene);
  stats.map_bytes = context->gpu.api->image_bytes(cascades->maps->image);
  if (cascades->mask)
    stats.mask_bytes =
        context->gpu.api->image_bytes(cascades->mask->mask) + context->gpu.api->image_bytes(cascades->mask->depth);
  stats.geometry_bytes = context->geometry.bytes;
  for (uint32_t i = 0; i < context->slot_count; ++i)
    stats.frame_bytes += context->ring[i].size;
  struct_write(out, sizeof stats, &stats);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_bind(csm_cascades *cascades, csm_binding *out) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  result = context_check_struct(context, struct_check(sizeof *out, out), "csm_binding");
  if (!result && !cascades->drawn)
    result = context_fail(context, CSM_ERROR_INVALID_STATE, "no maps have been drawn with this configuration yet");
  if (result)
    return result;
  const plan_frame *plan = &cascades->plans[cascades->current].frame;
  csm_binding binding = {.cascade_count = plan->cascade_count, .resolution = cascades->maps->resolution};
  memcpy(binding.origin, plan->camera.position, sizeof binding.origin);
  for (uint32_t i = 0; i < plan->cascade_count; ++i)
    binding.cascades[i] = plan->cascades[i].info;
  binding.constants_size = plan_write_constants(binding.constants, plan, &cascades->config);
  binding.native_maps = context->gpu.api->image_native(cascades->maps->image);
  if (cascades->mask)
    binding.native_mask = context->gpu.api->image_native(cascades->mask->mask);
  struct_write(out, sizeof binding, &binding);
  return CSM_SUCCESS;
}
