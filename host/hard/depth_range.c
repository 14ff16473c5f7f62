/*
 * depth_range.c: near planes from 1 mm to 1 km, far planes from twice as far to 10^7 times, or none, depth reversed and
 * not, fields of view from half a degree to 170. A plane with nothing on it is lit; under a roof it is dark. Whatever the
 * numbers are, no pixel may be otherwise, and the splits are numbers that rise, also as the floats that shaders read.
 */
#include "base/host.h"
#include "csm_constants.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>

static const double degree = 3.14159265358979323846 / 180.0;

typedef struct view_range {
  double near, far; /* far: INFINITY for none */
  double reach;     /* shadows end there */
  double distance;  /* to where the camera looks */
  double fov_deg;
  bool reversed;
  uint32_t cascades, split_mode;
} view_range;

/* ---- scene ---- */

/*
 * A level square of rings about the origin, each twice as wide as the one inside it: triangles are as large as they are
 * far away. A ray that meets one next to its edge is moved inside by a share of it.
 */
static void add_rings(host_setup *setup, double inner, double half, const double position[3]) {
  static const int8_t around[8][2] = {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
  mesh_builder b = {0};
  uint32_t inside = builder_vertex(&b, 0.0, 0.0, 0.0), rings = 0;
  for (double size = inner; rings == 0 || size < 2.0 * half; size *= 2.0, rings++) {
    const uint32_t ring = inside + (rings ? 8 : 1);
    for (int i = 0; i < 8; i++)
      builder_vertex(&b, around[i][0] * size, 0.0, around[i][1] * size);
    for (uint32_t i = 0; i < 8; i++) {
      const uint32_t next = (i + 1) % 8;
      builder_triangle(&b, rings ? inside + i : inside, ring + next, ring + i);
      if (rings)
        builder_triangle(&b, inside + i, inside + next, ring + next);
    }
    inside = ring;
  }
  hard_add(setup, &b, "rings", position);
}

/* Looks down on the ground at 30 degrees, along -z. */
static int set_camera(host_setup *setup, const view_range *v) {
  double view[16], projection[16];
  hard_look(setup, (const double[3]){0.0, 0.5 * v->distance, 0.0},
            (const double[3]){0.0, 0.0, -cos(30.0 * degree) * v->distance}, v->fov_deg);
  for (int i = 0; i < 16; i++) {
    view[i] = setup->camera.view[i];
    projection[i] = setup->camera.projection[i];
  }
  const double n = v->near, share = isinf(v->far) ? 0.0 : n / (v->far - n); /* what the far plane takes off */
  projection[10] = v->reversed ? share : -1.0 - share;
  projection[14] = v->reversed ? n + n * share : -n - n * share;
  const char *problem = camera_from_matrices(&setup->camera, view, projection, NULL);
  return problem ? host_fail(HOST_BAD_INPUT, "depth_range: %s", problem) : 0;
}

/*
 * The ground goes on beyond all that is seen within the shadows' reach, and so does the roof, which hangs above the
 * camera, and higher than the bias reaches: with this light that is half a texel and half a texel's slope along each
 * axis, at most 1.1, and no texel is larger than a sphere around all that is seen is wide, over the resolution. Their
 * triangles are small beside the reach, for it is not their size that is looked into here.
 */
static int build(host_setup *out, hard_run *run, const view_range *v, bool roof) {
  hard_setup_begin(out, run->sweep ? 320 : 192, run->sweep ? 180 : 108);
  out->config.cascade_count = v->cascades;
  out->config.split_mode = v->split_mode;
  out->config.resolution = run->sweep ? 2048 : 512;
  const double up = tan(0.5 * v->fov_deg * degree), aside = up * out->width / out->height;
  const double farthest = v->reach * sqrt(1.0 + up * up + aside * aside), half = 1.5 * farthest;
  const double height = fmax(v->distance, 2.0 * (2.0 * farthest / out->config.resolution));
  add_rings(out, v->distance, half, NULL);
  if (roof)
    add_rings(out, height, half + 2.0 * height, (const double[3]){0.0, height, 0.0});
  out->light = hard_sun(50.0, 70.0);
  hard_reach(out, v->reach);
  return set_camera(out, v);
}

/* ---- splits ---- */

/* How many of the cascades do not begin where the one before ends, and end farther away; as doubles and as floats. */
static uint32_t count_out_of_order(const csm_binding *binding, const view_range *v) {
  const csm_cascades_block *block = binding->cascade_constants;
  double last = v->near;
  float last_float = (float)v->near;
  uint32_t wrong = 0;
  for (uint32_t i = 0; i < binding->cascade_count; i++) {
    const csm_cascade_info *c = &binding->cascades[i];
    const bool begins = fabs(c->near_depth - last) <= (i ? 0.0 : 1e-8 * v->near);
    wrong += !(begins && isfinite(c->far_depth) && c->far_depth > c->near_depth && block->splits[i] > last_float &&
               isfinite(block->splits[i]));
    last = c->far_depth;
    last_float = block->splits[i];
  }
  return wrong + !(fabs(last - v->reach) <= 1e-8 * v->reach);
}

/* ---- pictures ---- */

static void add_figures(hard_run *run, const hard_truth *truth, const float *mask, bool roof, const char *how) {
  const hard_count count = hard_judge(run, truth, mask, (hard_margin){.silhouette_px = 0.0});
  /* There is no edge of a shadow anywhere, so no pixel has a reason to be wrong. */
  if (roof)
    hard_figure_add(run, (double)count.false_lit, 0.0, "px", "lit pixels under a roof, %s", how);
  else
    hard_figure_add(run, (double)count.false_dark, 0.0, "px", "dark pixels of a bare plane, %s", how);
  hard_figure_add(run, count.judged && count.lit == (roof ? 0 : count.judged) ? 0.0 : 1.0, 0.0, "1",
                  "pictures in which nothing could be judged");
}

/* The engine's depth and normals, which a float holds if they are reversed. */
static int draw_with_inputs(hard_run *run, const host_setup *setup, const hard_truth *truth, bool roof) {
  hard_picture drawn = {0};
  float *depth = hard_true_depth(truth);
  const hard_inputs inputs = {.camera_depth = depth};
  const int code = hard_draw_engine(run, &inputs, &setup->camera, &setup->light, &drawn);
  if (code == 0)
    add_figures(run, truth, drawn.mask, roof, "the engine's reversed depth");
  free(depth);
  hard_picture_free(&drawn);
  return code;
}

static int draw(hard_run *run, const view_range *v, bool roof) {
  host_setup setup;
  hard_picture drawn = {0};
  hard_truth truth = {0};
  csm_binding binding;
  int code = build(&setup, run, v, roof);
  if (code == 0)
    code = hard_load(run, &setup);
  if (code == 0)
    code = hard_draw(run, &setup.camera, &setup.light, 0, &drawn);
  if (code == 0)
    code = hard_bind(run, &binding);
  if (code == 0)
    hard_figure_add(run, count_out_of_order(&binding, v), 0.0, "1", "splits that are out of order");
  if (code == 0)
    code = hard_cast(run, &setup.camera, &setup.light, &truth);
  if (code == 0)
    add_figures(run, &truth, drawn.mask, roof, "depth of csm's own");
  if (code == 0 && v->reversed && hard_has_engine(run))
    code = draw_with_inputs(run, &setup, &truth, roof);
  hard_truth_free(&truth);
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/* ---- ranges ---- */

static const double nears[] = {1e-3, 1e3, 1.0, 0.03};
static const double ratios[] = {2.0, 1e7, INFINITY, 1e3, 30.0}; /* of the far plane to the near one */
static const double fovs[] = {0.5, 170.0, 60.0, 5.0, 120.0};

/*
 * All nears, ratios and fields of view meet. What else there is takes turns among them, so that each value meets each
 * of theirs: a near plane of 1 mm that is not reversed also where the camera looks 7 km away.
 */
static view_range range_of(uint32_t near, uint32_t ratio, uint32_t fov) {
  static const uint32_t cascades[] = {4, 8, 1};
  static const uint32_t modes[] = {CSM_SPLIT_PRACTICAL, CSM_SPLIT_LOGARITHMIC, CSM_SPLIT_PRACTICAL, CSM_SPLIT_UNIFORM};
  const double n = nears[near], most = 1e9; /* as far as a configuration's shadows may reach */
  const double reach = fmin(n * fmin(ratios[ratio], 1e7), most);
  /* Just beyond the near plane, midway by ratio, and two thirds of the way */
  const double places[] = {1.4 * n, sqrt(n * reach), 0.7 * reach};
  return (view_range){.near = n,
                      .far = n * ratios[ratio],
                      .reach = reach,
                      .distance = places[(fov + ratio) % 3],
                      .fov_deg = fovs[fov],
                      .reversed = (near + ratio + fov) % 2,
                      .cascades = cascades[(near + 2 * ratio + fov) % 3],
                      .split_mode = modes[(near + ratio + fov) / 2 % 4]};
}

static int run_case(hard_run *run) {
  const uint32_t near_count = run->sweep ? 4 : 2, ratio_count = run->sweep ? 5 : 3, fov_count = run->sweep ? 5 : 3;
  int code = 0;
  for (uint32_t i = 0; i < near_count * ratio_count * fov_count; i++) {
    const view_range v = range_of(i % near_count, i / near_count % ratio_count, i / near_count / ratio_count);
    for (int roof = 0; code == 0 && roof < 2; roof++)
      code = draw(run, &v, roof);
  }
  return code;
}

const hard_case hard_depth_range = {
    .name = "depth_range",
    .about = "near planes from 1 mm to 1 km, far ones to 10^7 times that, fields of view from 0.5 to 170 degrees",
    .run = run_case};
