/*
 * view/surfaces.h: what the viewer's camera sees. Its depth gives surfaces at once, without colours. Rays that are cast
 * in the background while the camera rests add the scene's colours.
 */
#ifndef HOST_VIEW_SURFACES_H
#define HOST_VIEW_SURFACES_H

#include "picture/trace.h"
#include <pthread.h>
#include <stdatomic.h>

/* `depth`: as csm_read gives it, drawn with this camera. */
void view_surfaces_from_depth(trace_surface *out, const camera *from, const float *depth, uint32_t width,
                              uint32_t height);

typedef struct view_trace {
  const scene *scene;
  camera camera;
  uint32_t width, height;
  trace_surface *surfaces; /* readable once view_trace_done */
  pthread_t thread;
  bool running;
  atomic_bool finished;
  int code;
} view_trace;

/* Begins, unless it is running; false then, or if there is no thread for it. */
bool view_trace_begin(view_trace *t, const camera *from);
/* True once, when what was begun has come to its end. */
bool view_trace_done(view_trace *t);
/* Waits for it; true if it was running. */
bool view_trace_wait(view_trace *t);

#endif
