/* scene/mesh_builder.h: meshes from simple solids. Triangles face outwards, counter-clockwise. */
#ifndef HOST_MESH_BUILDER_H
#define HOST_MESH_BUILDER_H

#include "scene/scene.h"

typedef struct mesh_builder {
  float *positions, *colors; /* three a vertex */
  uint32_t *indices;
  size_t vertex_count, index_count;
  size_t position_capacity, color_capacity, index_capacity;
  float color[3]; /* of the vertices that are added next; linear */
} mesh_builder;

void builder_color(mesh_builder *b, float red, float green, float blue);
uint32_t builder_vertex(mesh_builder *b, double x, double y, double z);
void builder_triangle(mesh_builder *b, uint32_t i, uint32_t j, uint32_t k);
/*
 * Two triangles for each cell of a grid, which look up. Precondition: its (cells + 1)^2 vertices have been added last,
 * row by row, z growing with the row and x within it.
 */
void builder_cells(mesh_builder *b, uint32_t cells);
/* Corners counter-clockwise, seen from the side that it faces. */
void builder_quad(mesh_builder *b, const double corners[4][3]);
void builder_box(mesh_builder *b, const double minimum[3], const double maximum[3]);
/* A cone's frustum between two points, closed at both ends. A radius of 0 makes a tip. */
void builder_tube(mesh_builder *b, const double from[3], const double to[3], double from_radius, double to_radius,
                  uint32_t sides);
/* An icosahedron divided `subdivisions` times; its surface is moved in and out by up to `roughness` of its radius. */
void builder_ball(mesh_builder *b, const double center[3], const double radius[3], uint32_t subdivisions,
                  double roughness, uint32_t seed);

/*
 * Adds what was built to the scene, and empties the builder. index_size is 2 or 4; 2 becomes 4 where vertices are too
 * many.
 */
uint32_t builder_finish(mesh_builder *b, scene *s, const char *name, uint32_t index_size, bool smooth);

/* A fixed hash of its arguments, in [0, 1). */
double noise_hash(uint32_t a, uint32_t b, uint32_t seed);
/* Smooth noise with features of size 1, in [-1, 1]; several octaves of it. */
double noise_value(double x, double y, uint32_t seed);
double noise_fractal(double x, double y, uint32_t octaves, uint32_t seed);

#endif
