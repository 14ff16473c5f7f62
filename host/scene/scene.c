#include "scene/scene.h"
#include "base/host.h"
#include "base/linear.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint32_t scene_add_material(scene *s, const scene_material *material) {
  s->materials = host_grow(s->materials, &s->material_capacity, s->material_count + 1, sizeof *s->materials);
  s->materials[s->material_count] = *material;
  return (uint32_t)s->material_count++;
}

uint32_t scene_add_mesh(scene *s, const scene_mesh *mesh) {
  s->meshes = host_grow(s->meshes, &s->mesh_capacity, s->mesh_count + 1, sizeof *s->meshes);
  s->meshes[s->mesh_count] = *mesh;
  return (uint32_t)s->mesh_count++;
}

void scene_add_instance(scene *s, uint32_t mesh, const double transform[16]) {
  s->instances = host_grow(s->instances, &s->instance_capacity, s->instance_count + 1, sizeof *s->instances);
  scene_instance *added = &s->instances[s->instance_count++];
  added->mesh = mesh;
  memcpy(added->transform, transform, sizeof added->transform);
}

uint32_t scene_index(const scene_mesh *mesh, uint32_t corner) {
  return mesh->index_size == 2 ? ((const uint16_t *)mesh->indices)[corner] : ((const uint32_t *)mesh->indices)[corner];
}

uint64_t scene_triangles(const scene *s) {
  uint64_t count = 0;
  for (size_t i = 0; i < s->instance_count; i++)
    count += s->meshes[s->instances[i].mesh].index_count / 3;
  return count;
}

static void bounds_begin(double minimum[3], double maximum[3]) {
  for (int i = 0; i < 3; i++) {
    minimum[i] = INFINITY;
    maximum[i] = -INFINITY;
  }
}

static void bounds_include(double minimum[3], double maximum[3], const double point[3]) {
  for (int i = 0; i < 3; i++) {
    minimum[i] = fmin(minimum[i], point[i]);
    maximum[i] = fmax(maximum[i], point[i]);
  }
}

void scene_mesh_bounds(const scene_mesh *mesh, double minimum[3], double maximum[3]) {
  bounds_begin(minimum, maximum);
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    const float *p = mesh->positions + 3 * (size_t)v;
    bounds_include(minimum, maximum, (double[3]){p[0], p[1], p[2]});
  }
}

void scene_bounds(const scene *s, double minimum[3], double maximum[3]) {
  double(*boxes)[2][3] = host_allocate(s->mesh_count, sizeof *boxes);
  for (size_t m = 0; m < s->mesh_count; m++)
    scene_mesh_bounds(&s->meshes[m], boxes[m][0], boxes[m][1]);
  bounds_begin(minimum, maximum);
  for (size_t i = 0; i < s->instance_count; i++)
    for (int corner = 0; corner < 8; corner++) {
      double(*box)[3] = boxes[s->instances[i].mesh];
      const double at[3] = {box[corner & 1][0], box[corner >> 1 & 1][1], box[corner >> 2][2]};
      double world[4];
      mat_transform(world, s->instances[i].transform, at, 1.0);
      bounds_include(minimum, maximum, world);
    }
  free(boxes);
}

void scene_default_view(scene *s) {
  double minimum[3], maximum[3], size[3], center[3], offset[3] = {0.45, 0.5, 0.75};
  scene_bounds(s, minimum, maximum);
  vec_subtract(size, maximum, minimum);
  const double radius = fmax(0.5 * vec_length(size), 1e-6);
  const double distance = 2.2 * radius;
  vec_normalize(offset);
  for (int i = 0; i < 3; i++) {
    center[i] = 0.5 * (minimum[i] + maximum[i]);
    s->camera.target[i] = center[i];
    s->camera.position[i] = center[i] + distance * offset[i];
  }
  s->camera.vertical_fov_deg = 45.0;
  s->camera.near_depth = 0.02 * radius;
  s->camera.far_depth = 10.0 * radius;
  s->light = (scene_light){.direction = {-0.55, -0.8, -0.3}};
  s->shadow_distance = distance + 1.05 * radius;
  s->haze_distance = INFINITY;
}

static bool is_file_name(const char *name) {
  return strchr(name, '/') || strchr(name, '.');
}

static int load_file(scene *s, const char *path) {
  double identity[16];
  mat_identity(identity);
  const int code = scene_add_gltf(s, path, identity);
  if (code == 0)
    scene_default_view(s);
  return code;
}

int scene_load(scene *out, const char *name) {
  memset(out, 0, sizeof *out);
  snprintf(out->name, sizeof out->name, "%s", name);
  if (strcmp(name, "valley") == 0) {
    scene_make_valley(out);
    return 0;
  }
  if (strcmp(name, "town") == 0) {
    scene_make_town(out);
    return 0;
  }
  if (strcmp(name, "oaks") == 0)
    return scene_make_oaks(out);
  if (is_file_name(name))
    return load_file(out, name);
  return host_fail(HOST_BAD_INPUT, "--scene: no scene is called '%s' (valley, town, oaks, or a glTF file)", name);
}

void scene_free(scene *s) {
  for (size_t m = 0; m < s->mesh_count; m++) {
    free(s->meshes[m].positions);
    free(s->meshes[m].normals);
    free(s->meshes[m].colors);
    free(s->meshes[m].uvs);
    free(s->meshes[m].indices);
  }
  for (size_t m = 0; m < s->material_count; m++)
    free(s->materials[m].alpha_mask.alpha);
  free(s->materials);
  free(s->meshes);
  free(s->instances);
  memset(s, 0, sizeof *s);
}

scene_light scene_light_turned(const scene_light *from, double turned_deg) {
  const double angle = turned_deg * (3.14159265358979323846 / 180.0), c = cos(angle), s = sin(angle);
  scene_light to = *from;
  to.direction[0] = c * from->direction[0] + s * from->direction[2];
  to.direction[2] = -s * from->direction[0] + c * from->direction[2];
  return to;
}
