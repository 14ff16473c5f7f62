/* camera_depth.c: what the depths in a camera's buffer mean, and the camera that csm draws depths of its own with. */
#include "plan/internal.h"

#include <math.h>

double plan_view_depth(const plan_camera *camera, double depth) {
  const double *p = camera->projection;
  const double above = p[14] - depth * p[15], below = depth * p[11] - p[10];
  if (fabs(above) > PLAN_LARGEST * fabs(below)) /* infinitely far away */
    return INFINITY;
  return plan_view_side(camera) * (above / below);
}

/* Clip z over w at a view depth. */
static double buffer_depth(const plan_camera *camera, double view_depth) {
  const double *p = camera->projection, z = plan_view_side(camera) * view_depth;
  return (p[10] * z + p[14]) / (p[11] * z + p[15]);
}

/* The view depth of a place in the picture, whatever the planes are. */
static double view_depth_at(const plan_camera *camera, const plan_pixel *pixel) {
  if (!camera->oblique)
    return plan_view_depth(camera, pixel->depth);
  double inverse[16], at[2] = {0.0, 0.0};
  if (!plan_invert(inverse, camera->projection)) /* plan_camera_make saw to it that it can be */
    return INFINITY;
  for (int row = 0; row < 2; ++row)
    at[row] = inverse[2 + row] * pixel->x + inverse[6 + row] * pixel->y + inverse[10 + row] * pixel->depth +
              inverse[14 + row];
  if (fabs(at[0]) > PLAN_LARGEST * fabs(at[1]))
    return INFINITY;
  return plan_view_side(camera) * (at[0] / at[1]);
}

static bool same_depths(const plan_camera *a, const plan_camera *b) {
  bool same = true;
  for (int column = 0; column < 4; ++column)
    same = same && a->projection[column * 4 + 2] == b->projection[column * 4 + 2];
  return same;
}

double plan_convert_depth(const plan_camera *from, const plan_camera *to, const plan_pixel *pixel) {
  if (to && same_depths(from, to))
    return pixel->depth;
  if (to && to->oblique)
    return 1.0 - pixel->depth; /* no more than turned around */
  const bool nothing = pixel->depth == plan_clear_depth(from);
  const double view_depth = nothing ? INFINITY : view_depth_at(from, pixel);
  if (!to)
    return view_depth;
  return view_depth < INFINITY ? fmin(fmax(buffer_depth(to, view_depth), 0.0), 1.0) : plan_clear_depth(to);
}

/* ---- a camera of csm's own ---- */

/*
 * How much a depth may be off that is computed from the stored positions of a mesh: shaders have floats, whose step is
 * 2^-24 of a number, and four products and their sum are rounded.
 */
static double stored_rounding(const plan_instance *instance, const plan_bounds *bounds, const double forward[3]) {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      sum += fabs(forward[i] * instance->transform[i * 4 + k]) *
             (fabs(bounds->center[k] - bounds->offset[k]) + bounds->extent[k]);
  return sum * 0x1p-21;
}

/* The view depths that the boxes of what is seen take up, with the room that rounding needs. */
static void seen_range(double range[2], const plan_camera *camera, const plan_list *seen, const plan_scene *scene) {
  for (uint32_t i = 0; i < seen->instance_count; ++i) {
    const plan_instance *instance = &scene->instances[seen->instances[i]];
    const plan_bounds *bounds = &scene->meshes[instance->mesh];
    plan_placed box;
    plan_place(&box, instance, bounds);
    for (int k = 0; k < 3; ++k)
      box.center[k] -= camera->position[k];
    const double middle = plan_dot(box.center, camera->forward);
    const double reach = plan_reach(&box, camera->forward) + stored_rounding(instance, bounds, camera->forward);
    range[0] = fmin(range[0], middle - reach);
    range[1] = fmax(range[1], middle + reach);
  }
}

/*
 * An orthographic camera's depths are linear, so a float tells a share of their range apart: it ends where what is seen
 * does. A surface that lies in the range's end may not be clipped by rounding, nor look like nothing: hence the rest.
 */
static void narrow(plan_camera *camera, const plan_list *seen, const plan_scene *scene) {
  double range[2] = {INFINITY, -INFINITY};
  seen_range(range, camera, seen, scene);
  if (!(range[0] <= range[1]))
    return;
  const double width = 2.0 / hypot(camera->projection[0], camera->projection[4]);
  const double rest = (range[1] - range[0]) / 64.0 + width / 1024.0;
  const double near = fmax(camera->near_depth, range[0] - rest), far = fmin(camera->far_depth, range[1] + rest);
  if (!(near < far))
    return;
  camera->near_depth = near;
  camera->far_depth = far;
  camera->projection[10] = -plan_view_side(camera) / (far - near);
  camera->projection[14] = far / (far - near);
}

void plan_depth_camera_make(plan_camera *out, const plan_camera *camera, const plan_list *seen,
                            const plan_scene *scene) {
  *out = *camera;
  out->reversed = true;
  for (int column = 0; column < 4 && !camera->reversed; ++column)
    out->projection[column * 4 + 2] = camera->projection[column * 4 + 3] - camera->projection[column * 4 + 2];
  if (camera->orthographic)
    narrow(out, seen, scene);
}
