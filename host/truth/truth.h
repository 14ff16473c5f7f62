/*
 * truth/truth.h: what a camera sees and how much of the sun each point sees, found by casting rays through the exact
 * triangles. It shares nothing with the renderer. docs/accuracy.md says how each thing is defined.
 */
#ifndef HOST_TRUTH_H
#define HOST_TRUTH_H

#include "scene/scene.h"

#define TRUTH_NOTHING UINT32_MAX
#define TRUTH_MAX_SUN_SAMPLES 4096

/* The world's triangles, ready for rays. */
typedef struct truth truth;

/* `s` must outlive it. alpha_test: triangles of alpha-tested materials are cut out by their alpha_mask. */
truth *truth_create(const scene *s, bool alpha_test);
void truth_destroy(truth *t); /* NULL is allowed */
/* Bytes that the triangles take, Embree's share included. */
uint64_t truth_memory(const truth *t);

/* The first surface that is seen through a pixel's centre. */
typedef struct truth_surface {
  double view_depth; /* metres along the camera's forward; negative: nothing is seen */
  float normal[3];   /* geometric, unit, turned to the camera */
  uint32_t triangle; /* of the world's; TRUTH_NOTHING */
  bool behind;       /* seen from the back of its winding */
} truth_surface;

/* What a camera sees: width * height pixels, top row first. */
typedef struct truth_view {
  const camera *camera;
  uint32_t width, height;
  truth_surface *surfaces;
} truth_view;

/* Which triangle each pixel sees, or TRUTH_NOTHING. 0, or HOST_BAD_INPUT after a message. */
int truth_find(truth *t, const camera *from, uint32_t width, uint32_t height, uint32_t *triangles);

/*
 * Fills view->surfaces for pixels that see those triangles. 0, or HOST_BAD_INPUT after a message.
 */
int truth_view_fill(truth *t, const truth_view *view, const uint32_t *triangles);

/* How near a part of the sun's samples comes to all of them, over pixels with a partly hidden sun. */
typedef struct truth_convergence {
  uint32_t samples;
  uint64_t pixels;              /* that see a part of the sun, by all samples or by the first half */
  double rms_quarter, rms_half; /* of the first quarter, and half, of the samples */
  double largest_half;
} truth_convergence;

typedef struct truth_asked {
  const scene_light *light;
  double max_depth; /* surfaces beyond it are not asked */
  uint32_t samples; /* rays for each pixel to a disc, 4 to TRUTH_MAX_SUN_SAMPLES; one goes to a disc of 0 degrees */
} truth_asked;

/*
 * The share of the sun that each pixel's surface sees: 1 lit, 0 shadowed. It is 1 where nothing is seen, and 0 where
 * the surface is turned away from the sun's middle, or lies beyond max_depth. 0, or HOST_BAD_INPUT after a message.
 */
int truth_visibility(truth *t, const truth_view *view, const truth_asked *asked, float *visibility,
                     truth_convergence *convergence);

/* Whether another camera sees each pixel's point too, from the same side. 0, or HOST_BAD_INPUT after a message. */
int truth_seen(truth *t, const truth_view *view, const camera *other, uint8_t *seen);

/*
 * Cosine of the angle between a surface's normal and the direction to the light: negative where it is turned away.
 * Precondition: the light's direction is not zero.
 */
double truth_facing(const truth_surface *surface, const scene_light *light);

#endif
