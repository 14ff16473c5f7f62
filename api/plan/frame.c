/* frame.c: the cascades of a frame: where their maps lie, how deep they are, and what they draw. */
#include "plan/internal.h"

#include <math.h>

/*
 * Places, sizes and depths are whole multiples of steps that follow from the projection and the configuration alone,
 * counted from the world's origin, so that whatever moves, a still point keeps its place within a texel, and its depth:
 *
 * - A slice's sphere has the same radius however the camera stands, so its texels always have the same size, and the
 *   map begins at a whole number of texels. The sphere leaves room at the border for the filter, the normal offset, the
 *   half texel by which the map's beginning is rounded, and half a texel for the rounding of floats.
 * - The map ends, along the light, at the first whole number of depth steps behind the sphere. A step is a quarter of
 *   the radius, so a camera that turns or moves a little leaves it where it is.
 * - It begins a whole number of steps before that end: 9 of them hold the sphere wherever it is within its step, and
 *   the number doubles until the casters before it fit too, up to the configured distance. So it depends on casters,
 *   but seldom changes. What lies before it is clamped to depth 0.
 */
#define DEPTH_STEPS_PER_RADIUS 4.0
#define DEPTH_STEPS (2.0 * DEPTH_STEPS_PER_RADIUS + 1.0)

/* From here on, a position's rounding error is no longer small against a texel. */
#define MOST_TEXELS 281474976710656.0 /* 2^48 */

/* Where a map lies, before its casters are known. */
typedef struct fit {
  double texel;
  double origin[2]; /* in texels */
  double step, end; /* metres, steps */
} fit;

static double padding_texels(const csm_config *config) {
  return plan_filter_radius_texels(config) + ceil(fabs(config->bias_normal_texels)) + 1.0;
}

static csm_result fit_slice(fit *out, const plan_camera *camera, const double basis[9], const csm_config *config,
                            double near, double far, const char **error) {
  double center[3], radius, inverse[9], light[3];
  plan_slice_sphere(center, &radius, camera, near, far);
  plan_view_rotation_inverse(inverse, camera->view);
  double offset[3];
  for (int i = 0; i < 3; ++i)
    offset[i] = inverse[i] * center[0] + inverse[3 + i] * center[1] + inverse[6 + i] * center[2];
  for (int i = 0; i < 3; ++i)
    light[i] = plan_dot(&basis[i * 3], camera->position) + plan_dot(&basis[i * 3], offset);

  out->texel = 2.0 * radius / (config->resolution - 2.0 * padding_texels(config));
  out->step = radius / DEPTH_STEPS_PER_RADIUS;
  for (int i = 0; i < 2; ++i)
    out->origin[i] = round(light[i] / out->texel - config->resolution / 2.0);
  out->end = ceil((light[2] + radius) / out->step);
  const double largest = fmax(fabs(light[0]), fmax(fabs(light[1]), fabs(light[2])));
  if (!isfinite(radius) || !(radius > 1e-12) || !(largest / out->texel < MOST_TEXELS))
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "view and projection have numbers too large to plan with");
  return CSM_SUCCESS;
}

static plan_area map_area(const fit *fit, const csm_config *config) {
  plan_area area = {.end = fit->end * fit->step};
  for (int i = 0; i < 2; ++i) {
    area.min[i] = fit->origin[i] * fit->texel;
    area.max[i] = (fit->origin[i] + config->resolution) * fit->texel;
  }
  return area;
}

/* Steps from the first kept depth to the map's end. */
static double depth_steps(const fit *fit, double first_caster, const csm_config *config) {
  const double most = DEPTH_STEPS + ceil(config->caster_distance / fit->step);
  const double wanted = fmin(fit->end - first_caster / fit->step, most); /* minus infinity without casters */
  double steps = DEPTH_STEPS;
  while (steps < wanted)
    steps *= 2.0;
  return fmin(steps, most);
}

static void place_map(plan_cascade *cascade, const fit *fit, double first_caster, const double basis[9],
                      const csm_config *config) {
  const double size = fit->texel * config->resolution;
  const double steps = depth_steps(fit, first_caster, config);
  const double range = steps * fit->step;
  const double origin[3] = {fit->origin[0] / config->resolution, fit->origin[1] / config->resolution,
                            (fit->end - steps) / steps};
  cascade->info.texel_size = fit->texel;
  cascade->info.depth_range = range;

  /* Light space to the map's unit cube, from there to clip, and to texture coordinates with v down */
  const double scale[3] = {1.0 / size, 1.0 / size, 1.0 / range};
  double *shadow = cascade->info.world_to_shadow;
  for (int axis = 0; axis < 3; ++axis) {
    const bool depth = axis == 2, down = axis == 1;
    cascade->to_clip[axis * 5] = depth ? scale[axis] : 2.0 * scale[axis];
    cascade->to_clip[axis * 4 + 3] = depth ? -origin[axis] : -2.0 * origin[axis] - 1.0;
    for (int k = 0; k < 3; ++k)
      shadow[k * 4 + axis] = (down ? -scale[axis] : scale[axis]) * basis[axis * 3 + k];
    shadow[12 + axis] = down ? 1.0 + origin[axis] : -origin[axis];
  }
  shadow[15] = 1.0;
}

static csm_result fit_cascades(plan_frame *frame, fit *fits, const csm_config *config, const char **error) {
  double depths[CSM_MAX_CASCADES + 1];
  csm_result result = plan_splits(depths, config, &frame->camera, error);
  for (uint32_t i = 0; i < frame->cascade_count && !result; ++i) {
    frame->cascades[i].info.near_depth = depths[i];
    frame->cascades[i].info.far_depth = depths[i + 1];
    result = fit_slice(&fits[i], &frame->camera, frame->basis, config, depths[i], depths[i + 1], error);
  }
  return result;
}

csm_result plan_frame_make(plan_frame *out, const csm_config *config, const double view[16],
                           const double projection[16], const double light[3], const plan_scene *scene, void *memory,
                           const char **error) {
  plan_frame frame = {.cascade_count = config->cascade_count};
  fit fits[CSM_MAX_CASCADES];
  csm_result result = plan_camera_make(&frame.camera, view, projection, error);
  if (!result)
    result = plan_light_basis(frame.basis, light, error);
  if (!result)
    result = fit_cascades(&frame, fits, config, error);
  if (result)
    return result;

  plan_area areas[CSM_MAX_CASCADES];
  plan_lists lists = {.count = frame.cascade_count};
  for (uint32_t i = 0; i < frame.cascade_count; ++i) {
    areas[i] = map_area(&fits[i], config);
    lists.lists[i] = &frame.cascades[i].list;
  }
  plan_lists_begin(&lists, scene, memory);
  plan_cull_light(&lists, areas, frame.basis, scene);
  plan_lists_end(&lists, scene);
  for (uint32_t i = 0; i < frame.cascade_count; ++i)
    place_map(&frame.cascades[i], &fits[i], areas[i].first_caster, frame.basis, config);
  *out = frame;
  return CSM_SUCCESS;
}
