#include "cascades.h"

#include <string.h>

/* ---- maps ---- */

static void maps_free(csm_context *context, retired *self) {
  cascade_maps *maps = (cascade_maps *)self;
  for (uint32_t i = 0; i < maps->count; ++i)
    context->gpu.api->target_destroy(context->gpu.device, maps->targets[i]);
  context_image_free(context, maps->image);
  context_release(context, maps);
}

static csm_result maps_create(csm_context *context, const csm_config *config, cascade_maps **out) {
  cascade_maps *maps = context_allocate(context, sizeof *maps);
  if (!maps)
    return CSM_ERROR_OUT_OF_MEMORY;
  maps->count = config->cascade_count;
  maps->resolution = config->resolution;
  const gpu_image_info info = {
      .name = "cascade maps",
      .format = GPU_FORMAT_D32_FLOAT,
      .usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE,
      .width = config->resolution,
      .height = config->resolution,
      .layers = config->cascade_count,
      .array = true,
  };
  csm_result result = context_image(context, &info, &maps->image);
  for (uint32_t i = 0; i < maps->count && !result; ++i) {
    const gpu_target_info target = {.name = "cascade map", .depth = maps->image, .depth_layer = i};
    result = context_check(context, context->gpu.api->target_create(context->gpu.device, &target, &maps->targets[i]),
                           "a cascade's target");
  }
  if (result) {
    maps_free(context, &maps->retired);
    return result;
  }
  *out = maps;
  return CSM_SUCCESS;
}

/* ---- the mask ---- */

static void mask_free(csm_context *context, retired *self) {
  const pass_gpu gpu = context->gpu;
  cascade_mask *mask = (cascade_mask *)self;
  gpu.api->bindings_destroy(gpu.device, mask->bindings);
  gpu.api->target_destroy(gpu.device, mask->depth_target);
  gpu.api->target_destroy(gpu.device, mask->mask_target);
  context_image_free(context, mask->depth);
  context_image_free(context, mask->mask);
  context_buffer_free(context, mask->constants, (uint64_t)context->slot_count * MASK_BLOCKS);
  context_release(context, mask);
}

static void mask_drop(csm_cascades *cascades) {
  if (cascades->mask)
    retire(cascades->context, &cascades->mask->retired, mask_free);
  cascades->mask = NULL;
}

static csm_result mask_images(csm_context *context, cascade_mask *mask) {
  gpu_image_info info = {
      .name = "camera depth",
      .format = GPU_FORMAT_D32_FLOAT,
      .usage = GPU_IMAGE_TARGET | GPU_IMAGE_SAMPLED | GPU_IMAGE_COPY_SOURCE,
      .width = mask->width,
      .height = mask->height,
      .layers = 1,
  };
  csm_result result = context_image(context, &info, &mask->depth);
  info.name = "mask";
  info.format = GPU_FORMAT_R8_UNORM;
  return result ? result : context_image(context, &info, &mask->mask);
}

static csm_result mask_create(csm_cascades *cascades, uint32_t width, uint32_t height, cascade_mask **out) {
  csm_context *context = cascades->context;
  const pass_gpu gpu = context->gpu;
  cascade_mask *mask = context_allocate(context, sizeof *mask);
  if (!mask)
    return CSM_ERROR_OUT_OF_MEMORY;
  mask->width = width;
  mask->height = height;
  csm_result result = mask_images(context, mask);
  if (!result)
    result = context_buffer(context,
                            &(gpu_buffer_info){.name = "mask constants",
                                               .kind = GPU_BUFFER_UPLOAD,
                                               .size = (uint64_t)context->slot_count * MASK_BLOCKS},
                            &mask->constants);
  if (!result)
    result = context_check(context,
                           gpu.api->target_create(gpu.device,
                                                  &(gpu_target_info){.name = "camera depth", .depth = mask->depth},
                                                  &mask->depth_target),
                           "the camera depth's target");
  if (!result)
    result = context_check(
        context,
        gpu.api->target_create(gpu.device, &(gpu_target_info){.name = "mask", .color = mask->mask}, &mask->mask_target),
        "the mask's target");
  if (!result)
    result = context_check(context,
                           mask_bindings(gpu, context->mask_programs[cascades->config.filter], mask->constants,
                                         cascades->maps->image, mask->depth, &mask->bindings),
                           "the mask's bindings");
  if (result) {
    mask_free(context, &mask->retired);
    return result;
  }
  *out = mask;
  return CSM_SUCCESS;
}

csm_result cascades_mask(csm_cascades *cascades, uint32_t width, uint32_t height, cascade_mask **out) {
  if (!cascades->mask || cascades->mask->width != width || cascades->mask->height != height) {
    cascade_mask *fresh;
    const csm_result result = mask_create(cascades, width, height, &fresh);
    if (result)
      return result;
    mask_drop(cascades);
    cascades->mask = fresh;
  }
  *out = cascades->mask;
  return CSM_SUCCESS;
}

/* ---- settings ---- */

static csm_result read_config(csm_context *context, const csm_config *in, csm_config *out) {
  csm_result result = context_check_struct(context, struct_read(out, sizeof *out, in), "csm_config");
  if (result)
    return result;
  out->struct_size = sizeof *out;
  const char *text = "";
  result = plan_config_check(out, &text);
  if (result)
    return context_fail(context, result, "csm_config: %s", text);
  if (out->resolution > context->info.max_image_size)
    return context_fail(context, CSM_ERROR_LIMIT_EXCEEDED, "csm_config: resolution is %u, the device allows %u",
                        out->resolution, context->info.max_image_size);
  return CSM_SUCCESS;
}

csm_result cascades_usable(csm_cascades *cascades) {
  return cascades ? context_usable(cascades->context) : CSM_ERROR_NULL_POINTER;
}

static void reset_stats(csm_cascades *cascades) {
  cascades->stats = (csm_stats){.cascade_count = cascades->config.cascade_count,
                                .clear_gpu_ms = -1,
                                .camera_depth_gpu_ms = -1,
                                .mask_gpu_ms = -1};
  for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i)
    cascades->stats.cascades[i].gpu_ms = -1;
}

static void forget_timing(csm_cascades *cascades) {
  for (uint32_t i = 0; i < CONTEXT_MAX_SLOTS; ++i)
    if (cascades->context->timing[i].cascades == cascades)
      cascades->context->timing[i].cascades = NULL;
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
  result = maps_create(context, &own, &cascades->maps);
  if (result) {
    context_release(context, cascades);
    return result;
  }
  reset_stats(cascades);
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
  csm_context *context = cascades->context;
  csm_config own;
  result = read_config(context, config, &own);
  if (result)
    return result;
  const bool reshaped = own.cascade_count != cascades->maps->count || own.resolution != cascades->maps->resolution;
  if (reshaped) {
    cascade_maps *maps;
    result = maps_create(context, &own, &maps);
    if (result)
      return result;
    retire(context, &cascades->maps->retired, maps_free);
    cascades->maps = maps;
  }
  if (reshaped || own.filter != cascades->config.filter)
    mask_drop(cascades);
  cascades->config = own;
  cascades->drawn = false;
  forget_timing(cascades);
  reset_stats(cascades);
  return CSM_SUCCESS;
}

static void cascades_unlink(csm_cascades *cascades) {
  forget_timing(cascades);
  *cascades->link = cascades->next;
  if (cascades->next)
    cascades->next->link = cascades->link;
  context_release(cascades->context, cascades->plans[0].memory);
  context_release(cascades->context, cascades->plans[1].memory);
  context_release(cascades->context, cascades);
}

csm_result CSM_CALL csm_cascades_destroy(csm_cascades *cascades) {
  if (!cascades)
    return CSM_SUCCESS;
  if (cascades->context->lost) {
    cascades_destroy_now(cascades);
    return CSM_SUCCESS;
  }
  mask_drop(cascades);
  retire(cascades->context, &cascades->maps->retired, maps_free);
  cascades_unlink(cascades);
  return CSM_SUCCESS;
}

void cascades_destroy_now(csm_cascades *cascades) {
  csm_context *context = cascades->context;
  if (cascades->mask)
    mask_free(context, &cascades->mask->retired);
  maps_free(context, &cascades->maps->retired);
  cascades_unlink(cascades);
}
