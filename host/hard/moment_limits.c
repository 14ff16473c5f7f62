/*
 * moment_limits.c: filters on moments at the limits of their formats: every depth of a map's range, near and far ranges,
 * 16 and 32 bits of depths and of moments, blurred or not, layered or not. What is bare is lit; what lies under a lid
 * with nothing behind it is dark, where the gap is large enough for the technique.
 *
 * The least gap follows from the least variance v or the exponent c that csm tells its shaders. Of one depth alone
 * Chebyshev leaves v / (v + gap^2) of the light, a thousandth at sqrt(999) = 31.6 deviations; an exponential leaves
 * exp(-c gap), a thousandth at ln(1000) / c = 6.91 / c. Both at once, and four moments: moment_model.h. To this comes
 * what a mean and a receiver may be off by rounding (moment_scene.h).
 *
 * A mask has 8 bits, in which a thousandth and 0 are the same, and so are 0.999 and 1. So what is lit is looked at with a
 * reduction of bleeding, of which 0.99 is dark and 1 is lit: a step of the mask is then 4e-5 of the light.
 */
#include "base/host.h"
#include "csm_constants.h"
#include "hard/terrace.h"
#include <math.h>

typedef struct settings {
  uint32_t filter, layers;
  uint32_t moments; /* CSM_MOMENTS_* */
  uint32_t map;     /* CSM_MAP_* */
  uint32_t blur;    /* its radius, in texels */
} settings;

static csm_config make_config(const host_setup *setup, const settings *s) {
  csm_config config = setup->config;
  /* a blur lies within a step, and what VSSM searches beside it */
  config.resolution = s->blur > 2 ? 2560 : s->filter == CSM_FILTER_VSSM ? 640 : 320;
  config.filter = s->filter;
  config.moment_layers = s->layers;
  config.moment_format = s->moments;
  config.moment_blur_texels = s->blur;
  config.map_format = s->map;
  config.soft_radius_max_texels = 1.0;
  if (s->filter == CSM_FILTER_VSSM)
    config.moment_levels = 4;
  return config;
}

/* ---- what is judged ---- */

/* What a reduction of bleeding leaves in the dark where lit steps are looked at. */
static const double magnified = 0.99;

typedef struct verdict {
  double darkest_lit, lightest_dark; /* the latter: of gaps above the least */
  double least, seen;                /* gaps, as shares of the range: the largest least one; the largest that is lit */
  uint32_t lit, dark;                /* pixels */
} verdict;

/* Two masks: as it is, and magnified. */
typedef struct pictures {
  hard_picture plain, magnified;
} pictures;

/* In shares of the range, which are halves of z. */
static double least_gap(const moment_scene *scene, const terrace_step *step) {
  const double z = 2.0 * (step->depth - step->gap) - 1.0;
  return 0.5 * (moment_model_least_gap(&scene->model, z, 0.001) + scene->doubt);
}

static verdict judge(const hard_run *run, const moment_scene *scene, const pictures *drawn, double reach) {
  verdict v = {.darkest_lit = 1.0};
  for (uint32_t y = 0; y < TERRACE_PIXELS; y++)
    for (uint32_t x = 0; x < TERRACE_PIXELS; x++) {
      const size_t at = (size_t)y * TERRACE_PIXELS + x;
      const double lit = drawn->plain.mask[at];
      terrace_step step;
      if (!terrace_step_at(&step, run->setup, x, y, reach))
        continue;
      if (step.gap == 0.0) {
        v.lit++;
        v.darkest_lit = fmin(v.darkest_lit, magnified + (1.0 - magnified) * drawn->magnified.mask[at]);
        continue;
      }
      const double least = least_gap(scene, &step);
      v.least = fmax(v.least, least);
      v.seen = !(lit <= 0.001) ? fmax(v.seen, step.gap) : v.seen;
      if (step.gap < least)
        continue;
      v.dark++;
      v.lightest_dark = fmax(v.lightest_dark, lit);
    }
  return v;
}

/* How far a square of the map, which may be turned about the light, reaches along the terrace's sides, of half its own. */
static double turned_reach(const csm_binding *binding) {
  const csm_cascades_block *block = binding->cascade_constants;
  return fabs((double)block->basis[0][0]) + fabs((double)block->basis[0][2]);
}

static void add_figures(hard_run *run, const moment_scene *scene, const pictures *drawn) {
  const csm_config *config = &scene->config;
  const bool soft = config->filter == CSM_FILTER_VSSM;
  const double texels = config->moment_blur_texels + 2.0 + (soft ? 2.0 * config->soft_radius_max_texels : 0.0);
  const double texel = scene->binding.cascades[0].texel_size;
  const verdict v = judge(run, scene, drawn, texels * texel * turned_reach(&scene->binding));
  char name[64];
  moment_scene_name(config, name, sizeof name);
  moment_scene_add_numbers(run, scene, name);
  hard_figure_add(run, 1.0 - v.darkest_lit, 0.001, "1", "what lit steps lack, %s", name);
  hard_figure_add(run, v.lightest_dark, 0.001, "1", "what dark ones get above the least gap, %s", name);
  hard_figure_add(run, v.least, INFINITY, "range", "the least gap, %s", name);
  hard_figure_add(run, v.seen, INFINITY, "range", "the largest gap that is not dark, %s", name);
  hard_figure_add(run, v.lit > 500 && v.dark > 50 ? 0.0 : 1.0, 0.0, "1", "pictures that show nothing, %s", name);
}

/* ---- the case ---- */

static int draw_settings(hard_run *run, const settings *s, moment_scene *scene, pictures *drawn) {
  csm_config config = make_config(run->setup, s);
  config.bleeding_reduction = magnified;
  int code = hard_configure(run, &config);
  if (code == 0)
    code = hard_draw(run, &run->setup->camera, &run->setup->light, 0, &drawn->magnified);
  config.bleeding_reduction = 0.0;
  if (code == 0)
    code = hard_configure(run, &config);
  if (code == 0)
    code = hard_draw(run, &run->setup->camera, &run->setup->light, 0, &drawn->plain);
  if (code == 0)
    code = moment_scene_read(scene, run, &config);
  if (code == 0)
    add_figures(run, scene, drawn);
  return code;
}

/* Nine techniques, and for each all that there is of formats and blurs; the short form goes round among these. */
static int draw_range(hard_run *run, uint32_t far, moment_scene *scene, pictures *drawn) {
  static const uint32_t techniques[][2] = {{CSM_FILTER_VSM, 1},   {CSM_FILTER_VSM, 2},  {CSM_FILTER_VSM, 3},
                                           {CSM_FILTER_VSM, 4},   {CSM_FILTER_ESM, 1},  {CSM_FILTER_EVSM2, 1},
                                           {CSM_FILTER_EVSM4, 1}, {CSM_FILTER_MSM4, 1}, {CSM_FILTER_VSSM, 1}};
  static const uint32_t blurs[] = {0, 2, 7, 32};
  const uint32_t blur_count = run->sweep ? 4 : 2;
  int code = 0;
  for (uint32_t i = 0; i < 9; i++)
    for (uint32_t k = 0; code == 0 && k < 4 * blur_count; k++) {
      const settings s = {.filter = techniques[i][0],
                          .layers = techniques[i][1],
                          .moments = k & 1,
                          .map = k >> 1 & 1,
                          .blur = blurs[k >> 2]};
      if (run->sweep || (s.map == (i + s.moments + far) % 2 && (k >> 2) == (i / 2 + far) % 2))
        code = draw_settings(run, &s, scene, drawn);
    }
  return code;
}

static int run_case(hard_run *run) {
  /* Metres. The map's texels are of 17 cm, and 16 bits resolve 65535 of them. */
  static const double ranges[] = {100.0, 1e4};
  moment_scene scene = {0};
  pictures drawn = {0};
  int code = 0;
  for (uint32_t far = 0; code == 0 && far < 2; far++) {
    host_setup setup;
    terrace_make(&setup, ranges[far]);
    code = hard_load(run, &setup);
    if (code == 0)
      code = terrace_hide_lids(run);
    if (code == 0)
      code = draw_range(run, far, &scene, &drawn);
    hard_unload(run);
    setup_free(&setup);
  }
  hard_picture_free(&drawn.plain);
  hard_picture_free(&drawn.magnified);
  moment_scene_free(&scene);
  return code;
}

const hard_case hard_moment_limits = {
    .name = "moment_limits",
    .about = "filters on moments at every depth, of near and far ranges, 16 and 32 bits, blurred or not",
    .run = run_case};
