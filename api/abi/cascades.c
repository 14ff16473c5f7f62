#include "abi/cascades.h"

#include <string.h>

/* ---- maps ---- */

static void maps_free(device *device, retired *self) {
  cascade_maps *maps = (cascade_maps *)self;
  for (uint32_t i = 0; i < maps->layout.layers; ++i)
    device->gpu.api->target_destroy(device->gpu.device, maps->targets[i]);
  device_image_free(device, maps->image);
  context_release(device->context, maps);
}

static csm_result maps_create(device *device, const plan_layout *layout, gpu_format format, cascade_maps **out) {
  cascade_maps *maps = context_allocate(device->context, sizeof *maps);
  if (!maps)
    return CSM_ERROR_OUT_OF_MEMORY;
  maps->layout = *layout;
  maps->format = format;
  const gpu_image_info info = {
      .name = "cascade maps",
      .format = format,
      .usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE,
      .width = layout->width,
      .height = layout->height,
      .layers = layout->layers,
      .array = true,
  };
  csm_result result = device_image(device, &info, &maps->image);
  for (uint32_t i = 0; i < layout->layers && !result; ++i) {
    const gpu_target_info target = {.name = "cascade map", .depth = maps->image, .depth_layer = i};
    result = device_check(device, device->gpu.api->target_create(device->gpu.device, &target, &maps->targets[i]),
                          "a cascade's target");
  }
  if (result) {
    maps_free(device, &maps->retired);
    return result;
  }
  *out = maps;
  return CSM_SUCCESS;
}

static bool maps_fit(const cascade_maps *maps, const plan_layout *layout, gpu_format format) {
  return maps->format == format && memcmp(&maps->layout, layout, sizeof *layout) == 0;
}

/* ---- all that a configuration needs on a device ---- */

void resources_free(device *device, cascade_resources *resources) {
  if (resources->maps)
    maps_free(device, &resources->maps->retired);
  caster_programs_give_back(device, resources->casters);
}

csm_result resources_create(device *device, const csm_config *config, const cascade_resources *old,
                            cascade_resources *out) {
  cascade_resources made = {0};
  plan_layout layout;
  plan_layout_make(&layout, config);
  csm_result result = device_mask_programs(device, config);
  if (!result)
    result = caster_programs_take(device, config, &made.casters);
  if (result)
    return result;
  const gpu_format format = made.casters->casters.format;
  if (old && maps_fit(old->maps, &layout, format))
    made.maps = old->maps;
  else
    result = maps_create(device, &layout, format, &made.maps);
  if (result) {
    caster_programs_give_back(device, made.casters);
    return result;
  }
  *out = made;
  return CSM_SUCCESS;
}

/* Retires what `kept`, which may be NULL, does not use on. */
static void resources_retire(device *device, const cascade_resources *resources, const cascade_resources *kept) {
  if (!kept || kept->maps != resources->maps)
    retire(device, &resources->maps->retired, maps_free);
  caster_programs_give_back(device, resources->casters);
}

/* ---- settings ---- */

static csm_result read_config(csm_context *context, const csm_config *in, csm_config *out) {
  csm_result result = context_check_struct(context, struct_read(out, sizeof *out, in), "csm_config");
  if (result)
    return result;
  out->struct_size = sizeof *out;
  const char *text = "";
  result = plan_config_check(out, &text);
  return result ? context_fail(context, result, "csm_config: %s", text) : CSM_SUCCESS;
}

csm_result cascades_usable(csm_cascades *cascades) {
  return cascades ? context_usable(cascades->context) : CSM_ERROR_NULL_POINTER;
}

static void reset(csm_cascades *cascades, device *device) {
  recording_forget_timing(device, cascades);
  cascades->drawn = false;
  cascades->stats = (csm_stats){.cascade_count = cascades->config.cascade_count,
                                .clear_gpu_ms = -1,
                                .camera_depth_gpu_ms = -1,
                                .mask_gpu_ms = -1};
  for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i)
    cascades->stats.cascades[i].gpu_ms = -1;
}

csm_result CSM_CALL csm_cascades_create(csm_context *context, const csm_config *config, csm_cascades **out) {
  if (out)
    *out = NULL;
  if (!context)
    return CSM_ERROR_NULL_POINTER;
  csm_result result = context_usable(context);
  if (!result && !out)
    result = context_fail(context, CSM_ERROR_NULL_POINTER, "cascades is NULL");
  csm_config own;
  if (!result)
    result = read_config(context, config, &own);
  if (result)
    return result;
  csm_cascades *cascades = context_allocate(context, sizeof *cascades);
  if (!cascades)
    return CSM_ERROR_OUT_OF_MEMORY;
  cascades->context = context;
  cascades->config = own;
  result = resources_create(context->device, &own, NULL, &cascades->resources);
  if (result) {
    context_release(context, cascades);
    return result;
  }
  reset(cascades, context->device);
  cascades->next = context->cascades;
  cascades->link = &context->cascades;
  if (cascades->next)
    cascades->next->link = &cascades->next;
  context->cascades = cascades;
  *out = cascades;
  return CSM_SUCCESS;
}

csm_result CSM_CALL csm_cascades_configure(csm_cascades *cascades, const csm_config *config) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  device *device = cascades->context->device;
  csm_config own;
  result = read_config(cascades->context, config, &own);
  if (result)
    return result;
  cascade_resources fresh;
  result = resources_create(device, &own, &cascades->resources, &fresh);
  if (result)
    return result;
  resources_retire(device, &cascades->resources, &fresh);
  cascades->resources = fresh;
  cascades->config = own;
  cascades->history = (plan_history){0};
  reset(cascades, device);
  return CSM_SUCCESS;
}

void cascades_move(csm_cascades *cascades, device *from, const cascade_resources *resources) {
  mask_drop(cascades, from);
  samples_drop(cascades, from);
  resources_retire(from, &cascades->resources, NULL);
  cascades->resources = *resources;
  reset(cascades, from);
}

/* ---- ends ---- */

static void cascades_unlink(csm_cascades *cascades) {
  csm_context *context = cascades->context;
  recording_forget_timing(context->device, cascades);
  *cascades->link = cascades->next;
  if (cascades->next)
    cascades->next->link = cascades->link;
  context_release(context, cascades->plans[0].memory);
  context_release(context, cascades->plans[1].memory);
  context_release(context, cascades->samples_memory);
  context_release(context, cascades);
}

csm_result CSM_CALL csm_cascades_destroy(csm_cascades *cascades) {
  if (!cascades)
    return CSM_SUCCESS;
  device *device = cascades->context->device;
  mask_drop(cascades, device);
  samples_drop(cascades, device);
  resources_retire(device, &cascades->resources, NULL);
  cascades_unlink(cascades);
  return CSM_SUCCESS;
}

void cascades_destroy_now(csm_cascades *cascades) {
  device *device = cascades->context->device;
  if (cascades->mask)
    mask_free(device, &cascades->mask->retired);
  if (cascades->tiles)
    sample_tiles_free(device, &cascades->tiles->retired);
  resources_free(device, &cascades->resources);
  cascades_unlink(cascades);
}
