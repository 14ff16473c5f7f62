#include "abi/context.h"

#include <string.h>

size_t scene_size(uint32_t instance_count) {
  return ((size_t)instance_count * sizeof(plan_instance) + 63) / 64 * 64;
}

csm_result frame_read(csm_context *context, const csm_frame *in, csm_frame *out) {
  const csm_result result = context_check_struct(context, struct_read(out, sizeof *out, in), "csm_frame");
  if (result)
    return result;
  if (out->flags & ~(uint32_t)CSM_FRAME_TIMESTAMPS || out->reserved)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_frame: unknown flags %x", out->flags);
  if (context->device->own && out->draw)
    return context_fail(context, CSM_ERROR_UNSUPPORTED, "csm_frame: draw needs an engine's device");
  if (context->device->own && (out->command_buffer || out->frame))
    return context_fail(context, CSM_ERROR_INVALID_VALUE,
                        "csm_frame: %s belongs to an engine's device, and this context opened its own",
                        out->frame ? "frame" : "command_buffer");
  if (!context->device->own && !out->command_buffer)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "csm_frame: command_buffer is NULL");
  if (!context->device->own && !out->frame)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_frame: frame is 0; frames are counted from 1");
  if (out->instance_count && !out->instances)
    return context_fail(context, CSM_ERROR_NULL_POINTER, "csm_frame: instances is NULL");
  return CSM_SUCCESS;
}

static csm_result instance_read(csm_context *context, uint32_t index, const csm_instance *in, plan_instance *out) {
  if (in->flags)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "instance %u: unknown flags %x", index, in->flags);
  const uint32_t mesh = handles_find(&context->meshes.handles, in->mesh);
  if (mesh == UINT32_MAX)
    return context_fail(context, CSM_ERROR_INVALID_HANDLE, "instance %u: mesh %llx does not exist", index,
                        (unsigned long long)in->mesh);
  const csm_result result = plan_check_affine(in->transform);
  if (result)
    return context_fail(context, result, "instance %u: the transform is %s", index,
                        result == CSM_ERROR_NOT_FINITE ? "not finite" : "singular or not affine");
  out->mesh = mesh;
  out->mirrored = plan_mirrors(in->transform);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      out->transform[row * 4 + column] = in->transform[column * 4 + row];
  return CSM_SUCCESS;
}

csm_result scene_read(csm_context *context, const csm_frame *frame, void *memory, plan_scene *scene) {
  plan_instance *instances = memory;
  const char *next = (const char *)frame->instances;
  uint32_t stride = 0;
  for (uint32_t i = 0; i < frame->instance_count; ++i, next += stride) {
    uint32_t size;
    memcpy(&size, next, sizeof size);
    csm_instance own;
    csm_result result = struct_read(&own, sizeof own, next);
    if (!result && i && size != stride)
      result = CSM_ERROR_STRUCT_SIZE;
    stride = size;
    if (result)
      return context_fail(context, result, "instance %u: a struct_size that is no csm_instance's, or not the first's",
                          i);
    result = instance_read(context, i, &own, &instances[i]);
    if (result)
      return result;
  }
  *scene = (plan_scene){.instances = instances,
                        .instance_count = frame->instance_count,
                        .meshes = context->meshes.bounds,
                        .mesh_count = context->meshes.handles.count};
  return CSM_SUCCESS;
}
