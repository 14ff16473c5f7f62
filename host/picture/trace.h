/* picture/trace.h: what a camera sees of a scene, found by casting a ray through every pixel's centre. For pictures. */
#ifndef HOST_TRACE_H
#define HOST_TRACE_H

#include "scene/scene.h"

typedef struct trace_surface {
  double view_depth; /* metres along the camera's forward; negative: nothing was hit */
  double distance;   /* metres from the camera */
  float position[3]; /* relative to the camera's position */
  float normal[3];   /* unit, in the world, turned to the camera */
  float color[3];    /* linear */
  uint32_t instance; /* of the scene; only where something was hit */
  float ray[3];      /* unit, in the world: the direction that this pixel looks */
} trace_surface;

/* Fills width * height surfaces, top row first. 0, or HOST_BAD_INPUT after a message. */
int trace_camera(const scene *s, const camera *from, uint32_t width, uint32_t height, trace_surface *out);

#endif
