/* stage/stage.h: one backend with a scene on it, and what it draws. */
#ifndef HOST_STAGE_H
#define HOST_STAGE_H

#include "csm/csm.h"
#include "setup/options.h"
#include "stage/assets.h"
#include <stdio.h>

/* Must not move once it is open. */
typedef struct stage {
  const char *backend;
  bool quiet;    /* errors are expected: they are not printed */
  bool by_depth; /* maps are drawn for what this frame's depth shows, where that is drawn before */
  char device[256], driver[256];
  const host_setup *setup;
  csm_context *context;
  csm_scene *scene;
  csm_cascades *cascades;
  csm_view *view;
  assets assets;
  csm_instance_id *instances; /* by the scene's instance */
  uint32_t layers;            /* that they lie in */
  csm_camera camera;
  csm_light light;
  csm_frame frame; /* of the three above */
} stage;

enum { STAGE_VIEWS = 6 }; /* CSM_SHOW_CASCADE to CSM_SHOW_PAGES, less 1; that of the history is not drawn */

/* What drawing took, in milliseconds, and how much of it there was. */
typedef struct stage_stats {
  csm_stats maps;
  csm_view_stats mask;
} stage_stats;

/* What one frame left behind, in host memory. */
typedef struct stage_frame {
  csm_binding binding;
  stage_stats stats;
  float *maps[CSM_MAX_CASCADES]; /* stage_map_texels each, top row first */
  float *mask, *camera_depth;    /* width * height, top row first */
  float *view_depth;             /* likewise, in metres; INFINITY where nothing is */
  float *views[STAGE_VIEWS];     /* likewise; NULL: not asked for, or the filter has none */
  uint8_t *casters;              /* by instance, as csm_get_casters tells; with the views */
} stage_frame;

/* For csm_create_info.log, with the stage as `user`: prints what is wrong, so that a code of a stage's has its message. */
void CSM_CALL stage_log(void *user, int32_t level, const char *message);

/* Opens a device whose context makes trees. 0, HOST_NO_DEVICE or HOST_BAD_INPUT after a message; stage_close is always allowed. */
int stage_open(stage *out, const char *backend, const char *device);
/* Likewise, one whose context has these flags, of CSM_CREATE_*. */
int stage_open_as(stage *out, const char *backend, const char *device, uint32_t flags);
void stage_close(stage *s);
/* Opens one for each backend that the options ask for, in their order; *count gets how many were tried. The stages are
 * all zeros before. */
int stage_open_all(stage stages[HOST_BACKENDS], uint32_t *count, const host_options *options);

/* Uploads the scene and makes the cascades. `setup` must live as long as the stage. 0, or a code after a message. */
int stage_load(stage *s, const host_setup *setup);

/* Gives back what stage_load made: the device stays open for another scene. */
void stage_unload(stage *s);

/* Moves to another backend; *ms gets what that took. 0, or a code after a message: the old one draws on then. */
int stage_switch(stage *s, const char *backend, const char *device, double *ms);

/* Changes the settings. 0, or a code after a message: the old ones hold then. */
int stage_configure(stage *s, const csm_config *config);

/* New cascades, without a history. 0, or a code after a message: the old ones are gone then. */
int stage_restart(stage *s, const csm_config *config);

/* A camera and a light as csm takes them. */
csm_camera stage_camera(const camera *from);
csm_light stage_light(const scene_light *from);

/* Where the frames that follow are seen from. */
void stage_look(stage *s, const camera *from);

/*
 * Changes every instance by what does not show, so that the next frame makes all that it sees: moments of maps that come out as
 * they were are kept, and a scene that stands still would get them for nothing. 0, or a code after a message.
 */
int stage_stir(stage *s);

/* Draws the cascades once and waits. 0, or a code after a message. */
int stage_render(stage *s);

/* Draws the cascades and the mask with timestamps, and waits. 0, or a code after a message. */
int stage_draw(stage *s, stage_stats *stats);
/* Likewise, until a budget has chosen how fine the maps are, if there is one. */
int stage_settle(stage *s, stage_stats *stats);
/* Prints what a budget says, if there is one. */
void stage_print_budget(FILE *to, const stage *s, const stage_stats *stats);

/*
 * Reads back what was drawn, with the maps if they are wanted; the stats are left out. 0, or a code after a message;
 * stage_frame_free is always allowed.
 */
int stage_read(stage *s, bool maps, stage_frame *out);

/* Whether the configuration has a view, of CSM_SHOW_*. */
bool stage_has_view(const stage *s, uint32_t show);
/* Adds the views of what was drawn and read, and its casters. The mask on the device is a view afterwards. 0, or a code
 * after a message. */
int stage_read_views(stage *s, stage_frame *out);

/* Draws the cascades for a camera and a light, by depth if the stage says so. 0, or a code after a message. */
int stage_draw_from(stage *s, const camera *from, const scene_light *light);
/*
 * Resolves the mask of what a camera sees, and reads it back. The maps are those that were drawn last, maybe for
 * another camera. view_depth, in metres, and cascades, which gets CSM_SHOW_CASCADE, may be NULL. All hold width * height pixels.
 * 0, or a code after a message.
 */
int stage_mask(stage *s, const camera *from, float *mask, float *view_depth, float *cascades);

/* CSM_SHOW_CASCADE alone, likewise. */
int stage_cascades(stage *s, const camera *from, float *cascades);
/* The same mask as a view has it without a history, whose patterns are those of its frame of this number, from 0 on. */
int stage_mask_alone(stage *s, const camera *from, uint32_t frame, float *mask);

/*
 * Draws the cascades and the mask with timestamps, after a frame that warms up, and, with a history, as many more as make
 * history_frames; GPU times are the medians of three.
 * Reads everything back. 0, or a code after a message; stage_frame_free is always allowed.
 */
int stage_capture(stage *s, stage_frame *out);
void stage_frame_free(stage_frame *frame);

/* Texels of a cascade's map. */
size_t stage_map_texels(const stage_frame *frame, uint32_t cascade);

/* Milliseconds on the GPU: of the clear and every cascade, of their moments or ranges, of the mask alone, of its history; of all
 * these; of the mask and the camera's depth. */
double stage_maps_ms(const stage_stats *stats);
double stage_moments_ms(const stage_stats *stats);
double stage_mask_ms(const stage_stats *stats);
double stage_history_ms(const stage_stats *stats);
double stage_shadows_ms(const stage_stats *stats);
double stage_view_ms(const stage_stats *stats);

#endif
