/*
 * moving_camera.c: a camera that turns, creeps and zooms under a sun that stands still. Maps of fits whose size does not
 * follow from the view lie on a grid in the world, so that nothing may change but where a map's size makes a step.
 */
#include "base/host.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>

static const double degrees = 3.14159265358979323846 / 180.0;

typedef struct fit {
  uint32_t mode;
  const char *name;
} fit;

static const fit fits[] = {{CSM_FIT_MINIMUM_SPHERE, "least sphere"},
                           {CSM_FIT_CASCADE_SQUARE, "square"},
                           {CSM_FIT_CENTROID_SPHERE, "centroid sphere"},
                           {CSM_FIT_SCENE_SQUARE, "scene square"}};

/* What a path may depend on. */
typedef struct journey {
  double texel_size; /* of the finest map */
} journey;

/* Where a camera is in a frame of a path. */
typedef camera_pose place_camera(const journey *on, uint32_t frame, double *aspect);

typedef struct motion {
  const char *name;
  place_camera *place;
  uint32_t frames, sweep_frames;
  uint32_t steps; /* of size that it may take */
} motion;

static camera_pose still_pose(void) {
  return (camera_pose){.position = {0.0, 2.5, 2.0},
                       .target = {1.0, 1.5, -10.0},
                       .vertical_fov_deg = 60.0,
                       .near_depth = 0.1,
                       .far_depth = INFINITY};
}

/* From the middle of the yard, so that there are shadows all around. */
static camera_pose turning(const journey *on, uint32_t frame, double *aspect) {
  camera_pose pose = still_pose();
  const double angle = 0.1 * degrees * frame;
  (void)on;
  (void)aspect;
  pose.position[2] = -20.0;
  for (int k = 0; k < 3; k++)
    pose.target[k] = pose.position[k] + (const double[]){sin(angle), -0.1, -cos(angle)}[k];
  return pose;
}

/* By a hundredth of a texel of the finest map, along no axis. */
static camera_pose creeping(const journey *on, uint32_t frame, double *aspect) {
  camera_pose pose = still_pose();
  (void)aspect;
  for (int k = 0; k < 3; k++)
    pose.position[k] += (const double[]){0.48, 0.36, -0.8}[k] * 0.01 * on->texel_size * frame;
  return pose;
}

static camera_pose zooming_in(const journey *on, uint32_t frame, double *aspect) {
  camera_pose pose = still_pose();
  (void)on;
  (void)aspect;
  pose.vertical_fov_deg = 80.0 * pow(1.001, -(double)frame);
  return pose;
}

static camera_pose zooming_out(const journey *on, uint32_t frame, double *aspect) {
  camera_pose pose = still_pose();
  (void)on;
  (void)aspect;
  pose.vertical_fov_deg = 40.0 * pow(1.001, frame);
  return pose;
}

static camera_pose widening(const journey *on, uint32_t frame, double *aspect) {
  (void)on;
  *aspect = pow(1.001, frame);
  return still_pose();
}

/* A window that is drawn narrower by 3 pixels a frame. */
static camera_pose resized(const journey *on, uint32_t frame, double *aspect) {
  (void)on;
  *aspect = (1600.0 - 3.0 * frame) / 900.0;
  return still_pose();
}

/* An octave is 693 frames of 0.1 %, and may take four steps; the short form goes a few frames of it. */
static const motion motions[] = {
    {"turning by 0.1 deg", turning, 12, 3600, 0},         {"moving by 0.01 texel", creeping, 8, 100, 0},
    {"field of view less 0.1 %", zooming_in, 12, 693, 4}, {"field of view more 0.1 %", zooming_out, 16, 693, 4},
    {"aspect more 0.1 %", widening, 16, 693, 4},          {"window narrower", resized, 10, 260, 4}};
enum { MOTIONS = sizeof motions / sizeof motions[0], FITS = sizeof fits / sizeof fits[0] };

/* ---- what changes ---- */

typedef struct tally {
  hard_run *run;
  double sizes[CSM_MAX_CASCADES];
  uint32_t steps, last_step; /* last_step: the frame's index */
  uint64_t points, changed;
  double worst;
} tally;

/* Whether a map has another size than in the frame before. */
static bool stepped(tally *t) {
  csm_binding binding;
  bool changed = false;
  if (hard_bind(t->run, &binding))
    return false;
  for (uint32_t i = 0; i < binding.cascade_count; i++) {
    changed = changed || t->sizes[i] != binding.cascades[i].texel_size;
    t->sizes[i] = binding.cascades[i].texel_size;
  }
  return changed;
}

/* Called for each backend in turn. */
static void add_pair(void *user, uint32_t index, const flicker *pair) {
  tally *t = user;
  if (stepped(t)) {
    t->steps++;
    t->last_step = index;
  }
  if (t->last_step == index)
    return;
  t->points += pair->points;
  t->changed += pair->changed;
  if (pair->points)
    t->worst = fmax(t->worst, (double)pair->changed / (double)pair->points);
}

static void place_all(camera *cameras, const hard_run *run, const motion *how, const journey *on, uint32_t count) {
  for (uint32_t i = 0; i < count; i++) {
    double aspect = (double)run->setup->width / run->setup->height;
    const camera_pose pose = how->place(on, i, &aspect);
    camera_from_pose(&cameras[i], &pose, aspect);
  }
}

/* Draws the first frame, which has no history, and notes its sizes. */
static int begin(tally *t, const motion *how, hard_picture *scratch) {
  camera first;
  place_all(&first, t->run, how, &(journey){0}, 1);
  const int code = hard_draw(t->run, &first, &t->run->setup->light, 0, scratch);
  if (code == 0)
    (void)stepped(t);
  return code;
}

/* On every backend, or by the first one alone. */
static int walk(hard_run *run, const motion *how, const char *fit_name, bool alone, hard_picture *scratch) {
  const uint32_t count = run->sweep ? how->sweep_frames : how->frames;
  camera *cameras = host_allocate(count, sizeof *cameras);
  scene_light *lights = host_allocate(count, sizeof *lights);
  tally t = {.run = run};
  int code = begin(&t, how, scratch);
  place_all(cameras, run, how, &(journey){.texel_size = t.sizes[0]}, count);
  for (uint32_t i = 0; i < count; i++)
    lights[i] = run->setup->light;
  if (code == 0)
    code = hard_walk(
        run, &(hard_path){
                 .count = count, .alone = alone, .cameras = cameras, .lights = lights, .each = add_pair, .user = &t});
  if (code == 0) {
    /* The grid stays, so that only what floats round differently may change. */
    hard_figure_add(run, t.points ? 100.0 * (double)t.changed / (double)t.points : INFINITY, 0.005, "%",
                    "mean flicker, %s, %s", how->name, fit_name);
    hard_figure_add(run, 100.0 * t.worst, 0.1, "%", "worst pair, %s, %s", how->name, fit_name);
    hard_figure_add(run, t.steps, how->steps, "1", "steps of size, %s, %s", how->name, fit_name);
  }
  free(cameras);
  free(lights);
  return code;
}

/*
 * Filters on moments and soft ones, at one level, for a level follows from the camera: what is blurred, and the pattern of
 * what is not, lie in the world too. The short form turns one of each, on one backend.
 */
static int walk_filters(hard_run *run, hard_picture *scratch) {
  int code = 0;
  for (uint32_t f = 0; f < HARD_FILTERS; f++)
    for (uint32_t i = 0; code == 0 && i < (run->sweep ? MOTIONS : 1); i++) {
      csm_config config = run->setup->config;
      if (hard_filters[f].filter == CSM_FILTER_VSSM || !(run->sweep || f % 3 == 1))
        continue;
      hard_filter_set(&config, &hard_filters[f]);
      config.moment_levels = 1;
      config.moment_sampling = CSM_SAMPLING_BILINEAR;
      code = hard_restart(run, &config);
      if (code == 0)
        code = walk(run, &motions[i], hard_filters[f].name, !run->sweep, scratch);
    }
  return code;
}

/* The short form has two of the fits, and the second of them on one backend. */
static int run_case(hard_run *run) {
  host_setup setup;
  hard_picture scratch = {0};
  hard_setup_begin(&setup, 160, 90);
  hard_yard(&setup, true);
  setup.config.resolution = 1024;
  int code = hard_load(run, &setup);
  for (uint32_t f = 0; code == 0 && f < (run->sweep ? FITS : 2); f++)
    for (uint32_t i = 0; code == 0 && i < MOTIONS; i++) {
      csm_config config = setup.config;
      config.fit_mode = fits[f].mode;
      code = hard_restart(run, &config);
      if (code == 0)
        code = walk(run, &motions[i], fits[f].name, !run->sweep && f, &scratch);
    }
  if (code == 0)
    code = walk_filters(run, &scratch);
  hard_picture_free(&scratch);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_moving_camera = {
    .name = "moving_camera", .about = "a camera that turns, creeps and zooms: nothing flickers", .run = run_case};
