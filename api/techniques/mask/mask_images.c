#include "abi/cascades.h"

static void inputs_free(device *device, mask_input *input) {
  while (input) {
    mask_input *next = input->next;
    device->gpu.api->bindings_destroy(device->gpu.device, input->bindings);
    context_release(device->context, input);
    input = next;
  }
}

void mask_free(device *device, retired *self) {
  const pass_gpu gpu = device->gpu;
  cascade_mask *mask = (cascade_mask *)self;
  for (int normals = 0; normals < 2; ++normals)
    inputs_free(device, mask->inputs[normals]);
  gpu.api->target_destroy(gpu.device, mask->depth_target);
  gpu.api->target_destroy(gpu.device, mask->mask_target);
  device_image_free(device, mask->depth);
  device_image_free(device, mask->mask);
  context_release(device->context, mask);
}

void mask_drop(csm_cascades *cascades, device *device) {
  if (cascades->mask)
    retire(device, &cascades->mask->retired, mask_free);
  cascades->mask = NULL;
}

csm_result mask_prepare(csm_cascades *cascades, uint32_t width, uint32_t height, bool depth, cascade_mask **out) {
  device *device = cascades->context->device;
  cascade_mask *mask = cascades->mask;
  const bool fits = mask && mask->width == width && mask->height == height && (!depth || mask->depth);
  *out = mask;
  if (fits)
    return CSM_SUCCESS;
  mask = context_allocate(cascades->context, sizeof *mask);
  if (!mask)
    return CSM_ERROR_OUT_OF_MEMORY;
  mask->width = width;
  mask->height = height;
  csm_result result =
      device_drawn_image(device, "mask", GPU_FORMAT_R8_UNORM, width, height, &mask->mask, &mask->mask_target);
  if (!result && depth)
    result = device_drawn_image(device, "camera depth", GPU_FORMAT_D32_FLOAT, width, height, &mask->depth,
                                &mask->depth_target);
  if (result) {
    mask_free(device, &mask->retired);
    return result;
  }
  *out = mask;
  return CSM_SUCCESS;
}

void mask_keep(csm_cascades *cascades, cascade_mask *mask) {
  if (mask == cascades->mask)
    return;
  mask_drop(cascades, cascades->context->device);
  cascades->mask = mask;
}

void mask_forget(csm_cascades *cascades, cascade_mask *mask) {
  if (mask && mask != cascades->mask)
    mask_free(cascades->context->device, &mask->retired);
}

csm_result mask_input_find(csm_cascades *cascades, cascade_mask *mask, const gpu_bindings_info *reads, bool normals,
                           mask_input **out) {
  device *device = cascades->context->device;
  const pass_gpu gpu = device->gpu;
  for (mask_input *input = mask->inputs[normals]; input; input = input->next)
    if (input->serial <= device->done) {
      gpu.api->bindings_write(gpu.device, input->bindings, reads);
      *out = input;
      return CSM_SUCCESS;
    }
  mask_input *input = context_allocate(cascades->context, sizeof *input);
  if (!input)
    return CSM_ERROR_OUT_OF_MEMORY;
  const csm_result result =
      device_check(device, gpu.api->bindings_create(gpu.device, reads, &input->bindings), "the mask's bindings");
  if (result) {
    context_release(cascades->context, input);
    return result;
  }
  input->next = mask->inputs[normals];
  mask->inputs[normals] = input;
  *out = input;
  return CSM_SUCCESS;
}
