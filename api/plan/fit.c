/* fit.c: what of light space a cascade's map covers, across the light and along it. */
#include "plan/internal.h"

#include <math.h>
#include <string.h>

/*
 * Places, sizes and depths are whole multiples of steps that follow from the projection and the configuration alone,
 * counted from an anchor in the world, so that however the camera moves, a still point keeps its place within a texel,
 * and its depth. steady.c says how sizes and anchors carry on where the projection or the light changes.
 *
 * - A slice's sphere has the same radius however the camera stands, so its texels always have the same size, and the
 *   map begins at a whole number of texels. So has a square as wide as the slice's longest diagonal. A box that fits
 * its slice changes with every turn. All leave room at the border for the filter, the normal offset, the texels by
 * which the map's beginning is rounded, and half a texel for the rounding of floats.
 * - The map ends, along the light, at the first whole number of depth steps behind the slice. A step is a quarter of
 *   the radius, so a camera that turns or moves a little leaves it where it is.
 * - It begins a whole number of steps before that end: 9 of them hold the slice wherever it is within its step, and
 *   the number doubles until the casters before it fit too, up to the configured distance. So it depends on casters,
 *   but seldom changes. What lies before it is clamped to depth 0 (pancaking).
 */
#define DEPTH_STEPS_PER_RADIUS 4.0
#define DEPTH_STEPS (2.0 * DEPTH_STEPS_PER_RADIUS + 1.0)

/* From here on, a position's rounding error is no longer small against a texel. */
#define MOST_TEXELS 281474976710656.0 /* 2^48 */

/* What a slice takes up of light space: its middle, its width along each axis, and its size however it is turned. */
typedef struct extent {
  double middle[3], width[3];
  double diameter;
} extent;

static bool is_sphere(const csm_config *config) {
  return config->fit_mode == CSM_FIT_MINIMUM_SPHERE || config->fit_mode == CSM_FIT_CENTROID_SPHERE;
}

static bool is_square(const csm_config *config) {
  return config->fit_mode == CSM_FIT_CASCADE_SQUARE || config->fit_mode == CSM_FIT_SCENE_SQUARE;
}

static bool begins_at_camera(const csm_config *config) {
  return config->fit_mode == CSM_FIT_SCENE || config->fit_mode == CSM_FIT_SCENE_SQUARE;
}

void plan_view_to_light(double out[3], const plan_camera *camera, const double basis[9], const double inverse[9],
                        const double view[3]) {
  double offset[3];
  for (int i = 0; i < 3; ++i)
    offset[i] = inverse[i] * view[0] + inverse[3 + i] * view[1] + inverse[6 + i] * view[2];
  for (int i = 0; i < 3; ++i)
    out[i] = plan_dot(&basis[i * 3], camera->position) + plan_dot(&basis[i * 3], offset);
}

static void sphere_extent(extent *out, const plan_fit_frame *frame, const double inverse[9],
                          const double corners[8][3]) {
  double center[3], radius;
  if (frame->config->fit_mode == CSM_FIT_CENTROID_SPHERE)
    plan_slice_centroid_sphere(center, &radius, corners);
  else
    plan_slice_sphere(center, &radius, corners);
  plan_view_to_light(out->middle, frame->camera, frame->basis, inverse, center);
  out->diameter = 2.0 * radius;
  for (int i = 0; i < 3; ++i)
    out->width[i] = out->diameter;
}

static void box_extent(extent *out, const plan_fit_frame *frame, const double inverse[9], const double corners[8][3]) {
  double low[3], high[3];
  for (int corner = 0; corner < 8; ++corner) {
    double light[3];
    plan_view_to_light(light, frame->camera, frame->basis, inverse, corners[corner]);
    for (int i = 0; i < 3; ++i) {
      low[i] = corner ? fmin(low[i], light[i]) : light[i];
      high[i] = corner ? fmax(high[i], light[i]) : light[i];
    }
  }
  for (int i = 0; i < 3; ++i) {
    out->middle[i] = (low[i] + high[i]) / 2.0;
    out->width[i] = high[i] - low[i];
  }
  out->diameter = 0.0;
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < a; ++b) {
      const double d[3] = {corners[a][0] - corners[b][0], corners[a][1] - corners[b][1], corners[a][2] - corners[b][2]};
      out->diameter = fmax(out->diameter, sqrt(plan_dot(d, d)));
    }
}

/* False: numbers too large to plan with. */
static bool slice_extent(extent *out, const plan_fit_frame *frame, const double depths[2]) {
  const bool stable = is_sphere(frame->config) || is_square(frame->config);
  double corners[8][3], inverse[9], own[2];
  plan_image(own, frame->camera);
  if (!plan_slice_corners(corners, frame->camera, stable ? frame->image : own, depths))
    return false;
  plan_view_rotation_inverse(inverse, frame->camera->view);
  if (is_sphere(frame->config))
    sphere_extent(out, frame, inverse, (const double(*)[3])corners);
  else
    box_extent(out, frame, inverse, (const double(*)[3])corners);
  return out->diameter > 1e-12 && out->diameter <= PLAN_LARGEST;
}

/*
 * A normal offset is in the larger texels, so the axis with the finer ones leaves more of them free for it.
 */
static void size_texels(double texel[2], const double width[2], const csm_config *config, uint32_t resolution) {
  const double padding = plan_padding_texels(config), offset = ceil(config->bias_normal_texels);
  double largest = 0.0;
  for (int i = 0; i < 2; ++i) {
    texel[i] = width[i] / (resolution - 2.0 * padding);
    largest = fmax(largest, texel[i]);
  }
  for (int i = 0; i < 2; ++i)
    if (texel[i] < largest)
      texel[i] = (width[i] + 2.0 * offset * largest) / (resolution - 2.0 * (padding - offset));
}

static double snap(double place, const csm_config *config) {
  const double grid = plan_grid_texels(config);
  return config->snap_mode == CSM_SNAP_OFF     ? place
         : config->snap_mode == CSM_SNAP_FLOOR ? floor(place / grid) * grid
                                               : round(place / grid) * grid;
}

/*
 * Narrows a map to what casts into it: beyond that all is lit. A width is a step of a quarter of an octave, which
 * casters that move change seldom, with room for the filter; of texels that are large against the rounding of doubles.
 */
static void bound_casters(double middle[2], double width[2], const plan_fit_frame *frame, uint32_t resolution) {
  const double room = 1.0 - 2.0 * plan_padding_texels(frame->config) / resolution;
  const double wanted = exp2(frame->after->casters_width.value / PLAN_STEPS_PER_OCTAVE) / room;
  const double needed = fmax(wanted, resolution * 0x1p-40 * fmax(fabs(middle[0]), fabs(middle[1])));
  for (int i = 0; i < 2; ++i)
    if (needed < width[i]) {
      middle[i] = (frame->casters->low[i] + frame->casters->high[i]) / 2.0;
      width[i] = needed;
    }
}

/*
 * Shaders take a point for a map's that lies beside its range by a 4096th of it, which is metres where a slice is
 * kilometres long. So the range of a map that is narrowed to its casters neither begins nor ends among them.
 */
static double beside(const plan_fit *fit) {
  return (fit->depth[1] - fit->depth[0]) / 1024.0;
}

static bool is_among_casters(const plan_fit *fit, double depth) {
  return fit->casters[0] < depth + beside(fit) && fit->casters[1] > depth - beside(fit);
}

csm_result plan_fit_slice(plan_fit *out, const plan_fit_frame *frame, uint32_t cascade, const double depths[2],
                          const char **error) {
  static const char too_large[] = "view and projection have numbers too large to plan with";
  const csm_config *config = frame->config;
  const double between[2] = {begins_at_camera(config) ? frame->camera->near_depth : depths[0], depths[1]};
  const uint32_t resolution = plan_resolution(config, cascade);
  extent slice;
  if (!slice_extent(&slice, frame, between))
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, too_large);

  double middle[3] = {slice.middle[0], slice.middle[1], slice.middle[2]}, width[2] = {slice.width[0], slice.width[1]};
  if (is_square(config))
    width[0] = width[1] = slice.diameter;
  if (frame->sample_count)
    plan_depth_samples_bound(middle, width, frame, cascade, depths);
  if (frame->casters)
    bound_casters(middle, width, frame, resolution);
  size_texels(out->texel, width, config, resolution);
  const double largest = fmax(fabs(middle[0]), fmax(fabs(middle[1]), fabs(middle[2])));
  const double finest = fmin(out->texel[0], out->texel[1]);
  if (!(finest > 1.0 / PLAN_LARGEST) || !(largest < MOST_TEXELS * finest))
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, too_large);

  plan_steady_anchor(out, frame, cascade, middle);
  for (int i = 0; i < 2; ++i)
    out->origin[i] = snap((middle[i] - out->anchor[i]) / out->texel[i] - resolution / 2.0, config);
  memcpy(out->jitter, frame->jitter, sizeof out->jitter);
  out->resolution = resolution;
  out->step = slice.diameter / (2.0 * DEPTH_STEPS_PER_RADIUS);
  out->depth[0] = slice.middle[2] - slice.width[2] / 2.0;
  out->depth[1] = slice.middle[2] + slice.width[2] / 2.0;
  out->casters[0] = frame->casters ? frame->casters->low[2] : INFINITY;
  out->casters[1] = frame->casters ? frame->casters->high[2] : -INFINITY;
  if (is_among_casters(out, out->depth[1]) && out->casters[1] < out->depth[1] + slice.width[2])
    out->depth[1] = out->casters[1] + beside(out);
  return CSM_SUCCESS;
}

/* ---- along the light ---- */

/* All in steps from the anchor. */
static double steps_end(const plan_fit *fit) {
  return ceil((fit->depth[1] - fit->anchor[2]) / fit->step);
}

/* Steps from the first kept depth to the map's end. */
static double depth_steps(const plan_fit *fit, const plan_area *area, double shift, const csm_config *config) {
  const double slice = steps_end(fit) - floor((fit->depth[0] - fit->anchor[2]) / fit->step + 1e-6);
  const double least = fmax(slice, DEPTH_STEPS) + ceil(shift / fit->step);
  const double farthest = fmin(config->caster_distance, plan_longest_range(fit, config) - least * fit->step);
  const double most = least + ceil(fmax(farthest, 0.0) / fit->step);
  const double wanted = fmin(steps_end(fit) - (area->first_caster - fit->anchor[2]) / fit->step,
                             most); /* minus infinity without casters */
  double steps = least;
  while (steps < wanted)
    steps *= 2.0;
  steps = fmin(steps, most);
  const double begin = fit->anchor[2] + (steps_end(fit) - steps) * fit->step;
  const bool among = is_among_casters(fit, begin) && fit->casters[0] > begin - least * fit->step;
  return among ? steps + ceil((begin - fit->casters[0] + beside(fit)) / fit->step) : steps;
}

/* The part of a convex polygon, of up to 4 corners more than it had, on one side of a plane along an axis. */
static int clip_polygon(double (*out)[3], const double (*in)[3], int count, int axis, double limit, double side) {
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    const double *a = in[i], *b = in[(i + 1) % count];
    const double da = side * (limit - a[axis]), db = side * (limit - b[axis]);
    if (da >= 0.0) {
      for (int k = 0; k < 3; ++k)
        out[kept][k] = a[k];
      ++kept;
    }
    if ((da < 0.0) != (db < 0.0)) {
      for (int k = 0; k < 3; ++k)
        out[kept][k] = a[k] + (b[k] - a[k]) * (da / (da - db));
      ++kept;
    }
  }
  return kept;
}

/* How far the box's faces reach along the light over the map. The faces hold both ends of all that the box holds. */
static void clip_scene(double depth[2], const plan_scene_box *box, const plan_area *area) {
  static const int faces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (int face = 0; face < 6; ++face) {
    double polygon[2][8][3];
    int count = 4, current = 0;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k)
        polygon[0][i][k] = box->corners[faces[face][i]][k];
    for (int plane = 0; plane < 4; ++plane, current = !current) {
      const int axis = plane / 2;
      const double limit = plane & 1 ? area->max[axis] : area->min[axis];
      count = clip_polygon(polygon[!current], (const double(*)[3])polygon[current], count, axis, limit,
                           plane & 1 ? 1.0 : -1.0);
    }
    for (int i = 0; i < count; ++i) {
      depth[0] = fmin(depth[0], polygon[current][i][2]);
      depth[1] = fmax(depth[1], polygon[current][i][2]);
    }
  }
}

/*
 * Keeps a range to what its format resolves. It then ends with the slice, as nothing behind shades it; what lies before
 * the range, towards the light, is clamped to its begin.
 */
static void bound_depth(double depth[2], const plan_fit *fit, const csm_config *config) {
  const double most = plan_longest_range(fit, config);
  if (depth[1] - depth[0] <= most)
    return;
  depth[1] = fit->depth[1];
  depth[0] = fmin(fmax(depth[0], depth[1] - most), fit->depth[0]);
}

/* Pages are kept while their depths mean the same: the range is the scene's, which stays though it is longer than need be. */
static void steady_depth(double depth[2], const plan_fit *fit, const plan_scene_box *box, const csm_config *config) {
  const double step = plan_longest_range(fit, config) / 8.0;
  depth[0] = box->steady[0];
  depth[1] = box->steady[1];
  if (depth[1] - depth[0] <= 8.0 * step)
    return;
  depth[1] = ceil(fit->depth[1] / step) * step;
  depth[0] = fmin(fmax(depth[0], depth[1] - 7.0 * step), floor(fit->depth[0] / step) * step);
}

/* Whether a range begins and ends at whole steps from the map's anchor. */
static bool steps_depth(const csm_config *config) {
  return config->depth_mode == CSM_DEPTH_CASTERS && !plan_has_pages(config);
}

plan_area plan_fit_area(const plan_fit *fit, const csm_config *config, const plan_scene_box *box) {
  plan_area area = {.depth = {INFINITY, -INFINITY}, .rounding = plan_rounding_begin(fit, config)};
  const double jitter = plan_jitter_room(config); /* casters are the same wherever it moves the map */
  for (int i = 0; i < 2; ++i) {
    area.min[i] = fit->anchor[i] + (fit->origin[i] - jitter) * fit->texel[i];
    area.max[i] = fit->anchor[i] + (fit->origin[i] + fit->resolution + jitter) * fit->texel[i];
  }
  if (config->depth_mode == CSM_DEPTH_SCENE && box->corner_count)
    for (int i = 0; i < 8; ++i) {
      area.depth[0] = fmin(area.depth[0], box->corners[i][2]);
      area.depth[1] = fmax(area.depth[1], box->corners[i][2]);
    }
  else if (config->depth_mode == CSM_DEPTH_SCENE_CLIPPED && box->corner_count)
    clip_scene(area.depth, box, &area);
  if (plan_has_pages(config) && box->corner_count)
    steady_depth(area.depth, fit, box, config);
  /* Without a scene, or where it has no depth, there is the slice. */
  if (!(area.depth[1] - area.depth[0] > 1e-6 * fit->step)) {
    area.depth[0] = fit->depth[0] - config->caster_distance;
    area.depth[1] = fit->depth[1];
  }
  bound_depth(area.depth, fit, config);
  if (steps_depth(config))
    area.depth[1] = fit->anchor[2] + steps_end(fit) * fit->step;
  return area;
}

/* Light space to the map's unit cube, from there to clip, and to texture coordinates with v down. */
static void put_matrices(plan_cascade *cascade, const double scale[3], const double origin[3], const double basis[9],
                         bool reversed) {
  double *shadow = cascade->info.world_to_shadow;
  for (int axis = 0; axis < 3; ++axis) {
    const bool depth = axis == 2, down = axis == 1 || (depth && reversed);
    const double sign = depth && down ? -1.0 : 1.0;
    cascade->to_clip[axis * 5] = sign * (depth ? scale[axis] : 2.0 * scale[axis]);
    cascade->to_clip[axis * 4 + 3] = depth ? (down ? 1.0 + origin[axis] : -origin[axis]) : -2.0 * origin[axis] - 1.0;
    for (int k = 0; k < 3; ++k)
      shadow[k * 4 + axis] = (down ? -scale[axis] : scale[axis]) * basis[axis * 3 + k];
    shadow[12 + axis] = down ? 1.0 + origin[axis] : -origin[axis];
  }
  shadow[15] = 1.0;
}

void plan_fit_place(plan_cascade *cascade, const plan_fit *fit, const plan_area *area, const double basis[9],
                    const csm_config *config) {
  /* In units of the map: its sides along right and up, its range along the light */
  double scale[3], origin[3];
  for (int i = 0; i < 2; ++i) {
    scale[i] = 1.0 / (fit->texel[i] * fit->resolution);
    origin[i] = (fit->anchor[i] / fit->texel[i] + fit->origin[i] + fit->jitter[i]) / fit->resolution;
  }
  /* Receivers at the range's begin stay within it when they are moved */
  const bool stepped = steps_depth(config);
  const double unmoved = stepped ? depth_steps(fit, area, 0.0, config) * fit->step : area->depth[1] - area->depth[0];
  const double least = plan_rounding_shift(&area->rounding, unmoved);
  /* Pages are kept while it stays */
  const double shift = plan_has_pages(config) && least > 0.0
                           ? exp2(ceil(log2(least) * PLAN_STEPS_PER_OCTAVE) / PLAN_STEPS_PER_OCTAVE)
                           : least;
  double range = unmoved + shift;
  origin[2] = (area->depth[0] - shift) / range;
  if (stepped) {
    const double steps = depth_steps(fit, area, shift, config);
    range = steps * fit->step;
    origin[2] = (fit->anchor[2] / fit->step + steps_end(fit) - steps) / steps;
  }
  scale[2] = 1.0 / range;
  cascade->info.texel_size = fmax(fit->texel[0], fit->texel[1]);
  cascade->info.depth_range = range;
  cascade->shift = shift;
  for (int i = 0; i < 2; ++i) {
    cascade->texel[i] = fit->texel[i];
    cascade->origin_texels[i] = fit->anchor[i] / fit->texel[i] + fit->origin[i];
    cascade->jitter_texels[i] = fit->jitter[i];
    cascade->place_texels[i] = fit->place[i] + floor(fit->origin[i]);
  }
  cascade->resolution = fit->resolution;
  put_matrices(cascade, scale, origin, basis, config->map_reversed);
}

/*
 * The intervals end far below every view depth. The matrices put every point of the world at
 * texture coordinates and a depth of 2. All numbers are such that a shader that computes with them, and throws the
 * result away, meets no division by 0.
 */
void plan_fit_nothing(plan_cascade *cascade, uint32_t index, const double basis[9], const csm_config *config) {
  const double far_below = -1e27, scale = 1.0 / (1e6 * PLAN_LARGEST);
  const double origin[3] = {-2.0, 1.0, config->map_reversed ? 1.0 : -2.0}; /* all come out at 2 */
  const uint32_t to_end = config->cascade_count - index;
  *cascade = (plan_cascade){.info = {.near_depth = (to_end + 1) * far_below,
                                     .far_depth = to_end * far_below,
                                     .texel_size = 1.0,
                                     .depth_range = 1.0},
                            .texel = {1.0, 1.0},
                            .resolution = plan_resolution(config, index)};
  put_matrices(cascade, (double[]){scale, scale, scale}, origin, basis, config->map_reversed);
}
