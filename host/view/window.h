/* view/window.h: a window, and what is done to it. The only part of csm-host that knows SDL. */
#ifndef HOST_VIEW_WINDOW_H
#define HOST_VIEW_WINDOW_H

#include "base/image.h"
#include <stdbool.h>
#include <stdint.h>

typedef struct view_window view_window;

typedef struct view_input {
  double right, up, forward; /* -1 to 1: which of the keys that move are held */
  bool fast;
  double turn, tilt; /* radians: by the mouse, while a button is held */
  char keys[16];     /* pressed since the last time, as capitals and digits */
  uint32_t key_count;
  bool uncovered; /* what it showed may be lost */
  bool quit;
} view_input;

/* 0, or HOST_BAD_INPUT after a message (no display); the window is closed then. */
int view_window_open(view_window **out, uint32_t width, uint32_t height);
void view_window_close(view_window *w); /* NULL is allowed */

/* Waits up to wait_ms for something to happen, then tells all that did. */
void view_window_poll(view_window *w, uint32_t wait_ms, view_input *out);

/* Shows a picture as large as it fits. */
void view_window_show(view_window *w, const image *picture);
void view_window_title(view_window *w, const char *text);

/* What the window shows. image_free it. */
void view_window_grab(view_window *w, image *out);

#endif
