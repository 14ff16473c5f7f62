/* scene/camera.h: where a picture is taken from. */
#ifndef HOST_CAMERA_H
#define HOST_CAMERA_H

#include <stdbool.h>
#include <stdint.h>

typedef struct camera {
  double view[16];       /* world to view */
  double projection[16]; /* view to clip, z in [0,1] */
  double position[3];    /* world */
  double forward[3];     /* world: unit, the way it looks */
  double near_depth;     /* metres along forward */
  double far_depth;      /* INFINITY for an infinite far plane */
  bool reversed;         /* clip z is 1 at the near plane */
} camera;

/* How a camera of the host's own is placed; its projection is made when the picture's size is known. */
typedef struct camera_pose {
  double position[3], target[3];
  double vertical_fov_deg;
  double near_depth, far_depth; /* metres; far may be INFINITY */
} camera_pose;

/* NULL, or what is wrong with the pose, in words. */
const char *camera_pose_check(const camera_pose *pose);

/* Right-handed, reversed-Z, looking along view -z. Precondition: the pose is checked, aspect (width / height) > 0. */
void camera_from_pose(camera *out, const camera_pose *pose, double aspect);

/*
 * Finds position, forward, near, far and reversed from the two matrices. NULL, or what is wrong with them.
 * `reversed` may be NULL, but for an orthographic camera whose near plane lies behind it: its matrix does not tell.
 */
const char *camera_from_matrices(camera *out, const double view[16], const double projection[16], const bool *reversed);

/* One that is turned to the left about the upright through its place, and then goes on level, ahead and to the right. */
camera camera_moved(const camera *from, double ahead_m, double aside_m, double turned_deg);

/* The rays through the centres of a picture's pixels. */
typedef struct camera_rays {
  double unproject[16]; /* clip to view */
  double unview[16];    /* view to world; its last column is the point that rays are relative to */
  uint32_t width, height;
  bool reversed;
} camera_rays;

/* False: the camera's matrices are singular. */
bool camera_rays_make(camera_rays *out, const camera *from, uint32_t width, uint32_t height);
/*
 * The ray through clip (x, y), in the world relative to the view's origin: from the near plane, in a unit direction,
 * to the far plane, `reach` metres on, or INFINITY. For every projection.
 */
void camera_ray(const camera_rays *rays, double x, double y, double origin[3], double direction[3], double *reach);
/* The point at a view depth on the ray through clip x and y, relative to the camera's position. */
void camera_point(const camera_rays *rays, const camera *from, double x, double y, double depth, double point[3]);
/*
 * The corners of what is seen between two view depths, as camera_point has them. Bits 0 to 2 of an index are right, top
 * and far.
 */
void camera_slice(const camera_rays *rays, const camera *from, double near, double far, double corners[8][3]);
/* Clip x and y of a pixel's centre. */
double camera_pixel_x(const camera_rays *rays, uint32_t column);
double camera_pixel_y(const camera_rays *rays, uint32_t row);

#endif
