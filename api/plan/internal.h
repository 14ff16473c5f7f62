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

/* ---- light ---- */
/*
 * The basis that a frame is drawn with: that of its light, or of the last frame's as long as the light has not moved a
 * step, turned as light_roll says. Errors: those of plan_light_basis.
 */
csm_result plan_light_make(double basis[9], const csm_config *config, const double direction[3],
                           const plan_history *before, const char **error);

/* ---- what all cascades of a frame are fitted to ---- */
typedef struct plan_fit_frame {
  const csm_config *config;
  const plan_camera *camera;
  const double *basis;
  const plan_samples *samples; /* NULL: nothing is fitted to them */
  const plan_history *before;  /* may be NULL */
  plan_history *after;
} plan_fit_frame;

/* ---- splits ---- */
/*
 * Where the cascades begin and end, as view depth: count + 1 values, strictly rising, the last one the end of the
 * shadows exactly. INVALID_CAMERA: there is nothing between the near plane and that end.
 */
csm_result plan_splits(double *depths, const plan_fit_frame *frame, const char **error);

/* ---- samples ---- */
/* Whether what was seen then says enough of what a camera sees now. */
bool plan_samples_usable(const plan_samples *samples, const plan_camera *camera, const csm_config *config);
/* Narrows the range of depths that splits divide. */
void plan_samples_range(double *near, double *end, const plan_fit_frame *frame);
/* Narrows what a map covers of light space, along right and up. */
void plan_samples_bound(double middle[2], double width[2], const plan_fit_frame *frame, uint32_t cascade, double near,
                        double far);

/* ---- slices ---- */
/* The corners in view space of what lies between two view depths: four of its near face, then of its far one. */
void plan_slice_corners(double corners[8][3], const plan_camera *camera, double near, double far);
/*
 * The least sphere, in view space, around what lies between two view depths; see sphere.c. Depends on the projection
 * alone. The result is infinite or NaN where numbers overflow.
 */
void plan_slice_sphere(double center[3], double *radius, const plan_camera *camera, double near, double far);
/* The sphere around the mean of its corners, likewise. */
void plan_slice_centroid_sphere(double center[3], double *radius, const plan_camera *camera, double near, double far);
/* A point of a camera's view space in light space; `inverse` is plan_view_rotation_inverse's. */
void plan_view_to_light(double out[3], const plan_camera *camera, const double basis[9], const double inverse[9],
                        const double view[3]);

/* ---- fit ---- */
/* Where a map lies in light space, before its casters are known. */
typedef struct plan_fit {
  double texel[2];  /* metres along right and up */
  double origin[2]; /* the map's beginning, in texels from the world's origin */
  double depth[2];  /* of the slice along the light, metres */
  double step;      /* of depths that are rounded, metres */
  uint32_t resolution;
} plan_fit;

/* What one map covers of light space, in metres from the world's origin. */
typedef struct plan_area {
  double min[2], max[2]; /* along right and up */
  double depth[2];       /* along the light; nothing beyond the second is drawn; with depth_mode casters the first is
                            where the slice begins */
  double first_caster;   /* found by culling: where the first caster begins along the light; INFINITY: none */
} plan_area;

/* The corners, in light space, of the box in the world that holds all instances; corner_count is 0 if there are none.
 */
typedef struct plan_scene_box {
  double corners[8][3];
  uint32_t corner_count;
} plan_scene_box;

/* INVALID_CAMERA: numbers too large to plan with. */
csm_result plan_fit_slice(plan_fit *out, const plan_fit_frame *frame, uint32_t cascade, double near, double far,
                          const char **error);
plan_area plan_fit_area(const plan_fit *fit, const csm_config *config, const plan_scene_box *box);
/* Writes the cascade's matrices, now that its casters are known. */
void plan_fit_place(plan_cascade *cascade, const plan_fit *fit, const plan_area *area, const double basis[9],
                    const csm_config *config);

/* ---- filter ---- */
enum { PLAN_MAX_TAPS = 31, PLAN_MAX_WEIGHTS = 16, PLAN_LEAST_RESOLUTION = 16 };
/* Taps a side, or points. */
uint32_t plan_filter_taps(const csm_config *config);
/* Of taps from the middle outwards, along one axis; returns the sum of all taps'. */
double plan_filter_weights(double weights[PLAN_MAX_WEIGHTS], const csm_config *config);
/* From a sample to the farthest texel's centre that it is compared with, along one axis. */
double plan_filter_reach_texels(const csm_config *config);
/* Room that a map leaves at its borders. */
double plan_padding_texels(const csm_config *config);

/* ---- culling ---- */
/* What a camera sees until the shadows end, across the light: the half-planes around it. */
typedef struct plan_hull {
  double normals[8][2], offsets[8]; /* inside: dot(normal, xy) <= offset */
  uint32_t count;                   /* 0: nothing is left out */
} plan_hull;
/* The hull, with so many metres of room around it. */
void plan_view_hull(plan_hull *out, const plan_camera *camera, const double basis[9], double end, double room);
void plan_scene_bounds(plan_scene_box *out, const double basis[9], const plan_scene *scene);

/* The lists of a plan while they are made. */
typedef struct plan_lists {
  plan_list *lists[CSM_MAX_CASCADES];
  uint32_t count;
  bool sides;       /* mirrored instances are drawn apart */
  uint8_t *masks;   /* for each instance: bit i is set if list i holds it */
  uint32_t *counts; /* [plan_list_key * count + list]: instances of that key in the list */
} plan_lists;

/* What instances share that are drawn together: the mesh and, where it matters, the side. */
static inline uint32_t plan_list_key(const plan_lists *lists, const plan_instance *instance) {
  return instance->mesh * 2 + (lists->sides ? instance->mirrored : 0);
}

/* Lays the lists out in memory of plan_memory_size bytes, with empty counts. */
void plan_lists_begin(plan_lists *lists, const plan_scene *scene, void *memory);
/* Fills every list from masks and counts. */
void plan_lists_end(plan_lists *lists, const plan_scene *scene);

/* Notes in list i what casts into area i, and how far towards the light those casters reach. */
void plan_cull_light(plan_lists *lists, plan_area *areas, const double basis[9], const plan_hull *hull,
                     const plan_scene *scene);
/* Notes in the one list what may be in the camera's clip volume. */
void plan_cull_view(plan_lists *lists, const plan_camera *camera, const plan_scene *scene);

/* ---- packing ---- */
/* World to clip of a cascade: three rows of four. */
void plan_cascade_to_clip(double rows[3][4], const plan_frame *frame, uint32_t cascade);
/* Object to clip of one instance: three rows of four. */
void plan_instance_to_clip(float out[12], const double rows[3][4], const plan_instance *instance);

#endif
