/* support.h: small scenes with known answers, for the tests that run on every backend. */
#ifndef SUPPORT_H
#define SUPPORT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "csm/csm.h"

/* What a context said and held; the log and allocator callbacks fill it in. */
typedef struct record {
  const char *backend;
  uint32_t errors; /* messages of level CSM_LOG_ERROR */
  uint32_t warnings;
  bool quiet;               /* errors are expected: do not print them */
  int64_t blocks;           /* live */
  uint64_t allocations;     /* made so far */
  int64_t allocations_left; /* then allocation fails; negative: never */
  char said[1024];          /* the errors since the caller emptied it, a line each, as far as they fit */
} record;

csm_create_info support_create_info(record *record);
csm_context *support_open(record *record);
/* Likewise, with more CSM_CREATE_*. */
csm_context *support_open_with(record *record, uint32_t flags);
/* Destroys the context, and asserts that it said nothing unexpected and gave every allocation back. */
void support_close(csm_context *context, record *record);

/* Meshes: a box of half size 1 about the origin, and a square of half size 1 in the plane y = 0, seen from above. */
csm_mesh support_box(csm_context *context, uint32_t index_size);
csm_mesh support_square(csm_context *context);

csm_instance support_instance(csm_mesh mesh, double x, double y, double z, double sx, double sy, double sz);

/* Right-handed view from `eye` to `target`; reversed-Z perspective with an infinite far plane if far is 0. */
void support_look_at(double view[16], const double eye[3], const double target[3]);
void support_perspective(double projection[16], double fov_y_degrees, double aspect, double near, double far);

/* The world position of what a perspective camera of ours sees at a place of its picture, from 0 to 1 right and down. */
void support_seen(const csm_camera *camera, float depth, double u, double v, double out[3]);

/* A frame with the camera and the light that it points to. */
typedef struct shot {
  csm_frame frame;
  csm_camera camera;
  csm_light light;
} shot;
/* With its structs' sizes; of instances, which may be NULL. */
shot shot_make(const csm_instance *instances, uint32_t count);
/* The frame, which points to what lies beside it: called again for each copy. */
const csm_frame *shot_frame(shot *shot);
/* Resolves a mask of the shot's camera. */
csm_result shot_resolve(shot *shot, csm_view *view, csm_cascades *cascades, uint32_t width, uint32_t height);

/* A frame of a scene that all tests know: a ground of 60 m a side at y = 0, and boxes on and above it. */
enum { SUPPORT_BOXES = 5, SUPPORT_INSTANCES = SUPPORT_BOXES + 1 };
typedef struct support_scene {
  csm_instance instances[SUPPORT_INSTANCES];
  shot shot;
} support_scene;
void support_scene_make(support_scene *scene, csm_context *context);
/* The same scene without a context, as triangles in world space: fills `corners` with three points for each. */
enum { SUPPORT_TRIANGLES = 12 * SUPPORT_BOXES + 2 };
void support_triangles(const support_scene *scene, double corners[SUPPORT_TRIANGLES][3][3]);
/* The nearest hit of a ray with the triangles, as a distance along `direction`; negative if there is none. `edge` gets
   how near to an edge of its triangle that hit is, in barycentric units. */
double support_trace(double corners[][3][3], uint32_t count, const double origin[3], const double direction[3],
                     double *edge);

/* The alpha that a mask has at a place, in doubles: bilinear, 0 to 1. */
typedef struct support_texture {
  const uint8_t *texels;
  int width, height, stride;
  uint32_t wrap_u, wrap_v; /* CSM_WRAP_* */
} support_texture;
double support_alpha(const support_texture *texture, double u, double v);

/* A ground, and after it so many flat boxes, 9 to 20 m over it: the same each time. */
void support_boxes_above(csm_context *context, csm_instance *out, uint32_t count);

/* The default configuration with fewer and smaller maps, for speed. */
csm_config support_config(void);

/* Keeps the programs that draw the meshes there are, which cascades share and which go with the last of them. */
void support_keep_programs(csm_context *context);
csm_view *support_view(csm_context *context);

/* Read a map, or a view's mask or camera depth (CSM_READ_*); the caller frees them. */
float *support_map(csm_context *context, csm_cascades *cascades, uint32_t cascade, uint32_t resolution);
float *support_image(csm_context *context, csm_view *view, uint32_t source, uint32_t width, uint32_t height);

/* Asserts that two bindings tell shaders the same, native handles apart. */
void support_same_binding(const csm_binding *a, const csm_binding *b);

/* Applies a column-major matrix to a point; returns w. */
double support_apply(const double m[16], const double p[3], double out[3]);

int support_main(int argc, char **argv, const struct CMUnitTest *tests, size_t count);
const char *support_backend(void);

#endif
