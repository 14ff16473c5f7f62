/*
 * depth_samples.c: splits and bounds by what views saw (SDSM). Lauritzen, Salvi and Lefohn, "Sample Distribution Shadow
 * Maps" (2011), with the depths of an earlier frame: its surfaces are seen again from where the camera is now.
 *
 * A tile of a view's picture holds the nearest and the farthest depth in it, so what was seen there lies in a frustum
 * of eight corners. Several views together saw what any of them saw.
 *
 * Sizes are steps of a quarter of an octave. They grow at once where they must, and shrink when they have been two
 * steps too large for some frames. So texels keep their size, and what is fitted does not jitter, nor does it where a
 * tile comes into a slice and leaves it again.
 */
#include "plan/internal.h"

#include <math.h>

#define SHRINK_STEPS 2.0
#define SHRINK_FRAMES 16
/* The bound of a map never shrinks below 1/16 of its fit. */
#define MOST_STEPS (4.0 * PLAN_STEPS_PER_OCTAVE)

/* The view-space corners of what a tile saw between two view depths; a tile at the border goes on beyond it. */
static void tile_corners(double (*corners)[3], const plan_depth_samples *samples, uint32_t column, uint32_t row,
                         const double depths[2], double margin) {
  const double *p = samples->camera.projection;
  const double determinant = p[0] * p[5] - p[4] * p[1];
  const double left = column == 0 ? -1.0 - 2.0 * margin : 2.0 * column * samples->tile_px / samples->width - 1.0;
  const double right = column + 1 == samples->columns ? 1.0 + 2.0 * margin
                                                      : 2.0 * (column + 1) * samples->tile_px / samples->width - 1.0;
  const double top = row == 0 ? 1.0 + 2.0 * margin : 1.0 - 2.0 * row * samples->tile_px / samples->height;
  const double bottom =
      row + 1 == samples->rows ? -1.0 - 2.0 * margin : 1.0 - 2.0 * (row + 1) * samples->tile_px / samples->height;
  for (int i = 0; i < 8; ++i) {
    const double z = plan_view_side(&samples->camera) * depths[i / 4], w = p[11] * z + p[15];
    const double x = w * (i & 1 ? right : left) - p[8] * z - p[12];
    const double y = w * (i & 2 ? top : bottom) - p[9] * z - p[13];
    corners[i][0] = (p[5] * x - p[4] * y) / determinant;
    corners[i][1] = (p[0] * y - p[1] * x) / determinant;
    corners[i][2] = z;
  }
}

/* The view depths between which a tile saw surfaces; false: it saw none. */
static bool tile_depths(double depths[2], const plan_depth_samples *samples, uint32_t column, uint32_t row) {
  const float *bounds = samples->depths[row * samples->columns + column];
  if (!islessequal(bounds[0], bounds[1]) || bounds[0] < 0.0f || bounds[1] > 1.0f)
    return false;
  const double a = plan_view_depth(&samples->camera, bounds[0]), b = plan_view_depth(&samples->camera, bounds[1]);
  depths[0] = fmin(a, b);
  depths[1] = fmax(a, b);
  return depths[1] < INFINITY;
}

/* How deep a point of the samples' view space lies in the view of another camera. */
static double depth_from(const plan_camera *camera, const plan_camera *samples, const double inverse[9],
                         const double view[3]) {
  double apart[3];
  for (int i = 0; i < 3; ++i)
    apart[i] = samples->position[i] - camera->position[i] + inverse[i] * view[0] + inverse[3 + i] * view[1] +
               inverse[6 + i] * view[2];
  return plan_dot(apart, camera->forward);
}

/* ---- what can be used ---- */

static double farthest_depth(const plan_depth_samples *samples) {
  double farthest = 0.0, depths[2];
  for (uint32_t row = 0; row < samples->rows; ++row)
    for (uint32_t column = 0; column < samples->columns; ++column)
      if (tile_depths(depths, samples, column, row))
        farthest = fmax(farthest, depths[1]);
  return farthest;
}

/* How much of clip space a unit at depth 1 spans along a row of the projection, which may turn the picture. */
static double row_scale(const plan_camera *camera, int row) {
  return hypot(camera->projection[row], camera->projection[4 + row]);
}

/* Whether two cameras see as wide, and to the same side, but for jitter and a slow zoom. */
static bool same_image(const plan_camera *a, const plan_camera *b) {
  const int scales[] = {0, 1, 4, 5}, offsets[] = {8, 9, 12, 13};
  const double scale = row_scale(a, 0) + row_scale(a, 1);
  for (int i = 0; i < 4; ++i)
    if (fabs(a->projection[scales[i]] - b->projection[scales[i]]) > 0.05 * scale ||
        fabs(a->projection[offsets[i]] - b->projection[offsets[i]]) > 0.02)
      return false;
  return a->orthographic == b->orthographic;
}

/*
 * Whether two cameras look alike. One that has turned by more than the margin's share of its field of view, or moved by
 * more than that of the way to the farthest surface, sees what no tile has seen. So does one with another image.
 */
static bool alike(const plan_camera *then, const plan_camera *camera, double margin, double farthest) {
  if (!same_image(then, camera) || then->oblique || camera->oblique) /* of which a depth alone tells no distance */
    return false;
  const double tangent = 1.0 / fmax(row_scale(camera, 0), row_scale(camera, 1));
  const double most = margin * (camera->orthographic ? 1.0 : 2.0 * atan(tangent));
  double right = 0.0, moved = 0.0;
  for (int i = 0; i < 3; ++i) {
    right += then->view[i * 4] * camera->view[i * 4];
    const double step = camera->position[i] - then->position[i];
    moved += step * step;
  }
  const double ahead = plan_dot(then->forward, camera->forward);
  return ahead >= cos(most) && right >= cos(most) && sqrt(moved) <= margin * farthest;
}

/* Else there was a cut since, or nothing was seen before. */
static bool usable(const plan_depth_samples *samples, const plan_camera *camera, double margin) {
  const double farthest = samples->columns && samples->rows ? farthest_depth(samples) : 0.0;
  return farthest > 0.0 && alike(&samples->camera, camera, margin, farthest);
}

bool plan_depth_samples_count(const plan_depth_samples *samples, double margin) {
  if (!samples->columns || !samples->rows)
    return false;
  const double farthest = farthest_depth(samples);
  return alike(&samples->camera, &samples->maps_camera, margin, farthest > 0.0 ? farthest : PLAN_LARGEST);
}

bool plan_depth_samples_usable(const plan_frame_info *info, const plan_camera *camera) {
  bool all = info->sample_count && info->config->depth_samples != CSM_DEPTH_SAMPLES_OFF;
  for (uint32_t i = 0; i < info->sample_count && all; ++i)
    all = usable(&info->samples[i], camera, info->config->depth_samples_margin);
  return all;
}

/* ---- splits ---- */

plan_steps plan_steps_keep(double needed, const plan_steps *before, double direction) {
  const bool holds = before && direction * (before->value - needed) >= 0.0;
  if (!holds)
    return (plan_steps){.value = needed};
  if (fabs(before->value - needed) < SHRINK_STEPS)
    return (plan_steps){.value = before->value};
  if (before->wide_frames + 1 < SHRINK_FRAMES)
    return (plan_steps){.value = before->value, .wide_frames = before->wide_frames + 1};
  return (plan_steps){.value = needed};
}

/* Widens a range of the camera's view depths to what a view saw. */
static void widen_range(double range[2], const plan_camera *camera, const plan_depth_samples *samples) {
  double inverse[9];
  plan_view_rotation_inverse(inverse, samples->camera.view);
  for (uint32_t row = 0; row < samples->rows; ++row)
    for (uint32_t column = 0; column < samples->columns; ++column) {
      double depths[2], corners[8][3];
      if (!tile_depths(depths, samples, column, row))
        continue;
      tile_corners(corners, samples, column, row, depths, 0.0);
      for (int i = 0; i < 8; ++i) {
        const double depth = depth_from(camera, &samples->camera, inverse, corners[i]);
        range[0] = fmin(range[0], depth);
        range[1] = fmax(range[1], depth);
      }
    }
}

void plan_depth_samples_range(double *near, double *end, const plan_fit_frame *frame) {
  const double margin = frame->config->depth_samples_margin;
  double range[2] = {INFINITY, -INFINITY};
  for (uint32_t i = 0; i < frame->sample_count; ++i)
    widen_range(range, frame->camera, &frame->samples[i]);
  const double nearest = range[0] - margin * fabs(range[0]), farthest = range[1] + margin * fabs(range[1]);
  plan_history *after = frame->after;
  const plan_history *before = frame->before;
  const bool had = before && before->has_samples;
  after->has_samples = true;
  const double least = fmax(fmax(nearest, 1e-12), fmax(*near, 1e-6 * fabs(*end)));
  after->sample_range[0] =
      plan_steps_keep(floor(log2(least) * PLAN_STEPS_PER_OCTAVE), had ? &before->sample_range[0] : NULL, -1.0);
  after->sample_range[1] = plan_steps_keep(ceil(log2(fmax(farthest, 1e-12)) * PLAN_STEPS_PER_OCTAVE),
                                           had ? &before->sample_range[1] : NULL, 1.0);
  /* An orthographic camera may see what lies behind its origin, of which there is no logarithm. */
  const double fitted_near =
      nearest > 0.0 ? fmax(*near, exp2(after->sample_range[0].value / PLAN_STEPS_PER_OCTAVE)) : *near;
  const double fitted_end = fmin(*end, exp2(after->sample_range[1].value / PLAN_STEPS_PER_OCTAVE));
  if (!(fitted_near < fitted_end)) /* all that is seen lies past the end of shadows */
    return;
  *near = fitted_near;
  *end = fitted_end;
}

/* ---- bounds ---- */

/*
 * Widens what a tile saw up to what its neighbours did: a surface that goes on from one to the other is seen at the
 * centres of pixels, and along a floor that runs away from the camera the next centre may lie far behind the last.
 */
static void meet_neighbours(double depths[2], const plan_depth_samples *samples, uint32_t column, uint32_t row) {
  static const int ways[4][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  const double own[2] = {depths[0], depths[1]};
  for (int way = 0; way < 4; ++way) {
    const uint32_t beside = column + (uint32_t)ways[way][0], below = row + (uint32_t)ways[way][1];
    double other[2];
    if (beside >= samples->columns || below >= samples->rows || !tile_depths(other, samples, beside, below))
      continue;
    if (other[0] > own[1])
      depths[1] = fmax(depths[1], other[0]);
    if (other[1] < own[0])
      depths[0] = fmin(depths[0], other[1]);
  }
}

/* A view that saw something, and the way back from its view space. */
typedef struct seen_view {
  const plan_depth_samples *samples;
  double inverse[9];
} seen_view;

/* Bounds across the light. */
typedef struct bounds {
  double low[2], high[2];
  bool any;
} bounds;

/*
 * What a tile saw, with its surroundings, between two view depths of the camera now; false: nothing. The tile's depths
 * are of another camera, so they are cut where the two differ most.
 */
static bool visible_corners(double corners[8][3], const plan_fit_frame *frame, const seen_view *view,
                            const uint32_t tile[2], const double between[2]) {
  const plan_depth_samples *samples = view->samples;
  const double margin = frame->config->depth_samples_margin;
  double depths[2], shift = 0.0;
  if (!tile_depths(depths, samples, tile[0], tile[1]))
    return false;
  meet_neighbours(depths, samples, tile[0], tile[1]);
  tile_corners(corners, samples, tile[0], tile[1], depths, margin);
  for (int i = 0; i < 8; ++i)
    shift = fmax(shift, fabs(depth_from(frame->camera, &samples->camera, view->inverse, corners[i]) - depths[i / 4]));
  depths[0] = fmax(depths[0], between[0] - shift);
  depths[1] = fmin(depths[1], between[1] + shift);
  if (depths[0] > depths[1])
    return false;
  tile_corners(corners, samples, tile[0], tile[1], depths, margin);
  return true;
}

/* Widens bounds to what a view saw between two view depths of the camera now. */
static void widen_bounds(bounds *out, const plan_fit_frame *frame, const plan_depth_samples *samples,
                         const double between[2]) {
  seen_view view = {.samples = samples};
  plan_view_rotation_inverse(view.inverse, samples->camera.view);
  for (uint32_t i = 0; i < samples->rows * samples->columns; ++i) {
    const uint32_t tile[2] = {i % samples->columns, i / samples->columns};
    double corners[8][3];
    if (!visible_corners(corners, frame, &view, tile, between))
      continue;
    for (int corner = 0; corner < 8; ++corner) {
      double light[3];
      plan_view_to_light(light, &samples->camera, frame->basis, view.inverse, corners[corner]);
      for (int k = 0; k < 2; ++k) {
        out->low[k] = out->any ? fmin(out->low[k], light[k]) : light[k];
        out->high[k] = out->any ? fmax(out->high[k], light[k]) : light[k];
      }
      out->any = true;
    }
  }
}

void plan_depth_samples_bound(double middle[2], double width[2], const plan_fit_frame *frame, uint32_t cascade,
                              const double depths[2]) {
  bounds seen = {0};
  if (frame->config->depth_samples != CSM_DEPTH_SAMPLES_BOUNDS)
    return;
  for (uint32_t i = 0; i < frame->sample_count; ++i)
    widen_bounds(&seen, frame, &frame->samples[i], depths);
  if (!seen.any)
    return;
  const plan_history *before = frame->before;
  for (int k = 0; k < 2; ++k) {
    const double room = 1.0 + frame->config->depth_samples_margin;
    const double begin = fmax(seen.low[k], middle[k] - width[k] / 2.0),
                 end = fmin(seen.high[k], middle[k] + width[k] / 2.0);
    const double needed = (end - begin) * room;
    if (!(needed > 0.0))
      continue;
    /* Steps that the fit's width is divided by; a quotient of 2^20 is more than all of them */
    const double times = width[k] / fmax(needed, width[k] * 0x1p-20);
    const double steps = fmin(fmax(floor(log2(times) * PLAN_STEPS_PER_OCTAVE), 0.0), MOST_STEPS);
    const bool had = before && before->has_bounds[cascade];
    const plan_steps kept = plan_steps_keep(steps, had ? &before->bound_steps[cascade][k] : NULL, -1.0);
    frame->after->bound_steps[cascade][k] = kept;
    if (kept.value <= 0.0)
      continue;
    middle[k] = (begin + end) / 2.0;
    width[k] *= exp2(-kept.value / PLAN_STEPS_PER_OCTAVE);
  }
  frame->after->has_bounds[cascade] = true;
}
