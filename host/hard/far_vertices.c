/*
 * far_vertices.c: vertices that lie far from their mesh's own origin, which their instance brings back. Copied ones keep
 * their precision. Those in an engine's buffers are read as they are, in floats.
 */
#include "base/host.h"
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>

/* The way out, as multiples of the distance. */
static const double outward[3] = {1.0, -0.5, 0.75};

typedef struct far_case {
  hard_picture near, drawn; /* at the mesh's origin, and far from it */
  float *near_map;
  uint32_t side;
  csm_cascade_info cascade; /* the first, at the origin */
  hard_truth truth;
} far_case;

/* Vertices go out, instances bring them back. Multiples of 1/8 m below 2^20 m are exact in floats. */
static void bake(host_setup *setup, double distance) {
  scene *s = &setup->scene;
  for (size_t m = 0; m < s->mesh_count; m++)
    for (uint32_t v = 0; v < 3 * s->meshes[m].vertex_count; v++)
      s->meshes[m].positions[v] += (float)(outward[v % 3] * distance);
  for (size_t i = 0; i < s->instance_count; i++)
    for (int axis = 0; axis < 3; axis++)
      s->instances[i].transform[12 + axis] -= outward[axis] * distance;
}

static void make_yard(host_setup *out, double distance) {
  hard_setup_begin(out, 320, 180);
  hard_yard(out, false);
  out->config.resolution = 1024;
  bake(out, distance);
}

/* ---- what floats allow ---- */

/*
 * How far from its place, in metres, one coordinate in light space may come out. A row of the matrix is rounded to
 * floats, 2^-24 of each of its terms; so is its constant, which takes the terms back; each of three products is
 * rounded, and so are the two sums that are still large, up to twice the terms: 7 * 2^-24 of the terms.
 */
static double coordinate_error(const csm_cascade_info *cascade, int axis, double distance) {
  double row[3], terms = 0.0;
  for (int k = 0; k < 3; k++)
    row[k] = cascade->world_to_shadow[k * 4 + axis];
  vec_normalize(row);
  for (int k = 0; k < 3; k++)
    terms += fabs(row[k] * outward[k]) * distance;
  return 7.0 * 0x1p-24 * terms;
}

/* Depth for a metre along the map's sides, on a level plane: up is (0, 1, 0) in the world. */
static double plane_slope(const csm_cascade_info *cascade, int axis) {
  double row[3], along[3];
  for (int k = 0; k < 3; k++) {
    row[k] = cascade->world_to_shadow[k * 4 + axis];
    along[k] = cascade->world_to_shadow[k * 4 + 2];
  }
  vec_normalize(row);
  vec_normalize(along);
  return fabs(row[1] / along[1]);
}

/* Of a level plane's depth in the map: what is across the light counts by the plane's slope. */
static double depth_error(const csm_cascade_info *cascade, double distance) {
  return coordinate_error(cascade, 2, distance) + plane_slope(cascade, 0) * coordinate_error(cascade, 0, distance) +
         plane_slope(cascade, 1) * coordinate_error(cascade, 1, distance);
}

/*
 * What differs without that: a corner that is off by next to nothing may be placed a 256th of a texel away, along each
 * axis, and depths in 32 bits, with their interpolation, are off by 2^-22 of the range.
 */
static double map_rounding(const csm_cascade_info *cascade) {
  return (plane_slope(cascade, 0) + plane_slope(cascade, 1)) * cascade->texel_size / 256.0 +
         0x1p-22 * cascade->depth_range;
}

/* ---- drawing ---- */

/* Marks texels at which there is no plane, or beside which a caster's edge goes through. */
static void mark_edges(const far_case *f, uint8_t *marked) {
  const double rise = (plane_slope(&f->cascade, 0) + plane_slope(&f->cascade, 1)) * f->cascade.texel_size;
  const double most = rise + map_rounding(&f->cascade);
  for (uint32_t y = 0; y < f->side; y++)
    for (uint32_t x = 0; x < f->side; x++) {
      const size_t at = (size_t)y * f->side + x, right = x + 1 < f->side ? at + 1 : at;
      const size_t below = y + 1 < f->side ? at + f->side : at;
      const double depth = f->near_map[at] * f->cascade.depth_range;
      if (fabs(f->near_map[right] * f->cascade.depth_range - depth) > most)
        marked[at] = marked[right] = 1;
      if (fabs(f->near_map[below] * f->cascade.depth_range - depth) > most)
        marked[at] = marked[below] = 1;
      if (f->near_map[at] <= 0.0f || f->near_map[at] >= 1.0f)
        marked[at] = 1;
    }
}

/* The most that two maps' depths are apart, in metres, farther from every edge than edges may move. */
static double plane_difference(const far_case *f, const csm_cascade_info *cascade, const float *map, double distance) {
  const size_t texels = (size_t)f->side * f->side;
  const double moved = coordinate_error(&f->cascade, 0, distance) + coordinate_error(&f->cascade, 1, distance);
  const double clear = 1.0 + moved / f->cascade.texel_size;
  uint8_t *marked = host_allocate(texels, 1);
  int64_t *squares = host_allocate(texels, sizeof *squares);
  double largest = -1.0;
  mark_edges(f, marked);
  metrics_distances(marked, f->side, f->side, squares);
  for (size_t at = 0; at < texels; at++)
    if ((double)squares[at] > clear * clear)
      largest = fmax(largest, fabs(hard_along(cascade, &f->truth.light, map[at]) -
                                   hard_along(&f->cascade, &f->truth.light, f->near_map[at])));
  free(squares);
  free(marked);
  return largest >= 0.0 ? largest : INFINITY; /* nothing was left to compare */
}

static int draw_copied(hard_run *run, far_case *f, const host_setup *setup) {
  const int code = hard_draw(run, &setup->camera, &setup->light, 0, &f->drawn);
  if (code)
    return code;
  const hard_difference difference = hard_compare(run, &f->near, &f->drawn, 1.0 / 255.0);
  /* Copied positions are stored less an offset, and exactly so: nothing is left of the distance but its double's
     rounding, far below a texel. */
  hard_figure_add(run, (double)difference.pixels, 0.0, "px", "pixels that change, copied");
  return 0;
}

static int draw_in_buffers(hard_run *run, far_case *f, const host_setup *setup, double distance) {
  const hard_inputs inputs = {.engine_buffers = true};
  float *map = NULL;
  csm_cascade_info cascade;
  int code = hard_draw_engine(run, &inputs, &setup->camera, &setup->light, &f->drawn);
  if (code == 0)
    code = hard_map_engine(run, &inputs, 0, &cascade, &map);
  if (code == 0) {
    const double step = distance * 0x1p-23, bound = depth_error(&cascade, distance);
    hard_figure_add(run, plane_difference(f, &cascade, map, distance) / step, (bound + map_rounding(&cascade)) / step,
                    "steps", "depth off in an engine's buffers");
    /* As long as that is half of the bias, the rest of which is for what it is for elsewhere, nothing is false. */
    const hard_count count =
        hard_judge(run, &f->truth, f->drawn.mask, (hard_margin){.silhouette_px = 2.0, .edge_px = 3.0});
    const bool within = bound < 0.5 * setup->config.bias_constant_texels * f->cascade.texel_size;
    hard_figure_add(run, (double)(count.false_dark + count.false_lit), within ? 0.0 : INFINITY, "px",
                    "wrong pixels with an engine's buffers, %.0e m", distance);
  }
  free(map);
  return code;
}

static int draw_far(hard_run *run, far_case *f, double distance) {
  host_setup setup;
  make_yard(&setup, distance);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = draw_copied(run, f, &setup);
  if (code == 0 && hard_has_engine(run))
    code = draw_in_buffers(run, f, &setup, distance);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int draw_near(hard_run *run, far_case *f, const host_setup *setup) {
  csm_binding binding;
  int code = hard_load(run, setup);
  if (code == 0)
    code = hard_draw(run, &setup->camera, &setup->light, 0, &f->near);
  if (code == 0)
    code = hard_bind(run, &binding);
  if (code == 0)
    code = hard_map(run, 0, &f->near_map, &f->side);
  if (code == 0)
    code = hard_cast(run, &setup->camera, &setup->light, &f->truth);
  if (code == 0)
    f->cascade = binding.cascades[0];
  return code;
}

static int run_case(hard_run *run) {
  host_setup setup;
  far_case f = {0};
  make_yard(&setup, 0.0);
  int code = draw_near(run, &f, &setup);
  for (int power = 2; code == 0 && power <= 6; power += run->sweep ? 1 : 2)
    code = draw_far(run, &f, pow(10.0, power));
  hard_truth_free(&f.truth);
  hard_picture_free(&f.near);
  hard_picture_free(&f.drawn);
  free(f.near_map);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_far_vertices = {
    .name = "far_vertices", .about = "vertices baked 1e2 to 1e6 m from their mesh's origin", .run = run_case};
