#include "cascades.h"
#include "clock.h"

enum { ring_alignment = 256 };

static csm_result make_plan(csm_cascades *cascades, const csm_frame *frame, planned *out) {
  csm_context *context = cascades->context;
  const size_t scene = scene_size(frame->instance_count);
  const size_t lists =
      plan_memory_size(frame->instance_count, context->meshes.handles.count, cascades->config.cascade_count);
  csm_result result = context_grow(context, &out->memory, &out->size, scene + lists);
  if (!result)
    result = scene_read(context, frame, out->memory, &out->scene);
  if (result)
    return result;
  const char *text = "";
  samples_collect(cascades);
  const plan_frame_info info = {.config = &cascades->config,
                                .view = frame->view,
                                .projection = frame->projection,
                                .light = frame->light_direction,
                                .scene = &out->scene,
                                .before = &cascades->history,
                                .samples = &cascades->samples};
  result = plan_frame_make(&out->frame, &info, (char *)out->memory + scene, &text);
  return result ? context_fail(context, result, "csm_frame: %s", text) : CSM_SUCCESS;
}

/* Where each cascade's matrices begin in the ring; returns the bytes of all. */
static uint64_t place_matrices(const plan_frame *plan, uint64_t offsets[CSM_MAX_CASCADES]) {
  uint64_t size = 0;
  for (uint32_t i = 0; i < plan->cascade_count; ++i) {
    offsets[i] = size;
    size += (uint64_t)plan->cascades[i].list.instance_count * PASS_CASCADE_ROWS * 4 * sizeof(float);
    size = (size + ring_alignment - 1) / ring_alignment * ring_alignment;
  }
  return size;
}

static void count_casters(csm_cascades *cascades, const plan_frame *plan) {
  for (uint32_t i = 0; i < plan->cascade_count; ++i) {
    const plan_list *list = &plan->cascades[i].list;
    csm_cascade_stats *stats = &cascades->stats.cascades[i];
    stats->casters_drawn = list->instance_count;
    stats->casters_culled = list->culled;
    stats->triangles_drawn = 0;
    for (uint32_t d = 0; d < list->draw_count; ++d)
      stats->triangles_drawn += (uint64_t)cascades->context->device->geometry.meshes[list->draws[d].mesh].index_count /
                                3 * list->draws[d].count;
  }
}

/* ---- an engine's own draws ---- */

typedef struct engine_draw {
  device *device;
  const csm_frame *frame;
  const plan_frame *plan;
  const csm_cascades *cascades;
} engine_draw;

static void call_engine(void *user, uint32_t cascade) {
  const engine_draw *draw = user;
  const plan_rect *rect = &draw->cascades->resources.maps->layout.rects[cascade];
  gpu_native_pass native;
  draw->device->gpu.api->pass_native(draw->device->gpu.device, &native);
  csm_draw_info info = {
      .struct_size = sizeof info,
      .cascade = cascade,
      .resolution = rect->side,
      .x = rect->x,
      .y = rect->y,
      .reversed = draw->cascades->config.map_reversed,
      .depth_format = native.target.depth_format,
      .command_buffer = native.command_buffer,
      .render_pass = native.target.render_pass,
      .depth_view = native.depth_view,
  };
  plan_cascade_volume(draw->plan, cascade, info.world_to_clip, info.planes);
  draw->frame->draw(draw->frame->draw_user, &info);
}

/* ---- the frame ---- */

static void record(csm_cascades *cascades, const csm_frame *frame, const planned *planned, const ring_range *ring,
                   const uint64_t *offsets) {
  device *device = cascades->context->device;
  const cascade_maps *maps = cascades->resources.maps;
  const caster_programs *casters = cascades->resources.casters;
  engine_draw engine = {.device = device, .frame = frame, .plan = &planned->frame, .cascades = cascades};
  cascade_depth_pass pass = {
      .casters = &casters->casters,
      .programs = {casters->programs[GPU_CULL_NONE], casters->programs[GPU_CULL_BACK],
                   casters->programs[GPU_CULL_FRONT]},
      .maps = maps->image,
      .targets = maps->targets,
      .layout = &maps->layout,
      .plan = &planned->frame,
      .meshes = device->geometry.meshes,
      .matrices = ring->buffer,
      .draw = frame->draw ? call_engine : NULL,
      .draw_user = &engine,
  };
  for (uint32_t i = 0; i < planned->frame.cascade_count; ++i)
    pass.matrices_offsets[i] = ring->offset + offsets[i];
  if (frame->flags & CSM_FRAME_TIMESTAMPS)
    pass.timestamps =
        recording_expect_timing(device, cascades, 2 + planned->frame.cascade_count, false, &pass.first_timestamp);
  cascade_depth_record(device->gpu, &pass);
}

csm_result CSM_CALL csm_render_cascades(csm_cascades *cascades, const csm_frame *in) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  csm_context *context = cascades->context;
  device *device = context->device;
  csm_frame frame;
  result = frame_read(context, in, &frame);
  if (result)
    return result;

  planned *next = &cascades->plans[!cascades->current];
  const double begin_ms = clock_ms();
  result = make_plan(cascades, &frame, next);
  if (result)
    return result;
  const double planned_ms = clock_ms();

  uint64_t offsets[CSM_MAX_CASCADES];
  ring_range ring = {0};
  result = recording_prepare(device, frame.frame, place_matrices(&next->frame, offsets), &ring);
  if (result)
    return result;
  const double ready_ms = clock_ms();
  for (uint32_t i = 0; i < next->frame.cascade_count; ++i)
    if (next->frame.cascades[i].list.instance_count)
      plan_write_cascade_matrices((float *)((char *)ring.memory + offsets[i]), &next->frame, i, &next->scene);
  const double written_ms = clock_ms();

  result = recording_begin(device, frame.command_buffer);
  if (result)
    return result;
  record(cascades, &frame, next, &ring, offsets);
  result = recording_end(device);
  if (result)
    return result;

  cascades->current = !cascades->current;
  cascades->history = next->frame.history;
  cascades->drawn = true;
  cascades->stats.plan_ms = planned_ms - begin_ms + (written_ms - ready_ms);
  cascades->stats.record_ms = clock_ms() - written_ms;
  count_casters(cascades, &next->frame);
  return CSM_SUCCESS;
}
