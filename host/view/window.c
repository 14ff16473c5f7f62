#include "view/window.h"
#include "base/host.h"
#define SDL_MAIN_HANDLED /* main is csm-host's own */
#include <SDL.h>
#include <stdlib.h>
#include <string.h>

static const double radians_per_px = 0.004;

struct view_window {
  SDL_Window *window;
};

int view_window_open(view_window **out, uint32_t width, uint32_t height) {
  *out = host_allocate(1, sizeof **out);
  SDL_SetMainReady();
  SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1"); /* Ctrl-C ends the program as it does every other command */
  if (SDL_Init(SDL_INIT_VIDEO) == 0)
    (*out)->window = SDL_CreateWindow("csm-host view", SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, (int)width,
                                      (int)height, SDL_WINDOW_RESIZABLE);
  if ((*out)->window && SDL_GetWindowSurface((*out)->window))
    return 0;
  const int code = host_fail(HOST_BAD_INPUT, "view: no window can be opened: %s", SDL_GetError());
  view_window_close(*out);
  *out = NULL;
  return code;
}

void view_window_close(view_window *w) {
  if (!w)
    return;
  if (w->window)
    SDL_DestroyWindow(w->window);
  SDL_Quit();
  free(w);
}

/* ---- input ---- */

static void add_key(view_input *out, SDL_Keycode code) {
  const bool digit = code >= SDLK_0 && code <= SDLK_9, letter = code >= SDLK_a && code <= SDLK_z;
  if ((digit || letter) && out->key_count < sizeof out->keys)
    out->keys[out->key_count++] = (char)(letter ? code - SDLK_a + 'A' : code - SDLK_0 + '0');
}

static void take_event(view_input *out, const SDL_Event *event) {
  const uint32_t buttons = SDL_BUTTON_LMASK | SDL_BUTTON_RMASK;
  if (event->type == SDL_QUIT || (event->type == SDL_KEYDOWN && event->key.keysym.sym == SDLK_ESCAPE))
    out->quit = true;
  else if (event->type == SDL_WINDOWEVENT)
    out->uncovered = true;
  else if (event->type == SDL_KEYDOWN && !event->key.repeat)
    add_key(out, event->key.keysym.sym);
  else if (event->type == SDL_MOUSEMOTION && (event->motion.state & buttons)) {
    out->turn -= radians_per_px * event->motion.xrel;
    out->tilt -= radians_per_px * event->motion.yrel;
  }
}

void view_window_poll(view_window *w, uint32_t wait_ms, view_input *out) {
  SDL_Event event;
  (void)w;
  *out = (view_input){0};
  if (wait_ms > 0 && SDL_WaitEventTimeout(&event, (int)wait_ms))
    take_event(out, &event);
  while (SDL_PollEvent(&event))
    take_event(out, &event);
  const uint8_t *held = SDL_GetKeyboardState(NULL);
  out->right = held[SDL_SCANCODE_D] - held[SDL_SCANCODE_A];
  out->up = held[SDL_SCANCODE_E] - held[SDL_SCANCODE_Q];
  out->forward = held[SDL_SCANCODE_W] - held[SDL_SCANCODE_S];
  out->fast = held[SDL_SCANCODE_LSHIFT] || held[SDL_SCANCODE_RSHIFT];
}

/* ---- pictures ---- */

void view_window_show(view_window *w, const image *picture) {
  SDL_Surface *screen = SDL_GetWindowSurface(w->window); /* anew each time: it changes with the window's size */
  SDL_Surface *from = SDL_CreateRGBSurfaceWithFormatFrom(picture->pixels, (int)picture->width, (int)picture->height, 24,
                                                         (int)picture->width * 3, SDL_PIXELFORMAT_RGB24);
  if (screen && from) {
    const double across = (double)screen->w / picture->width, down = (double)screen->h / picture->height;
    const double scale = across < down ? across : down;
    SDL_Rect to = {.w = (int)(scale * picture->width), .h = (int)(scale * picture->height)};
    to.x = (screen->w - to.w) / 2;
    to.y = (screen->h - to.h) / 2;
    SDL_FillRect(screen, NULL, 0);
    SDL_BlitScaled(from, NULL, screen, &to);
    SDL_UpdateWindowSurface(w->window);
  }
  SDL_FreeSurface(from);
}

void view_window_title(view_window *w, const char *text) {
  SDL_SetWindowTitle(w->window, text);
}

void view_window_grab(view_window *w, image *out) {
  SDL_Surface *screen = SDL_GetWindowSurface(w->window);
  image_create(out, (uint32_t)screen->w, (uint32_t)screen->h);
  SDL_ConvertPixels(screen->w, screen->h, screen->format->format, screen->pixels, screen->pitch, SDL_PIXELFORMAT_RGB24,
                    out->pixels, screen->w * 3);
}
