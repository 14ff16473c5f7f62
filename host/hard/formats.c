/*
 * formats.c: depths in 16 bits against 32, running either way, over ranges to 1e5 m. Half a step of 16 bits is all that
 * may get lost: range / 131070.
 */
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>

/* What a scene is made for. */
typedef struct formats_scene {
  double range; /* how far the map reaches up the light */
  bool fine;    /* its texels are of 2 mm, not of 3 cm */
  bool clipped; /* what lies before the range is lost: then it may not be shortened */
} formats_scene;

/* A level ground, and a lid over a part of it, thick, at some height. */
static void make_scene(host_setup *out, const formats_scene *of, double lid_height) {
  mesh_builder b = {0};
  hard_setup_begin(out, 256, 144);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 40.0, 4);
  hard_add(out, &b, "ground", NULL);
  if (isfinite(lid_height)) {
    builder_box(&b, (const double[3]){-12.0, lid_height, -40.0}, (const double[3]){12.0, lid_height + 8.0, 4.0});
    hard_add(out, &b, "lid", NULL);
  }
  hard_look(out, (const double[3]){0.0, 1.0, 8.0}, (const double[3]){0.0, 0.0, -6.0}, 70.0);
  hard_reach(out, of->fine ? 6.0 : 30.0);
  out->config.resolution = of->fine ? 2048 : 1024;
  out->config.cascade_count = 2;
  out->config.depth_mode = CSM_DEPTH_SLICE;
  out->config.pancaking = of->clipped ? CSM_PANCAKING_CLIP : CSM_PANCAKING_CLAMP;
  out->config.caster_distance = of->range;
}

/* The same, with a caster as far up the light as its range reaches, which the planner finds by itself. */
static void add_far_caster(host_setup *setup, double range) {
  mesh_builder b = {0};
  double place[3];
  for (int axis = 0; axis < 3; axis++)
    place[axis] = floor(-0.9 * range * setup->light.direction[axis]);
  builder_box(&b, (const double[3]){-0.5, -0.5, -0.5}, (const double[3]){0.5, 0.5, 0.5});
  hard_add(setup, &b, "far caster", place);
  setup->config.depth_mode = CSM_DEPTH_CASTERS;
}

/* ---- what a map loses ---- */

typedef struct format_map {
  csm_cascade_info cascade;
  float *depths;
  uint32_t side;
} format_map;

static int read_map(format_map *out, hard_run *run, const host_setup *setup, uint32_t format, bool reversed) {
  csm_config config = setup->config;
  csm_binding binding;
  hard_picture drawn = {0};
  config.map_format = format;
  config.map_reversed = reversed;
  int code = hard_restart(run, &config);
  if (code == 0)
    code = hard_draw(run, &setup->camera, &setup->light, 0, &drawn);
  if (code == 0)
    code = hard_bind(run, &binding);
  if (code == 0)
    code = hard_map(run, 0, &out->depths, &out->side);
  if (code == 0)
    out->cascade = binding.cascades[0];
  hard_picture_free(&drawn);
  return code;
}

/* The most that a map's depths are off the exact ones, in metres. What lies before its range is clamped to its begin. */
static double map_error(const format_map *exact, const format_map *map, const scene_light *light, bool reversed) {
  const double begins[2] = {hard_along(&exact->cascade, light, 0.0),
                            hard_along(&map->cascade, light, reversed ? 1.0 : 0.0)};
  double largest = 0.0;
  for (size_t i = 0; i < (size_t)map->side * map->side; i++) {
    const double right = hard_along(&exact->cascade, light, exact->depths[i]);
    const double stored = hard_along(&map->cascade, light, map->depths[i]);
    const bool empty = exact->depths[i] >= 1.0f; /* each range has an end of its own */
    if (!empty)
      largest = fmax(largest, fabs(stored - fmax(right, fmax(begins[0], begins[1]))));
  }
  return largest;
}

/*
 * The nearest of 65536 depths is half a step away at most. The float arithmetic to a depth is off by 2^-22 of the range
 * (docs/accuracy.md), in each of two maps.
 */
static void compare_maps(hard_run *run, const format_map *exact, const format_map *map, const scene_light *light,
                         int kind) {
  const bool bits_16 = kind & 1, reversed = kind & 2;
  const double texel = map->cascade.texel_size, range = map->cascade.depth_range;
  const double bound = (bits_16 ? range / 131070.0 : 0.0) + 0x1p-22 * (range + exact->cascade.depth_range);
  hard_figure_add(run, map_error(exact, map, light, reversed) / texel, bound / texel, "texels",
                  "lost in %d bits%s, a range of %.0e m", bits_16 ? 16 : 32, reversed ? ", reversed" : "", range);
}

static int lose_depth(hard_run *run, const host_setup *setup) {
  format_map exact = {0};
  int code = read_map(&exact, run, setup, CSM_MAP_D32, false);
  for (int kind = 1; code == 0 && kind < 4; kind++) {
    format_map map = {0};
    code = read_map(&map, run, setup, kind & 1 ? CSM_MAP_D16 : CSM_MAP_D32, kind & 2);
    if (code == 0)
      compare_maps(run, &exact, &map, &setup->light, kind);
    free(map.depths);
  }
  free(exact.depths);
  return code;
}

/* ---- what is drawn ---- */

static int judge_scene(hard_run *run, const host_setup *setup, hard_margin margin, const char *what) {
  hard_picture drawn = {0};
  hard_truth truth = {0};
  int code = hard_load(run, setup);
  if (code == 0)
    code = hard_cast(run, &setup->camera, &setup->light, &truth);
  for (int i = 0; code == 0 && i < 4; i++) {
    csm_config config = setup->config;
    config.map_format = i & 1 ? CSM_MAP_D16 : CSM_MAP_D32;
    config.map_reversed = i & 2 ? 1 : 0;
    code = hard_restart(run, &config);
    if (code == 0)
      code = hard_draw(run, &setup->camera, &setup->light, 0, &drawn);
    if (code)
      break;
    const hard_count count = hard_judge(run, &truth, drawn.mask, margin);
    hard_figure_add(run, (double)(count.false_dark + count.false_lit), 0.0, "px", "wrong, %s, %d bits%s", what,
                    i & 1 ? 16 : 32, i & 2 ? ", reversed" : "");
    hard_figure_add(run, count.judged > 1000 ? 0.0 : 1.0, 0.0, "1", "pictures that show nothing");
  }
  hard_picture_free(&drawn);
  hard_truth_free(&truth);
  return code;
}

static int draw_plane(hard_run *run, const formats_scene *of, double height_deg, uint32_t filter, uint32_t bias) {
  host_setup setup;
  make_scene(&setup, of, INFINITY);
  setup.light = hard_sun(height_deg, 70.0);
  setup.config.filter = filter;
  setup.config.bias_mode = filter == CSM_FILTER_LINEAR_DEPTH ? CSM_BIAS_SLOPE : bias; /* it compares once */
  const int code = judge_scene(run, &setup, (hard_margin){.edge_px = 0.0}, "a lit plane");
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/* With the default filter and bias, or with all. */
static int draw_planes(hard_run *run, const formats_scene *of, double height_deg) {
  int code = draw_plane(run, of, height_deg, CSM_FILTER_PCF_3X3, CSM_BIAS_RECEIVER_PLANE);
  for (uint32_t filter = 0; run->sweep && code == 0 && filter <= CSM_FILTER_GRID_17; filter++)
    for (uint32_t bias = 0; code == 0 && bias <= CSM_BIAS_RECEIVER_PLANE; bias++)
      code = draw_plane(run, of, height_deg, filter, bias);
  return code;
}

/* The same with a caster at the range's far end: its shadow has edges, and is left out. */
static int draw_plane_far_below(hard_run *run, const formats_scene *of, double height_deg) {
  host_setup setup;
  make_scene(&setup, of, INFINITY);
  setup.light = hard_sun(height_deg, 70.0);
  add_far_caster(&setup, of->range);
  const int code = judge_scene(run, &setup, (hard_margin){.edge_px = 5.0}, "a plane far below a caster");
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/*
 * A lid hangs two steps of 16 bits over the ground, and what the bias takes at a sun of 60 degrees, a texel and more:
 * a metre. All under it is dark. Its shadow's edges are 5 px wide at most.
 */
static int draw_lid(hard_run *run, const formats_scene *of) {
  host_setup setup;
  make_scene(&setup, of, 1.0 + 2.0 * of->range / 65535.0);
  setup.light = hard_sun(60.0, 70.0);
  const int code = judge_scene(run, &setup, (hard_margin){.silhouette_px = 2.0, .edge_px = 5.0}, "under a lid");
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int draw_maps(hard_run *run, const formats_scene *of, bool far_caster) {
  host_setup setup;
  make_scene(&setup, of, 2.0);
  if (far_caster)
    add_far_caster(&setup, of->range);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = lose_depth(run, &setup);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/* The short form leaves out some suns, and maps of fine texels that are drawn as coarse ones are. */
static int draw_all(hard_run *run, const formats_scene *of) {
  static const double suns[] = {70.0, 45.0, 20.0};
  int code = 0;
  for (int i = 0; code == 0 && i < 3; i++) {
    if (!run->sweep && (i == 1) != of->fine)
      continue;
    code = draw_planes(run, of, suns[i]);
    if (code == 0 && (run->sweep || i == 2))
      code = draw_plane_far_below(run, of, suns[i]);
  }
  if (code == 0)
    code = draw_lid(run, of);
  if (code == 0 && (run->sweep || !of->fine || of->clipped))
    code = draw_maps(run, of, false);
  if (code == 0 && (run->sweep || !of->fine))
    code = draw_maps(run, of, true);
  return code;
}

static int run_case(hard_run *run) {
  int code = 0;
  for (int power = 2; code == 0 && power <= 5; power += run->sweep ? 1 : 3)
    code = draw_all(run, &(formats_scene){.range = pow(10.0, power)});
  for (int clipped = 0; code == 0 && clipped < 2; clipped++)
    code = draw_all(run, &(formats_scene){.range = 1e5, .fine = true, .clipped = clipped});
  return code;
}

const hard_case hard_formats = {
    .name = "formats", .about = "depths in 16 bits, running either way, over ranges to 1e5 m", .run = run_case};
