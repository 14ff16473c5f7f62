#include "abi/frame_input.h"

static csm_result check_recording(csm_context *context, const csm_frame *frame, bool draws) {
  host *host = &context->host;
  const bool own = context_device(context)->own;
  if (own && frame->draw && draws)
    return host_fail(host, CSM_ERROR_UNSUPPORTED, "csm_frame: draw needs an engine's device");
  if (own && (frame->command_buffer || frame->frame))
    return host_fail(host, CSM_ERROR_INVALID_VALUE,
                     "csm_frame: %s belongs to an engine's device, and this context opened its own",
                     frame->frame ? "frame" : "command_buffer");
  if (!own && !frame->command_buffer)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "csm_frame: command_buffer is NULL");
  if (!own && !frame->frame)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_frame: frame is 0; frames are counted from 1");
  return CSM_SUCCESS;
}

static csm_result check_instances(csm_context *context, const csm_frame *frame) {
  host *host = &context->host;
  if (frame->scene && (frame->instances || frame->instance_count))
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_frame: a scene and instances are given");
  if (frame->scene && !scene_known(&context->assets, frame->scene))
    return host_fail(host, CSM_ERROR_INVALID_HANDLE, "csm_frame: scene is none of this context");
  if (frame->instance_count && !frame->instances)
    return host_fail(host, CSM_ERROR_NULL_POINTER, "csm_frame: instances is NULL");
  return CSM_SUCCESS;
}

static csm_result read_light(csm_context *context, frame_input *out) {
  host *host = &context->host;
  const csm_result result =
      host_check_struct(host, struct_read(&out->light, sizeof out->light, out->frame.light), "csm_frame: light");
  if (result)
    return result;
  const double diameter = out->light.angular_diameter;
  if (!plan_finite(&out->light.angular_diameter, 1))
    return host_fail(host, CSM_ERROR_NOT_FINITE, "csm_light: angular_diameter is not finite");
  if (diameter < 0 || diameter > 1)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_light: angular_diameter is not from 0 to 1");
  return CSM_SUCCESS;
}

csm_result frame_input_read(csm_context *context, const csm_frame *in, bool light, frame_input *out) {
  host *host = &context->host;
  csm_frame *frame = &out->frame;
  csm_result result = host_check_struct(host, struct_read(frame, sizeof *frame, in), "csm_frame");
  if (!result && frame->flags & ~(uint32_t)(CSM_FRAME_TIMESTAMPS | CSM_FRAME_RECEIVERS))
    result = host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_frame: unknown flags %x", frame->flags);
  if (!result && frame->reserved)
    result = host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_frame: reserved is %u, not 0", frame->reserved);
  if (!result)
    result = check_recording(context, frame, light);
  if (!result)
    result = check_instances(context, frame);
  if (!result)
    result = host_check_struct(host, struct_read(&out->camera, sizeof out->camera, frame->camera), "csm_frame: camera");
  if (!result && light)
    result = read_light(context, out);
  if (result)
    return result;
  frame->camera = &out->camera;
  frame->light = light ? &out->light : NULL;
  return CSM_SUCCESS;
}

csm_result frame_input_scene(csm_context *context, const frame_input *input, instances *list, plan_scene *out) {
  const csm_frame *frame = &input->frame;
  if (frame->scene) {
    *out = scene_of(&context->assets, &frame->scene->store);
    return CSM_SUCCESS;
  }
  const csm_result result = scene_take_list(&context->assets, list, frame->instances, frame->instance_count);
  if (!result)
    *out = scene_of(&context->assets, list);
  return result;
}
