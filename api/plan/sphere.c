/* sphere.c: the least sphere around a slice of what a camera sees. */
#include "plan/internal.h"

#include <math.h>

void plan_image(double half[2], const plan_camera *camera) {
  for (int i = 0; i < 2; ++i)
    half[i] = 1.0 / hypot(camera->projection[i], camera->projection[4 + i]);
}

/*
 * The corners of the slice's face at a view depth, in view space, ordered around the face. An image that is not as wide
 * as the camera's is wider about the view axis, as when a camera zooms, or about its own middle if the view axis lies
 * outside. Corners follow from the image's width alone, in every bit, and not from the projection's scale.
 */
static void face_corners(double (*corners)[3], const plan_camera *camera, const double image[2], double depth) {
  const double *p = camera->projection;
  const double z = plan_view_side(camera) * depth, w = p[11] * z + p[15];
  double axes[2][2], own[2], low[2], high[2];
  plan_image(own, camera);
  for (int i = 0; i < 2; ++i) {
    const double length = hypot(p[i], p[4 + i]), offset = (p[8 + i] * z + p[12 + i]) / w;
    const double middle = -round(offset / PLAN_OFFSET_STEP) * PLAN_OFFSET_STEP;
    const double side = (1.0 + PLAN_OFFSET_STEP / 2.0) * image[i], at = middle * (fabs(middle) < 1.0 ? image : own)[i];
    axes[i][0] = p[i] / length;
    axes[i][1] = p[4 + i] / length;
    low[i] = w * (at - side);
    high[i] = w * (at + side);
  }
  const double determinant = axes[0][0] * axes[1][1] - axes[0][1] * axes[1][0];
  for (int i = 0; i < 4; ++i) {
    const double x = i == 0 || i == 3 ? low[0] : high[0], y = i < 2 ? low[1] : high[1];
    corners[i][0] = (axes[1][1] * x - axes[0][1] * y) / determinant;
    corners[i][1] = (axes[0][0] * y - axes[1][0] * x) / determinant;
    corners[i][2] = z;
  }
}

/*
 * The centre of the least sphere through `count` points, 2 to 4: origin + sum of weights times edges, where
 * dot(edge i, sum) = dot(edge i, edge i) / 2. Cramer's rule. False: the points are degenerate.
 */
static bool circumcenter(double center[3], const double *const points[4], int count) {
  const double most = 1e30; /* no least sphere lies so many edges away */
  double edges[3][3] = {{0}}, g[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, half[3] = {0}, weights[3];
  for (int i = 0; i + 1 < count; ++i)
    for (int k = 0; k < 3; ++k)
      edges[i][k] = points[i + 1][k] - points[0][k];
  for (int a = 0; a + 1 < count; ++a) {
    for (int b = 0; b + 1 < count; ++b)
      g[a][b] = plan_dot(edges[a], edges[b]);
    half[a] = g[a][a] / 2.0;
  }
  double cofactors[3][3];
  for (int i = 0; i < 3; ++i)
    plan_cross(cofactors[i], g[(i + 1) % 3], g[(i + 2) % 3]);
  const double determinant = plan_dot(g[0], cofactors[0]);
  for (int i = 0; i < 3; ++i) { /* the Gram matrix is symmetric, so cofactors need no transposition */
    const double above = plan_dot(cofactors[i], half);
    if (determinant == 0.0 || fabs(above) > most * fabs(determinant))
      return false;
    weights[i] = above / determinant;
  }
  for (int k = 0; k < 3; ++k)
    center[k] = points[0][k] + weights[0] * edges[0][k] + weights[1] * edges[1][k] + weights[2] * edges[2][k];
  return true;
}

/* The square of the distance to the farthest point, or `limit` if that is less. */
static double farthest_square(const double center[3], const double points[8][3], double limit) {
  double farthest = 0.0;
  for (int i = 0; i < 8; ++i) {
    const double to[3] = {points[i][0] - center[0], points[i][1] - center[1], points[i][2] - center[2]};
    const double square = plan_dot(to, to);
    if (!(square < limit))
      return limit;
    farthest = square > farthest ? square : farthest;
  }
  return farthest;
}

/*
 * The least sphere goes through two to four of the points, and is the least one through those. So the centre of each
 * such choice is tried, and the one with the nearest farthest point is it: whatever rounding does to degenerate
 * choices, no point is left outside.
 */
static double least_sphere(double center[3], const double points[8][3]) {
  double best = INFINITY;
  for (unsigned choice = 3; choice < 256; ++choice) {
    const double *chosen[4];
    int count = 0;
    for (int i = 0; i < 8 && count <= 4; ++i)
      if (choice & (1u << i)) {
        if (count < 4)
          chosen[count] = points[i];
        ++count;
      }
    if (count < 2 || count > 4)
      continue;
    double tried[3];
    const double square = circumcenter(tried, chosen, count) ? farthest_square(tried, points, best) : best;
    if (square < best) {
      best = square;
      for (int k = 0; k < 3; ++k)
        center[k] = tried[k];
    }
  }
  return sqrt(best);
}

/* A view that is rigid within the tolerance stretches lengths by up to half of that. */
static double stretched(double length) {
  return length * (1.0 + PLAN_RIGID_TOLERANCE / 2.0);
}

bool plan_slice_corners(double corners[8][3], const plan_camera *camera, const double image[2],
                        const double depths[2]) {
  face_corners(corners, camera, image, depths[0]);
  face_corners(corners + 4, camera, image, depths[1]);
  return plan_within(corners[0], 24, PLAN_LARGEST);
}

void plan_slice_sphere(double center[3], double *radius, const double corners[8][3]) {
  center[0] = center[1] = center[2] = 0.0;
  *radius = stretched(least_sphere(center, corners));
}

void plan_slice_centroid_sphere(double center[3], double *radius, const double corners[8][3]) {
  for (int k = 0; k < 3; ++k) {
    center[k] = 0.0;
    for (int i = 0; i < 8; ++i)
      center[k] += corners[i][k] / 8.0;
  }
  *radius = stretched(sqrt(farthest_square(center, corners, INFINITY)));
}
