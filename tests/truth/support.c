#include "base/linear.h"
#include "support.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

scene_mesh *add_triangles(scene *s, const float (*corners)[9], uint32_t count, const double offset[3]) {
  scene_mesh mesh = {.vertex_count = 3 * count, .index_count = 3 * count, .index_size = 4};
  mesh.positions = calloc(9 * (size_t)count, sizeof *mesh.positions);
  memcpy(mesh.positions, corners, 9 * sizeof(float) * count);
  uint32_t *indices = calloc(3 * (size_t)count, sizeof *indices);
  for (uint32_t i = 0; i < 3 * count; i++)
    indices[i] = i;
  mesh.indices = indices;
  if (s->material_count == 0)
    scene_add_material(s, &(scene_material){.color = {1, 1, 1}});
  double transform[16];
  mat_identity(transform);
  memcpy(transform + 12, offset, 3 * sizeof(double));
  const uint32_t index = scene_add_mesh(s, &mesh);
  scene_add_instance(s, index, transform);
  return &s->meshes[index];
}

void add_quad(scene *s, const float corners[4][3], const double offset[3]) {
  float triangles[2][9];
  for (int t = 0; t < 2; t++) {
    memcpy(triangles[t], corners[0], 3 * sizeof(float));
    memcpy(triangles[t] + 3, corners[t + 1], 3 * sizeof(float));
    memcpy(triangles[t] + 6, corners[t + 2], 3 * sizeof(float));
  }
  add_triangles(s, (const float(*)[9])triangles, 2, offset);
}

void add_box(scene *s, const float low[3], const float high[3], const double offset[3]) {
  for (int axis = 0; axis < 3; axis++)
    for (int side = 0; side < 2; side++) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3;
      float corners[4][3];
      for (int i = 0; i < 4; i++) {
        const int at = side ? i : 3 - i; /* outwards */
        corners[i][axis] = side ? high[axis] : low[axis];
        corners[i][u] = at == 1 || at == 2 ? high[u] : low[u];
        corners[i][v] = at >= 2 ? high[v] : low[v];
      }
      add_quad(s, (const float(*)[3])corners, offset);
    }
}

double random_unit(uint32_t *state) {
  *state = *state * 1664525u + 1013904223u;
  return (*state >> 8) / 16777216.0;
}

void add_random(scene *s, uint32_t count, double reach, double size, uint32_t seed, const double offset[3]) {
  float(*corners)[9] = calloc(count, sizeof *corners);
  for (uint32_t t = 0; t < count; t++)
    for (int axis = 0; axis < 3; axis++) {
      const double middle = reach * (2.0 * random_unit(&seed) - 1.0);
      for (int i = 0; i < 3; i++)
        corners[t][3 * i + axis] = (float)(middle + size * (random_unit(&seed) - 0.5));
    }
  add_triangles(s, (const float(*)[9])corners, count, offset);
  free(corners);
}

camera look(const double from[3], const double at[3], double fov_deg, double aspect) {
  camera made;
  camera_pose pose = {.vertical_fov_deg = fov_deg, .near_depth = 0.1, .far_depth = 1000.0};
  memcpy(pose.position, from, sizeof pose.position);
  memcpy(pose.target, at, sizeof pose.target);
  camera_from_pose(&made, &pose, aspect);
  return made;
}

void ask(answer *out, const scene *s, const camera *from, const truth_asked *asked, bool alpha_test) {
  const uint32_t width = ANSWER_WIDTH, height = ANSWER_HEIGHT;
  const size_t pixels = (size_t)width * height;
  *out = (answer){.view = {.camera = from, .width = width, .height = height}};
  out->view.surfaces = calloc(pixels, sizeof *out->view.surfaces);
  out->visibility = calloc(pixels, sizeof *out->visibility);
  uint32_t *triangles = calloc(pixels, sizeof *triangles);
  truth *caster = truth_create(s, alpha_test);
  if (truth_find(caster, from, width, height, triangles) || truth_view_fill(caster, &out->view, triangles) ||
      truth_visibility(caster, &out->view, asked, out->visibility, &out->convergence))
    abort();
  truth_destroy(caster);
  free(triangles);
}

void answer_free(answer *a) {
  free(a->view.surfaces);
  free(a->visibility);
}

/* ---- brute force ---- */

void brute_make(brute *out, const scene *s) {
  *out = (brute){.triangles = calloc(scene_triangles(s), sizeof *out->triangles)};
  for (size_t i = 0; i < s->instance_count; i++) {
    const scene_mesh *mesh = &s->meshes[s->instances[i].mesh];
    for (uint32_t corner = 0; corner < mesh->index_count; corner++) {
      const float *p = mesh->positions + 3 * (size_t)scene_index(mesh, corner);
      double world[4];
      mat_transform(world, s->instances[i].transform, (const double[3]){p[0], p[1], p[2]}, 1.0);
      memcpy(out->triangles[out->count + corner / 3].corners[corner % 3], world, 3 * sizeof(double));
    }
    out->count += mesh->index_count / 3;
  }
}

void brute_free(brute *b) {
  free(b->triangles);
}

static bool hits(const brute_triangle *t, const double from[3], const double direction[3], double *distance) {
  double along[3], across[3], to[3], p[3], q[3];
  vec_subtract(along, t->corners[1], t->corners[0]);
  vec_subtract(across, t->corners[2], t->corners[0]);
  vec_cross(p, direction, across);
  const double determinant = vec_dot(along, p);
  if (determinant == 0.0)
    return false;
  vec_subtract(to, from, t->corners[0]);
  const double u = vec_dot(to, p) / determinant;
  vec_cross(q, to, along);
  const double v = vec_dot(direction, q) / determinant;
  *distance = vec_dot(across, q) / determinant;
  return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && *distance > 0.0;
}

uint32_t brute_nearest(const brute *b, const double from[3], const double direction[3], uint32_t skip,
                       double *distance) {
  uint32_t nearest = TRUTH_NOTHING;
  *distance = INFINITY;
  for (uint32_t t = 0; t < b->count; t++) {
    double at;
    if (t != skip && hits(&b->triangles[t], from, direction, &at) && at < *distance) {
      *distance = at;
      nearest = t;
    }
  }
  return nearest;
}

void brute_ray(const truth_view *view, uint32_t column, uint32_t row, double origin[3], double direction[3]) {
  const camera *from = view->camera;
  double unproject[16], unview[16], ends[2][4], world[2][4];
  mat_invert(unproject, from->projection);
  mat_invert(unview, from->view);
  const double x = (2.0 * column + 1.0) / view->width - 1.0, y = 1.0 - (2.0 * row + 1.0) / view->height;
  const double depths[2] = {from->reversed ? 1.0 : 0.0, 0.25};
  for (int i = 0; i < 2; i++) {
    mat_transform(ends[i], unproject, (const double[3]){x, y, depths[i]}, 1.0);
    for (int axis = 0; axis < 3; axis++)
      ends[i][axis] /= ends[i][3];
    mat_transform(world[i], unview, ends[i], 1.0);
  }
  memcpy(origin, world[0], 3 * sizeof(double));
  vec_subtract(direction, world[1], world[0]);
  vec_normalize(direction);
}
