/*
 * bleeding.c: light that moments let through where two casters hang above each other. The lower one covers all; the
 * upper one ends in the middle, where the blur sees both. Nothing is lit, by the truth.
 *
 * With the upper caster x above the lower one, and the receiver y below that, a share q of the upper one has a variance
 * of q (1 - q) x^2 and a mean y + q x above the receiver, so Chebyshev's inequality leaves q (1 - q) x^2 / (q (1 - q) x^2
 * + (y + q x)^2): the more, the smaller y : x. What every technique leaves at every share is in moment_model.h, and no
 * pixel may be off it by more than rounding; without a reduction it is stated, and what reductions make of it.
 */
#include "base/host.h"
#include "hard/moment_scene.h"
#include <math.h>

enum { BANDS = 4, BAND_PIXELS = 48, PIXELS = BANDS * BAND_PIXELS, JUDGED = 2 };

/* y : x is 1 to so much, in each band. */
static const double ratios[2][BANDS] = {{2.0, 5.0, 20.0, 100.0}, {3.0, 10.0, 30.0, 50.0}};
static const double range = 100.0, side = 64.0, apart = 50.0, edge = 0.3;

static void make_scene(host_setup *out, const double of[BANDS]) {
  mesh_builder ground = {0}, casters = {0};
  const double half = 0.5 * side, band = side / BANDS;
  overhead_begin(out, &(overhead){.side = side, .eye = range, .floor = -0.001 * range, .pixels = PIXELS});
  overhead_tile(&ground, (const double[4]){-half, -half, half, half}, 1.0);
  hard_add(out, &ground, "ground", NULL);
  for (int i = 0; i < BANDS; i++) {
    const double lower = 1.0 + apart / of[i], from = i * band - half;
    overhead_tile(&casters, (const double[4]){-half, from, half, from + band}, lower);
    overhead_tile(&casters, (const double[4]){-half, from, edge, from + band}, lower + apart);
  }
  hard_add(out, &casters, "casters", NULL);
  overhead_range(out, range, 0.0);
  out->config.resolution = 96;
  out->config.moment_blur_texels = 3;
  out->config.bias_constant_texels = out->config.bias_slope_texels = 0.0;
}

typedef struct reduction {
  const char *name;
  double below, power;
  uint32_t curve;
} reduction;

static const reduction reductions[] = {{"no reduction", 0.0, 1.0, CSM_BLEEDING_LINEAR},
                                       {"linear 0.3", 0.3, 1.0, CSM_BLEEDING_LINEAR},
                                       {"power 4", 0.0, 4.0, CSM_BLEEDING_LINEAR},
                                       {"linear 0.6, power 2", 0.6, 2.0, CSM_BLEEDING_LINEAR},
                                       {"smoothstep 0.2", 0.2, 1.0, CSM_BLEEDING_SMOOTHSTEP}};
enum { REDUCTIONS = sizeof reductions / sizeof reductions[0], SHORT_REDUCTIONS = 3 };

/* In the middle of a band, farther from the next one than the blur reaches. */
static void judge_band(hard_run *run, const moment_scene *scene, const hard_picture *drawn, double ratio, int band,
                       const char *reduction) {
  double most = 0.0, off = 0.0;
  char name[64];
  for (int i = 0; i < JUDGED; i++)
    for (uint32_t column = 0; column < PIXELS; column++) {
      const uint32_t row = (uint32_t)(band * BAND_PIXELS + BAND_PIXELS / 2 - JUDGED / 2 + i);
      const double lit = drawn->mask[(size_t)row * PIXELS + column];
      double at[2], bounds[2];
      overhead_place(run->setup, column, row, at);
      if (fabs(at[0] - edge) > 6.0 * scene->binding.cascades[0].texel_size)
        continue; /* the blur sees one of them alone */
      moment_scene_bounds(scene, (const double[3]){at[0], 1.0, at[1]}, bounds);
      most = fmax(most, lit);
      off = fmax(off, fmax(lit - bounds[1], bounds[0] - lit));
    }
  moment_scene_name(&scene->config, name, sizeof name);
  hard_figure_add(run, most, INFINITY, "1", "bleeding at 1 : %g, %s, %s", ratio, name, reduction);
  hard_figure_add(run, off, moment_scene_step, "1", "off the closed form, %s, %s", name, reduction);
}

static int draw_filter(hard_run *run, const double of[BANDS], uint32_t filter, const reduction *reduction) {
  csm_config config = run->setup->config;
  moment_scene scene = {0};
  hard_picture drawn = {0};
  config.filter = filter;
  config.bleeding_reduction = reduction->below;
  config.bleeding_power = reduction->power;
  config.bleeding_curve = reduction->curve;
  int code = hard_configure(run, &config);
  if (code == 0)
    code = hard_draw(run, &run->setup->camera, &run->setup->light, 0, &drawn);
  if (code == 0)
    code = moment_scene_read(&scene, run, &config);
  for (int band = 0; code == 0 && band < BANDS; band++)
    judge_band(run, &scene, &drawn, of[band], band, reduction->name);
  moment_scene_free(&scene);
  hard_picture_free(&drawn);
  return code;
}

static int run_case(hard_run *run) {
  int code = 0;
  for (int set = 0; code == 0 && set < (run->sweep ? 2 : 1); set++) {
    host_setup setup;
    make_scene(&setup, ratios[set]);
    code = hard_load(run, &setup);
    if (code == 0)
      code = hard_flag(run, 1, 2, CSM_INSTANCE_CAST_ONLY);
    for (uint32_t filter = CSM_FILTER_VSM; filter <= CSM_FILTER_MSM4; filter++)
      for (int i = 0; code == 0 && i < (run->sweep ? REDUCTIONS : SHORT_REDUCTIONS); i++)
        code = draw_filter(run, ratios[set], filter, &reductions[i]);
    hard_unload(run);
    setup_free(&setup);
  }
  return code;
}

const hard_case hard_bleeding = {.name = "bleeding",
                                 .about = "two casters above each other: what moments let through, at 1 : 2 to 1 : 100",
                                 .run = run_case};
