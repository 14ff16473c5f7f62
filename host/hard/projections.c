/*
 * projections.c: every way to write the same camera down, and cameras of other kinds. Where the slices of the view are
 * the same in the world, so are the maps, and no pixel may differ at the same points; another view is judged against the
 * truth; and what a matrix cannot tell is refused.
 */
#include "base/host.h"
#include "base/linear.h"
#include "hard/hard.h"
#include "stage/compare.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct base {
  host_setup setup;
  hard_picture drawn; /* by its camera */
  hard_truth truth;
  hard_picture other; /* scratch */
} base;

static int base_draw(base *b, hard_run *run) {
  int code = hard_load(run, &b->setup);
  if (code == 0)
    code = hard_draw(run, &b->setup.camera, &b->setup.light, HARD_DEPTH, &b->drawn);
  return code ? code : hard_cast(run, &b->setup.camera, &b->setup.light, &b->truth);
}

static void base_free(base *b, hard_run *run) {
  hard_unload(run);
  hard_truth_free(&b->truth);
  hard_picture_free(&b->drawn);
  hard_picture_free(&b->other);
  setup_free(&b->setup);
}

/* ---- ways to write a camera down ---- */

static void negate_row(double m[16], int row) {
  for (int column = 0; column < 4; column++)
    m[column * 4 + row] = -m[column * 4 + row];
}

static void negate_column(double m[16], int column) {
  for (int row = 0; row < 4; row++)
    m[column * 4 + row] = -m[column * 4 + row];
}

/* View z the other way. */
static void change_hand(camera *c) {
  negate_row(c->view, 2);
  negate_column(c->projection, 2);
}

/* View x the other way, which mirrors the view and not the picture. */
static void mirror(camera *c) {
  negate_row(c->view, 0);
  negate_column(c->projection, 0);
}

static void turn_y_down(camera *c) {
  negate_row(c->projection, 1);
}

static void scale_clip(camera *c) {
  for (int i = 0; i < 16; i++)
    c->projection[i] *= 3.0;
}

/* Clip z over w turned around: 1 less it. */
static void turn_depth(camera *c) {
  for (int column = 0; column < 4; column++)
    c->projection[column * 4 + 2] = c->projection[column * 4 + 3] - c->projection[column * 4 + 2];
  c->reversed = !c->reversed;
}

/* A far plane at a depth, of a perspective that is reversed and has none. */
static void end_at(camera *c, double far) {
  const double near = c->near_depth, share = near / (far - near);
  c->projection[10] = share * (c->projection[11] < 0.0 ? 1.0 : -1.0);
  c->projection[14] = near + near * share;
  c->far_depth = far;
}

static void end_at_500(camera *c) {
  end_at(c, 500.0);
}

static void end_at_500_unreversed(camera *c) {
  end_at(c, 500.0);
  turn_depth(c);
}

static void left_handed_unreversed(camera *c) {
  change_hand(c);
  turn_depth(c);
}

typedef struct writing {
  const char *name;
  void (*write)(camera *c);
  bool upside_down;
} writing;

static const writing writings[] = {{"depth not reversed", turn_depth, false},
                                   {"left-handed", change_hand, false},
                                   {"left-handed, not reversed", left_handed_unreversed, false},
                                   {"mirrored", mirror, false},
                                   {"y down", turn_y_down, true},
                                   {"clip w scaled", scale_clip, false},
                                   {"a far plane", end_at_500, false},
                                   {"a far plane, not reversed", end_at_500_unreversed, false}};
enum { WRITINGS = sizeof writings / sizeof writings[0], ORTHOGRAPHIC_WRITINGS = WRITINGS - 2 };

/* ---- the same slices ---- */

static void turn_upside_down(hard_picture *picture) {
  const size_t width = picture->width;
  for (uint32_t row = 0; row < picture->height / 2; row++)
    for (size_t x = 0; x < width; x++) {
      float *a = &picture->mask[row * width + x], *b = &picture->mask[(picture->height - 1 - row) * width + x];
      const float kept = *a;
      *a = *b;
      *b = kept;
    }
}

/* Maps that the variant's camera has, seen by the base's: the points are the same to the last bit, and so must be the
   mask. */
static int compare_slices(base *b, hard_run *run, const camera *variant, const csm_config *config, const char *name) {
  int code = hard_restart(run, config);
  if (code == 0)
    code = hard_draw(run, variant, &b->setup.light, 0, &b->other);
  if (code == 0)
    code = hard_resolve(run, &b->setup.camera, 0, &b->other);
  if (code == 0)
    hard_figure_add(run, (double)hard_compare(run, &b->drawn, &b->other, 0.0).pixels, 0.0, "px",
                    "differ, the same slices: %s", name);
  return code;
}

/*
 * What the variant's own camera sees of them. Its depth is drawn with another matrix, whose floats round otherwise, and a
 * point at a shadow's edge may fall to the other side: the bound is that for other rasterisers.
 */
static int compare_view(base *b, hard_run *run, const camera *variant, bool upside_down) {
  const int code = hard_resolve(run, variant, 0, &b->other);
  if (code)
    return code;
  if (upside_down)
    turn_upside_down(&b->other);
  const hard_difference apart = hard_compare(run, &b->drawn, &b->other, compare_mask_tolerance);
  hard_figure_add(run, (double)apart.pixels / ((double)b->drawn.width * b->drawn.height), compare_mask_share, "1",
                  "mask pixels of the variants' own cameras that differ");
  return 0;
}

static int write_all(base *b, hard_run *run, uint32_t count, const char *kind) {
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < count; i++) {
    camera variant = b->setup.camera;
    char name[64];
    snprintf(name, sizeof name, "%s%s", kind, writings[i].name);
    writings[i].write(&variant);
    code = compare_slices(b, run, &variant, &b->setup.config, name);
    if (code == 0)
      code = compare_view(b, run, &variant, writings[i].upside_down);
  }
  return code;
}

/* ---- judged against the truth ---- */

/*
 * Lit or dark, no pixel is more than half wrong farther than two pixels from a silhouette, where normals come from
 * neighbours, and than two from a shadow's edge, which the filter may move by two texels: of the scene's maps no texel is
 * wider than a pixel sees at its depth.
 */
static void add_judged(hard_run *run, const hard_truth *truth, const hard_picture *drawn, const char *name) {
  const hard_count count = hard_judge(run, truth, drawn->mask, (hard_margin){.silhouette_px = 2.0, .edge_px = 2.0});
  hard_figure_add(run, (double)(count.false_dark + count.false_lit), 0.0, "px", "wrong, by the truth: %s", name);
  hard_figure_add(run, count.judged * 10 > (uint64_t)drawn->width * drawn->height ? 0.0 : 1.0, 0.0, "1",
                  "pictures in which next to nothing could be judged");
}

/* Draws another frustum and judges it. */
static int judge_camera(base *b, hard_run *run, const camera *from, const char *name) {
  hard_truth truth = {0};
  int code = hard_restart(run, &b->setup.config);
  if (code == 0)
    code = hard_draw(run, from, &b->setup.light, 0, &b->other);
  if (code == 0)
    code = hard_cast(run, from, &b->setup.light, &truth);
  if (code == 0)
    add_judged(run, &truth, &b->other, name);
  hard_truth_free(&truth);
  return code;
}

static int judge_perspectives(base *b, hard_run *run) {
  camera aside = b->setup.camera, jittered = aside, both;
  aside.projection[8] = 0.6;
  aside.projection[9] = -0.35;
  jittered.projection[8] = 0.7 / b->setup.width;
  jittered.projection[9] = -0.9 / b->setup.height;
  both = aside;
  turn_depth(&both);
  change_hand(&both);
  int code = judge_camera(b, run, &aside, "off-centre");
  if (code == 0)
    code = judge_camera(b, run, &jittered, "jittered");
  return code ? code : judge_camera(b, run, &both, "off-centre, left-handed, not reversed");
}

/* ---- an oblique near plane ---- */

/* World planes: a point p is kept where dot(p, xyz) + w > 0. */
static double plane_at(const double plane[4], const double point[3]) {
  return vec_dot(plane, point) + plane[3];
}

/*
 * Lengyel's (2005): clip z is the distance from the plane, scaled so that the corner of the image that rises fastest from
 * it ends at 1. Precondition: the camera is right-handed and lies before the plane.
 */
static void cut_by(camera *c, const double plane[4], bool reversed) {
  double row[4] = {0.0, 0.0, 0.0, plane_at(plane, c->position)}, fastest = 0.0;
  for (int axis = 0; axis < 3; axis++)
    for (int k = 0; k < 3; k++)
      row[axis] += c->view[k * 4 + axis] * plane[k];
  for (int i = 0; i < 4; i++)
    fastest = fmax(fastest, row[0] * (i & 1 ? 1.0 : -1.0) / c->projection[0] +
                                row[1] * (i & 2 ? 1.0 : -1.0) / c->projection[5] - row[2]);
  for (int column = 0; column < 4; column++)
    c->projection[column * 4 + 2] = row[column] / fastest;
  c->reversed = false;
  if (reversed)
    turn_depth(c);
}

/* Takes what the plane cuts off out of a truth; returns how much that is. */
static uint64_t cut_truth(hard_truth *truth, const double plane[4]) {
  camera_rays rays;
  uint64_t count = 0;
  camera_rays_make(&rays, &truth->camera, truth->view.width, truth->view.height);
  for (size_t i = 0; i < (size_t)truth->view.width * truth->view.height; i++) {
    truth_surface *surface = &truth->view.surfaces[i];
    double point[3];
    if (surface->triangle == TRUTH_NOTHING)
      continue;
    camera_point(&rays, &truth->camera, camera_pixel_x(&rays, (uint32_t)(i % rays.width)),
                 camera_pixel_y(&rays, (uint32_t)(i / rays.width)), surface->view_depth, point);
    for (int axis = 0; axis < 3; axis++)
      point[axis] += truth->camera.position[axis];
    if (plane_at(plane, point) > 0.0)
      continue;
    surface->triangle = TRUTH_NOTHING;
    count++;
  }
  return count;
}

/* What is left is where it was, and behind what is cut off nothing is nearer than that. */
static void add_depths(hard_run *run, const base *b, const hard_truth *cut, const hard_picture *drawn) {
  uint64_t moved = 0, uncut = 0;
  for (size_t i = 0; i < (size_t)drawn->width * drawn->height; i++) {
    const truth_surface *surface = &b->truth.view.surfaces[i];
    const double depth = drawn->view_depth[i], is = surface->view_depth;
    if (surface->triangle == TRUTH_NOTHING || cut->silhouette_squares[i] < 4)
      continue;
    /* The contract's bound, that S has */
    if (cut->view.surfaces[i].triangle != TRUTH_NOTHING)
      moved += !(fabs(depth - is) <= 1e-3 * is);
    else
      uncut += !(depth > is * (1.0 + 1e-3));
  }
  hard_figure_add(run, (double)moved, 0.0, "px", "elsewhere than they are, beyond an oblique near plane");
  hard_figure_add(run, (double)uncut, 0.0, "px", "drawn, though an oblique near plane cuts them off");
}

static int judge_oblique(base *b, hard_run *run, const double plane[4], bool reversed) {
  camera cut = b->setup.camera;
  hard_truth truth = {0};
  cut_by(&cut, plane, reversed);
  int code = hard_cast(run, &b->setup.camera, &b->setup.light, &truth);
  if (code == 0)
    code = hard_restart(run, &b->setup.config);
  if (code == 0)
    code = hard_draw(run, &cut, &b->setup.light, HARD_DEPTH, &b->other);
  if (code == 0) {
    const uint64_t count = cut_truth(&truth, plane);
    hard_figure_add(run, count ? 0.0 : 1.0, 0.0, "1", "oblique near planes that cut off nothing");
    add_judged(run, &truth, &b->other, "an oblique near plane");
    add_depths(run, b, &truth, &b->other);
  }
  hard_truth_free(&truth);
  return code;
}

/* ---- orthographic ---- */

/* The planes of an orthographic camera, which looks along view -z. */
static void set_planes(camera *c, double near, double far, bool reversed) {
  c->projection[10] = reversed ? 1.0 / (far - near) : -1.0 / (far - near);
  c->projection[14] = reversed ? far / (far - near) : -near / (far - near);
  c->near_depth = near;
  c->far_depth = far;
  c->reversed = reversed;
}

static void make_orthographic(host_setup *setup) {
  camera *c = &setup->camera;
  hard_look(setup, (const double[3]){-6.0, 16.0, 8.0}, (const double[3]){0.0, 0.0, -16.0}, 60.0);
  memset(c->projection, 0, sizeof c->projection);
  c->projection[0] = 2.0 / 32.0;
  c->projection[5] = 2.0 / 18.0;
  c->projection[15] = 1.0;
  set_planes(c, 0.25, 100.25, true);
  setup->config.split_mode = CSM_SPLIT_UNIFORM; /* which knows no place of the camera's */
}

/* The same slab of the world, seen from so many metres farther back. */
static void step_back(camera *c, double meters) {
  for (int axis = 0; axis < 3; axis++)
    c->position[axis] -= meters * c->forward[axis];
  c->view[14] -= meters;
  set_planes(c, c->near_depth + meters, c->far_depth + meters, c->reversed);
}

/* What shaders' positions are relative to; NULL: the camera's place. */
static void set_origin(hard_run *run, const double *origin) {
  for (uint32_t i = 0; i < run->stage_count; i++)
    run->stages[i].frame.origin = origin;
}

/* Its planes from 30 m on, at the camera, symmetric about it, and most of them behind it. The origin stays, or points
   would be rounded otherwise. */
static int step_all(base *b, hard_run *run) {
  static const double steps[] = {30.0, -0.25, -50.25, -55.0, 3000.0};
  int code = 0;
  set_origin(run, b->setup.camera.position);
  for (uint32_t i = 0; code == 0 && i < sizeof steps / sizeof steps[0]; i++)
    for (int reversed = 0; code == 0 && reversed < 2; reversed++) {
      camera variant = b->setup.camera;
      csm_config config = b->setup.config;
      char name[64];
      step_back(&variant, steps[i]);
      if (!reversed)
        turn_depth(&variant);
      config.shadow_distance += steps[i];
      snprintf(name, sizeof name, "near %g, far %g", variant.near_depth, variant.far_depth);
      code = compare_slices(b, run, &variant, &config, name);
    }
  set_origin(run, NULL);
  return code;
}

static int judge_orthographic(base *b, hard_run *run) {
  static const double planes[][2] = {{-500.0, 400.0}, {-60.0, 60.0}, {-1e6, 1e6}, {1.0, 90.0}};
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < 4 * 2; i++) {
    camera from = b->setup.camera;
    set_planes(&from, planes[i / 2][0], planes[i / 2][1], i % 2);
    code = judge_camera(b, run, &from, "orthographic, other planes");
  }
  camera aside = b->setup.camera;
  aside.projection[12] = 0.4;
  aside.projection[13] = -0.3;
  return code ? code : judge_camera(b, run, &aside, "orthographic, off-centre");
}

/* ---- what cannot be told ---- */

/* Whether every backend refuses a camera, with a word in its error. */
static bool is_refused(hard_run *run, const camera *from, uint32_t reversed, const char *word) {
  bool refused = true;
  for (uint32_t i = 0; i < run->stage_count; i++) {
    stage *s = &run->stages[i];
    csm_camera camera = stage_camera(from);
    csm_frame frame = s->frame;
    camera.reversed = reversed;
    frame.camera = &camera;
    s->quiet = true;
    refused = refused && csm_render_cascades(s->cascades, &frame) == CSM_ERROR_INVALID_CAMERA &&
              strstr(csm_last_error(s->context), word);
    s->quiet = false;
  }
  return refused;
}

static void refuse(hard_run *run, const camera *from, uint32_t reversed, const char *word) {
  hard_figure_add(run, is_refused(run, from, reversed, word) ? 0.0 : 1.0, 0.0, "1",
                  "cameras that cannot be told, and are not refused by name");
}

static void refuse_all(hard_run *run, const camera *from) {
  camera other = *from;
  set_planes(&other, -50.0, 50.0, false);
  refuse(run, &other, CSM_REVERSED_BY_MATRIX, "reversed");
  set_planes(&other, -60.0, -10.0, false); /* all of it behind: by its matrix it looks the other way */
  refuse(run, &other, CSM_REVERSED_NO, "reversed");
  set_planes(&other, 1.0, 50.0, false);
  refuse(run, &other, CSM_REVERSED_YES, "reversed");
  other.projection[2] = 0.01;
  refuse(run, &other, CSM_REVERSED_NO, "oblique");
  other = *from;
  other.projection[11] = -0.3;
  refuse(run, &other, CSM_REVERSED_YES, "neither perspective nor orthographic");
}

/* ---- all of it ---- */

static int run_perspective(hard_run *run) {
  /* A plane across the yard that leans to the side and up, 5 m before the camera */
  static const double planes[][4] = {{-0.3, 0.1, -1.0, -3.0}, {0.1, -0.8, -0.6, -2.0}};
  base b = {0};
  hard_setup_begin(&b.setup, 320, 180);
  b.setup.config.resolution = run->sweep ? 2048 : 1024;
  hard_yard(&b.setup, false);
  int code = base_draw(&b, run);
  if (code == 0)
    add_judged(run, &b.truth, &b.drawn, "reversed, no far plane");
  if (code == 0)
    code = write_all(&b, run, WRITINGS, "");
  if (code == 0)
    code = judge_perspectives(&b, run);
  for (int i = 0; code == 0 && i < 4; i++)
    code = judge_oblique(&b, run, planes[i / 2], i % 2);
  base_free(&b, run);
  return code;
}

/*
 * The same points in the same maps with filters on moments and soft ones: their levels and search follow from the base's
 * camera, whoever's maps they read.
 */
static int run_filters(hard_run *run) {
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < HARD_ALL_FILTERS; i++) {
    base b = {0};
    if (!run->sweep && i % 3 != 1)
      continue;
    hard_setup_begin(&b.setup, 320, 180);
    hard_yard(&b.setup, false);
    b.setup.config.resolution = run->sweep ? 512 : 256;
    hard_filter_set(&b.setup.config, &hard_filters[i]);
    code = base_draw(&b, run);
    for (uint32_t k = 0; code == 0 && k < WRITINGS; k += run->sweep ? 1 : 3) {
      camera variant = b.setup.camera;
      char name[64];
      snprintf(name, sizeof name, "%s, %s", hard_filters[i].name, writings[k].name);
      writings[k].write(&variant);
      code = compare_slices(&b, run, &variant, &b.setup.config, name);
      if (code == 0)
        code = compare_view(&b, run, &variant, writings[k].upside_down);
    }
    base_free(&b, run);
  }
  return code;
}

static int run_orthographic(hard_run *run) {
  base b = {0};
  hard_setup_begin(&b.setup, 320, 180);
  b.setup.config.resolution = run->sweep ? 2048 : 1024;
  hard_yard(&b.setup, false);
  make_orthographic(&b.setup);
  int code = base_draw(&b, run);
  if (code == 0)
    add_judged(run, &b.truth, &b.drawn, "orthographic");
  if (code == 0)
    code = write_all(&b, run, ORTHOGRAPHIC_WRITINGS, "orthographic, ");
  if (code == 0)
    code = step_all(&b, run);
  if (code == 0)
    code = judge_orthographic(&b, run);
  if (code == 0)
    refuse_all(run, &b.setup.camera);
  base_free(&b, run);
  return code;
}

static int run_case(hard_run *run) {
  int code = run_perspective(run);
  if (code == 0)
    code = run_orthographic(run);
  return code ? code : run_filters(run);
}

const hard_case hard_projections = {
    .name = "projections",
    .about = "every way to write a camera down: planes behind it, either hand, off-centre, oblique, y down",
    .run = run_case};
