/* view/flying_camera.h: a camera that flies. */
#ifndef HOST_VIEW_CAMERA_H
#define HOST_VIEW_CAMERA_H

#include "scene/camera.h"

/* Where it started, and how far it has turned since. Its projection and handedness stay. */
typedef struct view_camera {
  camera start;
  double right[3];        /* unit: its right at the start */
  double position[3];     /* now */
  double turn, tilt;      /* radians, to the left and upwards */
  double lowest, highest; /* tilts at which it would look straight down and up */
} view_camera;

void view_camera_start(view_camera *out, const camera *from);
/* Radians, to the left and upwards; it stops short of the vertical. */
void view_camera_turn(view_camera *c, double left, double up);
/* Metres along its right, the world's up, and its forward. */
void view_camera_move(view_camera *c, double right, double up, double forward);
/* Where it is now, as a camera. */
void view_camera_place(const view_camera *c, camera *out);

#endif
