/* measure/path.h: measuring along a path of the camera, or of the light, or of both. */
#ifndef HOST_MEASURE_PATH_H
#define HOST_MEASURE_PATH_H

#include "metrics/flicker.h"
#include "metrics/ghosts.h"
#include "stage/stage.h"
#include "truth/store.h"

/* One frame after the other. */
typedef struct measure_path {
  uint32_t count; /* 0: the options name no path */
  camera *cameras;
  scene_light *lights;
  /* Told of each pair of neighbouring frames, on each stage: its second frame's index, and that pair's flicker alone.
     May be NULL. */
  void (*each)(void *user, uint32_t index, const flicker *pair);
  void *user;
} measure_path;

/*
 * Reads the files that the options name. A camera or a light without a path stays the setup's. 0, or HOST_BAD_INPUT
 * after a message; measure_path_free is allowed in both cases.
 */
int measure_path_load(measure_path *out, const host_options *options, const host_setup *setup);
void measure_path_free(measure_path *path);

/* What a backend got wrong along a path. */
typedef struct path_result {
  metrics *frames; /* one for each */
  metrics pooled;
  flicker flicker;   /* of frames without a history */
  ghosts *histories; /* one for each frame; NULL: the configuration keeps no history */
  ghosts ghosts;     /* of all of them */
} path_result;

/*
 * Draws and measures every frame on `count` loaded stages. 0, or a code after a message; path_result_free is allowed in
 * both cases.
 */
int measure_path_run(path_result *results, const measure_path *path, truth_store *store, stage *stages, uint32_t count,
                     uint32_t sun_samples);
void path_result_free(path_result *result);

#endif
