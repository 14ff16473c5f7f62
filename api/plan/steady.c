/* steady.c: what carries on from frame to frame: the image that maps are sized for, and where their grids are counted
   from. */
#include "plan/internal.h"

#include <math.h>
#include <string.h>

/* ---- the image ---- */

/*
 * A zoom would change every size in every frame. So maps are sized for an image that stays while it holds the camera's.
 * One that does not grows by a third. An octave of the field of view takes no more than four such steps up to 120
 * degrees, for tan 60 = 3 tan 30 < (4/3)^4 tan 30. One that is 1.4 times too wide becomes as wide as the camera's, which
 * leaves a twentieth between growing and shrinking, so that a zoom that wavers does not change sizes each time. A first
 * image, and one that has to be more than a third wider, is exact: there was a cut.
 */
#define GROWTH (4.0 / 3.0)
#define TOO_WIDE 1.4

/*
 * The share of its width that an image needs of what slices are made for. They leave room for jitter, and an image in
 * the middle knows how much of that it takes up; any other may take up all. One share for both axes, which so step
 * together when the camera zooms.
 */
static double needed_share(const plan_camera *camera) {
  const double *offset = &camera->projection[camera->orthographic ? 12 : 8];
  const double *by_depth = &camera->projection[camera->orthographic ? 8 : 12];
  const double most = fmax(fabs(offset[0]), fabs(offset[1]));
  const bool everywhere = by_depth[0] == 0.0 && by_depth[1] == 0.0;
  return everywhere ? fmin((1.0 + most) / (1.0 + PLAN_OFFSET_STEP / 2.0), 1.0) : 1.0;
}

static double kept_width(double width, double needed, double kept) {
  if (needed <= kept && kept < TOO_WIDE * width)
    return kept;
  return kept < needed && needed <= GROWTH * kept ? GROWTH * kept : width;
}

void plan_steady_image(double image[2], const plan_fit_frame *frame) {
  const double share = needed_share(frame->camera);
  plan_image(image, frame->camera);
  for (int axis = 0; axis < 2; ++axis) {
    const double kept = frame->before ? frame->before->image[axis] : 0.0, width = image[axis];
    image[axis] = kept_width(width, width * share, kept);
    frame->after->image[axis] = image[axis];
  }
}

/* ---- the anchor ---- */

/*
 * When the light turns, every point moves over the grid by as much as it lies away, along the light, from the point that
 * the grid is counted from. So that point is first moved to the middle of the map: across the light by whole steps of
 * the grid as it was, which leaves the grid where it is, and along the light freely, which no map tells.
 */
static void move_anchor(plan_anchor *anchor, const plan_fit_frame *frame, const double middle[3]) {
  const double *then = frame->before->basis, grid = fmax(plan_grid_texels(frame->config), 1.0);
  double to_middle[3], shift[3] = {0};
  for (int k = 0; k < 3; ++k)
    to_middle[k] =
        middle[0] * frame->basis[k] + middle[1] * frame->basis[3 + k] + middle[2] * frame->basis[6 + k] - anchor->at[k];
  for (int axis = 0; axis < 3; ++axis) {
    double way = plan_dot(&then[axis * 3], to_middle);
    if (axis < 2) {
      const double texels = round(way / (grid * anchor->texel[axis])) * grid;
      anchor->place[axis] += texels;
      way = texels * anchor->texel[axis];
    }
    for (int k = 0; k < 3; ++k)
      shift[k] += way * then[axis * 3 + k];
  }
  for (int k = 0; k < 3; ++k)
    anchor->at[k] += shift[k];
}

/*
 * Whether a cut left the anchor so far away that doubles no longer place the map from there to a millionth of a texel,
 * though they would from the world's origin.
 */
static bool left_behind(const plan_fit *fit, const double middle[3]) {
  double away = 0.0, here = 0.0;
  for (int i = 0; i < 3; ++i) {
    away = fmax(away, fabs(fit->anchor[i]));
    here = fmax(here, fabs(middle[i]));
  }
  return away > 0x1p32 * fmin(fit->texel[0], fit->texel[1]) && away > 4.0 * here;
}

static void count_from(plan_fit *fit, const plan_anchor *anchor, const double basis[9]) {
  for (int i = 0; i < 3; ++i)
    fit->anchor[i] = plan_dot(&basis[i * 3], anchor->at);
}

void plan_steady_anchor(plan_fit *fit, const plan_fit_frame *frame, uint32_t cascade, const double middle[3]) {
  const plan_history *before = frame->before;
  plan_anchor anchor = {0};
  if (before)
    anchor = before->anchors[cascade];
  if (anchor.texel[0] > 0.0 && memcmp(before->basis, frame->basis, sizeof before->basis) != 0)
    move_anchor(&anchor, frame, middle);
  count_from(fit, &anchor, frame->basis);
  if (left_behind(fit, middle)) {
    anchor = (plan_anchor){0};
    count_from(fit, &anchor, frame->basis);
  }
  for (int i = 0; i < 2; ++i) {
    anchor.texel[i] = fit->texel[i];
    fit->place[i] = anchor.place[i];
  }
  frame->after->anchors[cascade] = anchor;
}
