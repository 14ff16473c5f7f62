/* frame.c: the cascades of a frame: where their maps lie, how deep they are, and what they draw. */
#include "plan/internal.h"

#include <math.h>

static csm_result fit_cascades(plan_frame *frame, plan_fit *fits, const plan_fit_frame *to, const char **error) {
  double depths[CSM_MAX_CASCADES + 1];
  csm_result result = plan_splits(depths, to, error);
  for (uint32_t i = 0; i < frame->cascade_count && !result; ++i) {
    frame->cascades[i].info.near_depth = depths[i];
    frame->cascades[i].info.far_depth = depths[i + 1];
    result = plan_fit_slice(&fits[i], to, i, depths[i], depths[i + 1], error);
  }
  return result;
}

static double largest_texel(const plan_fit *fits, uint32_t count) {
  double largest = 0.0;
  for (uint32_t i = 0; i < count; ++i)
    largest = fmax(largest, fmax(fits[i].texel[0], fits[i].texel[1]));
  return largest;
}

csm_result plan_frame_make(plan_frame *out, const plan_frame_info *info, void *memory, const char **error) {
  const csm_config *config = info->config;
  plan_frame frame = {.cascade_count = config->cascade_count};
  plan_fit fits[CSM_MAX_CASCADES];
  csm_result result = plan_camera_make(&frame.camera, info->view, info->projection, error);
  if (!result)
    result = plan_light_make(frame.basis, config, info->light, info->before, error);
  if (result)
    return result;

  const plan_fit_frame to = {.config = config,
                             .camera = &frame.camera,
                             .basis = frame.basis,
                             .samples =
                                 plan_samples_usable(info->samples, &frame.camera, config) ? info->samples : NULL,
                             .before = info->before,
                             .after = &frame.history};
  result = fit_cascades(&frame, fits, &to, error);
  if (result)
    return result;
  frame.history.has_light = true;
  for (int i = 0; i < 9; ++i)
    frame.history.basis[i] = frame.basis[i];

  plan_scene_box box = {0};
  if (config->depth_mode == CSM_DEPTH_SCENE || config->depth_mode == CSM_DEPTH_SCENE_CLIPPED)
    plan_scene_bounds(&box, frame.basis, info->scene);
  plan_area areas[CSM_MAX_CASCADES];
  plan_hull hull = {0};
  if (config->caster_set == CSM_CASTER_SET_VIEW)
    plan_view_hull(&hull, &frame.camera, frame.basis, frame.cascades[frame.cascade_count - 1].info.far_depth,
                   largest_texel(fits, frame.cascade_count) * plan_padding_texels(config));
  plan_lists lists = {.count = frame.cascade_count, .sides = true};
  for (uint32_t i = 0; i < frame.cascade_count; ++i) {
    areas[i] = plan_fit_area(&fits[i], config, &box);
    lists.lists[i] = &frame.cascades[i].list;
  }
  plan_lists_begin(&lists, info->scene, memory);
  plan_cull_light(&lists, areas, frame.basis, &hull, info->scene);
  plan_lists_end(&lists, info->scene);
  for (uint32_t i = 0; i < frame.cascade_count; ++i)
    plan_fit_place(&frame.cascades[i], &fits[i], &areas[i], frame.basis, config);
  *out = frame;
  return CSM_SUCCESS;
}
