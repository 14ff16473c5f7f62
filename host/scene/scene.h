/* scene/scene.h: what is drawn: meshes placed in a world of doubles, a light, and a default camera. Metres, y up. */
#ifndef HOST_SCENE_H
#define HOST_SCENE_H

#include "scene/camera.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum scene_wrap { SCENE_WRAP_REPEAT, SCENE_WRAP_MIRROR, SCENE_WRAP_CLAMP } scene_wrap;

/* What cuts a surface out: it is there where scene_alpha_mask_at is at least `cutoff`. */
typedef struct scene_alpha_mask {
  uint8_t *alpha; /* width * height, the row of v = 0 first; NULL: opaque everywhere */
  uint32_t width, height;
  scene_wrap wrap[2]; /* of u and v */
  double cutoff;      /* what the material multiplies its alpha by has been taken into account */
} scene_alpha_mask;

typedef struct scene_material {
  char name[64];
  float color[3];              /* linear, reflected share of light */
  bool alpha_tested;           /* the file wants it cut out by its texture */
  scene_alpha_mask alpha_mask; /* where it is alpha-tested */
  bool two_sided;
} scene_material;

typedef struct scene_mesh {
  char name[64];
  uint32_t material;
  uint32_t vertex_count;
  uint32_t index_count;
  uint32_t index_size; /* 2 or 4 bytes */
  float *positions;    /* three a vertex, object space */
  float *normals;      /* three a vertex; NULL: flat */
  float *colors;       /* three a vertex, times the material's; NULL: 1 */
  float *uvs;          /* two a vertex, v = 0 at the texture's first row; NULL: none */
  void *indices;
} scene_mesh;

typedef struct scene_instance {
  uint32_t mesh;
  double transform[16]; /* object to world */
} scene_instance;

typedef struct scene_light {
  double direction[3]; /* the way it travels */
  double disc_deg;     /* the sun's apparent diameter; 0 is a hard sun */
} scene_light;

/* Turned about the upright. */
scene_light scene_light_turned(const scene_light *from, double turned_deg);

typedef struct scene {
  char name[256];
  scene_material *materials;
  scene_mesh *meshes;
  scene_instance *instances;
  size_t material_count, mesh_count, instance_count;
  size_t material_capacity, mesh_capacity, instance_capacity;
  camera_pose camera;
  scene_light light;
  double shadow_distance; /* view depth up to which shadows matter */
  double haze_distance;   /* pictures: where haze takes 63 % of a colour; INFINITY is clear air */
} scene;

/*
 * Loads a scene by name (valley, town, oaks) or from a glTF file. 0, or HOST_BAD_INPUT after a message.
 * scene_free is allowed in both cases.
 */
int scene_load(scene *out, const char *name);
void scene_free(scene *s);

uint32_t scene_add_material(scene *s, const scene_material *material);
/* Takes over the mesh's arrays. */
uint32_t scene_add_mesh(scene *s, const scene_mesh *mesh);
void scene_add_instance(scene *s, uint32_t mesh, const double transform[16]);

/* Opacity from 0 to 1, bilinear between texels, at a texture coordinate. Precondition: there is a texture. */
double scene_alpha_mask_at(const scene_alpha_mask *alpha_mask, const double uv[2]);
/* What cuts a mesh out, or NULL if it is opaque everywhere. */
const scene_alpha_mask *scene_cut_out(const scene *s, const scene_mesh *mesh);

uint32_t scene_index(const scene_mesh *mesh, uint32_t corner);
/* Triangles drawn: those of every instance. */
uint64_t scene_triangles(const scene *s);
/* Of a mesh in object space. */
void scene_mesh_bounds(const scene_mesh *mesh, double minimum[3], double maximum[3]);
/* Of every instance's box in the world. Precondition: there is one. */
void scene_bounds(const scene *s, double minimum[3], double maximum[3]);

/* A light, a camera that looks down at everything, and a shadow distance that reaches it all. */
void scene_default_view(scene *s);

/* The makers. Those from code cannot fail. */
void scene_make_valley(scene *s);
void scene_make_town(scene *s);
int scene_make_oaks(scene *s);
/* Adds a glTF file's meshes and nodes, placed by `root`. 0, or HOST_BAD_INPUT after a message. */
int scene_add_gltf(scene *s, const char *path, const double root[16]);

#endif
