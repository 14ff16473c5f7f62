/* camera.c: what a view and a projection say about a camera. */
#include "plan/internal.h"

#include <math.h>

/* Entries that a perspective or orthographic projection has at 0 may be this much of the largest one beside them. */
#define RESIDUE 1e-6
/* A far plane counts as infinitely far where the depth at infinity misses that plane's depth by no more than this. */
#define INFINITE_DEPTH 1e-3

double plan_view_side(const plan_camera *camera) {
  const double row[3] = {camera->view[2], camera->view[6], camera->view[10]};
  return plan_dot(camera->forward, row) < 0.0 ? -1.0 : 1.0;
}

void plan_view_rotation_inverse(double out[9], const double view[16]) {
  const double rows[3][3] = {{view[0], view[4], view[8]}, {view[1], view[5], view[9]}, {view[2], view[6], view[10]}};
  double cofactors[3][3];
  for (int i = 0; i < 3; ++i)
    plan_cross(cofactors[i], rows[(i + 1) % 3], rows[(i + 2) % 3]);
  const double determinant = plan_dot(rows[0], cofactors[0]);
  for (int column = 0; column < 3; ++column)
    for (int row = 0; row < 3; ++row)
      out[column * 3 + row] = cofactors[column][row] / determinant;
}

static bool is_rigid(const double view[16]) {
  double square = 0.0;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const double off = plan_dot(&view[a * 4], &view[b * 4]) - (a == b);
      square += off * off;
    }
  return square <= PLAN_RIGID_TOLERANCE * PLAN_RIGID_TOLERANCE;
}

static csm_result take_view(plan_camera *camera, const double view[16], const char **error) {
  const csm_result result = plan_check_affine(view);
  if (result == CSM_ERROR_NOT_FINITE)
    return plan_fail(error, result, "view is not finite");
  if (result)
    return plan_fail(error, result, "view is singular or not affine");
  if (!plan_within(view, 16, PLAN_LARGEST))
    return plan_fail(error, CSM_ERROR_INVALID_MATRIX, "view has numbers too large to plan with");
  if (!is_rigid(view))
    return plan_fail(error, CSM_ERROR_INVALID_MATRIX, "view is more than a rotation, a translation and a mirroring");
  double inverse[9];
  plan_view_rotation_inverse(inverse, view);
  for (int i = 0; i < 16; ++i)
    camera->view[i] = view[i];
  for (int i = 0; i < 3; ++i)
    camera->position[i] = -(inverse[i] * view[12] + inverse[3 + i] * view[13] + inverse[6 + i] * view[14]);
  return CSM_SUCCESS;
}

/* Divides the projection so that clip w is plus or minus view z (perspective), or 1 (orthographic). */
static csm_result scale_projection(plan_camera *camera, const double p[16], const char **error) {
  const double scale = fmax(fabs(p[11]), fabs(p[15]));
  const double least = fmin(fabs(p[11]), fabs(p[15]));
  const double across = fmax(fabs(p[3]), fabs(p[7]));
  if (scale == 0.0)
    return plan_fail(error, CSM_ERROR_INVALID_MATRIX, "projection is singular: no clip w along view z");
  if (least > RESIDUE * scale || across > RESIDUE * scale)
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA,
                     "projection is neither perspective nor orthographic along view z: its clip w");
  camera->orthographic = fabs(p[15]) > fabs(p[11]);
  if (camera->orthographic && p[15] < 0.0)
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection is orthographic with a negative clip w");
  for (int i = 0; i < 16; ++i) {
    if (fabs(p[i]) / PLAN_LARGEST > scale)
      return plan_fail(error, CSM_ERROR_INVALID_MATRIX, "projection's numbers are too far apart");
    camera->projection[i] = p[i] / scale;
  }
  p = camera->projection;
  camera->oblique = fmax(fabs(p[2]), fabs(p[6])) > RESIDUE * fmax(fabs(p[10]), fabs(p[14]));
  if (camera->oblique && camera->orthographic)
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection is orthographic with an oblique near or far plane");
  const double image = p[0] * p[5] - p[4] * p[1];
  if (camera->oblique && fabs(image) <= RESIDUE * hypot(p[0], p[4]) * hypot(p[1], p[5]))
    return plan_fail(error, CSM_ERROR_INVALID_MATRIX, "projection is singular: its clip x and y are the same");
  double inverse[16];
  if (!plan_invert(inverse, p))
    return plan_fail(error, CSM_ERROR_INVALID_MATRIX, "projection is singular");
  if (!plan_within(inverse, 16, PLAN_LARGEST))
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection has numbers too far apart to plan with");
  return CSM_SUCCESS;
}

/*
 * Clip z over w is limit + slope / depth, for depth from 0 to infinity before the camera. The limit is the same all over
 * the image, but where the near plane is oblique: there it is linear across it, and the ends that it has are in corners.
 */
static void depth_limits(double limits[2], double *slope, const plan_camera *camera, double side) {
  const double *p = camera->projection;
  *slope = p[14];
  limits[0] = limits[1] = side * p[10];
  if (!camera->oblique)
    return;
  const double determinant = p[0] * p[5] - p[4] * p[1];
  limits[0] = INFINITY;
  limits[1] = -INFINITY;
  /* Clip z is a x + b y + p[10] z + p[14], where a and b are of what the image's x and y are of */
  const double a = (p[2] * p[5] - p[6] * p[1]) / determinant, b = (p[6] * p[0] - p[2] * p[4]) / determinant;
  for (int i = 0; i < 4; ++i) {
    const double x = (i & 1 ? 1.0 : -1.0) - side * p[8], y = (i & 2 ? 1.0 : -1.0) - side * p[9];
    const double limit = a * x + b * y + side * p[10];
    limits[0] = fmin(limits[0], limit);
    limits[1] = fmax(limits[1], limit);
  }
  *slope -= a * p[12] + b * p[13];
}

/* An oblique plane cuts the view at the least depth that it leaves, and ends it at the largest. */
static csm_result perspective_depths(plan_camera *camera, double *side, const char **error) {
  double limits[2], slope;
  *side = camera->projection[11];
  depth_limits(limits, &slope, camera, *side);
  camera->reversed = slope > 0.0;
  /* Reversed or not, measured from the near plane's depth towards the far plane's */
  const double to_near = camera->reversed ? 1.0 - limits[0] : limits[1];
  const double to_far = camera->reversed ? -limits[1] : limits[0] - 1.0;
  const double least = fabs(slope) / PLAN_LARGEST; /* what is smaller puts a plane past the largest distance */
  if (!(to_near > least) || slope == 0.0)
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection has no near plane before the camera");
  if (to_far < -INFINITE_DEPTH && !camera->oblique)
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection has a near or far plane behind the camera");
  camera->near_depth = fabs(slope) / to_near;
  camera->far_depth = to_far > least ? fabs(slope) / to_far : INFINITY;
  return CSM_SUCCESS;
}

/*
 * Clip z grows along view z with the slope's sign: towards the far plane, unless it is reversed. So the matrix and
 * `reversed` say together which way an orthographic camera looks. Where all depths lie on one side of the camera, that
 * side is its front, and the matrix alone says it.
 */
static csm_result orthographic_depths(plan_camera *camera, double *side, uint32_t reversed, const char **error) {
  const double slope = camera->projection[10], offset = camera->projection[14];
  const double z0 = -offset / slope, z1 = (1.0 - offset) / slope; /* bounded, for so is the matrix's inverse */
  const double rounding = RESIDUE * fabs(z1 - z0);
  const bool before = fmin(z0, z1) >= -rounding, behind = fmax(z0, z1) <= rounding;
  if (reversed == CSM_REVERSED_BY_MATRIX && !before && !behind)
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA,
                     "projection is orthographic and holds the camera's place, so it does not tell whether it is "
                     "reversed: set csm_camera.reversed to CSM_REVERSED_YES or CSM_REVERSED_NO");
  if (before || behind)
    *side = before ? 1.0 : -1.0;
  else
    *side = copysign(1.0, reversed == CSM_REVERSED_YES ? -slope : slope);
  camera->near_depth = fmin(*side * z0, *side * z1);
  camera->far_depth = fmax(*side * z0, *side * z1);
  camera->reversed = *side * z0 > *side * z1;
  return CSM_SUCCESS;
}

csm_result plan_camera_make(plan_camera *out, const double view[16], const double projection[16], uint32_t reversed,
                            const char **error) {
  plan_camera camera = {0};
  csm_result result = take_view(&camera, view, error);
  if (result)
    return result;
  if (!plan_finite(projection, 16))
    return plan_fail(error, CSM_ERROR_NOT_FINITE, "projection is not finite");
  if (reversed > CSM_REVERSED_NO)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "reversed is not a CSM_REVERSED_*");
  double side = 0.0;
  result = scale_projection(&camera, projection, error);
  if (!result)
    result = camera.orthographic ? orthographic_depths(&camera, &side, reversed, error)
                                 : perspective_depths(&camera, &side, error);
  if (result)
    return result;
  if (reversed != CSM_REVERSED_BY_MATRIX && camera.reversed != (reversed == CSM_REVERSED_YES))
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA,
                     camera.reversed ? "projection is reversed, and csm_camera.reversed says that it is not"
                                     : "projection is not reversed, and csm_camera.reversed says that it is");
  if (!(camera.near_depth < camera.far_depth))
    return plan_fail(error, CSM_ERROR_INVALID_CAMERA, "projection has its near plane at or beyond its far plane");
  for (int i = 0; i < 3; ++i)
    camera.forward[i] = side * view[i * 4 + 2];
  (void)plan_normalize(camera.forward);
  *out = camera;
  return CSM_SUCCESS;
}
