/*
 * offsets.c: the whole scene, camera and all, far from the world's origin. Maps lie on a grid in the world, so a scene
 * that moves by whole texels of a cascade, and by whole depth ranges of it, finds that cascade's map just as it was.
 */
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>

#define MASK_STEP (1.0 / 255.0)

/* Fits whose sizes do not change with a move, and ways to reach along the light. */
typedef struct variant {
  uint32_t fit_mode, depth_mode, snap_mode;
  const char *name;
  const hard_filter *filter; /* NULL: the default */
} variant;

static const variant variants[] = {
    {CSM_FIT_MINIMUM_SPHERE, CSM_DEPTH_CASTERS, CSM_SNAP_ROUND, "default", NULL},
    {CSM_FIT_MINIMUM_SPHERE, CSM_DEPTH_CASTERS, CSM_SNAP_ROUND, "evsm4", &hard_filters[1]},
    {CSM_FIT_CENTROID_SPHERE, CSM_DEPTH_SLICE, CSM_SNAP_FLOOR, "centroid sphere, slice", NULL},
    {CSM_FIT_CASCADE_SQUARE, CSM_DEPTH_SCENE, CSM_SNAP_ROUND, "cascade square, scene", NULL},
    {CSM_FIT_SCENE_SQUARE, CSM_DEPTH_SCENE_CLIPPED, CSM_SNAP_FLOOR, "scene square, scene clipped", NULL},
    {CSM_FIT_MINIMUM_SPHERE, CSM_DEPTH_CASTERS, CSM_SNAP_ROUND, "vsm", &hard_filters[0]},
    {CSM_FIT_MINIMUM_SPHERE, CSM_DEPTH_CASTERS, CSM_SNAP_ROUND, "msm4", &hard_filters[2]},
    {CSM_FIT_MINIMUM_SPHERE, CSM_DEPTH_CASTERS, CSM_SNAP_ROUND, "exact", &hard_filters[HARD_EXACT]}};
enum { VARIANTS = sizeof variants / sizeof variants[0] };

typedef struct yard {
  host_setup setup;
  hard_picture drawn;
  csm_binding binding;
} yard;

static void yard_free(hard_run *run, yard *y) {
  hard_unload(run);
  hard_picture_free(&y->drawn);
  setup_free(&y->setup);
}

/* Draws the yard, moved. */
static int yard_draw(yard *out, hard_run *run, const variant *how, const double offset[3], uint32_t resolution) {
  double moved[16];
  mat_identity(moved);
  for (int axis = 0; axis < 3; axis++)
    moved[12 + axis] = offset[axis];
  hard_setup_begin(&out->setup, 320, 180);
  hard_yard(&out->setup, true);
  out->setup.config.resolution = resolution;
  out->setup.config.fit_mode = how->fit_mode;
  out->setup.config.depth_mode = how->depth_mode;
  out->setup.config.snap_mode = how->snap_mode;
  if (how->filter)
    hard_filter_set(&out->setup.config, how->filter);
  out->setup.config.blend_mode = CSM_BLEND_OFF; /* with the next cascade, which moves by other texels than its own */
  hard_place(&out->setup, moved);
  out->drawn = (hard_picture){0};
  int code = hard_load(run, &out->setup);
  if (code == 0)
    code = hard_draw(run, &out->setup.camera, &out->setup.light, HARD_CASCADES, &out->drawn);
  return code ? code : hard_bind(run, &out->binding);
}

/* ---- by whole texels ---- */

/* A way to go along right, up and along of light space, in metres, and what that is in the world. */
typedef struct journey {
  double basis[3][3];
  double way[3];
  double offset[3]; /* so rounded that sums with the scene's places, multiples of 1/8 m, are exact */
} journey;

static void plan_journey(journey *out, const csm_cascade_info *cascade, double distance) {
  const double units[3] = {cascade->texel_size, cascade->texel_size, cascade->depth_range};
  /* Sums are below 4 * distance, and have 53 bits. */
  const double grain = ldexp(1.0, ilogb(distance) + 3 - 53);
  for (int axis = 0; axis < 3; axis++) {
    const double sign = axis == 1 ? -1.0 : 1.0;
    for (int k = 0; k < 3; k++)
      out->basis[axis][k] = sign * cascade->world_to_shadow[k * 4 + axis];
    vec_normalize(out->basis[axis]);
    out->way[axis] = round(distance / sqrt(3.0) / units[axis]) * units[axis];
  }
  for (int k = 0; k < 3; k++) {
    const double exact =
        out->way[0] * out->basis[0][k] + out->way[1] * out->basis[1][k] + out->way[2] * out->basis[2][k];
    out->offset[k] = round(exact / grain) * grain;
  }
}

/* A world place's coordinates in a cascade's map, in the units of the plan's matrix. */
static long double shadow_coordinate(const csm_cascade_info *cascade, const double place[3], int axis) {
  long double sum = cascade->world_to_shadow[12 + axis];
  for (int k = 0; k < 3; k++)
    sum += (long double)cascade->world_to_shadow[k * 4 + axis] * place[k];
  return sum;
}

/*
 * The farthest that the moved cascade's map is from where it was, in texels of it, across the light and along it. The
 * offset was rounded, so the scene really stands off its place on the grid by a little, which is known.
 */
static double plan_error(const yard *still, const yard *moved, uint32_t cascade, const journey *way) {
  const csm_cascade_info *a = &still->binding.cascades[cascade], *b = &moved->binding.cascades[cascade];
  double largest = fabs(a->texel_size - b->texel_size) / a->texel_size * still->binding.resolutions[cascade];
  largest = fmax(largest, fabs(a->depth_range - b->depth_range) / a->texel_size);
  for (int axis = 0; axis < 3; axis++) {
    const double extent = axis == 2 ? a->depth_range : a->texel_size * still->binding.resolutions[cascade];
    long double off_grid = -way->way[axis];
    double place[3];
    for (int k = 0; k < 3; k++) {
      off_grid += (long double)way->basis[axis][k] * way->offset[k];
      place[k] = still->setup.camera.position[k] + way->offset[k];
    }
    const long double before = shadow_coordinate(a, still->setup.camera.position, axis);
    const long double after = shadow_coordinate(b, place, axis) - (axis == 1 ? -off_grid : off_grid) / extent;
    largest = fmax(largest, (double)fabsl(after - before) * extent / a->texel_size);
  }
  return largest;
}

/* Share of the pixels of one cascade whose shadow changes, of those that are the cascade's in both pictures. */
static double changed_share(const hard_picture *a, const hard_picture *b, uint32_t cascade) {
  const float wanted = (float)(cascade + 1) / 255.0f;
  uint64_t pixels = 0, changed = 0;
  for (size_t i = 0; i < (size_t)a->width * a->height; i++)
    if (fabsf(a->cascades[i] - wanted) < 1e-4f && fabsf(b->cascades[i] - wanted) < 1e-4f) {
      pixels++;
      changed += fabsf(a->mask[i] - b->mask[i]) > MASK_STEP;
    }
  return pixels ? (double)changed / (double)pixels : 1.0;
}

static int move_by_texels(hard_run *run, const yard *still, const variant *how, double distance) {
  int code = 0;
  for (uint32_t cascade = 0; code == 0 && cascade < still->binding.cascade_count; cascade++) {
    const csm_cascade_info *info = &still->binding.cascades[cascade];
    yard moved;
    journey way;
    plan_journey(&way, info, distance);
    code = yard_draw(&moved, run, how, way.offset, 1024);
    if (code == 0) {
      double farthest = 0.0;
      for (int axis = 0; axis < 3; axis++)
        farthest = fmax(farthest, fabs(moved.setup.camera.position[axis]));
      const double ulp = nextafter(farthest, INFINITY) - farthest;
      /* The bound: what a double knows of the place, four times over, beside a millionth of a texel. */
      hard_figure_add(run, plan_error(still, &moved, cascade, &way), 1e-6 + 4.0 * ulp / info->texel_size, "texels",
                      "plan after whole texels, %s", how->name);
      hard_figure_add(run, changed_share(&still->drawn, &moved.drawn, cascade), 1e-4, "1",
                      "mask pixels that change then, %s", how->name);
      hard_compare(run, &still->drawn, &moved.drawn, MASK_STEP);
    }
    yard_free(run, &moved);
  }
  return code;
}

/* ---- by anything ---- */

/* The root mean square error against the truth at the origin, for the scene is the same wherever it lies. */
static int draw_error(hard_run *run, hard_truth *truth, const double offset[3], double *rms) {
  yard moved;
  int code = yard_draw(&moved, run, &variants[0], offset, 512);
  if (code == 0 && !truth->visibility)
    code = hard_cast(run, &moved.setup.camera, &moved.setup.light, truth);
  if (code == 0)
    *rms = hard_judge(run, truth, moved.drawn.mask, (hard_margin){.edge_px = 0.0}).rms;
  yard_free(run, &moved);
  return code;
}

/* The mean over offsets in all directions, of up to `farthest` metres, from `nearest` on. */
static int mean_error(hard_run *run, hard_truth *truth, uint32_t count, const double distances[2], double *mean) {
  int code = 0;
  *mean = 0.0;
  for (uint32_t i = 0; code == 0 && i < count; i++) {
    const double distance = distances[0] * pow(distances[1] / distances[0], noise_hash(i, 1, 10));
    double way[3] = {noise_hash(i, 2, 10) - 0.5, noise_hash(i, 3, 10) - 0.5, noise_hash(i, 4, 10) - 0.5}, rms = 0.0;
    vec_normalize(way);
    for (int axis = 0; axis < 3; axis++)
      way[axis] = round(way[axis] * distance * 0x1p20) * 0x1p-20; /* sums with it are exact up to 2^33 m */
    code = draw_error(run, truth, way, &rms);
    *mean += rms / count;
  }
  return code;
}

/* The error changes with the phase of the texels, so that one offset says little: means are compared. */
static int move_by_anything(hard_run *run) {
  hard_truth truth = {0};
  double near = 0.0, far = 0.0;
  int code = draw_error(run, &truth, (const double[3]){0.0, 0.0, 0.0}, &near);
  if (code == 0)
    code = mean_error(run, &truth, run->sweep ? 32 : 16, (const double[2]){0.01, 1.0}, &near);
  if (code == 0)
    code = mean_error(run, &truth, run->sweep ? 256 : 32, (const double[2]){1e3, 1e7}, &far);
  if (code == 0)
    hard_figure_add(run, far / near, 1.1, "1", "rmse at 32 offsets to 1e7 m, against that near the origin");
  hard_truth_free(&truth);
  return code;
}

static int move_variant(hard_run *run, const variant *how) {
  yard still;
  int code = yard_draw(&still, run, how, (const double[3]){0.0, 0.0, 0.0}, 1024);
  for (int power = how->filter && !run->sweep ? 7 : 3; code == 0 && power <= 7; power += run->sweep ? 1 : 2)
    code = move_by_texels(run, &still, how, pow(10.0, power));
  yard_free(run, &still);
  return code;
}

static int run_case(hard_run *run) {
  int code = 0;
  for (int i = 0; code == 0 && i < (run->sweep ? VARIANTS : 2); i++)
    code = move_variant(run, &variants[i]);
  return code ? code : move_by_anything(run);
}

const hard_case hard_offsets = {
    .name = "offsets", .about = "the whole scene, camera and all, 1e3 to 1e7 m from the origin", .run = run_case};
