/* hull.c: what a camera sees, across the light. */
#include "plan/internal.h"

/* Twice the area of a triangle, above 0 where it turns left. */
static double turn(const double a[3], const double b[3], const double c[3]) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* By x, then by y. */
static void sort_points(double (*points)[3], int count) {
  for (int i = 1; i < count; ++i)
    for (int k = i; k && (points[k][0] < points[k - 1][0] ||
                          (points[k][0] == points[k - 1][0] && points[k][1] < points[k - 1][1]));
         --k)
      for (int axis = 0; axis < 3; ++axis) {
        const double moved = points[k][axis];
        points[k][axis] = points[k - 1][axis];
        points[k - 1][axis] = moved;
      }
}

/*
 * Andrew, "Another efficient algorithm for convex hulls in two dimensions" (1979): a chain of left turns through sorted
 * points, and one back. Returns how many indices it wrote. Rounding of `turn` may leave points on both chains, and some
 * that are no corners.
 */
static int find_hull(int hull[PLAN_HULL_MOST + 1], const double (*points)[3], int count) {
  int size = 0;
  for (int pass = 0; pass < 2; ++pass) {
    const int first = size;
    for (int i = 0; i < count; ++i) {
      const int point = pass ? count - 1 - i : i;
      while (size >= first + 2 && turn(points[hull[size - 2]], points[hull[size - 1]], points[point]) <= 0.0)
        --size;
      hull[size++] = point;
    }
    --size; /* the next pass begins with it */
  }
  return size;
}

/*
 * An edge between points that rounding moved may point anywhere. So the half-plane of each edge is moved out until it
 * holds all points, and leaves nothing out whichever way it is turned.
 */
static double farthest(const double normal[2], const double (*points)[3], int count) {
  double most = normal[0] * points[0][0] + normal[1] * points[0][1];
  for (int i = 1; i < count; ++i)
    most = fmax(most, normal[0] * points[i][0] + normal[1] * points[i][1]);
  return most;
}

bool plan_outside_hull(const plan_hull *hull, const double low[2], const double high[2]) {
  bool outside = false;
  for (uint32_t i = 0; i < hull->count; ++i) {
    const double *normal = hull->normals[i];
    const double x = normal[0] > 0.0 ? low[0] : high[0], y = normal[1] > 0.0 ? low[1] : high[1];
    outside |= normal[0] * x + normal[1] * y > hull->offsets[i];
  }
  return outside;
}

void plan_view_hull(plan_hull *out, const plan_camera *camera, const double basis[9], const double depths[2],
                    double room) {
  double corners[8][3], points[8][3], inverse[9], image[2];
  int hull[PLAN_HULL_MOST + 1];
  *out = (plan_hull){0};
  plan_image(image, camera);
  if (!plan_slice_corners(corners, camera, image, depths))
    return;
  plan_view_rotation_inverse(inverse, camera->view);
  for (int i = 0; i < 8; ++i)
    plan_view_to_light(points[i], camera, basis, inverse, corners[i]);
  sort_points(points, 8);
  const int count = find_hull(hull, (const double(*)[3])points, 8);
  for (int i = 0; i < count && count > 2; ++i) {
    const double *a = points[hull[i]], *b = points[hull[(i + 1) % count]];
    const double x = b[1] - a[1], y = a[0] - b[0], length = sqrt(x * x + y * y);
    if (!(length > 0.0))
      continue;
    double *normal = out->normals[out->count];
    normal[0] = x / length;
    normal[1] = y / length;
    const double corner = fabs(normal[0]) + fabs(normal[1]);
    out->offsets[out->count++] = farthest(normal, (const double(*)[3])points, 8) + room * corner;
  }
}
