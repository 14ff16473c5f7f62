/* support.h: random cameras, lights and scenes for the plan's tests, made without the plan's own arithmetic. */
#ifndef TEST_PLAN_SUPPORT_H
#define TEST_PLAN_SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "plan/plan.h"

/* ---- random numbers: the same ones in every run ---- */
typedef struct random_state {
  uint64_t value;
} random_state;

uint64_t random_bits(random_state *random);
double random_between(random_state *random, double low, double high);
/* Evenly over orders of magnitude; both above 0. */
double random_scale(random_state *random, double low, double high);
uint32_t random_below(random_state *random, uint32_t count);
void random_unit(random_state *random, double out[3]);

/* ---- cameras ---- */
typedef struct test_camera {
  double eye[3];
  double right[3], up[3], forward[3]; /* world; orthonormal */
  double half_width, half_height;     /* perspective: tangents; orthographic: metres */
  double center[2];                   /* clip x and y of the view axis; off-centre or jittered where not 0 */
  double near, far;                   /* far may be INFINITY */
  bool orthographic, reversed, left_handed, mirrored;
} test_camera;

/* Of every kind that the plan accepts, within `world` metres of the origin. */
test_camera random_camera(random_state *random, double world);
/* Points the camera along a direction, with some roll. */
void camera_look(test_camera *camera, const double forward[3], double roll);
void camera_matrices(const test_camera *camera, double view[16], double projection[16]);
/* The world position that a camera sees at clip x, y and a view depth. */
void camera_point(const test_camera *camera, double x, double y, double depth, double out[3]);
/* A 16:9 perspective camera at the origin that looks along -z, 60 degrees high, from 0.1 to 1000 m. */
test_camera plain_camera(void);

/* ---- frames ---- */
/* Plans without casters; the test fails if that fails. */
plan_frame plan_empty(const csm_config *config, const test_camera *camera, const double light[3]);
csm_config default_config(void);
/* A configuration within all ranges, with practical or manual splits. */
csm_config random_config(random_state *random);
/* A sound one whose fit, snapping, filter, resolutions and splits may be any of all. */
csm_config random_full_config(random_state *random);

/* Memory for a store of instances, and for caches. */
void *CSM_CALL support_allocate(void *user, size_t size, size_t align);
void CSM_CALL support_release(void *user, void *memory);
/* Room for plans that find so many instances. */
plan_memory *memory_make(uint32_t most, uint32_t mesh_count, uint32_t window_count);
void memory_free(plan_memory *memory);

/* A scene with its memory, as a plan needs it. */
typedef struct test_scene {
  plan_scene scene;
  plan_instance *instances;
  plan_box *boxes;
  plan_bounds *meshes;
  plan_memory *memory;
} test_scene;

test_scene scene_make(uint32_t instance_count, uint32_t mesh_count);
void scene_free(test_scene *scene);
/* Finds what follows from instances and meshes. */
void scene_place(test_scene *scene);
/* Random transforms (also mirrored, sheared and flat) within `spread` metres of a point. */
void scene_scatter(test_scene *scene, random_state *random, const double center[3], double spread);
/* The world position of a point of the instance's box, each coordinate from -1 to 1. */
void instance_point(const plan_scene *scene, uint32_t instance, const double at[3], double out[3]);

/* Column-major matrix times (p, 1), without the last row; summed in long double, so that tests measure the plan. */
void transform_point(const double m[16], const double p[3], double out[3]);

/* The light's depth of world points, as a share of a cascade's range, is row 2 of world_to_shadow. */
double shadow_depth(const csm_cascade_info *info, const double p[3]);
/* A point of a slice: its corners and edges too, where maps are tightest. */
void slice_point(random_state *random, const test_camera *camera, const csm_cascade_info *info, double out[3]);

/* CSM_REVERSED_*, as the camera is. */
uint32_t camera_reversed(const test_camera *camera);

void assert_near(double value, double expected, double tolerance);
/* Nothing has divided by 0, overflowed or been invalid since feclearexcept. */
void assert_no_exceptions(void);
/* plan_frame_make, which must raise no floating-point exception. */
csm_result plan_traced(plan_frame *out, const plan_frame_info *info, plan_memory *memory, const char **error);
/* A camera's matrices, CSM_REVERSED_*, and the light's direction. */
typedef struct test_shot {
  const double *view, *projection;
  uint32_t reversed;
  const double *light;
} test_shot;

/* A first frame, without depth samples. */
csm_result plan_made(plan_frame *out, const csm_config *config, const test_shot *shot, const plan_scene *scene,
                     plan_memory *memory, const char **error);

#endif
