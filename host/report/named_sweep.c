/* report_named_sweep.c: sweeps of configurations that have names, each a shape of its own. */
#include "base/host.h"
#include "plan.h"
#include "report/sweep.h"
#include "setup/config_json.h"
#include "setup/presets.h"
#include <stdlib.h>
#include <string.h>

/* Room for one more point; the others may move. */
static report_point *add_point(report_sweep *out, const char *name) {
  report_point *points = host_allocate(out->count + 1, sizeof *points);
  if (out->count)
    memcpy(points, out->points, out->count * sizeof *points);
  free(out->points);
  out->points = points;
  points[out->count].name = name;
  return &points[out->count++];
}

static void begin(report_sweep *out, const host_options *options, const csm_config *base) {
  *out = (report_sweep){.per_shape = 1};
  add_point(out, options_base_name(options))->config = *base;
}

static bool has_point(const report_sweep *sweep, const char *name) {
  for (uint32_t i = 0; i < sweep->count; i++)
    if (strcmp(sweep->points[i].name, name) == 0)
      return true;
  return false;
}

static int add_preset(report_sweep *out, const char *name, double shadow_distance) {
  if (has_point(out, name))
    return 0;
  report_point *point = add_point(out, name);
  point->is_preset = true;
  return config_load(&point->config, name, NULL, shadow_distance);
}

static int add_presets(report_sweep *out, const options_presets *presets, double shadow_distance) {
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < presets->count; i++)
    code = add_preset(out, presets->names[i], shadow_distance);
  return code;
}

int report_sweep_make_presets(report_sweep *out, const host_options *options, const host_setup *setup) {
  begin(out, options, &setup->config);
  const int code = add_presets(out, &options->against, setup->shadow_distance);
  return code ? code : add_presets(out, &options->presets, setup->shadow_distance);
}

/* ---- what techniques are known by ---- */

/* A filter, with what else is set; 0 leaves a field as the base has it. */
typedef struct setting {
  const char *name;
  uint32_t filter;
  uint32_t filter_taps, blur_texels, levels, sampling, layers, halved, format, soft_taps, history;
  double radius_texels;
} setting;

static const setting settings[] = {
    {"pcf_n 15", CSM_FILTER_PCF_N, .filter_taps = 15},
    {"vogel 32, radius 8", CSM_FILTER_VOGEL, .filter_taps = 32, .radius_texels = 8.0},
    {"vsm, blur 8", CSM_FILTER_VSM, .blur_texels = 8},
    {"vsm, 4 layers", CSM_FILTER_VSM, .layers = 4},
    {"vsm, trilinear", CSM_FILTER_VSM, .levels = 12, .sampling = CSM_SAMPLING_TRILINEAR},
    {"esm, blur 8", CSM_FILTER_ESM, .blur_texels = 8},
    {"evsm2, blur 8", CSM_FILTER_EVSM2, .blur_texels = 8},
    {"evsm4, blur 8", CSM_FILTER_EVSM4, .blur_texels = 8},
    {"evsm4, float16", CSM_FILTER_EVSM4, .format = CSM_MOMENTS_FLOAT16},
    {"evsm4, halved", CSM_FILTER_EVSM4, .halved = 1},
    {"evsm4, anisotropic", CSM_FILTER_EVSM4, .levels = 12, .sampling = CSM_SAMPLING_ANISOTROPIC},
    {"msm4, blur 8", CSM_FILTER_MSM4, .blur_texels = 8},
    {"msm4, float16", CSM_FILTER_MSM4, .format = CSM_MOMENTS_FLOAT16},
    {"vssm, 12 levels", CSM_FILTER_VSSM, .levels = 12},
    {"pcss, 16 taps", CSM_FILTER_PCSS, .soft_taps = 16},
    {"pcss, 64 taps", CSM_FILTER_PCSS, .soft_taps = 64},
    {"pcss, history", CSM_FILTER_PCSS, .history = CSM_HISTORY_ON},
    {"backprojection, 64 taps", CSM_FILTER_BACKPROJECTION, .soft_taps = 64},
};

static void change(uint32_t *field, uint32_t value) {
  *field = value ? value : *field;
}

static void apply(csm_config *config, const setting *s) {
  config->filter = s->filter;
  change(&config->filter_taps, s->filter_taps);
  change(&config->moment_blur_texels, s->blur_texels);
  change(&config->moment_levels, s->levels);
  change(&config->moment_sampling, s->sampling);
  change(&config->moment_layers, s->layers);
  change(&config->moment_halved, s->halved);
  change(&config->moment_format, s->format);
  change(&config->soft_taps, s->soft_taps);
  change(&config->history, s->history);
  config->filter_radius_texels = s->radius_texels > 0.0 ? s->radius_texels : config->filter_radius_texels;
}

/* What contradicts the base is left out; one comparison has no plane to place texels on. */
static void add_setting(report_sweep *out, const csm_config *base, const setting *s) {
  const char *unused;
  csm_config config = *base;
  apply(&config, s);
  if (config.filter == CSM_FILTER_LINEAR_DEPTH)
    config.bias_mode = CSM_BIAS_SLOPE;
  if (plan_config_check(&config, &unused) == CSM_SUCCESS && memcmp(&config, base, sizeof config) != 0)
    add_point(out, s->name)->config = config;
}

static void add_filters(report_sweep *out, const csm_config *base) {
  csm_config_field field = {.struct_size = sizeof field};
  for (uint32_t i = 0; csm_config_describe(i, &field) == CSM_SUCCESS; i++)
    if (strcmp(field.name, "filter") == 0)
      for (uint32_t filter = 0; field.values[filter]; filter++)
        add_setting(out, base, &(setting){.name = field.values[filter], .filter = filter});
}

int report_sweep_make_soft(report_sweep *out, const host_options *options, const host_setup *setup) {
  begin(out, options, &setup->config);
  add_filters(out, &setup->config);
  for (size_t i = 0; i < sizeof settings / sizeof settings[0]; i++)
    add_setting(out, &setup->config, &settings[i]);
  options_presets all = options->presets;
  if (all.count == 0)
    for (; all.count < OPTIONS_MAX_PRESETS && preset_name(all.count); all.count++)
      all.names[all.count] = preset_name(all.count);
  return add_presets(out, &all, setup->shadow_distance);
}
