/* setup/options.h: the command line. */
#ifndef HOST_OPTIONS_H
#define HOST_OPTIONS_H

#include "base/json_source.h"
#include "csm/csm.h"
#include "scene/camera.h"
#include "scene/scene.h"
#include <stdio.h>

typedef enum host_command {
  COMMAND_HELP,
  COMMAND_CONFIG,
  COMMAND_PRESETS,
  COMMAND_RUN,
  COMMAND_MEASURE,
  COMMAND_BENCH,
  COMMAND_REPORT,
  COMMAND_HARD,
  COMMAND_VIEW
} host_command;

#define HOST_BACKENDS 2
#define OPTIONS_MAX_SCENES 16
#define OPTIONS_MAX_LIST 16
#define OPTIONS_MAX_PRESETS 96
#define OPTIONS_MAX_CASES 64
#define OPTIONS_MAX_SUNS 8

/* Presets by name, as presets have it, each once. */
typedef struct options_presets {
  const char *names[OPTIONS_MAX_PRESETS];
  uint32_t count;
} options_presets;

/* Whole numbers, each once. */
typedef struct options_list {
  uint32_t values[OPTIONS_MAX_LIST];
  uint32_t count;
} options_list;

typedef struct host_options {
  host_command command;
  const char *scene;
  const char *camera_text; /* as given; NULL: the scene's own */
  bool has_light, has_shadow_distance, has_size;
  scene_light light;
  double shadow_distance;
  uint32_t width, height;
  const char *config_file;                /* what it says goes over the preset; NULL: nothing */
  const char *preset;                     /* its name as presets have it; NULL: the default configuration */
  bool backends[HOST_BACKENDS];           /* which of host_backend_names */
  const char *device;                     /* part of a device's name, or NULL */
  const char *out;                        /* folder for pictures */
  const char *json;                       /* file, "-" for stdout, or NULL */
  const char *dump;                       /* folder, or NULL */
  const char *cache;                      /* folder for truths, or NULL: the user's own */
  const char *camera_path, *light_path;   /* files, or NULL */
  uint32_t sun_samples;                   /* rays to a soft sun, for each pixel */
  bool quick;                             /* bench, report: fewer pairs */
  const char *only;                       /* bench: one part, or NULL */
  const char *scenes[OPTIONS_MAX_SCENES]; /* report: all that were named */
  uint32_t scene_count;
  options_list cascades, resolutions; /* report: what is swept */
  options_presets presets;            /* measure: what is compared; report: what joins a sweep under a soft sun */
  options_presets against;            /* measure: what `presets` are held against */
  double suns[OPTIONS_MAX_SUNS];      /* report, measure: the discs' diameters in degrees; none: the light's own */
  uint32_t sun_count;
  bool has_disc; /* the one that is meant is: */
  double disc_deg;
  const char *cases[OPTIONS_MAX_CASES]; /* hard: by name; none: all of them */
  uint32_t case_count;
  char case_names[1024]; /* what `cases` points into */
  bool sweep;            /* hard: every value */
  bool markdown;         /* hard: print the table as Markdown */
  bool has_out;          /* --out was given */
  double minutes;        /* report, measure: when to stop drawing again */
  char **arguments;      /* the command line itself */
  int argument_count;
  uint32_t frames;  /* view: how many before it ends by itself; 0: until it is closed */
  const char *keys; /* view: pressed by themselves, one a frame; "" for none */
} host_options;

extern const char *const host_backend_names[HOST_BACKENDS];

/* 0, or HOST_BAD_INPUT after a message that names the option. */
int options_parse(host_options *out, int count, char **arguments);
void options_print_help(FILE *to);

/* What to call the configuration that the options ask for. */
const char *options_base_name(const host_options *options);

/* A light as --light takes it. 0, or HOST_BAD_INPUT after a message. */
int light_from_text(scene_light *out, const char *text, const json_source *from);
/*
 * A camera in --camera's own words. What the text leaves out, all if it is NULL, is `standard`'s. 0, or HOST_BAD_INPUT
 * after a message.
 */
int camera_from_text(camera *out, const camera_pose *standard, const char *text, double aspect,
                     const json_source *from);

/* What one frame is made of: the scene with the options applied. */
typedef struct host_setup {
  scene scene;
  camera camera;
  scene_light light;
  double shadow_distance; /* the scene's */
  uint32_t width, height;
  csm_config config;
} host_setup;

/* Loads the scene, the camera and the configuration. 0, or HOST_BAD_INPUT after a message. setup_free is always
 * allowed. */
int setup_load(host_setup *out, const host_options *options);
void setup_free(host_setup *setup);

#endif
