#include "abi/budget.h"
#include "abi/frame_input.h"
#include "abi/view.h"
#include "device/clock.h"
#include "techniques/depth_samples/depth_samples.h"
#include "techniques/rays/instances.h"
#include "techniques/seen_depth/seen_depth.h"

#include <string.h>

/* ---- planning ---- */

/* What the views that are resolved with these cascades have seen, of those that look where they do. */
static csm_result gather_samples(csm_cascades *cascades, uint32_t *count) {
  csm_context *context = cascades->context;
  uint32_t most = 0;
  *count = 0;
  if (cascades->config.depth_samples == CSM_DEPTH_SAMPLES_OFF)
    return CSM_SUCCESS;
  for (const csm_view *v = context->views; v; v = v->next)
    most += view_resolves(v, cascades);
  const csm_result result =
      host_grow(&context->host, (void **)&cascades->samples, &cascades->samples_size, most * sizeof *cascades->samples);
  for (const csm_view *v = context->views; v && !result; v = v->next) {
    if (!view_resolves(v, cascades))
      continue;
    plan_depth_samples *samples = &cascades->samples[*count];
    depth_samples_collect(&v->techniques, context_device(context), samples);
    *count += plan_depth_samples_count(samples, cascades->config.depth_samples_margin);
  }
  return result;
}

/* Room for the boxes of a scene that stays. */
static csm_result reserve_cache(csm_cascades *cascades, const plan_scene *scene) {
  host *host = &cascades->context->host;
  plan_cache *cache = &cascades->cache;
  if (scene->slot_count <= cache->slots)
    return CSM_SUCCESS;
  const uint32_t slots = scene->slot_count + scene->slot_count / 2;
  void *memory = host_allocate(host, plan_cache_size(slots));
  if (!memory)
    return CSM_ERROR_OUT_OF_MEMORY;
  host_release(host, cache->memory);
  *cache = (plan_cache){.memory = memory, .slots = slots};
  return CSM_SUCCESS;
}

/* How many instances came, moved, changed or went since the last frame; all of a list's may have. */
static uint32_t count_changed(const csm_cascades *cascades, const planned *next) {
  const planned *last = cascades_planned(cascades);
  const bool same = next->scene && next->scene == last->scene;
  return same ? instances_changed_since(&next->scene->store, last->revision) : next->instances;
}

/* On an own device no depth of an engine's is resolved, so none but the frame's receivers are asked for. */
static bool only_receivers(const csm_context *context, const csm_frame *frame) {
  return context_device(context)->own || frame->flags & CSM_FRAME_RECEIVERS;
}

/* Instances that a plan has room for, so that no plan of a small scene is made twice. */
enum { room_to_begin_with = 1024 };

/* A plan that finds more than there is room for is made once more. */
static csm_result plan_with_room(host *host, planned *out, const plan_frame_info *info) {
  const char *text = "";
  const uint32_t slots = info->scene->slot_count, begin = slots < room_to_begin_with ? slots : room_to_begin_with;
  csm_result result;
  out->memory.most = out->memory.most > begin ? out->memory.most : begin;
  do {
    const size_t size = plan_memory_size(out->memory.most, info->scene->mesh_count, plan_windows_most(info->config));
    result = host_grow(host, &out->memory.at, &out->size, size);
    if (result)
      return result;
    result = plan_frame_make(&out->frame, info, &out->memory, &text);
  } while (result == CSM_ERROR_OUT_OF_MEMORY && plan_memory_short(&out->memory));
  return result ? host_fail(host, result, "csm_frame: %s", text) : CSM_SUCCESS;
}

/* What a frame's camera sees, by a depth that was drawn for this very frame. */
typedef struct frame_depth {
  const plan_seen_depth *seen; /* NULL: it is not known */
  planned_depth about;
} frame_depth;

/* Whether a look was one at this frame: by its camera, and its scene as it is. */
static csm_result check_look(csm_context *context, const view_look *look, const frame_input *input) {
  host *host = &context->host;
  plan_camera camera;
  const char *text = "";
  const plan_scene scene = scene_of(&context->assets, &input->frame.scene->store);
  const csm_result result =
      plan_camera_make(&camera, input->camera.view, input->camera.projection, input->camera.reversed, &text);
  if (result)
    return host_fail(host, result, "csm_frame: %s", text);
  if (!view_looked_with(look, &camera))
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_frame: depth_view saw what another camera sees");
  if (look->scene != scene.identity)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_frame: depth_view saw another scene");
  if (look->revision != scene.revision)
    return host_fail(host, CSM_ERROR_INVALID_STATE, "csm_frame: the scene has changed since depth_view saw it");
  return CSM_SUCCESS;
}

static csm_result find_depth(csm_context *context, const frame_input *input, frame_depth *out) {
  const csm_view *view = input->frame.depth_view;
  host *host = &context->host;
  *out = (frame_depth){0};
  if (!view)
    return CSM_SUCCESS;
  if (!view_known(context, view))
    return host_fail(host, CSM_ERROR_INVALID_HANDLE, "csm_frame: depth_view is none of this context");
  if (!input->frame.scene)
    return host_fail(host, CSM_ERROR_INVALID_VALUE, "csm_frame: depth_view is given, and no scene");
  csm_result result = seen_depth_collect(&view->techniques, context_device(context), &out->seen);
  if (!result)
    result = check_look(context, &view->look, input);
  out->about = (planned_depth){.width = view->look.width, .height = view->look.height, .own = view->look.own};
  return result;
}

static csm_result make_plan(csm_cascades *cascades, const frame_input *input, const frame_depth *depth, planned *out,
                            plan_scene *scene) {
  csm_context *context = cascades->context;
  csm_config config;
  budget_choose(cascades, &out->budget);
  plan_budget_coarser(&config, &cascades->config, out->budget.step);
  csm_result result = frame_input_scene(context, input, &out->list, scene);
  if (result)
    return result;
  const csm_frame *frame = &input->frame;
  const instances *store = frame->scene ? &frame->scene->store : &out->list;
  out->scene = frame->scene;
  out->scene_gone = false;
  out->others_cast = frame->draw != NULL;
  out->revision = store->revision;
  out->meshes_revision = context->assets.meshes.revision;
  out->instances = store->live;
  uint32_t sample_count;
  result = gather_samples(cascades, &sample_count);
  if (!result && frame->scene)
    result = reserve_cache(cascades, scene);
  if (result)
    return result;
  if (frame->draw && plan_has_pages(&cascades->config))
    return host_fail(&context->host, CSM_ERROR_UNSUPPORTED,
                     "csm_frame: map_layout pages keeps what it knows of, and draw casts what no instance tells");
  const plan_frame_info info = {.config = &config,
                                .view = input->camera.view,
                                .projection = input->camera.projection,
                                .light = input->light.direction,
                                .light_diameter = input->light.angular_diameter,
                                .reversed = input->camera.reversed,
                                .light_layers = input->light.layers,
                                .others_cast = frame->draw != NULL,
                                .origin = frame->origin,
                                .scene = scene,
                                .maps_kept = cascades->drawn,
                                .seen = depth->seen,
                                .all_receivers = only_receivers(context, frame),
                                .cache = frame->scene ? &cascades->cache : NULL,
                                .before = &cascades->history,
                                .samples = cascades->samples,
                                .sample_count = sample_count,
                                .jitter = (uint32_t)cascades->renders};
  result = plan_with_room(&context->host, out, &info);
  if (result)
    return result;
  out->camera = input->camera;
  out->light = input->light;
  out->flags = frame->flags;
  out->seen = depth->about;
  out->changed = count_changed(cascades, out);
  plan_write_constants((float *)&out->constants, &out->frame, &cascades->config);
  return CSM_SUCCESS;
}

/* Whether two frames of one camera and one scene know the same of what is seen. An engine's depth may hold more than the
 * scene. */
static bool same_depth(const planned_depth *a, const planned_depth *b) {
  return a->width == b->width && a->height == b->height && a->own == b->own && (a->own || !a->width);
}

/* Whether a frame of pages is the last one once more: then nothing has to be planned, or drawn. */
static bool stands_still(const csm_cascades *cascades, const frame_input *input, const frame_depth *depth) {
  const planned *last = cascades_planned(cascades);
  const csm_frame *frame = &input->frame;
  const plan_frame *plan = &last->frame;
  const double *origin = frame->origin ? frame->origin : plan->camera.position;
  return cascades->drawn && plan->pages && !plan->unshadowed && frame->scene && frame->scene == last->scene &&
         planned_current(cascades) && !frame->draw && cascades->config.depth_samples == CSM_DEPTH_SAMPLES_OFF &&
         memcmp(&input->camera, &last->camera, sizeof last->camera) == 0 &&
         memcmp(&input->light, &last->light, sizeof last->light) == 0 &&
         memcmp(origin, plan->origin, sizeof plan->origin) == 0 && same_depth(&depth->about, &last->seen) &&
         !((frame->flags ^ last->flags) & CSM_FRAME_RECEIVERS);
}

/* The last plan, once more. */
static void plan_again(planned *last, const csm_context *context, plan_scene *scene) {
  *scene = scene_of(&context->assets, &last->scene->store);
  plan_frame_rest(&last->frame);
  last->changed = 0;
}

/* ---- the frame ---- */

/* Whose maps come out as they did in the last frame. */
static uint32_t same_maps(const csm_cascades *cascades, const planned *next, const plan_scene *scene) {
  const planned *last = cascades_planned(cascades);
  uint32_t same = 0;
  if (!cascades->drawn || !next->scene || next->scene != last->scene || next->others_cast || last->others_cast)
    return 0;
  for (uint32_t i = 0; i < next->frame.cascade_count; ++i)
    same |= (uint32_t)plan_cascade_same(&last->frame, &next->frame, i, scene, last->revision) << i;
  return same;
}

/* Whether shadows come out as they did in the last frame, but for the maps' jitter. */
static bool rests(const csm_cascades *cascades, const planned *next, const plan_scene *scene) {
  const planned *last = cascades_planned(cascades);
  return cascades->drawn && next->scene && next->scene == last->scene && !next->others_cast && !last->others_cast &&
         plan_frame_rests(&last->frame, &next->frame, scene, last->revision);
}

csm_result CSM_CALL csm_render_cascades(csm_cascades *cascades, const csm_frame *in) {
  csm_result result = cascades_usable(cascades);
  if (result)
    return result;
  frame_input input;
  frame_depth depth = {0};
  plan_scene scene;
  result = frame_input_read(cascades->context, in, true, &input);
  if (!result)
    result = find_depth(cascades->context, &input, &depth);
  const double begin_ms = clock_ms();
  const bool still = !result && stands_still(cascades, &input, &depth);
  planned *next = &cascades->plans[still ? cascades->current : !cascades->current];
  if (still)
    plan_again(next, cascades->context, &scene);
  else if (!result)
    result = make_plan(cascades, &input, &depth, next, &scene);
  if (result)
    return result;
  const double planned_ms = clock_ms();
  technique_run run = {.device = context_device(cascades->context),
                       .config = &cascades->config,
                       .plan = &next->frame,
                       .constants = &next->constants,
                       .constants_size = sizeof next->constants,
                       .frame = &input.frame,
                       .timestamps =
                           input.frame.flags & CSM_FRAME_TIMESTAMPS || cascades->config.budget & CSM_BUDGET_TIME,
                       .cascades = &cascades->techniques,
                       .same = still ? 0 : same_maps(cascades, next, &scene),
                       .light_layers = input.light.layers,
                       .scene = &scene};
  technique_times times;
  result = technique_run_record(&run, &times);
  if (result)
    return result;
  ray_instances_write(&cascades->techniques, &next->frame, &next->constants);
  cascades->changes += !still && !rests(cascades, next, &scene);
  cascades->current = (uint32_t)(next - cascades->plans);
  cascades->history = next->frame.history;
  cascades->budget = next->budget;
  cascades->drawn = true;
  ++cascades->renders;
  cascades->plan_ms = planned_ms - begin_ms + times.write_ms;
  cascades->record_ms = times.record_ms;
  return CSM_SUCCESS;
}
