#include "abi/cascades.h"

#include <string.h>

static double between_ms(const uint64_t *stamps, uint32_t first) {
  return (double)(stamps[first + 1] - stamps[first]) * 1e-6;
}

void cascades_take_timing(csm_cascades *cascades, const timing *timing, const uint64_t *stamps) {
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
    result = recording_finish(context->device);
  if (result)
    return result;
  csm_stats stats = cascades->stats;
  const planned *planned = &cascades->plans[cascades->current];
  if (cascades->drawn)
    stats.plan_hash = plan_hash(&planned->frame, &cascades->config, &planned->scene);
  const device *device = context->device;
  stats.map_bytes = device->gpu.api->image_bytes(cascades->resources.maps->image);
  if (cascades->mask)
    stats.mask_bytes = device->gpu.api->image_bytes(cascades->mask->mask);
  if (cascades->mask && cascades->mask->depth)
    stats.mask_bytes += device->gpu.api->image_bytes(cascades->mask->depth);
  stats.geometry_bytes = device->geometry.bytes;
  for (uint32_t i = 0; i < device->slot_count; ++i)
    if (device->slots[i].ring)
      stats.frame_bytes += device->slots[i].ring->size;
  struct_write(out, sizeof stats, &stats);
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_get_casters(csm_cascades *cascades, uint32_t instance_count, uint8_t *drawn) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  const planned *planned = &cascades->plans[cascades->current];
  if (!drawn && instance_count)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "drawn is NULL");
  if (!cascades->drawn)
    return context_fail(context, CSM_ERROR_INVALID_STATE, "no maps have been drawn with this configuration yet");
  if (instance_count != planned->scene.instance_count)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "instance_count is %u, and the frame had %u", instance_count,
                        planned->scene.instance_count);
  for (uint32_t i = 0; i < instance_count; ++i)
    drawn[i] = 0;
  for (uint32_t k = 0; k < planned->frame.cascade_count; ++k) {
    const plan_list *list = &planned->frame.cascades[k].list;
    for (uint32_t i = 0; i < list->instance_count; ++i)
      drawn[list->instances[i]] |= (uint8_t)(1u << k);
  }
  return CSM_SUCCESS;
}

static void bind_images(csm_cascades *cascades, csm_binding *binding) {
  const pass_gpu gpu = cascades->context->device->gpu;
  gpu_native_image native;
  gpu.api->image_native(gpu.device, cascades->resources.maps->image, &native);
  binding->native_maps = native.image;
  binding->native_maps_view = native.view;
  binding->native_sampler = cascades->config.map_reversed ? native.sampler_reversed : native.sampler;
  if (binding->maps_descriptor)
    gpu.api->image_describe(gpu.device, cascades->resources.maps->image, binding->maps_descriptor);
  if (!cascades->mask || !cascades->mask->drawn)
    return;
  gpu.api->image_native(gpu.device, cascades->mask->mask, &native);
  binding->native_mask = native.image;
  binding->native_mask_view = native.view;
  if (binding->mask_descriptor)
    gpu.api->image_describe(gpu.device, cascades->mask->mask, binding->mask_descriptor);
}

csm_result CSM_CALL csm_bind(csm_cascades *cascades, csm_binding *out) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  csm_binding given;
  result = context_check_struct(context, struct_read(&given, sizeof given, out), "csm_binding");
  if (!result && !cascades->drawn)
    result = context_fail(context, CSM_ERROR_INVALID_STATE, "no maps have been drawn with this configuration yet");
  if (result)
    return result;
  const plan_frame *plan = &cascades->plans[cascades->current].frame;
  csm_binding binding = {.cascade_count = plan->cascade_count,
                         .resolution = cascades->config.resolution,
                         .maps_descriptor = given.maps_descriptor,
                         .mask_descriptor = given.mask_descriptor};
  memcpy(binding.origin, plan->camera.position, sizeof binding.origin);
  for (uint32_t i = 0; i < plan->cascade_count; ++i) {
    binding.cascades[i] = plan->cascades[i].info;
    binding.resolutions[i] = plan->cascades[i].resolution;
  }
  binding.constants_size = plan_write_constants(binding.constants, plan, &cascades->config);
  bind_images(cascades, &binding);
  struct_write(out, sizeof binding, &binding);
  return CSM_SUCCESS;
}
