/* cull.c: which instances a map or a camera can see. */
#include "plan/internal.h"

#include <math.h>

/* A mesh's bounds placed in the world: a box with three half-axes. */
typedef struct world_box {
  double center[3], axes[3][3];
} world_box;

static inline void place_box(world_box *box, const plan_instance *instance, const plan_bounds *bounds) {
  for (int i = 0; i < 3; ++i) {
    const double *row = &instance->transform[i * 4];
    box->center[i] = plan_dot(row, bounds->center) + row[3];
    for (int k = 0; k < 3; ++k)
      box->axes[k][i] = row[k] * bounds->extent[k];
  }
}

/* How far the box reaches from its centre along a direction. */
static inline double reach(const world_box *box, const double direction[3]) {
  return fabs(plan_dot(box->axes[0], direction)) + fabs(plan_dot(box->axes[1], direction)) +
         fabs(plan_dot(box->axes[2], direction));
}

void plan_scene_bounds(plan_scene_box *out, const double basis[9], const plan_scene *scene) {
  static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (uint32_t instance = 0; instance < scene->instance_count; ++instance) {
    world_box box;
    place_box(&box, &scene->instances[instance], &scene->meshes[scene->instances[instance].mesh]);
    for (int axis = 0; axis < 3; ++axis) {
      const double extent = reach(&box, axes[axis]);
      low[axis] = fmin(low[axis], box.center[axis] - extent);
      high[axis] = fmax(high[axis], box.center[axis] + extent);
    }
  }
  out->corner_count = scene->instance_count ? 8 : 0;
  for (uint32_t i = 0; i < out->corner_count; ++i) {
    const double corner[3] = {i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]};
    for (int axis = 0; axis < 3; ++axis)
      out->corners[i][axis] = plan_dot(corner, &basis[axis * 3]);
  }
}

/* Twice the area of a triangle, above 0 where it turns left. */
static double turn(const double a[3], const double b[3], const double c[3]) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

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

/* Andrew, "Another efficient algorithm for convex hulls in two dimensions" (1979); returns how many of `points` it has.
 */
static int find_hull(int hull[17], const double (*points)[3], int count) {
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

void plan_view_hull(plan_hull *out, const plan_camera *camera, const double basis[9], double end, double room) {
  double corners[8][3], points[8][3], inverse[9];
  int hull[17];
  plan_slice_corners(corners, camera, camera->near_depth, end);
  plan_view_rotation_inverse(inverse, camera->view);
  for (int i = 0; i < 8; ++i)
    plan_view_to_light(points[i], camera, basis, inverse, corners[i]);
  sort_points(points, 8);
  const int count = find_hull(hull, (const double(*)[3])points, 8);
  *out = (plan_hull){0};
  for (int i = 0; i < count && count > 2; ++i) {
    const double *a = points[hull[i]], *b = points[hull[(i + 1) % count]];
    const double x = b[1] - a[1], y = a[0] - b[0], length = sqrt(x * x + y * y);
    if (!(length > 0.0))
      continue;
    double *normal = out->normals[out->count];
    normal[0] = x / length;
    normal[1] = y / length;
    out->offsets[out->count++] = normal[0] * a[0] + normal[1] * a[1] + room;
  }
}

/* Whether what casts along the light from between `low` and `high` can shade nothing inside. */
static bool outside_hull(const plan_hull *hull, const double low[3], const double high[3]) {
  bool outside = false;
  for (uint32_t i = 0; i < hull->count; ++i) {
    const double *normal = hull->normals[i];
    const double x = normal[0] > 0.0 ? low[0] : high[0], y = normal[1] > 0.0 ? low[1] : high[1];
    outside |= normal[0] * x + normal[1] * y > hull->offsets[i];
  }
  return outside;
}

/*
 * A caster is kept if its bounds, swept towards the light, meet what the map covers: there is no test at the near
 * plane. The rasteriser draws where texels' centres are covered, half a texel inside the area, so the area itself has
 * that much room for rounding. Comparisons are such that NaN keeps the caster.
 */
void plan_cull_light(plan_lists *lists, plan_area *areas, const double basis[9], const plan_hull *hull,
                     const plan_scene *scene) {
  for (uint32_t i = 0; i < lists->count; ++i)
    areas[i].first_caster = INFINITY;
  for (uint32_t instance = 0; instance < scene->instance_count; ++instance) {
    const uint32_t mesh = scene->instances[instance].mesh;
    uint32_t *counts = &lists->counts[(size_t)plan_list_key(lists, &scene->instances[instance]) * lists->count];
    world_box box;
    double low[3], high[3];
    place_box(&box, &scene->instances[instance], &scene->meshes[mesh]);
    for (int axis = 0; axis < 3; ++axis) {
      const double center = plan_dot(box.center, &basis[axis * 3]), extent = reach(&box, &basis[axis * 3]);
      low[axis] = center - extent;
      high[axis] = center + extent;
    }
    uint32_t mask = 0;
    for (uint32_t i = 0; i < lists->count && !outside_hull(hull, low, high); ++i) {
      plan_area *area = &areas[i];
      const bool outside = (low[0] > area->max[0]) | (high[0] < area->min[0]) | (low[1] > area->max[1]) |
                           (high[1] < area->min[1]) | (low[2] > area->depth[1]);
      if (outside)
        continue;
      mask |= 1u << i;
      ++counts[i];
      area->first_caster = low[2] < area->first_caster ? low[2] : area->first_caster;
    }
    lists->masks[instance] = (uint8_t)mask;
  }
}

/* The six half-spaces of clip space, -w <= x, y <= w and 0 <= z <= w, for world positions relative to the camera's. */
static void clip_planes(double normals[6][3], double offsets[6], const plan_camera *camera) {
  double rows[4][4];
  for (int row = 0; row < 4; ++row) {
    const double *p = &camera->projection[row];
    for (int axis = 0; axis < 3; ++axis)
      rows[row][axis] = plan_dot((double[]){p[0], p[4], p[8]}, &camera->view[axis * 4]);
    rows[row][3] = p[12];
  }
  for (int plane = 0; plane < 6; ++plane) {
    const double sign = plane & 1 ? -1.0 : 1.0, w = plane == 4 ? 0.0 : 1.0;
    for (int k = 0; k < 3; ++k)
      normals[plane][k] = w * rows[3][k] + sign * rows[plane / 2][k];
    offsets[plane] = w * rows[3][3] + sign * rows[plane / 2][3];
  }
}

void plan_cull_view(plan_lists *lists, const plan_camera *camera, const plan_scene *scene) {
  const double rounding = 1.0 + 1e-12;
  double normals[6][3], offsets[6];
  clip_planes(normals, offsets, camera);
  for (uint32_t instance = 0; instance < scene->instance_count; ++instance) {
    const uint32_t mesh = scene->instances[instance].mesh;
    world_box box;
    place_box(&box, &scene->instances[instance], &scene->meshes[mesh]);
    for (int i = 0; i < 3; ++i)
      box.center[i] -= camera->position[i];
    bool outside = false;
    for (int plane = 0; plane < 6 && !outside; ++plane)
      outside = plan_dot(box.center, normals[plane]) + offsets[plane] < -rounding * reach(&box, normals[plane]);
    lists->masks[instance] = !outside;
    lists->counts[plan_list_key(lists, &scene->instances[instance])] += !outside;
  }
}

void plan_view_make(plan_list *out, const plan_camera *camera, const plan_scene *scene, void *memory) {
  *out = (plan_list){0};
  plan_lists lists = {.lists = {out}, .count = 1};
  plan_lists_begin(&lists, scene, memory);
  plan_cull_view(&lists, camera, scene);
  plan_lists_end(&lists, scene);
}
