#include "scene/camera.h"
#include "base/linear.h"
#include <math.h>
#include <string.h>

const char *camera_pose_check(const camera_pose *pose) {
  double forward[3];
  vec_subtract(forward, pose->target, pose->position);
  if (!all_finite(pose->position, 3) || !all_finite(pose->target, 3))
    return "position and target must be finite";
  if (!vec_normalize(forward))
    return "position and target must differ";
  if (!(pose->vertical_fov_deg >= 0.01 && pose->vertical_fov_deg <= 179.0))
    return "the vertical field of view must lie in 0.01 to 179 degrees";
  if (!(pose->near_depth > 0.0) || !isfinite(pose->near_depth))
    return "near must be above 0";
  if (!(pose->far_depth > pose->near_depth))
    return "far must be beyond near";
  return NULL;
}

/* Right and up for a direction; world up is +y, or +z where the direction is vertical. */
static void look_basis(double right[3], double up[3], const double forward[3]) {
  const double world_up[3] = {0.0, 1.0, 0.0}, other_up[3] = {0.0, 0.0, -1.0};
  vec_cross(right, forward, world_up);
  if (vec_length(right) < 1e-6)
    vec_cross(right, forward, other_up);
  vec_normalize(right);
  vec_cross(up, right, forward);
}

void camera_from_pose(camera *out, const camera_pose *pose, double aspect) {
  double right[3], up[3], forward[3];
  vec_subtract(forward, pose->target, pose->position);
  vec_normalize(forward);
  look_basis(right, up, forward);
  memset(out, 0, sizeof *out);
  for (int i = 0; i < 3; i++) {
    out->view[i * 4 + 0] = right[i];
    out->view[i * 4 + 1] = up[i];
    out->view[i * 4 + 2] = -forward[i];
  }
  out->view[12] = -vec_dot(right, pose->position);
  out->view[13] = -vec_dot(up, pose->position);
  out->view[14] = vec_dot(forward, pose->position);
  out->view[15] = 1.0;

  const double near = pose->near_depth, far = pose->far_depth;
  const double focal = 1.0 / tan(pose->vertical_fov_deg * (3.14159265358979323846 / 360.0));
  out->projection[0] = focal / aspect;
  out->projection[5] = focal;
  out->projection[10] = isinf(far) ? 0.0 : near / (far - near);
  out->projection[11] = -1.0;
  out->projection[14] = isinf(far) ? near : near * far / (far - near);

  memcpy(out->position, pose->position, sizeof out->position);
  memcpy(out->forward, forward, sizeof out->forward);
  out->near_depth = near;
  out->far_depth = far;
  out->reversed = true;
}

/* View z at which clip z / w is `depth`; infinite where no finite one is. */
static double view_z_at(const double p[16], double depth) {
  return (depth * p[15] - p[14]) / (p[10] - depth * p[11]);
}

/*
 * Whether a camera looks along +z or -z of its view. What lies before a perspective one has w > 0. An orthographic one
 * looks to the side where its slab lies, from z0 to z1. Where the slab lies on both, `reversed` decides.
 */
static const char *find_side(double *out, const double projection[16], double z0, double z1, const bool *reversed) {
  double toward = projection[11];
  if (toward == 0.0 && z0 * z1 >= 0.0)
    toward = z0 + z1;
  else if (toward == 0.0 && reversed)
    toward = *reversed ? z0 - z1 : z1 - z0;
  *out = toward < 0.0 ? -1.0 : 1.0;
  return toward != 0.0 ? NULL : "its projection does not tell whether it is reversed: 'reversed' must";
}

const char *camera_from_matrices(camera *out, const double view[16], const double projection[16],
                                 const bool *reversed) {
  double inverse[16], sign;
  if (!all_finite(view, 16) || !all_finite(projection, 16))
    return "its matrices must be finite";
  if (!mat_invert(inverse, view))
    return "its view matrix is singular";
  memcpy(out->view, view, sizeof out->view);
  memcpy(out->projection, projection, sizeof out->projection);
  memcpy(out->position, inverse + 12, sizeof out->position);
  if (!mat_invert(inverse, projection))
    return "its projection is singular";

  const double z0 = view_z_at(projection, 0.0), z1 = view_z_at(projection, 1.0);
  const char *problem = find_side(&sign, projection, z0, z1, reversed);
  if (problem)
    return problem;
  const double depth0 = isfinite(z0) ? sign * z0 : INFINITY, depth1 = isfinite(z1) ? sign * z1 : INFINITY;
  out->reversed = depth1 < depth0;
  out->near_depth = out->reversed ? depth1 : depth0;
  out->far_depth = out->reversed ? depth0 : depth1;
  if (projection[11] != 0.0 && out->far_depth > 1e12 * out->near_depth)
    out->far_depth = INFINITY;
  if (!isfinite(out->near_depth) || !(out->far_depth > out->near_depth))
    return "its projection has no near plane before its far plane";
  if (reversed && *reversed != out->reversed)
    return "'reversed' contradicts its projection";
  for (int i = 0; i < 3; i++)
    out->forward[i] = sign * view[i * 4 + 2];
  return vec_normalize(out->forward) ? NULL : "its view matrix is singular";
}

/* ---- rays ---- */

bool camera_rays_make(camera_rays *out, const camera *from, uint32_t width, uint32_t height) {
  *out = (camera_rays){.width = width, .height = height, .reversed = from->reversed};
  return mat_invert(out->unproject, from->projection) && mat_invert(out->unview, from->view);
}

/* View position of clip (x, y, depth). False where it is at infinity. */
static bool view_position(double out[3], const camera_rays *rays, double x, double y, double depth) {
  double point[4];
  mat_transform(point, rays->unproject, (const double[3]){x, y, depth}, 1.0);
  for (int i = 0; i < 3; i++)
    out[i] = point[i] / point[3];
  return all_finite(out, 3) && vec_length(out) < 1e15;
}

/* The direction is taken towards the middle of the depth range, which is finite for every projection. */
void camera_ray(const camera_rays *rays, double x, double y, double origin[3], double direction[3], double *reach) {
  double from[3], middle[3], end[3], turned[4];
  view_position(from, rays, x, y, rays->reversed ? 1.0 : 0.0);
  view_position(middle, rays, x, y, 0.5);
  vec_subtract(middle, middle, from);
  vec_normalize(middle);
  *reach = INFINITY;
  if (view_position(end, rays, x, y, rays->reversed ? 0.0 : 1.0)) {
    vec_subtract(end, end, from);
    *reach = vec_length(end);
  }
  mat_transform(turned, rays->unview, from, 0.0);
  memcpy(origin, turned, 3 * sizeof(double));
  mat_transform(turned, rays->unview, middle, 0.0);
  memcpy(direction, turned, 3 * sizeof(double));
  vec_normalize(direction);
}

void camera_point(const camera_rays *rays, const camera *from, double x, double y, double depth, double point[3]) {
  double origin[3], direction[3], reach;
  camera_ray(rays, x, y, origin, direction, &reach);
  const double along = (depth - vec_dot(origin, from->forward)) / vec_dot(direction, from->forward);
  for (int axis = 0; axis < 3; axis++)
    point[axis] = origin[axis] + along * direction[axis];
}

void camera_slice(const camera_rays *rays, const camera *from, double near, double far, double corners[8][3]) {
  for (int i = 0; i < 8; i++)
    camera_point(rays, from, i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? far : near, corners[i]);
}

double camera_pixel_x(const camera_rays *rays, uint32_t column) {
  return 2.0 * (column + 0.5) / rays->width - 1.0;
}

double camera_pixel_y(const camera_rays *rays, uint32_t row) {
  return 1.0 - 2.0 * (row + 0.5) / rays->height;
}

camera camera_moved(const camera *from, double ahead_m, double aside_m, double turned_deg) {
  const double angle = turned_deg * (3.14159265358979323846 / 180.0), c = cos(angle), s = sin(angle);
  const double x = from->forward[0], z = from->forward[2];
  camera to = *from;
  for (int row = 0; row < 3; row++) {
    to.view[row] = c * from->view[row] - s * from->view[8 + row];
    to.view[8 + row] = s * from->view[row] + c * from->view[8 + row];
  }
  to.forward[0] = c * x + s * z;
  to.forward[2] = -s * x + c * z;
  const double level = hypot(to.forward[0], to.forward[2]);
  to.position[0] += (ahead_m * to.forward[0] - aside_m * to.forward[2]) / level;
  to.position[2] += (ahead_m * to.forward[2] + aside_m * to.forward[0]) / level;
  for (int row = 0; row < 3; row++)
    to.view[12 + row] = -(to.view[row] * to.position[0] + to.view[4 + row] * to.position[1] +
                          to.view[8 + row] * to.position[2]);
  return to;
}
