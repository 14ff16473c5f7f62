#include "truth/geometry.h"
#include "base/host.h"
#include "base/linear.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void place_instance(truth_geometry *g, const scene_instance *instance, uint32_t *vertex, uint32_t *corner) {
  const scene_mesh *mesh = &g->scene->meshes[instance->mesh];
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    const float *p = mesh->positions + 3 * (size_t)v;
    double world[4];
    mat_transform(world, instance->transform, (const double[3]){p[0], p[1], p[2]}, 1.0);
    for (int i = 0; i < 3; i++)
      g->vertices[3 * ((size_t)*vertex + v) + i] = (float)(world[i] - g->origin[i]);
  }
  for (uint32_t i = 0; i < mesh->index_count; i++)
    g->indices[(*corner)++] = *vertex + scene_index(mesh, i);
  *vertex += mesh->vertex_count;
}

/* ---- surfaces ---- */

typedef struct corner_set {
  float corners[3][3]; /* in a fixed order */
} corner_set;

static void sort_corners(corner_set *set) {
  for (int pass = 0; pass < 2; pass++)
    for (int i = 0; i < 2 - pass; i++)
      if (memcmp(set->corners[i], set->corners[i + 1], sizeof set->corners[i]) > 0) {
        float kept[3];
        memcpy(kept, set->corners[i], sizeof kept);
        memcpy(set->corners[i], set->corners[i + 1], sizeof kept);
        memcpy(set->corners[i + 1], kept, sizeof kept);
      }
}

static corner_set corners_of(const truth_geometry *g, uint32_t triangle) {
  corner_set set;
  for (int i = 0; i < 3; i++)
    for (int axis = 0; axis < 3; axis++) /* + 0 makes both zeros one */
      set.corners[i][axis] = g->vertices[3 * (size_t)g->indices[3 * (size_t)triangle + i] + axis] + 0.0f;
  sort_corners(&set);
  return set;
}

static uint64_t hash_corners(const corner_set *set) {
  uint32_t words[9];
  uint64_t hash = 14695981039346656037u;
  memcpy(words, set, sizeof words);
  for (int i = 0; i < 9; i++)
    hash = (hash ^ words[i]) * 0x9e3779b97f4a7c15u;
  return hash ^ hash >> 32;
}

/* Leaves are often two triangles in one place, one for each side: they are one surface. */
static void find_surfaces(truth_geometry *g) {
  size_t slots = 16;
  while (slots < 2 * (size_t)g->triangle_count)
    slots *= 2;
  uint32_t *table = host_allocate(slots, sizeof *table); /* triangle + 1 */
  for (uint32_t t = 0; t < g->triangle_count; t++) {
    const corner_set set = corners_of(g, t);
    size_t slot = hash_corners(&set) & (slots - 1);
    for (; table[slot]; slot = (slot + 1) & (slots - 1)) {
      const corner_set other = corners_of(g, table[slot] - 1);
      if (memcmp(&set, &other, sizeof set) == 0)
        break;
    }
    if (!table[slot])
      table[slot] = t + 1;
    g->surfaces[t] = table[slot] - 1;
  }
  free(table);
}

/* ---- alpha mask ---- */

static void find_cut_out(truth_geometry *g) {
  const scene *s = g->scene;
  bool any = false;
  g->cut_out = host_allocate(s->instance_count, sizeof *g->cut_out);
  for (size_t i = 0; i < s->instance_count; i++) {
    g->cut_out[i] = scene_cut_out(s, &s->meshes[s->instances[i].mesh]) != NULL;
    any = any || g->cut_out[i];
  }
  if (any)
    return;
  free(g->cut_out);
  g->cut_out = NULL;
}

static uint32_t instance_of(const truth_geometry *g, uint32_t triangle) {
  uint32_t low = 0, high = (uint32_t)g->scene->instance_count;
  while (high - low > 1) {
    const uint32_t middle = low + (high - low) / 2;
    if (g->first[middle] <= triangle)
      low = middle;
    else
      high = middle;
  }
  return low;
}

bool truth_geometry_opaque(const truth_geometry *g, uint32_t triangle, const double weights[3]) {
  if (!g->cut_out)
    return true;
  const uint32_t instance = instance_of(g, triangle);
  if (!g->cut_out[instance])
    return true;
  const scene_mesh *mesh = &g->scene->meshes[g->scene->instances[instance].mesh];
  const scene_material *material = &g->scene->materials[mesh->material];
  double uv[2] = {0.0, 0.0};
  for (uint32_t i = 0; i < 3; i++) {
    const float *corner = mesh->uvs + 2 * (size_t)scene_index(mesh, 3 * (triangle - g->first[instance]) + i);
    uv[0] += weights[i] * corner[0];
    uv[1] += weights[i] * corner[1];
  }
  return scene_alpha_mask_at(&material->alpha_mask, uv) >= material->alpha_mask.cutoff;
}

/* ---- making ---- */

static int count_all(truth_geometry *g) {
  uint64_t vertices = 0, triangles = 0;
  g->first = host_allocate(g->scene->instance_count + 1, sizeof *g->first);
  for (size_t i = 0; i < g->scene->instance_count; i++) {
    const scene_mesh *mesh = &g->scene->meshes[g->scene->instances[i].mesh];
    g->first[i] = (uint32_t)triangles;
    vertices += mesh->vertex_count;
    triangles += mesh->index_count / 3;
    if (vertices > INT32_MAX || triangles > INT32_MAX / 3)
      return host_fail(HOST_BAD_INPUT, "the scene has too many triangles to cast rays at");
  }
  g->first[g->scene->instance_count] = (uint32_t)triangles;
  g->vertex_count = (uint32_t)vertices;
  g->triangle_count = (uint32_t)triangles;
  return triangles ? 0 : host_fail(HOST_BAD_INPUT, "the scene is empty: it draws no triangles");
}

int truth_geometry_make(truth_geometry *out, const scene *s, const double origin[3], bool alpha_test) {
  *out = (truth_geometry){.scene = s, .origin = {origin[0], origin[1], origin[2]}};
  const int code = count_all(out);
  if (code)
    return code;
  out->vertices = host_allocate(3 * (size_t)out->vertex_count + 1, sizeof *out->vertices);
  out->indices = host_allocate(3 * (size_t)out->triangle_count, sizeof *out->indices);
  out->surfaces = host_allocate(out->triangle_count, sizeof *out->surfaces);
  uint32_t vertex = 0, corner = 0;
  for (size_t i = 0; i < s->instance_count; i++)
    place_instance(out, &s->instances[i], &vertex, &corner);
  find_surfaces(out);
  if (alpha_test)
    find_cut_out(out);
  return 0;
}

void truth_geometry_free(truth_geometry *g) {
  free(g->vertices);
  free(g->indices);
  free(g->surfaces);
  free(g->first);
  free(g->cut_out);
  *g = (truth_geometry){0};
}

void truth_geometry_corners(const truth_geometry *g, uint32_t triangle, double corners[3][3]) {
  for (int i = 0; i < 3; i++)
    for (int axis = 0; axis < 3; axis++)
      corners[i][axis] = g->vertices[3 * (size_t)g->indices[3 * (size_t)triangle + i] + axis];
}

bool truth_geometry_mirrored(const truth_geometry *g, uint32_t triangle) {
  return mat_determinant3(g->scene->instances[instance_of(g, triangle)].transform) < 0.0;
}

/* ---- rays ---- */

/* Which side of an edge the ray passes: exactly the opposite with the ends exchanged. */
static double edge_side(const double direction[3], const double a[3], const double b[3]) {
  double cross[3];
  vec_cross(cross, a, b);
  return vec_dot(direction, cross);
}

bool truth_ray_triangle(double corners[3][3], const double from[3], const double direction[3], double weights[3],
                        double *distance) {
  double local[3][3], along[3], across[3], normal[3];
  for (int i = 0; i < 3; i++)
    vec_subtract(local[i], corners[i], from);
  for (int i = 0; i < 3; i++)
    weights[i] = edge_side(direction, local[(i + 1) % 3], local[(i + 2) % 3]);
  const double sum = weights[0] + weights[1] + weights[2];
  vec_subtract(along, corners[1], corners[0]);
  vec_subtract(across, corners[2], corners[0]);
  vec_cross(normal, along, across);
  *distance = vec_dot(normal, local[0]) / vec_dot(normal, direction);
  const bool inside = (weights[0] >= 0.0 && weights[1] >= 0.0 && weights[2] >= 0.0) ||
                      (weights[0] <= 0.0 && weights[1] <= 0.0 && weights[2] <= 0.0);
  for (int i = 0; i < 3; i++)
    weights[i] /= sum;
  return inside && isfinite(*distance) && all_finite(weights, 3);
}
