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

/*
 * A caster is kept if its bounds, swept towards the light, meet what the map covers: there is no test at the near
 * plane. The rasteriser draws where texels' centres are covered, half a texel inside the area, so the area itself has
 * that much room for rounding. Comparisons are such that NaN keeps the caster.
 */
void plan_cull_light(plan_lists *lists, plan_area *areas, const double basis[9], const plan_scene *scene) {
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
    for (uint32_t i = 0; i < lists->count; ++i) {
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
