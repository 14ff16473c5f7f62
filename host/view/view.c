#include "view/view.h"
#include "base/host.h"
#include "base/output_file.h"
#include "picture/outside.h"
#include "picture/picture.h"
#include "setup/config_json.h"
#include "setup/presets.h"
#include "stage/compare.h"
#include "stage/stage.h"
#include "view/flying_camera.h"
#include "view/surfaces.h"
#include "view/window.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* How long the camera rests before rays are cast for colours. */
static const double rest_ms = 250.0;
/* A frame of --frames lasts this long, however long it takes. */
static const double scripted_seconds = 0.1;

static const char help[] = "  W A S D   fly; E and Q up and down; shift faster; drag the mouse to look around\n"
                           "  B         swap the backend\n"
                           "  V         next view: lit, cascades, density, penumbra (of soft filters), rays (of exact\n"
                           "            ones), pages (of maps that have them), maps, frusta, culled\n"
                           "  C         the cascades, and back\n"
                           "  M         the maps, and back\n"
                           "  F         next filter\n"
                           "  R         next resolution\n"
                           "  1 to 8    so many cascades\n"
                           "  P         next preset\n"
                           "  H         this text\n"
                           "  Esc       leave\n";

typedef enum shown {
  SHOW_LIT,
  SHOW_CASCADES,
  SHOW_DENSITY,
  SHOW_PENUMBRA,
  SHOW_RAYS,
  SHOW_PAGES,
  SHOW_MAPS,
  SHOW_FRUSTA,
  SHOW_CULLED,
  SHOW_COUNT
} shown;
static const char *const shown_names[SHOW_COUNT] = {"lit",   "cascades", "density", "penumbra", "rays",
                                                    "pages", "maps",     "frusta",  "culled"};

/* CSM_SHOW_*, of those that csm draws; 0: none. */
static const uint32_t shown_views[SHOW_COUNT] = {[SHOW_CASCADES] = CSM_SHOW_CASCADE,
                                                 [SHOW_DENSITY] = CSM_SHOW_DENSITY,
                                                 [SHOW_PENUMBRA] = CSM_SHOW_PENUMBRA,
                                                 [SHOW_RAYS] = CSM_SHOW_RAYS,
                                                 [SHOW_PAGES] = CSM_SHOW_PAGES};

typedef struct view {
  const host_options *options;
  host_setup setup; /* with the camera and the settings of now */
  stage stage;
  stage_frame frame; /* drawn last */
  view_window *window;
  view_camera flight;
  view_trace trace;
  trace_surface *surfaces; /* that are shown */
  bool colored;            /* those were cast by rays; else they come from the depth */
  uint32_t preset;         /* that P takes next */
  shown shown;
  bool redraw, repaint;
  bool by_itself;  /* --frames */
  bool differs;    /* a swap has changed the mask */
  double moved_ms; /* when the camera moved last */
  double draw_ms, picture_ms;
} view;

/* ---- drawing ---- */

static size_t pixel_count(const view *v) {
  return (size_t)v->setup.width * v->setup.height;
}

/* Draws with csm from where the camera is, and reads back what the picture needs. */
static int draw(view *v) {
  const double start_ms = host_now_ms();
  stage_stats stats;
  view_camera_place(&v->flight, &v->setup.camera);
  stage_look(&v->stage, &v->setup.camera);
  int code = stage_draw(&v->stage, &stats);
  stage_frame_free(&v->frame);
  if (code == 0)
    code = stage_read(&v->stage, v->shown == SHOW_MAPS, &v->frame);
  if (code == 0 && (shown_views[v->shown] || v->shown == SHOW_CULLED))
    code = stage_read_views(&v->stage, &v->frame);
  if (code)
    return code;
  v->frame.stats = stats;
  if (!v->colored)
    view_surfaces_from_depth(v->surfaces, &v->setup.camera, v->frame.camera_depth, v->setup.width, v->setup.height);
  v->draw_ms = host_now_ms() - start_ms;
  v->redraw = false;
  v->repaint = true;
  return 0;
}

/* NULL beyond the last one. */
static const char *filter_name(uint32_t filter) {
  csm_config_field field = {.struct_size = sizeof field};
  for (uint32_t i = 0; csm_config_describe(i, &field) == CSM_SUCCESS; i++)
    if (strcmp(field.name, "filter") == 0)
      return filter <= field.maximum ? field.values[filter] : NULL;
  return NULL;
}

static void describe(const view *v, char *text, size_t size) {
  const csm_config *config = &v->setup.config;
  const stage_stats *stats = &v->frame.stats;
  snprintf(text, size,
           "%s on %s: %u x %u², %s: maps %.0f ms, moments %.0f ms, mask %.0f ms; frame %.0f + %.0f ms; %s%s%s",
           v->setup.scene.name, v->stage.backend, config->cascade_count, config->resolution,
           filter_name(config->filter), stage_maps_ms(stats), stage_moments_ms(stats), stage_view_ms(stats), v->draw_ms,
           v->picture_ms, shown_names[v->shown], stats->maps.budget_side ? "; " : "", stats->maps.budget_text);
}

/* These cast rays from outside, which takes longer than the others. */
static int make_outside(image *picture, const view *v, const picture_view *seen) {
  outside_view outside;
  const int code = outside_view_make(&outside, seen, &v->frame.binding);
  if (code == 0 && v->shown == SHOW_FRUSTA)
    picture_frusta(picture, &outside);
  else if (code == 0)
    picture_culled(picture, &outside, v->frame.casters);
  outside_view_free(&outside);
  return code;
}

/* One of those that csm draws. Other settings, which have none, may have been chosen since. */
static void make_view(image *picture, const view *v, const picture_view *seen) {
  const uint32_t show = shown_views[v->shown];
  if (v->frame.views[show - 1])
    picture_shown(picture, seen, v->frame.mask, show, v->frame.views[show - 1]);
  else
    picture_lit(picture, seen, v->frame.mask);
}

static int make_picture(image *picture, const view *v, const picture_view *seen) {
  switch (v->shown) {
  case SHOW_CASCADES:
  case SHOW_DENSITY:
  case SHOW_PENUMBRA:
  case SHOW_RAYS:
  case SHOW_PAGES:
    make_view(picture, v, seen);
    return 0;
  case SHOW_MAPS:
    picture_maps(picture, (const float *const *)v->frame.maps, v->frame.binding.cascade_count,
                 v->frame.binding.resolutions, v->setup.config.map_reversed);
    return 0;
  case SHOW_FRUSTA:
  case SHOW_CULLED:
    return make_outside(picture, v, seen);
  default:
    picture_lit(picture, seen, v->frame.mask);
    return 0;
  }
}

static int paint(view *v) {
  const double start_ms = host_now_ms();
  const picture_view seen = {.scene = &v->setup.scene,
                             .light = &v->setup.light,
                             .camera = &v->setup.camera,
                             .width = v->setup.width,
                             .height = v->setup.height,
                             .surfaces = v->surfaces};
  image picture;
  const int code = make_picture(&picture, v, &seen);
  if (code)
    return code;
  view_window_show(v->window, &picture);
  image_free(&picture);
  v->picture_ms = host_now_ms() - start_ms;
  v->repaint = false;

  char text[700], title[800];
  describe(v, text, sizeof text);
  snprintf(title, sizeof title, "csm-host view: %s (H: help)", text);
  view_window_title(v->window, title);
  return 0;
}

/* Takes the surfaces that were cast, if the camera is still where they were cast from. */
static void take_traced(view *v) {
  if (v->trace.code || memcmp(v->trace.camera.view, v->setup.camera.view, sizeof v->trace.camera.view) != 0)
    return;
  trace_surface *traced = v->trace.surfaces;
  v->trace.surfaces = v->surfaces;
  v->surfaces = traced;
  v->colored = true;
  v->repaint = true;
}

/* ---- keys ---- */

/* Settings that the library refuses are told by its log, and the old ones hold. False then. */
static bool configure(view *v, const csm_config *wanted) {
  if (stage_configure(&v->stage, wanted))
    return false;
  v->setup.config = *wanted;
  v->redraw = true;
  return true;
}

/* Filters that do not go with the other settings are passed over. */
static void next_filter(view *v) {
  csm_config wanted = v->setup.config;
  const uint32_t now = wanted.filter;
  v->stage.quiet = true;
  do
    wanted.filter = filter_name(wanted.filter + 1) ? wanted.filter + 1 : 0;
  while (wanted.filter != now && !configure(v, &wanted));
  v->stage.quiet = false;
}

static void next_resolution(view *v) {
  csm_config wanted = v->setup.config;
  wanted.resolution = wanted.resolution < 4096 ? 2 * wanted.resolution : 512;
  configure(v, &wanted);
}

static void next_preset(view *v) {
  csm_config wanted;
  const char *name = preset_name(v->preset);
  if (config_load(&wanted, name, NULL, v->setup.shadow_distance))
    return;
  printf("preset %s\n", name);
  configure(v, &wanted);
  v->preset = preset_name(v->preset + 1) ? v->preset + 1 : 0;
}

static void set_cascades(view *v, uint32_t count) {
  csm_config wanted = v->setup.config;
  wanted.cascade_count = count;
  configure(v, &wanted);
}

/* Tells whether the masks before and after a swap agree, as two backends must. */
static void compare_masks(view *v, const float *before, const char *from, double ms) {
  size_t beyond = 0;
  for (size_t i = 0; i < pixel_count(v); i++)
    beyond += !(fabsf(before[i] - v->frame.mask[i]) <= compare_mask_tolerance);
  const bool same = (double)beyond <= compare_mask_share * (double)pixel_count(v);
  v->differs = v->differs || !same;
  printf("%s -> %s in %.0f ms: the mask %s (%zu of %zu pixels beyond 1/255)\n", from, v->stage.backend, ms,
         same ? "is the same" : "DIFFERS", beyond, pixel_count(v));
}

/* A swap that fails has been told; the old backend draws on. */
static int swap_backend(view *v) {
  const char *from = v->stage.backend;
  const bool to_second = strcmp(from, host_backend_names[0]) == 0;
  double ms;
  int code = v->redraw ? draw(v) : 0;
  if (code || stage_switch(&v->stage, host_backend_names[to_second], v->options->device, &ms))
    return code;
  float *before = v->frame.mask;
  v->frame.mask = NULL;
  code = draw(v);
  if (code == 0)
    compare_masks(v, before, from, ms);
  free(before);
  return code;
}

/* Drawn anew, because the last frame has been read for another view. */
static void show(view *v, shown what) {
  v->shown = what;
  v->redraw = true;
}

static bool has(const view *v, shown what) {
  return !shown_views[what] || stage_has_view(&v->stage, shown_views[what]);
}

/* The next view that there is. */
static void show_next(view *v) {
  shown next = v->shown;
  do
    next = (next + 1) % SHOW_COUNT;
  while (!has(v, next));
  show(v, next);
}

static int press(view *v, char key) {
  switch (key) {
  case 'B':
    return swap_backend(v);
  case 'C':
    show(v, v->shown == SHOW_CASCADES ? SHOW_LIT : SHOW_CASCADES);
    break;
  case 'M':
    show(v, v->shown == SHOW_MAPS ? SHOW_LIT : SHOW_MAPS);
    break;
  case 'V':
    show_next(v);
    break;
  case 'F':
    next_filter(v);
    break;
  case 'R':
    next_resolution(v);
    break;
  case 'P':
    next_preset(v);
    break;
  case 'H':
    fputs(help, stdout);
    break;
  default:
    if (key >= '1' && key <= '8')
      set_cascades(v, (uint32_t)(key - '0'));
  }
  return 0;
}

/* ---- frames ---- */

static void move(view *v, const view_input *input, double seconds) {
  const double metres = v->setup.shadow_distance / 12.0 * (input->fast ? 5.0 : 1.0) * seconds;
  if (input->right == 0.0 && input->up == 0.0 && input->forward == 0.0 && input->turn == 0.0 && input->tilt == 0.0)
    return;
  view_camera_turn(&v->flight, input->turn, input->tilt);
  view_camera_move(&v->flight, metres * input->right, metres * input->up, metres * input->forward);
  v->moved_ms = host_now_ms();
  v->colored = false;
  v->redraw = true;
}

static int step(view *v, const view_input *input, double seconds) {
  int code = 0;
  for (uint32_t i = 0; i < input->key_count && code == 0; i++)
    code = press(v, input->keys[i]);
  move(v, input, seconds);
  v->repaint = v->repaint || input->uncovered;
  if (code == 0 && v->redraw)
    code = draw(v);
  else if (code == 0 && !v->colored && !v->by_itself && host_now_ms() - v->moved_ms > rest_ms)
    view_trace_begin(&v->trace, &v->setup.camera);
  if (view_trace_done(&v->trace))
    take_traced(v);
  if (code == 0 && v->repaint)
    code = paint(v);
  return code;
}

static int fly_by_hand(view *v) {
  view_input input = {0};
  double last_ms = host_now_ms();
  int code = 0;
  fputs(help, stdout);
  while (code == 0 && !input.quit) {
    const bool moving = last_ms - v->moved_ms < rest_ms;
    view_window_poll(v->window, moving ? 1 : 20, &input);
    const double now_ms = host_now_ms();
    code = step(v, &input, fmin((now_ms - last_ms) * 1e-3, 0.25));
    last_ms = now_ms;
  }
  return code;
}

static void input_from_key(view_input *out, char key) {
  *out = (view_input){0};
  switch (key >= 'a' && key <= 'z' ? key - 'a' + 'A' : key) {
  case 'W':
  case 'S':
    out->forward = key == 'W' || key == 'w' ? 1.0 : -1.0;
    break;
  case 'A':
  case 'D':
    out->right = key == 'D' || key == 'd' ? 1.0 : -1.0;
    break;
  case 'E':
  case 'Q':
    out->up = key == 'E' || key == 'e' ? 1.0 : -1.0;
    break;
  default:
    out->keys[out->key_count++] = (char)(key >= 'a' && key <= 'z' ? key - 'a' + 'A' : key);
  }
}

static int save_window(view *v) {
  char path[OUTPUT_PATH_SIZE];
  image shown;
  int code = host_make_folder(v->options->out);
  if (code == 0)
    code = output_path(path, v->options->out, "view.png");
  if (code)
    return code;
  view_window_grab(v->window, &shown);
  code = image_write_png(&shown, path);
  image_free(&shown);
  return code;
}

/* Every frame is drawn, and the last one is in the scene's colours. */
static int fly_by_itself(view *v) {
  const size_t length = strlen(v->options->keys);
  int code = 0;
  for (uint32_t i = 0; i < v->options->frames && code == 0; i++) {
    view_input input;
    char text[700];
    view_window_poll(v->window, 0, &input);
    input_from_key(&input, i < length ? v->options->keys[i] : '.');
    v->redraw = true;
    code = step(v, &input, scripted_seconds);
    describe(v, text, sizeof text);
    printf("frame %u: %s\n", i + 1, text);
  }
  if (code == 0 && view_trace_begin(&v->trace, &v->setup.camera) && view_trace_wait(&v->trace)) {
    take_traced(v);
    code = paint(v);
  }
  if (code == 0)
    code = save_window(v);
  return code ? code : v->differs ? HOST_DIFFER : 0;
}

/* ---- the command ---- */

static int open_view(view *v, host_options *options) {
  if (!options->has_size) {
    options->width = 640;
    options->height = 360;
  }
  int code = setup_load(&v->setup, options);
  if (code)
    return code;
  if (!options->config_file && !options->preset)
    v->setup.config.resolution = 1024; /* like the size above: what a CPU draws fluently; keys change it */
  const uint32_t scale = v->setup.width <= 960 && v->setup.height <= 540 ? 2 : 1;
  code = view_window_open(&v->window, scale * v->setup.width, scale * v->setup.height);
  if (code == 0)
    code = stage_open(&v->stage, host_backend_names[options->backends[0] ? 0 : 1], options->device);
  if (code == 0)
    code = stage_load(&v->stage, &v->setup);
  if (code)
    return code;
  v->by_itself = options->frames > 0;
  v->surfaces = host_allocate(pixel_count(v), sizeof *v->surfaces);
  v->trace.scene = &v->setup.scene;
  v->trace.width = v->setup.width;
  v->trace.height = v->setup.height;
  v->trace.surfaces = host_allocate(pixel_count(v), sizeof *v->trace.surfaces);
  view_camera_start(&v->flight, &v->setup.camera);
  return draw(v);
}

int view_command(const host_options *asked) {
  host_options options = *asked;
  view *v = host_allocate(1, sizeof *v);
  v->options = &options;
  int code = open_view(v, &options);
  if (code == 0)
    code = v->by_itself ? fly_by_itself(v) : fly_by_hand(v);
  view_trace_wait(&v->trace);
  stage_frame_free(&v->frame);
  stage_close(&v->stage);
  view_window_close(v->window);
  free(v->trace.surfaces);
  free(v->surfaces);
  setup_free(&v->setup);
  free(v);
  return code;
}
