/* hard/moment_scene.h: what csm drew with a filter on moments, read back, and what it should be by brute force. */
#ifndef HOST_HARD_MOMENT_SCENE_H
#define HOST_HARD_MOMENT_SCENE_H

#include "hard/moment_model.h"
#include "hard/overhead.h"

/* Cascade 0 of the last frame. */
typedef struct moment_scene {
  csm_config config;
  csm_binding binding;
  moment_model model;
  double error; /* the most that a mean of z is off, by its format's rounding; receivers are moved by so much */
  double doubt; /* the most that a mean and a receiver are apart, all rounding taken together */
  uint32_t side;
  float *map; /* depths as they are stored */
  uint32_t moment_side, layers, channels;
  float *moments; /* layer after layer */
} moment_scene;

/* Reads it from the first backend; *out may hold an earlier one, or zeros. 0, or a code after a message. */
int moment_scene_read(moment_scene *out, hard_run *run, const csm_config *config);
void moment_scene_free(moment_scene *scene);

/* Depth z, from -1 to 1, of a place in the world, and its place in the map in texels. */
double moment_scene_depth(const moment_scene *scene, const double place[3]);
void moment_scene_texel(const moment_scene *scene, const double place[3], double texel[2]);

/*
 * Between which two the visibility of a place in the world lies: by what moments, places and depths may be off. Weights
 * of bilinear filtering have 8 bits, a depth of the receiver and the moments the bits of their formats, which a blur
 * rounds them to more than once.
 */
void moment_scene_bounds(const moment_scene *scene, const double place[3], double bounds[2]);

/* The same of a receiver at depth z below one caster at depth `caster`, with nothing behind it; of one layer. */
void moment_scene_bounds_of_one(const moment_scene *scene, double caster, double z, double bounds[2]);

/* Half a step of a mask, which has 8 bits, and what a float's arithmetic may be off. */
static const double moment_scene_step = 0.5 / 255.0 + 4e-6;

/* What filters are called: "vsm float16", "vsm float32, 4 layers" ... */
void moment_scene_name(const csm_config *config, char *out, size_t size);

/*
 * Figures of all moments: those that are no number, and the most that a variance is below 0, of the least variance that
 * shaders take for it.
 */
void moment_scene_add_numbers(hard_run *run, const moment_scene *scene, const char *name);

#endif
