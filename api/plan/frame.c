/* frame.c: the cascades of a frame: where their maps lie, how deep they are, and what they draw. */
#include "plan/internal.h"

#include <string.h>

/* Where each cascade lies, before its casters are known, and what of the world may cast into it. */
typedef struct fitted {
  plan_fit fits[CSM_MAX_CASCADES];
  plan_area areas[CSM_MAX_CASCADES];
} fitted;

static csm_result fit_cascades(plan_frame *frame, plan_fit *fits, const plan_fit_frame *to, const char **error) {
  plan_depths depths;
  csm_result result = plan_splits(&depths, to, error);
  frame->unshadowed = !result && depths.none;
  frame->shadow_end = result ? 0.0 : depths.shadow_end;
  for (uint32_t i = 0; i < frame->cascade_count && !result && !frame->unshadowed; ++i) {
    frame->cascades[i].info.near_depth = depths.at[i];
    frame->cascades[i].info.far_depth = depths.at[i + 1];
    result = plan_fit_slice(&fits[i], to, i, &depths.at[i], error);
  }
  return result;
}

static csm_result take_origin(plan_frame *frame, const double *origin, const char **error) {
  if (origin && !plan_finite(origin, 3))
    return plan_fail(error, CSM_ERROR_NOT_FINITE, "origin is not finite");
  if (origin && !plan_within(origin, 3, PLAN_LARGEST))
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "origin is farther away than 1e30 m");
  for (int i = 0; i < 3; ++i)
    frame->origin[i] = origin ? origin[i] : frame->camera.position[i];
  return CSM_SUCCESS;
}

/* What a filter reaches past a picture's border, in metres, from a map as wide as the picture of an orthographic camera. */
static double filter_room(const plan_fit_frame *frame) {
  double most = 0.0;
  for (uint32_t i = 0; i < frame->config->cascade_count; ++i)
    most = fmax(most, plan_view_room_texels(frame->config, i) / plan_resolution(frame->config, i));
  return 2.0 * hypot(frame->image[0], frame->image[1]) * most;
}

/*
 * Where casters lie across the light, for maps that need be no wider: those of an orthographic camera, whose slices may
 * be far longer than all that casts. What lies in no map must be lit, and every caster known.
 */
static bool find_casters(plan_span *casters, const plan_fit_frame *frame, const plan_frame_info *info) {
  if (!frame->camera->orthographic || info->others_cast || frame->config->out_of_range == CSM_OUT_OF_RANGE_DARK)
    return false;
  plan_hull hull = {0};
  const double depths[2] = {frame->camera->near_depth, fmin(frame->config->shadow_distance, frame->camera->far_depth)};
  if (frame->config->caster_set == CSM_CASTER_SET_VIEW)
    plan_view_hull(&hull, frame->camera, frame->basis, depths, filter_room(frame));
  const plan_kept kept = plan_cache_fill(info->cache, frame->basis, info->scene);
  const plan_light_cull to = {.basis = frame->basis, .hull = &hull, .layers = info->light_layers, .kept = &kept};
  if (!plan_casters_span(casters, &to, info->scene))
    return false;
  const double width = fmax(casters->high[0] - casters->low[0], casters->high[1] - casters->low[1]);
  const bool had = frame->before && frame->before->has_casters_width;
  frame->after->has_casters_width = true;
  frame->after->casters_width = plan_steps_keep(ceil(log2(fmax(width, 1e-12)) * PLAN_STEPS_PER_OCTAVE),
                                                had ? &frame->before->casters_width : NULL, 1.0);
  return true;
}

/* The camera, the light, and where each cascade lies. */
static csm_result fit_frame(plan_frame *frame, plan_fit *fits, const plan_frame_info *info, const char **error) {
  double light[3];
  csm_result result = plan_camera_make(&frame->camera, info->view, info->projection, info->reversed, error);
  if (!result)
    result = take_origin(frame, info->origin, error);
  if (!result)
    result = plan_light_make(frame->basis, light, info, error);
  if (result)
    return result;
  plan_span casters;
  plan_fit_frame to = {.config = info->config,
                       .camera = &frame->camera,
                       .basis = frame->basis,
                       .samples = info->samples,
                       .sample_count = plan_depth_samples_usable(info, &frame->camera) ? info->sample_count : 0,
                       .before = info->before,
                       .after = &frame->history};
  if (plan_jitter_room(info->config) > 0.0)
    plan_history_jitter(to.jitter, info->jitter);
  plan_steady_image(to.image, &to);
  if (find_casters(&casters, &to, info))
    to.casters = &casters;
  result = fit_cascades(frame, fits, &to, error);
  if (frame->unshadowed && info->before) { /* what was fitted waits until there are shadows again */
    frame->history = *info->before;
    frame->history.pages_identity = info->maps_kept ? info->before->pages_identity : 0;
  }
  frame->light_diameter = info->light_diameter;
  frame->history.has_light = true;
  memcpy(frame->history.light, light, sizeof light);
  memcpy(frame->history.basis, frame->basis, sizeof frame->basis);
  return result;
}

/* Around what the camera sees, in metres, for whichever cascade is read there. */
static double view_room(const plan_fit *fits, const csm_config *config) {
  double largest = 0.0;
  for (uint32_t i = 0; i < config->cascade_count; ++i)
    largest = fmax(largest, fmax(fits[i].texel[0], fits[i].texel[1]) * plan_view_room_texels(config, i));
  return largest;
}

/* Whether nothing is asked for that a caster could shade: only where visibility is asked for no further than the camera
 * sees. */
static bool shades_nothing(const plan_frame *frame, const plan_frame_info *info, const plan_order *order) {
  const double end = frame->cascades[frame->cascade_count - 1].info.far_depth;
  return info->config->caster_set == CSM_CASTER_SET_VIEW && info->all_receivers &&
         !plan_sees_receivers(&frame->camera, info->scene, order, end);
}

/* Lists are of cascades: these draw what is in them. */
static void note_drawn(const plan_lists *lists) {
  for (uint32_t i = 0; i < lists->found_count; ++i)
    lists->found[i].drawn = (uint32_t)lists->found[i].mask;
}

/* Lists for as many windows. */
static void begin_lists(plan_frame *frame, plan_lists *lists, uint32_t windows, const plan_scene *scene) {
  frame->window_count = lists->count = windows;
  for (uint32_t i = 0; i < windows; ++i)
    lists->lists[i] = &frame->windows[i].list;
  plan_lists_room(lists, scene);
}

static uint32_t count_read(const plan_cells *cells, uint32_t count) {
  uint32_t read = 0;
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t y = 0; y < PLAN_CELLS; ++y)
      for (uint64_t row = cells[i].read[y]; row; row &= row - 1)
        ++read;
  return read;
}

/* Leaves out what lies over no cell of a map that is read, and, of pages, over none that is to be drawn. */
static void cull_by_cells(plan_frame *frame, const fitted *fitted, const plan_frame_info *info, plan_lists *lists,
                          const plan_light_cull *cull) {
  plan_cells cells[PLAN_WINDOWS_MOST];
  const plan_order *order = &cull->kept->order;
  if (info->config->caster_set == CSM_CASTER_SET_VIEW)
    frame->cells_by = info->seen ? CSM_CELLS_DEPTH : info->all_receivers ? CSM_CELLS_RECEIVERS : CSM_CELLS_ALL;
  const bool culls = frame->cells_by != CSM_CELLS_ALL || frame->pages;
  if (frame->cells_by != CSM_CELLS_ALL)
    plan_read_cells(cells, frame, fitted->areas, order, info);
  else if (frame->pages)
    plan_seen_cells(cells, frame, fitted->areas, info->config);
  if (culls) {
    frame->cells_read = count_read(cells, frame->cascade_count);
    plan_cull_unread(lists, cells, cull, info->scene);
  }
  if (frame->pages) {
    note_drawn(lists);
    plan_pages_make(frame, fitted->fits, lists, cells, info);
    begin_lists(frame, lists, frame->window_count, info->scene);
    plan_cull_unread(lists, cells, cull, info->scene);
  }
  plan_lists_sort(lists, order);
  if (culls)
    plan_cull_unread_parts(lists, cells, cull, info->scene);
}

/* Pages that something moved over are no longer valid, though none is drawn. */
static void read_nothing(plan_frame *frame, const fitted *fitted, const plan_frame_info *info, plan_lists *lists) {
  plan_cells cells[PLAN_WINDOWS_MOST];
  for (uint32_t i = 0; i < frame->cascade_count; ++i)
    plan_cells_lay(&cells[i], &fitted->areas[i]);
  plan_pages_make(frame, fitted->fits, lists, cells, info);
}

/* Where each map lies along the light, which is where its casters begin, and what is drawn into it. False: there is no room for
 * all that was found. */
static bool cull_and_place(plan_frame *frame, fitted *fitted, const plan_frame_info *info, plan_lists *lists) {
  const csm_config *config = info->config;
  const plan_kept kept = plan_cache_fill(info->cache, frame->basis, info->scene);
  plan_scene_box box = {0};
  if (config->depth_mode == CSM_DEPTH_SCENE || config->depth_mode == CSM_DEPTH_SCENE_CLIPPED || frame->pages)
    plan_scene_bounds(&box, frame->basis, info->scene, &kept.order);
  if (frame->pages)
    plan_pages_depth(&box, frame, fitted->fits, info);
  plan_hull hull = {0};
  const double depths[2] = {frame->camera.near_depth, frame->cascades[frame->cascade_count - 1].info.far_depth};
  if (config->caster_set == CSM_CASTER_SET_VIEW && !frame->pages) /* a page that is drawn is drawn whole */
    plan_view_hull(&hull, &frame->camera, frame->basis, depths, view_room(fitted->fits, config));
  for (uint32_t i = 0; i < frame->cascade_count; ++i) {
    fitted->areas[i] = plan_fit_area(&fitted->fits[i], config, &box);
    plan_rounding_origin(&fitted->areas[i].rounding, frame->basis, frame->origin);
    fitted->areas[i].first_caster = INFINITY;
  }
  const plan_light_cull to = {
      .basis = frame->basis, .hull = &hull, .layers = info->light_layers, .areas = fitted->areas, .kept = &kept};
  const bool shades = !shades_nothing(frame, info, &kept.order);
  if (shades)
    plan_cull_light(lists, &to, info->scene);
  if (!plan_lists_fit(lists))
    return false;
  for (uint32_t i = 0; i < frame->cascade_count; ++i)
    plan_fit_place(&frame->cascades[i], &fitted->fits[i], &fitted->areas[i], frame->basis, config);
  if (shades)
    cull_by_cells(frame, fitted, info, lists, &to);
  else if (frame->pages)
    read_nothing(frame, fitted, info, lists);
  frame->to_light = shades ? (const double(*)[12])kept.transforms : NULL;
  return true;
}

/* A window is a whole map. */
static void place_windows(plan_frame *frame) {
  for (uint32_t i = 0; i < frame->window_count; ++i) {
    frame->windows[i].cascade = i;
    memcpy(frame->windows[i].to_clip, frame->cascades[i].to_clip, sizeof frame->windows[i].to_clip);
  }
}

/* Into how many maps each instance is drawn; windows of one map may share some. */
static void count_casters(plan_frame *frame, const plan_lists *lists) {
  uint64_t windows[CSM_MAX_CASCADES] = {0};
  for (uint32_t i = 0; i < frame->window_count; ++i)
    windows[frame->windows[i].cascade] |= (uint64_t)1 << i;
  for (uint32_t at = 0; at < lists->found_count; ++at)
    for (uint32_t i = 0; i < frame->cascade_count; ++i)
      frame->cascades[i].casters += (lists->found[at].mask & windows[i]) != 0;
}

csm_result plan_frame_make(plan_frame *out, const plan_frame_info *info, plan_memory *memory, const char **error) {
  plan_frame frame = {.cascade_count = info->config->cascade_count,
                      .slot_count = info->scene->slot_count,
                      .pages = plan_has_pages(info->config)};
  fitted fitted;
  if (frame.pages)
    plan_pages_begin(info);
  const csm_result result = fit_frame(&frame, fitted.fits, info, error);
  if (result)
    return result;
  plan_lists lists = {.count = frame.cascade_count, .sides = true, .among = info->scene->caster_count};
  plan_lists_begin(&lists, memory);
  if (!frame.pages)
    begin_lists(&frame, &lists, frame.cascade_count, info->scene);
  if (!frame.unshadowed && !cull_and_place(&frame, &fitted, info, &lists))
    return plan_fail(error, CSM_ERROR_OUT_OF_MEMORY, "there is no room for all that may be drawn");
  for (uint32_t i = 0; i < frame.cascade_count && frame.unshadowed; ++i)
    plan_fit_nothing(&frame.cascades[i], i, frame.basis, info->config);
  if (!frame.pages)
    note_drawn(&lists);
  plan_lists_drawn(&lists, &frame);
  if (!frame.pages)
    place_windows(&frame);
  else if (!lists.room)
    begin_lists(&frame, &lists, 0, info->scene);
  plan_lists_end(&lists, info->scene);
  count_casters(&frame, &lists);
  *out = frame;
  return CSM_SUCCESS;
}

void plan_frame_rest(plan_frame *frame) {
  frame->window_count = 0;
  for (uint32_t i = 0; i < frame->cascade_count; ++i) {
    plan_cascade *of = &frame->cascades[i];
    memset(of->due, 0, sizeof of->due);
    memset(of->saved, 0, sizeof of->saved);
    memset(of->still_due, 0, sizeof of->still_due);
    memset(of->copied, 0, sizeof of->copied);
    of->casters = 0;
  }
}

void plan_history_reconfigure(plan_history *history) {
  plan_history kept = {.has_light = history->has_light};
  memcpy(kept.light, history->light, sizeof kept.light);
  memcpy(kept.basis, history->basis, sizeof kept.basis);
  memcpy(kept.anchors, history->anchors, sizeof kept.anchors);
  *history = kept;
}
