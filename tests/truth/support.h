/* support.h: small scenes, cameras, and a brute-force ray caster of its own. */
#ifndef TRUTH_SUPPORT_H
#define TRUTH_SUPPORT_H

#include "metrics/metrics.h"
#include "truth/truth.h"

/* Adds a mesh of `count` triangles (nine floats each) in one instance, moved by `offset`. Returns the mesh. */
scene_mesh *add_triangles(scene *s, const float (*corners)[9], uint32_t count, const double offset[3]);
void add_quad(scene *s, const float corners[4][3], const double offset[3]);
/* Twelve triangles. */
void add_box(scene *s, const float low[3], const float high[3], const double offset[3]);

/* A number in [0, 1) from a state that it moves on. */
double random_unit(uint32_t *state);
/* Triangles of about `size` in a box of half side `reach` around the offset. */
void add_random(scene *s, uint32_t count, double reach, double size, uint32_t seed, const double offset[3]);

camera look(const double from[3], const double at[3], double fov_deg, double aspect);

enum { ANSWER_WIDTH = 160, ANSWER_HEIGHT = 120 };

/* What the caster says of one picture. answer_free it. */
typedef struct answer {
  truth_view view;
  float *visibility;
  truth_convergence convergence;
} answer;
void ask(answer *out, const scene *s, const camera *from, const truth_asked *asked, bool alpha_test);
void answer_free(answer *a);

/* ---- brute force, in doubles, over the exact triangles: one after the other (Moeller and Trumbore 1997) ---- */

typedef struct brute_triangle {
  double corners[3][3];
} brute_triangle;

typedef struct brute {
  brute_triangle *triangles;
  uint32_t count;
} brute;

void brute_make(brute *out, const scene *s);
void brute_free(brute *b);
/* The nearest triangle along a ray, leaving out `skip`; TRUTH_NOTHING if there is none. */
uint32_t brute_nearest(const brute *b, const double from[3], const double direction[3], uint32_t skip,
                       double *distance);
/* The ray through a pixel's centre, from the inverse of projection times view. */
void brute_ray(const truth_view *view, uint32_t column, uint32_t row, double origin[3], double direction[3]);

#endif
