/*
 * moment_gaps.c: lids 5 m (a hundredth of the depth range) to 1 mm over the ground, in one cascade that is 500 m wide
 * and 500 m deep: when each technique sees the gap. What it must give is a closed form of one depth (moment_limits.c);
 * it is stated, and nothing may be off it by more than rounding. A gap is seen where no more than half of the light is
 * left; the least such gap follows likewise: a deviation for Chebyshev, ln 2 / c for an exponential.
 */
#include "base/host.h"
#include "hard/moment_scene.h"
#include <math.h>

enum { GAPS = 6, CELL_PIXELS = 16, PIXELS = GAPS * CELL_PIXELS };

/* In metres. 0: there is no lid. */
static const double gaps[GAPS] = {0.0, 5.0, 1.0, 0.1, 0.01, 0.001};
static const double extent = 500.0;

static void make_scene(host_setup *out) {
  mesh_builder b = {0};
  const double half = 0.5 * extent, cell = extent / GAPS;
  overhead_begin(out, &(overhead){.side = extent, .eye = extent, .floor = -1.0, .pixels = PIXELS});
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, half, 1);
  hard_add(out, &b, "ground", NULL);
  for (int i = 1; i < GAPS; i++)
    overhead_tile(&b, (const double[4]){i * cell - half, -half, (i + 1) * cell - half, half}, gaps[i]);
  hard_add(out, &b, "lids", NULL);
  overhead_range(out, extent, 0.0);
  out->config.resolution = 256;
  out->config.bias_constant_texels = out->config.bias_slope_texels = 0.0;
  out->config.bleeding_reduction = 0.0;
}

/* The least gap at which the closed form leaves a share of the light, on the ground, in metres. */
static double least_gap(const moment_scene *scene, double share) {
  double low = 0.0, high = 2.0;
  for (int i = 0; i < 60; i++) {
    const double middle = 0.5 * (low + high);
    double bounds[2];
    moment_scene_bounds_of_one(scene, 1.0 - middle, 1.0, bounds);
    *(bounds[1] > share ? &low : &high) = middle;
  }
  return 0.5 * high * scene->binding.cascades[0].depth_range;
}

static void add_figures(hard_run *run, const moment_scene *scene, const hard_picture *drawn) {
  char name[64];
  moment_scene_name(&scene->config, name, sizeof name);
  for (int i = 0; i < GAPS; i++) {
    const uint32_t column = (uint32_t)i * CELL_PIXELS + CELL_PIXELS / 2, row = PIXELS / 2;
    const double lit = drawn->mask[(size_t)row * PIXELS + column];
    double place[3] = {0.0}, at[2], bounds[2];
    overhead_place(run->setup, column, row, at);
    place[0] = at[0];
    place[2] = at[1];
    moment_scene_bounds(scene, place, bounds);
    hard_figure_add(run, lit, INFINITY, "1", "light under a gap of %g m, %s", gaps[i], name);
    hard_figure_add(run, fmax(lit - bounds[1], bounds[0] - lit), moment_scene_step, "1", "off the closed form, %s",
                    name);
  }
  hard_figure_add(run, least_gap(scene, 0.5), INFINITY, "m", "the least gap that is seen, %s", name);
  hard_figure_add(run, least_gap(scene, 0.001), INFINITY, "m", "the least gap that is dark, %s", name);
}

static int draw_filter(hard_run *run, uint32_t filter, uint32_t layers, uint32_t format) {
  csm_config config = run->setup->config;
  moment_scene scene = {0};
  hard_picture drawn = {0};
  config.filter = filter;
  config.moment_layers = layers;
  config.moment_format = format;
  config.moment_blur_texels = 2;
  int code = hard_configure(run, &config);
  if (code == 0)
    code = hard_draw(run, &run->setup->camera, &run->setup->light, 0, &drawn);
  if (code == 0)
    code = moment_scene_read(&scene, run, &config);
  if (code == 0)
    add_figures(run, &scene, &drawn);
  moment_scene_free(&scene);
  hard_picture_free(&drawn);
  return code;
}

static int run_case(hard_run *run) {
  host_setup setup;
  make_scene(&setup);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = hard_flag(run, 1, 2, CSM_INSTANCE_CAST_ONLY);
  for (uint32_t filter = CSM_FILTER_VSM; filter <= CSM_FILTER_MSM4; filter++)
    for (uint32_t format = 0; code == 0 && format < 2; format++)
      code = draw_filter(run, filter, 1, format);
  if (code == 0)
    code = draw_filter(run, CSM_FILTER_VSM, 4, CSM_MOMENTS_FLOAT32);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_moment_gaps = {.name = "moment_gaps",
                                    .about = "gaps of 5 m to 1 mm in a cascade of 500 m: when moments see them",
                                    .run = run_case};
