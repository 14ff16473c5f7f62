/*
 * moving_sun.c: a sun that moves, near the world's origin and far from it. Each map's grid turns about a point near its
 * own middle, so that distances do not count, and snapping is never worse than a map that follows the camera freely.
 */
#include "base/host.h"
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>

static const double degrees = 3.14159265358979323846 / 180.0;

/* Pixels that one texel changes: a filter reads 4 x 4 of them, which are about two pixels wide at most here. */
#define PIXELS 4.0

/* A way for the sun to go, and for the camera. */
typedef struct motion {
  double degrees; /* a frame; the sun's */
  double walk;    /* metres a frame; the camera's */
  uint32_t frames;
} motion;

typedef struct tally {
  hard_run *run;
  double basis[16]; /* the last frame's world_to_shadow: turned where the light was moved */
  uint32_t pairs, steps;
  uint64_t points, changed, stepped_points, stepped_changed;
} tally;

/* Whether the maps' light has another direction than in the frame before. */
static bool turned(tally *t) {
  csm_binding binding;
  bool changed = false;
  if (hard_bind(t->run, &binding))
    return false;
  for (int column = 0; column < 3; column++)
    for (int row = 0; row < 3; row++) {
      const int at = column * 4 + row;
      changed = changed || t->basis[at] != binding.cascades[0].world_to_shadow[at];
      t->basis[at] = binding.cascades[0].world_to_shadow[at];
    }
  return changed;
}

static void add_pair(void *user, uint32_t index, const flicker *pair) {
  tally *t = user;
  t->pairs = index;
  t->points += pair->points;
  t->changed += pair->changed;
  if (!turned(t))
    return;
  t->steps++;
  t->stepped_points += pair->points;
  t->stepped_changed += pair->changed;
}

static double share(uint64_t part, uint64_t whole) {
  return whole ? 100.0 * (double)part / (double)whole : 0.0;
}

/* The sun goes round a tilted axis, as on a day of spring. */
static scene_light sun_at(double angle) {
  const double axis[3] = {0.6, 0.64, -0.48}, start[3] = {0.41, -0.72, 0.56};
  scene_light light = {0};
  double across[3];
  vec_cross(across, axis, start);
  const double along = vec_dot(axis, start);
  for (int k = 0; k < 3; k++)
    light.direction[k] = cos(angle) * start[k] + sin(angle) * across[k] + (1.0 - cos(angle)) * along * axis[k];
  return light;
}

/* The camera of the yard, moved with it and walking on. */
static camera camera_at(const hard_run *run, const double offset[3], double way) {
  camera_pose pose = run->setup->scene.camera;
  camera at;
  for (int k = 0; k < 3; k++) {
    const double move = offset[k] + (const double[]){0.6, 0.0, -0.8}[k] * way;
    pose.position[k] += move;
    pose.target[k] += move;
  }
  camera_from_pose(&at, &pose, (double)run->setup->width / run->setup->height);
  return at;
}

/* By the first backend: the same plans would be drawn by the other one, and each walk's first frame is compared. */
static int walk_alone(hard_run *run, uint32_t count, const camera *cameras, const scene_light *lights, tally *out) {
  const hard_path path = {
      .count = count, .alone = true, .cameras = cameras, .lights = lights, .each = add_pair, .user = out};
  return hard_walk(run, &path);
}

static int walk(tally *out, hard_run *run, const motion *how, const csm_config *config, const double offset[3]) {
  camera *cameras = host_allocate(how->frames, sizeof *cameras);
  scene_light *lights = host_allocate(how->frames, sizeof *lights);
  hard_picture scratch = {0};
  *out = (tally){.run = run};
  for (uint32_t i = 0; i < how->frames; i++) {
    cameras[i] = camera_at(run, offset, how->walk * i);
    lights[i] = sun_at(how->degrees * degrees * i);
  }
  int code = hard_restart(run, config);
  if (code == 0) /* which notes how the first frame's maps are turned, and compares the backends */
    code = hard_draw(run, &cameras[0], &lights[0], 0, &scratch);
  (void)turned(out);
  if (code == 0)
    code = walk_alone(run, how->frames, cameras, lights, out);
  hard_picture_free(&scratch);
  free(cameras);
  free(lights);
  return code;
}

/* ---- snapping ---- */

static int compare_snapping(hard_run *run, const double offset[3], const char *where) {
  const uint32_t frames = run->sweep ? 100 : 8;
  const motion motions[] = {{0.001, 0.0, frames}, {0.01, 0.0, frames}, {0.001, 0.03, frames}, {0.01, 0.03, frames}};
  int code = 0;
  for (size_t i = 0; code == 0 && i < sizeof motions / sizeof motions[0]; i++) {
    const motion *how = &motions[i];
    csm_config config = run->setup->config;
    tally snapped, unsnapped;
    code = walk(&snapped, run, how, &config, offset);
    config.snap_mode = CSM_SNAP_OFF;
    if (code == 0)
      code = walk(&unsnapped, run, how, &config, offset);
    if (code)
      break;
    /*
     * A camera that stands: both maps turn about the slice's middle, and differ by where in a texel that lies. So the
     * counts differ by chance, as counts of single pixels do, of which one texel of a silhouette may change PIXELS: the
     * bound is three times that deviation. One that walks has maps of its own in every frame without snapping.
     */
    const double by_chance = 3.0 * sqrt(2.0 * PIXELS / fmax((double)unsnapped.changed, 1.0));
    hard_figure_add(run, (double)snapped.changed / fmax((double)unsnapped.changed, 1.0),
                    how->walk > 0.0 ? 1.0 : 1.0 + by_chance, "1",
                    "flicker to that without snapping, %g deg a frame, %s, %s", how->degrees,
                    how->walk > 0.0 ? "walking" : "standing", where);
    hard_figure_add(run, share(snapped.changed, snapped.points), INFINITY, "%", "flicker, %g deg a frame, %s, %s",
                    how->degrees, how->walk > 0.0 ? "walking" : "standing", where);
  }
  return code;
}

/* A sun that has moved, and rests. */
static int rest(hard_run *run, const double offset[3], const char *where) {
  const motion moves = {0.01, 0.0, 3}, rests = {0.0, 0.0, 4};
  tally t;
  const camera at = camera_at(run, offset, 0.0);
  int code = walk(&t, run, &moves, &run->setup->config, offset);
  camera cameras[4];
  scene_light lights[4];
  for (uint32_t i = 0; i < rests.frames; i++) {
    cameras[i] = at;
    lights[i] = sun_at(moves.degrees * degrees * 2.0);
  }
  t = (tally){.run = run};
  if (code == 0)
    code = walk_alone(run, rests.frames, cameras, lights, &t);
  if (code == 0)
    hard_figure_add(run, (double)t.changed, 0.0, "points", "flicker at rest, %s", where);
  return code;
}

/* ---- steps ---- */

/* Steps that are never worse than a light that moves freely; how many frames step, and what a step changes, is stated. */
static int compare_steps(hard_run *run, double degrees_a_frame) {
  static const double origin[3] = {0.0}, steps[] = {0.25, 1.0, 4.0};
  const motion how = {degrees_a_frame, 0.0, run->sweep ? 480 : 12};
  csm_config config = run->setup->config;
  tally freely, stepping;
  int code = walk(&freely, run, &how, &config, origin);
  for (size_t i = 0; code == 0 && i < sizeof steps / sizeof steps[0]; i++) {
    config.light_step_texels = steps[i];
    code = walk(&stepping, run, &how, &config, origin);
    if (code)
      break;
    hard_figure_add(run, (double)stepping.changed / fmax((double)freely.changed, 1.0), 1.0, "1",
                    "flicker with steps of %g texels to that without, %g deg a frame", steps[i], degrees_a_frame);
    hard_figure_add(run, share(stepping.steps, stepping.pairs), INFINITY, "%",
                    "frames that step, steps of %g texels, %g deg a frame", steps[i], degrees_a_frame);
    hard_figure_add(run, share(stepping.stepped_changed, stepping.stepped_points), INFINITY, "%",
                    "points that a step changes, steps of %g texels, %g deg a frame", steps[i], degrees_a_frame);
  }
  return code;
}

/* A day and a night: every way that a light can travel along its path, from below too. */
static int day_and_night(hard_run *run) {
  static const double origin[3] = {0.0};
  const uint32_t frames = run->sweep ? 360 : 12;
  csm_config config = run->setup->config;
  const motion how = {360.0 / frames, 0.0, frames + 1};
  tally fixed, carried;
  int code = walk(&fixed, run, &how, &config, origin);
  config.light_roll = CSM_LIGHT_ROLL_CARRIED;
  if (code == 0)
    code = walk(&carried, run, &how, &config, origin);
  if (code == 0) {
    hard_figure_add(run, share(fixed.changed, fixed.points), INFINITY, "%", "flicker, a day and a night");
    hard_figure_add(run, share(carried.changed, carried.points), INFINITY, "%",
                    "flicker, a day and a night, roll carried");
    hard_figure_add(run, fixed.steps == frames && carried.steps == frames ? 0.0 : 1.0, 0.0, "1",
                    "days on which a light stands still");
  }
  return code;
}

/* ---- places ---- */

static int run_at(hard_run *run, double away) {
  /* Whole numbers, whose sums with the yard's places are exact. */
  const double offset[3] = {away, 0.125 * away, -0.5 * away};
  double moved[16];
  char where[32];
  host_setup setup;
  snprintf(where, sizeof where, "%g m", away);
  mat_identity(moved);
  for (int k = 0; k < 3; k++)
    moved[12 + k] = offset[k];
  hard_setup_begin(&setup, 160, 90);
  hard_yard(&setup, true);
  hard_place(&setup, moved);
  setup.config.resolution = 1024;
  int code = hard_load(run, &setup);
  if (code == 0)
    code = compare_snapping(run, offset, where);
  if (code == 0)
    code = rest(run, offset, where);
  if (code == 0 && away == 0.0)
    code = compare_steps(run, 0.001);
  if (code == 0 && away == 0.0)
    code = compare_steps(run, 0.01);
  if (code == 0 && away == 0.0)
    code = day_and_night(run);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  static const double distances[] = {0.0, 1e7, 1e2, 1e3, 1e4, 1e5, 1e6};
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < (run->sweep ? 7 : 2); i++)
    code = run_at(run, distances[i]);
  return code;
}

const hard_case hard_moving_sun = {.name = "moving_sun",
                                   .about = "a sun that moves, near the world's origin and far away: snapping is never "
                                            "worse than none, and steps are never worse than a free light",
                                   .run = run_case};
