/*
 * turned.c: the same yard, turned with its camera and its sun to directions at which a basis of light space may break
 * down: axes, the poles of csm's own, the camera's forward and up, and a thousandth of a degree beside each of them.
 */
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Directions of travel: the axes, and the pole that csm's basis is carried from (api/plan/light.c), both ways. */
static const double directions[][3] = {{0.0, -1.0, 0.0},
                                       {0.0, 1.0, 0.0},
                                       {1.0, 0.0, 0.0},
                                       {-1.0, 0.0, 0.0},
                                       {0.0, 0.0, 1.0},
                                       {0.0, 0.0, -1.0},
                                       {-0.4379, -0.6471, -0.6241},
                                       {0.4379, 0.6471, 0.6241}};
enum { DIRECTIONS = sizeof directions / sizeof directions[0] };

/* How the sun stands to the yard and its camera. */
typedef enum sun_place {
  SUN_ASIDE,  /* as the yard has it */
  SUN_BEHIND, /* it shines the way the camera looks */
  SUN_ABOVE,  /* it shines down the camera's up */
  SUN_PLACES
} sun_place;

static const char *const sun_names[] = {"aside", "along the camera's forward", "along the camera's up"};

static void make_yard(host_setup *out, sun_place place, const hard_filter *filter) {
  hard_setup_begin(out, 320, 180);
  hard_yard(out, true);
  out->config.resolution = 512;
  if (filter)
    hard_filter_set(&out->config, filter);
  for (int axis = 0; place != SUN_ASIDE && axis < 3; axis++)
    out->light.direction[axis] = place == SUN_BEHIND ? out->camera.forward[axis] : -out->camera.view[axis * 4 + 1];
  vec_normalize(out->light.direction);
}

/* A turn about an axis of unit length, in radians. */
static void turn_about(double out[16], const double axis[3], double angle) {
  const double c = cos(angle), s = sin(angle);
  mat_identity(out);
  for (int column = 0; column < 3; column++)
    for (int row = 0; row < 3; row++)
      out[column * 4 + row] = (row == column ? c : 0.0) + (1.0 - c) * axis[row] * axis[column];
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out[i * 4 + j] += s * axis[k];
    out[j * 4 + i] -= s * axis[k];
  }
}

/* Some unit vector at right angles to another. */
static void any_aside(double out[3], const double from[3]) {
  vec_cross(out, from, fabs(from[0]) < 0.7 ? (const double[3]){1.0, 0.0, 0.0} : (const double[3]){0.0, 1.0, 0.0});
  vec_normalize(out);
}

/* The shortest turn from one direction to another. */
static void turn_to(double out[16], const double from[3], const double to[3]) {
  double axis[3];
  vec_cross(axis, from, to);
  const double angle = atan2(vec_length(axis), vec_dot(from, to));
  if (!vec_normalize(axis))
    any_aside(axis, from);
  turn_about(out, axis, angle);
}

/* ---- the basis ---- */

/* Right, up and along of a cascade's map, as long as its matrix makes them: 1. */
static void read_basis(double basis[3][3], const csm_binding *binding) {
  const csm_cascade_info *cascade = &binding->cascades[0];
  const double side = cascade->texel_size * binding->resolutions[0];
  const double extents[3] = {side, -side, cascade->depth_range}; /* v runs down */
  for (int axis = 0; axis < 3; axis++)
    for (int k = 0; k < 3; k++)
      basis[axis][k] = extents[axis] * cascade->world_to_shadow[k * 4 + axis];
}

/* The most that it is off being orthonormal, along the light, and no mirror image: right is along x up. */
static double basis_error(const csm_binding *binding, const scene_light *light) {
  double basis[3][3], along[3], right[3], largest = 0.0;
  memcpy(along, light->direction, sizeof along);
  vec_normalize(along);
  read_basis(basis, binding);
  vec_cross(right, basis[2], basis[1]);
  for (int i = 0; i < 3; i++) {
    largest = fmax(largest, fabs(vec_dot(basis[i], basis[i]) - 1.0));
    largest = fmax(largest, fabs(vec_dot(basis[i], basis[(i + 1) % 3])));
    largest = fmax(largest, fabs(basis[2][i] - along[i]));
    largest = fmax(largest, fabs(basis[0][i] - right[i]));
  }
  return largest;
}

/* ---- turned scenes ---- */

/* What is turned. */
typedef struct turned_yard {
  sun_place place;
  const hard_filter *filter; /* NULL: the default */
} turned_yard;

/* Draws the yard turned by `turn`, and judges it with a truth that is cast before or, if there is none, now. */
static int draw_turned(hard_run *run, const turned_yard *of, const double turn[16], hard_truth *truth, double *rms) {
  host_setup setup;
  hard_picture drawn = {0};
  csm_binding binding;
  make_yard(&setup, of->place, of->filter);
  hard_place(&setup, turn);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = hard_draw(run, &setup.camera, &setup.light, 0, &drawn);
  if (code == 0 && !truth->visibility)
    code = hard_cast(run, &setup.camera, &setup.light, truth);
  if (code == 0)
    code = hard_bind(run, &binding);
  if (code == 0) {
    *rms = hard_judge(run, truth, drawn.mask, (hard_margin){.edge_px = 0.0}).rms;
    hard_figure_add(run, basis_error(&binding, &setup.light), 1e-12, "1", "basis off orthonormal");
  }
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/*
 * Texels lie otherwise on a scene that is turned, and the error depends on how. So the unturned one is drawn with its
 * texels turned, too: with scene, camera and sun turned a little about the sun.
 */
static int unturned_error(hard_run *run, const turned_yard *of, hard_truth *truth, double *mean) {
  const uint32_t rolls = run->sweep ? 16 : 4;
  host_setup setup;
  int code = 0;
  make_yard(&setup, of->place, of->filter);
  vec_normalize(setup.light.direction);
  *mean = 0.0;
  for (uint32_t i = 0; code == 0 && i < rolls; i++) {
    double turn[16], rms = 0.0;
    turn_about(turn, setup.light.direction, i * (pi / 2.0) / rolls);
    code = draw_turned(run, of, turn, truth, &rms);
    *mean += rms / rolls;
  }
  setup_free(&setup);
  return code;
}

/* The short form takes a few directions with other filters than the default. */
static int turn_yard(hard_run *run, const turned_yard *of) {
  const int step = of->filter && !run->sweep ? 3 : 1;
  hard_truth truth = {0};
  host_setup setup;
  double unturned;
  int code = unturned_error(run, of, &truth, &unturned);
  make_yard(&setup, of->place, of->filter);
  vec_normalize(setup.light.direction);
  for (int i = 0; code == 0 && i < DIRECTIONS; i += step)
    for (int beside = 0; code == 0 && beside <= (run->sweep ? 4 : 1); beside++) {
      double to[3], aside[3], turn[16], nudge[16], beside_it[4], rms = 0.0;
      memcpy(to, directions[i], sizeof to);
      vec_normalize(to);
      any_aside(aside, to);
      turn_about(nudge, to, beside * pi / 2.0);
      mat_transform(beside_it, nudge, aside, 0.0);
      turn_about(nudge, beside_it, beside ? 0.001 * pi / 180.0 : 0.0);
      mat_transform(beside_it, nudge, to, 0.0);
      turn_to(turn, setup.light.direction, beside_it);
      code = draw_turned(run, of, turn, &truth, &rms);
      hard_figure_add(run, rms / unturned, 1.1, "1", "rmse against the unturned scene, sun %s%s%s",
                      sun_names[of->place], of->filter ? ", " : "", of->filter ? of->filter->name : "");
    }
  hard_truth_free(&truth);
  setup_free(&setup);
  return code;
}

/* ---- a path of lights ---- */

/* A great circle through two directions, so that lights go exactly through the first. */
static void path_light(scene_light *out, const double through[3], const double aside[3], double angle) {
  for (int axis = 0; axis < 3; axis++)
    out->direction[axis] = cos(angle) * through[axis] + sin(angle) * aside[axis];
}

/* The farthest that the map turned about the light in one frame, beyond what the light itself did. */
static int follow_path(hard_run *run, const host_setup *setup, const double through[3], hard_picture *drawn) {
  const int frames = run->sweep ? 180 : 12;
  double aside[3], before[3][3], basis[3][3];
  csm_config config = setup->config;
  int code = hard_restart(run, &config);
  any_aside(aside, through);
  for (int i = -frames; code == 0 && i <= frames; i++) {
    scene_light light = {0};
    csm_binding binding;
    path_light(&light, through, aside, i * (pi / 180.0));
    /* Settings change on the way, right at the pole too: shape of the maps, and others. */
    config.resolution = i % 4 == 0 ? 256 : 512;
    config.bias_constant_texels = 0.5 + 0.01 * (i % 2);
    if (i % 2 == 0)
      code = hard_configure(run, &config);
    if (code == 0)
      code = hard_draw(run, &setup->camera, &light, 0, drawn);
    if (code == 0)
      code = hard_bind(run, &binding);
    if (code)
      break;
    read_basis(basis, &binding);
    double right[3], along[3];
    vec_subtract(right, basis[0], before[0]);
    vec_subtract(along, basis[2], before[2]);
    /* The shortest turn from one light to the next moves no vector by more than it moves the light. */
    if (i > -frames)
      hard_figure_add(run, fmax(vec_length(right) - vec_length(along), 0.0), 1e-12, "1",
                      "a carried map turns more than its light");
    hard_figure_add(run, basis_error(&binding, &light), 1e-12, "1", "basis off orthonormal");
    memcpy(before, basis, sizeof before);
  }
  return code;
}

static int follow_paths(hard_run *run) {
  host_setup setup;
  hard_picture drawn = {0};
  hard_setup_begin(&setup, 64, 36);
  hard_yard(&setup, false);
  setup.config.light_roll = CSM_LIGHT_ROLL_CARRIED;
  int code = hard_load(run, &setup);
  for (int i = 0; code == 0 && i < DIRECTIONS; i++) {
    double through[3];
    memcpy(through, directions[i], sizeof through);
    vec_normalize(through);
    code = follow_path(run, &setup, through, &drawn);
  }
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  int code = follow_paths(run);
  for (int place = 0; code == 0 && place < SUN_PLACES; place++)
    code = turn_yard(run, &(turned_yard){.place = (sun_place)place});
  for (int i = run->sweep ? 0 : 1; code == 0 && i < (run->sweep ? HARD_ALL_FILTERS : 2); i++)
    code = turn_yard(run, &(turned_yard){.filter = &hard_filters[i]});
  return code;
}

const hard_case hard_turned = {.name = "turned",
                               .about = "scene, camera and sun turned to axes and poles, and suns that go through them",
                               .run = run_case};
