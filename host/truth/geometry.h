/* truth/geometry.h: a scene's triangles in the world, in float32 relative to an origin in doubles. */
#ifndef HOST_TRUTH_GEOMETRY_H
#define HOST_TRUTH_GEOMETRY_H

#include "scene/scene.h"

typedef struct truth_geometry {
  const scene *scene;
  double origin[3];
  uint32_t vertex_count, triangle_count;
  float *vertices;    /* three each, and one float more at the end, as Embree wants it */
  uint32_t *indices;  /* three a triangle */
  uint32_t *surfaces; /* of each triangle: those with the same three corners are one surface */
  uint32_t *first;    /* of each instance, its first triangle; one more at the end */
  bool *cut_out;      /* of each instance: its alpha mask decides; NULL: of none */
} truth_geometry;

/* 0, or HOST_BAD_INPUT after a message. truth_geometry_free is allowed in both cases. */
int truth_geometry_make(truth_geometry *out, const scene *s, const double origin[3], bool alpha_test);
void truth_geometry_free(truth_geometry *g);

void truth_geometry_corners(const truth_geometry *g, uint32_t triangle, double corners[3][3]);

/* Whether there is something at a point of a triangle, given by its weights of the corners. */
bool truth_geometry_opaque(const truth_geometry *g, uint32_t triangle, const double weights[3]);

/* Whether the triangle's winding makes its normal (b - a) x (c - a) point to the back: its instance is mirrored. */
bool truth_geometry_mirrored(const truth_geometry *g, uint32_t triangle);

/*
 * The ray from `from` (relative to the origin) along `direction` against a triangle's plane and edges, in doubles.
 * False: it misses. Edges count as inside, and two triangles that share one leave no gap between them.
 * weights: of the corners; *distance in lengths of `direction`, of either sign.
 */
bool truth_ray_triangle(double corners[3][3], const double from[3], const double direction[3], double weights[3],
                        double *distance);

#endif
