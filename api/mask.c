#include "cascades.h"

enum { largest_mask = 16384, ring_alignment = 256 };

/* Everything that a resolve needs, reserved before its first command. */
typedef struct resolve {
  csm_mask_info info;
  csm_frame frame;
  plan_camera camera;
  plan_scene scene;
  plan_list list; /* what the camera sees; empty if the engine brings its depth */
  cascade_mask *mask;
  mask_input *input;
  gpu_image *depth, *normals; /* the engine's, or NULL */
  bool unorm_normals;
  sample_read *samples; /* NULL: none are wanted */
  ring_range ring;
  uint64_t matrices_size;
} resolve;

static csm_result read_info(csm_context *context, const csm_mask_info *in, resolve *out) {
  csm_mask_info *info = &out->info;
  const csm_result result = context_check_struct(context, struct_read(info, sizeof *info, in), "csm_mask_info");
  if (result)
    return result;
  if (info->flags & ~(uint32_t)CSM_FRAME_TIMESTAMPS)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_mask_info: unknown flags %x", info->flags);
  if (info->view > CSM_VIEW_DENSITY || info->reserved)
    return context_fail(context, CSM_ERROR_INVALID_VALUE,
                        info->reserved ? "csm_mask_info: reserved is %u, not 0" : "csm_mask_info: there is no view %u",
                        info->reserved ? info->reserved : info->view);
  if (context->device->own && (info->camera_depth || info->normals))
    return context_fail(context, CSM_ERROR_UNSUPPORTED, "csm_mask_info: %s needs an engine's device",
                        info->camera_depth ? "camera_depth" : "normals");
  if (!info->width || !info->height || info->width > largest_mask || info->height > largest_mask)
    return context_fail(context, CSM_ERROR_INVALID_VALUE, "csm_mask_info: a size of %u x %u", info->width,
                        info->height);
  return frame_read(context, info->frame, &out->frame);
}

/* The camera, the instances, and which of them it sees; all but the camera lie in the context's scratch memory. */
static csm_result make_view(csm_context *context, resolve *r) {
  const char *text = "";
  csm_result result = plan_camera_make(&r->camera, r->frame.view, r->frame.projection, &text);
  if (result)
    return context_fail(context, result, "csm_frame: %s", text);
  if (r->info.camera_depth)
    return CSM_SUCCESS;
  const size_t instances = scene_size(r->frame.instance_count);
  const size_t size = instances + plan_memory_size(r->frame.instance_count, context->meshes.handles.count, 0);
  result = context_grow(context, &context->scratch, &context->scratch_size, size);
  if (!result)
    result = scene_read(context, &r->frame, context->scratch, &r->scene);
  if (!result)
    plan_view_make(&r->list, &r->camera, &r->scene, (char *)context->scratch + instances);
  return result;
}

/* ---- the engine's images ---- */

typedef struct imported_image {
  retired retired;
  gpu_image *image;
} imported_image;

static void imported_free(device *device, retired *self) {
  device->gpu.api->image_destroy(device->gpu.device, ((imported_image *)self)->image);
  context_release(device->context, self);
}

/* Takes an engine's image in until the frame that is about to be recorded is done. */
static csm_result import(device *device, const csm_mask_info *info, const void *native, const char *name,
                         gpu_image **out, bool *unorm) {
  if (!native)
    return CSM_SUCCESS;
  imported_image *imported = context_allocate(device->context, sizeof *imported);
  if (!imported)
    return CSM_ERROR_OUT_OF_MEMORY;
  gpu_imported about = {0};
  csm_result result =
      device_check(device, device->gpu.api->image_import(device->gpu.device, native, &imported->image, &about), name);
  if (result) {
    context_release(device->context, imported);
    return result;
  }
  retire(device, &imported->retired, imported_free);
  imported->retired.serial = device->prepared.serial;
  if (about.width != info->width || about.height != info->height)
    return context_fail(device->context, CSM_ERROR_INVALID_VALUE, "%s is %u x %u, and the mask %u x %u", name,
                        about.width, about.height, info->width, info->height);
  *unorm = about.unorm;
  *out = imported->image;
  return CSM_SUCCESS;
}

/* ---- reserving and recording ---- */

/* Whether the program reads the engine's normals: views do without. */
static bool reads_normals(const resolve *r) {
  return r->normals && r->info.view == CSM_VIEW_SHADOW;
}

static gpu_program *choose_program(const csm_cascades *cascades, const resolve *r) {
  return device_mask_program(cascades->context->device, mask_key(&cascades->config, reads_normals(r), r->info.view));
}

static csm_result reserve(csm_cascades *cascades, resolve *r) {
  device *device = cascades->context->device;
  const uint64_t matrices = (uint64_t)r->list.instance_count * PASS_CAMERA_ROWS * 4 * sizeof(float);
  r->matrices_size = (matrices + ring_alignment - 1) / ring_alignment * ring_alignment;
  bool ignored;
  csm_result result = r->info.view == CSM_VIEW_SHADOW ? CSM_SUCCESS : device_view_program(device);
  if (!result)
    result = recording_prepare(device, r->frame.frame, r->matrices_size + MASK_BLOCKS + DEPTH_TILES_BLOCKS, &r->ring);
  if (!result)
    result = mask_prepare(cascades, r->info.width, r->info.height, !r->info.camera_depth, &r->mask);
  if (!result)
    result = import(device, &r->info, r->info.camera_depth, "csm_mask_info: camera_depth", &r->depth, &ignored);
  if (!result)
    result = import(device, &r->info, r->info.normals, "csm_mask_info: normals", &r->normals, &r->unorm_normals);
  if (result)
    return result;
  gpu_image *depth = r->depth ? r->depth : r->mask->depth;
  if (cascades->config.depth_samples != CSM_DEPTH_SAMPLES_OFF)
    result = samples_prepare(cascades, &r->camera, r->info.width, r->info.height, r->ring.buffer, depth, &r->samples);
  if (result)
    return result;
  const gpu_bindings_info reads =
      mask_inputs(choose_program(cascades, r), r->ring.buffer, cascades->resources.maps->image, depth,
                  reads_normals(r) ? r->normals : NULL);
  return mask_input_find(cascades, r->mask, &reads, reads_normals(r), &r->input);
}

static void write_ring(const csm_cascades *cascades, const resolve *r) {
  const plan_frame *plan = &cascades->plans[cascades->current].frame;
  char *blocks = (char *)r->ring.memory + r->matrices_size;
  if (r->list.instance_count)
    plan_write_view_matrices(r->ring.memory, &r->list, &r->camera, &r->scene);
  plan_write_constants((float *)blocks, plan, &cascades->config);
  plan_write_mask_constants((float *)(blocks + MASK_CASCADES_BLOCK), plan, &r->camera, r->mask->width, r->mask->height,
                            r->unorm_normals, r->info.view);
  if (r->samples)
    depth_tiles_write(blocks + MASK_BLOCKS, r->mask->width, r->mask->height, r->camera.reversed ? 0.0f : 1.0f);
}

static void record_depth(csm_cascades *cascades, const resolve *r) {
  const device *device = cascades->context->device;
  if (r->depth)
    return;
  camera_depth_record(device->gpu, &(camera_depth_pass){.programs = device->programs.camera[r->camera.reversed],
                                                        .depth = r->mask->depth,
                                                        .target = r->mask->depth_target,
                                                        .reversed = r->camera.reversed,
                                                        .list = &r->list,
                                                        .meshes = device->geometry.meshes,
                                                        .matrices = r->ring.buffer,
                                                        .matrices_offset = r->ring.offset});
}

static void record(csm_cascades *cascades, const resolve *r) {
  device *device = cascades->context->device;
  const pass_gpu gpu = device->gpu;
  uint32_t first = 0;
  const bool timed = (r->info.flags | r->frame.flags) & CSM_FRAME_TIMESTAMPS &&
                     recording_expect_timing(device, cascades, 3, true, &first);
  if (timed)
    gpu.api->timestamp(gpu.device, first);
  record_depth(cascades, r);
  if (timed)
    gpu.api->timestamp(gpu.device, first + 1);
  const uint32_t blocks = (uint32_t)(r->ring.offset + r->matrices_size);
  mask_record(gpu, &(mask_pass){.program = choose_program(cascades, r),
                                .bindings = r->input->bindings,
                                .target = r->mask->mask_target,
                                .constants_offset = blocks});
  if (r->samples)
    samples_record(cascades, r->samples, blocks + MASK_BLOCKS);
  if (timed)
    gpu.api->timestamp(gpu.device, first + 2);
}

csm_result CSM_CALL csm_resolve_mask(csm_cascades *cascades, const csm_mask_info *in) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  resolve r = {0};
  result = read_info(context, in, &r);
  if (!result && !cascades->drawn)
    result = context_fail(context, CSM_ERROR_INVALID_STATE, "no maps have been drawn with this configuration yet");
  if (!result)
    result = make_view(context, &r);
  if (!result)
    result = reserve(cascades, &r);
  if (!result) {
    write_ring(cascades, &r);
    result = recording_begin(context->device, r.frame.command_buffer);
  }
  if (result) {
    mask_forget(cascades, r.mask);
    return result;
  }
  record(cascades, &r);
  r.input->serial = context->device->serial;
  mask_keep(cascades, r.mask);
  result = recording_end(context->device);
  if (result)
    return result;
  r.mask->drawn = true;
  r.mask->depth_drawn = !r.depth;
  return CSM_SUCCESS;
}
