#include "cascades.h"

enum { largest_mask = 16384 };

static csm_result read_mask_info(csm_context *context, const csm_mask_info *in, csm_mask_info *out, csm_frame *frame) {
  const csm_result result = context_check_struct(context, struct_read(out, sizeof *out, in), "csm_mask_info");
  if (result)
    return result;
  if (out->flags & ~(uint32_t)CSM_FRAME_TIMESTAMPS)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_mask_info: unknown flags %x", out->flags);
  if (out->camera_depth || out->normals)
    return context_fail(context, CSM_ERROR_UNSUPPORTED, "csm_mask_info: an engine's %s is not taken in this version",
                        out->camera_depth ? "camera_depth" : "normals");
  if (!out->width || !out->height || out->width > largest_mask || out->height > largest_mask)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_mask_info: a size of %u x %u", out->width, out->height);
  return frame_read(context, out->frame, frame);
}

/* The camera, the instances, and which of them it sees; all but the camera lie in the context's scratch memory. */
static csm_result make_view(csm_context *context, const csm_frame *frame, plan_camera *camera, plan_scene *scene,
                            plan_list *list) {
  const char *text = "";
  csm_result result = plan_camera_make(camera, frame->view, frame->projection, &text);
  if (result)
    return context_fail(context, result, "csm_frame: %s", text);
  const size_t instances = scene_size(frame->instance_count);
  const size_t size = instances + plan_memory_size(frame->instance_count, context->geometry.slot_count, 0);
  result = context_grow(context, &context->scratch, &context->scratch_size, size);
  if (!result)
    result = scene_read(context, frame, context->scratch, scene);
  if (!result)
    plan_view_make(list, camera, scene, (char *)context->scratch + instances);
  return result;
}

static uint32_t write_constants(const csm_cascades *cascades, const cascade_mask *mask, const plan_camera *camera,
                                uint32_t slot) {
  const uint32_t offset = slot * MASK_BLOCKS;
  char *memory = (char *)cascades->context->gpu.api->buffer_memory(mask->constants) + offset;
  const plan_frame *plan = &cascades->plans[cascades->current].frame;
  plan_write_constants((float *)memory, plan, &cascades->config);
  plan_write_mask_constants((float *)(memory + MASK_CASCADES_BLOCK), plan, camera, mask->width, mask->height);
  return offset;
}

static void record(csm_cascades *cascades, const cascade_mask *mask, const plan_camera *camera, const plan_list *list,
                   const ring_range *ring, bool timestamps) {
  csm_context *context = cascades->context;
  const pass_gpu gpu = context->gpu;
  if (timestamps)
    gpu.api->timestamp(gpu.device, 0);
  camera_depth_record(gpu, &(camera_depth_pass){.program = context->camera_programs[camera->reversed],
                                                .depth = mask->depth,
                                                .target = mask->depth_target,
                                                .reversed = camera->reversed,
                                                .list = list,
                                                .meshes = context->geometry.meshes,
                                                .matrices = ring->buffer,
                                                .matrices_offset = ring->offset});
  if (timestamps)
    gpu.api->timestamp(gpu.device, 1);
  mask_record(gpu, &(mask_pass){.program = context->mask_programs[cascades->config.filter],
                                .bindings = mask->bindings,
                                .target = mask->mask_target,
                                .constants_offset = write_constants(cascades, mask, camera, recording_slot(context))});
  if (timestamps)
    gpu.api->timestamp(gpu.device, 2);
}

csm_result CSM_CALL csm_resolve_mask(csm_cascades *cascades, const csm_mask_info *in) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  csm_mask_info info;
  csm_frame frame;
  result = read_mask_info(context, in, &info, &frame);
  if (!result && !cascades->drawn)
    result = context_fail(context, CSM_ERROR_INVALID_STATE, "no maps have been drawn with this configuration yet");
  if (result)
    return result;

  plan_camera camera;
  plan_scene scene;
  plan_list list;
  cascade_mask *mask;
  ring_range ring = {0};
  result = make_view(context, &frame, &camera, &scene, &list);
  if (!result)
    result = recording_prepare(context, (uint64_t)list.instance_count * PASS_CAMERA_ROWS * 4 * sizeof(float), &ring);
  if (!result)
    result = cascades_mask(cascades, info.width, info.height, &mask);
  if (result)
    return result;
  if (list.instance_count)
    plan_write_view_matrices(ring.memory, &list, &camera, &scene);

  result = recording_begin(context);
  if (result)
    return result;
  const bool timestamps = (info.flags | frame.flags) & CSM_FRAME_TIMESTAMPS;
  record(cascades, mask, &camera, &list, &ring, timestamps);
  result = recording_end(context);
  if (result)
    return result;
  if (timestamps)
    cascades_expect_timing(cascades, 3, true);
  mask->drawn = true;
  return CSM_SUCCESS;
}
