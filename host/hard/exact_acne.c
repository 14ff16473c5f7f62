/*
 * exact_acne.c: no surface shadows itself where rays decide: planes and balls far from the world's origin, and from
 * what shaders' positions are relative to, under low suns, with near planes of a millimetre, with maps of 16 bits, seen by
 * orthographic cameras that stand among them, and on a ground of 10^6 m.
 */
#include "base/linear.h"
#include "hard/exact.h"
#include <math.h>
#include <string.h>

/* What is hard about a yard. */
typedef struct yard {
  const char *name;
  double offset; /* from the world's origin, along each axis */
  double origin; /* what shaders' positions are relative to is so far from the camera */
  double near, far;
  double ground; /* its half, in metres */
  double width;  /* of an orthographic picture, in metres; 0: perspective */
  double scale;  /* of balls and shadows, so that the camera stands among them; 0: 1 */
  bool forward;  /* depth is not reversed */
  bool d16;
  double lowest;  /* sun's height over the horizon, in degrees */
  double edge_px; /* of an edge of a shadow that are left out; 0: those that it goes between */
} yard;

static const yard yards[] = {
    {.name = "near the origin", .near = 0.1, .far = INFINITY, .ground = 256.0},
    {.name = "10^7 m away", .offset = 1e7, .near = 0.1, .far = INFINITY, .ground = 256.0},
    {.name = "a near plane of 1 mm", .near = 1e-3, .far = INFINITY, .ground = 256.0},
    {.name = "a near plane of 1 mm, not reversed", .near = 1e-3, .far = 200.0, .ground = 256.0, .forward = true},
    {.name = "relative to a place 10^4 m away",
     .origin = 8192.0,
     .near = 0.1,
     .far = INFINITY,
     .ground = 256.0,
     .lowest = 1.0,
     .edge_px = 4.0},
    {.name = "orthographic", .near = 0.25, .far = 100.25, .ground = 256.0, .width = 24.0},
    {.name = "orthographic, to 10^4 m", .near = 0.25, .far = 1e4, .ground = 256.0, .width = 24.0},
    {.name = "orthographic, 2 km wide", .near = -4e3, .far = 4e3, .ground = 8192.0, .width = 2048.0, .scale = 100.0},
    {.name = "maps of 16 bits", .near = 0.1, .far = INFINITY, .ground = 256.0, .d16 = true},
    {.name = "a ground of 10^6 m", .near = 0.1, .far = INFINITY, .ground = 1e6, .lowest = 20.0, .edge_px = 8.0},
};
enum { YARDS = sizeof yards / sizeof yards[0], WIDTH = 160, HEIGHT = 90 };

/* Clip z from the near plane to the far one, either way. */
static void set_depths(camera *c, const yard *of) {
  const double near = of->near, far = of->far;
  c->near_depth = near;
  c->far_depth = far;
  c->reversed = !of->forward;
  if (of->width > 0.0) {
    memset(c->projection, 0, sizeof c->projection);
    c->projection[0] = 2.0 / of->width;
    c->projection[5] = 2.0 / of->width * WIDTH / HEIGHT;
    c->projection[10] = 1.0 / (far - near);
    c->projection[14] = far / (far - near);
    c->projection[15] = 1.0;
  } else if (of->forward) {
    c->projection[10] = -far / (far - near);
    c->projection[14] = -far * near / (far - near);
  } else {
    c->projection[14] = near;
  }
}

/* Balls of many and few triangles on a ground; at a whole number of metres from the origin. */
static void make_yard(host_setup *out, const yard *of) {
  static const double balls[][3] = {{0.0, 1.0, 0.0}, {3.0, 0.75, 2.0}, {-3.0, 1.25, -2.0}};
  mesh_builder b = {0};
  double moved[16];
  const double scale = of->scale > 0.0 ? of->scale : 1.0;
  hard_setup_begin(out, WIDTH, HEIGHT);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, of->ground, 1);
  hard_add(out, &b, "ground", NULL);
  for (uint32_t i = 0; i < 3; i++) {
    const double radius = scale * balls[i][1], at[3] = {scale * balls[i][0], radius, scale * balls[i][2]};
    builder_ball(&b, (const double[3]){0.0, 0.0, 0.0}, (const double[3]){radius, radius, radius}, 2 + 2 * i, 0.0, 1);
    hard_add(out, &b, "ball", at);
  }
  hard_look(out, (const double[3]){0.0, 3.0, 10.0}, (const double[3]){0.0, 0.5, 0.0}, 50.0);
  set_depths(&out->camera, of);
  out->config.split_mode = of->width > 0.0 ? CSM_SPLIT_UNIFORM : out->config.split_mode;
  hard_reach(out, 60.0 * scale);
  out->config.resolution = 1024;
  out->config.map_format = of->d16 ? CSM_MAP_D16 : CSM_MAP_D32;
  mat_identity(moved);
  for (int axis = 0; axis < 3; axis++)
    moved[12 + axis] = of->offset;
  hard_place(out, moved);
}

/*
 * What is lit is lit, and what is dark is dark, but for the pixels that an edge of a shadow, or of a thing, goes between.
 * Where maps decide, two pixels beside a thing's edge have normals from what lies beside.
 *
 * Floats put a ground of 10^6 m off its place by two roundings of 2^-24 of the way to its corners: 0.17 m, and a shadow's
 * edge by 0.47 m, under a sun at 20 degrees. A pixel sees more than 0.06 m of it. Positions relative to a place 11.6 km
 * away are off by four roundings: 2.8 mm, and 0.16 m under a sun at a degree. Lower suns graze the ground so that maps do
 * not know its plane from itself.
 */
static int draw_yard(hard_run *run, const yard *of) {
  static const double heights[] = {5.0, 1.0, 0.1, 30.0, 60.0, 2.0}, azimuths[] = {100.0, 220.0, 340.0, 40.0};
  host_setup setup;
  hard_truth truth = {0};
  const exact_asked asked = {.what = of->name,
                             .margin = {.silhouette_px = 2.0, .edge_px = of->edge_px > 0.0 ? of->edge_px : 1.0}};
  make_yard(&setup, of);
  const double *at = setup.camera.position, origin[3] = {at[0] + of->origin, at[1], at[2] - of->origin};
  int code = hard_load(run, &setup);
  for (uint32_t i = 0; of->origin > 0.0 && i < run->stage_count; i++)
    run->stages[i].frame.origin = origin;
  for (int i = 0; code == 0 && i < (run->sweep ? 24 : 3); i++) {
    const double height = fmax(heights[run->sweep ? i % 6 : i], of->lowest);
    const scene_light sun = hard_sun(height, azimuths[run->sweep ? i / 6 : i]);
    code = exact_judge(run, &sun, &asked, &truth);
  }
  hard_truth_free(&truth);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  int code = 0;
  for (int i = 0; code == 0 && i < YARDS; i++)
    code = draw_yard(run, &yards[i]);
  return code;
}

const hard_case hard_exact_acne = {
    .name = "exact_acne",
    .about = "exact: planes and balls far away, low suns, near planes of 1 mm, D16, orthographic, 10^6 m",
    .run = run_case};
