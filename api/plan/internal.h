/* internal.h: what the plan's files share among themselves. */
#ifndef PLAN_INTERNAL_H
#define PLAN_INTERNAL_H

#include "plan/plan.h"

/* Largest Frobenius norm of transpose(view) * view - 1 at which a view still counts as rigid. */
#define PLAN_RIGID_TOLERANCE 1e-3

/* ---- vectors ---- */
static inline double plan_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void plan_cross(double out[3], const double a[3], const double b[3]);
/* Of any length but 0: also one whose square would overflow or vanish. False: zero, or not finite. */
bool plan_normalize(double v[3]);

/* The nearest float; what a float cannot hold becomes the largest one, and no result is NaN. */
static inline float plan_float(double value) {
  const double limit = 3.4028234663852886e38;
  const double above = value > -limit ? value : -limit;
  return (float)(above < limit ? above : limit);
}

/* ---- errors ---- */
static inline csm_result plan_fail(const char **error, csm_result result, const char *text) {
  if (error)
    *error = text;
  return result;
}

/* ---- camera ---- */
/* The view z that lies before the camera: 1 or -1. */
double plan_view_side(const plan_camera *camera);
/* Inverse of the view's rotation, column-major 3 x 3. */
void plan_view_rotation_inverse(double out[9], const double view[16]);

/* ---- splits ---- */
/*
 * Where the cascades begin and end, as view depth: count + 1 values, strictly rising, the last one the end of the
 * shadows exactly. INVALID_CAMERA: there is nothing between the near plane and that end.
 */
csm_result plan_splits(double *depths, const csm_config *config, const plan_camera *camera, const char **error);

/* ---- fit ---- */
/*
 * The least sphere, in view space, around what lies between two view depths; see sphere.c. Depends on the projection
 * alone. The result is infinite or NaN where numbers overflow.
 */
void plan_slice_sphere(double center[3], double *radius, const plan_camera *camera, double near, double far);

/* ---- culling ---- */
/* What one map covers of light space, in metres from the world's origin. */
typedef struct plan_area {
  double min[2], max[2]; /* along right and up */
  double end;            /* along the light: nothing beyond it is drawn */
  double first_caster;   /* found by culling: where the first caster begins along the light; INFINITY: none */
} plan_area;

/* The lists of a plan while they are made. */
typedef struct plan_lists {
  plan_list *lists[CSM_MAX_CASCADES];
  uint32_t count;
  uint8_t *masks;   /* for each instance: bit i is set if list i holds it */
  uint32_t *counts; /* [mesh * count + list]: instances of the mesh in the list */
} plan_lists;

/* Lays the lists out in memory of plan_memory_size bytes, with empty counts. */
void plan_lists_begin(plan_lists *lists, const plan_scene *scene, void *memory);
/* Fills every list from masks and counts. */
void plan_lists_end(plan_lists *lists, const plan_scene *scene);

/* Notes in list i what casts into area i, and how far towards the light those casters reach. */
void plan_cull_light(plan_lists *lists, plan_area *areas, const double basis[9], const plan_scene *scene);
/* Notes in the one list what may be in the camera's clip volume. */
void plan_cull_view(plan_lists *lists, const plan_camera *camera, const plan_scene *scene);

/* ---- packing ---- */
/* World to clip of a cascade: three rows of four. */
void plan_cascade_to_clip(double rows[3][4], const plan_frame *frame, uint32_t cascade);
/* Object to clip of one instance: three rows of four. */
void plan_instance_to_clip(float out[12], const double rows[3][4], const plan_instance *instance);

#endif
