/*
 * world.h: what the mini-engine draws: a stone circle with a tree in it that bends in the wind. Nothing here knows of a
 * graphics API or of csm. Metres, y up, world positions in doubles; matrices are column-major.
 */
#ifndef EXAMPLE_WORLD_H
#define EXAMPLE_WORLD_H

#include <stdint.h>

enum { WORLD_WIDTH = 640, WORLD_HEIGHT = 360, WORLD_MESHES = 3, WORLD_MAX_THINGS = 32 };

typedef struct vertex {
  float position[3];
  float normal[3];
} vertex;

typedef struct mesh {
  const char *name;
  vertex *vertices;
  uint16_t *indices;
  uint32_t vertex_count, index_count;
  float bounds_min[3], bounds_max[3];
} mesh;

/* Something placed in the world. A rigid one follows bones[0]; a skinned one blends towards bones[1] with its height.
 */
typedef struct thing {
  uint32_t mesh;
  double bones[2][16]; /* object to world */
  float color[3];      /* linear */
  float bend;          /* weight of bones[1] for each metre of height; 0 is rigid */
} thing;

typedef struct world {
  mesh meshes[WORLD_MESHES];
  thing things[WORLD_MAX_THINGS]; /* the skinned one is the last */
  uint32_t thing_count;
  double view[16], projection[16]; /* right-handed, reversed-Z */
  double camera[3];
  double sun_direction[3]; /* the way the light travels */
  float sun_light[3], sky_light[3];
} world;

void world_create(world *w);
void world_destroy(world *w);

/* Moves the camera and the tree to where they are in a frame, from 1 on. */
void world_animate(world *w, uint32_t frame);

/* A sphere around the skinned thing in any pose; returns its radius. */
double world_skinned_bounds(const world *w, double center[3]);

/* What a draw's shader needs; the block of shaders/include/bones.*. */
typedef struct draw_constants {
  float bones[2][3][4]; /* rows of two affine matrices */
  float color[3], bend;
} draw_constants;

/* What a frame's shaders need; the block of shaders/forward.*. */
typedef struct frame_constants {
  float to_clip[4][4]; /* rows; from positions relative to an origin */
  float to_sun[4];     /* unit */
  float sun_light[4], sky_light[4];
} frame_constants;

/*
 * Floats hold a position 12 km from the world's origin only to a millimetre, and a matrix that holds such a translation
 * no better. So all that the GPU gets is relative to an origin near the camera, subtracted here, in doubles.
 */
void world_frame_constants(frame_constants *out, const world *w, const double origin[3]);
void world_draw_constants(draw_constants *out, const thing *t, const double origin[3]);

/* For drawing into a shadow map: bones that lead to its clip space straight away. */
void world_caster_constants(draw_constants *out, const thing *t, const double world_to_clip[16]);

#endif
