/* bench_tables.c: which configurations are timed. */
#include "bench/rows.h"
#include "setup/presets.h"
#include <string.h>

static csm_config *add(bench_table *table, const char *name) {
  bench_row *row = &table->rows[table->count++];
  *row = (bench_row){.name = name, .config = table->base.config};
  return &row->config;
}

static void add_filter(bench_table *table, const char *name, uint32_t filter) {
  add(table, name)->filter = filter;
}

static void add_weights(bench_table *table, const char *name, uint32_t filter, uint32_t weights) {
  csm_config *config = add(table, name);
  config->filter = filter;
  config->filter_weights = weights;
}

static void add_early(bench_table *table, const char *name, uint32_t filter) {
  csm_config *config = add(table, name);
  config->filter = filter;
  config->filter_early_out = 1;
  config->filter_taps = 9;
}

/* The same with moments, and by the size of the light. */
static void add_soft_filters(bench_table *table) {
  add_filter(table, "vsm", CSM_FILTER_VSM);
  add_filter(table, "esm", CSM_FILTER_ESM);
  add_filter(table, "evsm2", CSM_FILTER_EVSM2);
  add_filter(table, "evsm4", CSM_FILTER_EVSM4);
  add_filter(table, "msm4", CSM_FILTER_MSM4);
  csm_config *config = add(table, "evsm4 float16");
  config->filter = CSM_FILTER_EVSM4;
  config->moment_format = CSM_MOMENTS_FLOAT16;
  config = add(table, "evsm4 trilinear");
  config->filter = CSM_FILTER_EVSM4;
  config->moment_levels = 12;
  config->moment_sampling = CSM_SAMPLING_TRILINEAR;
  config = add(table, "evsm4 anisotropic");
  *config = table->rows[table->count - 2].config;
  config->moment_sampling = CSM_SAMPLING_ANISOTROPIC;
  config = add(table, "vssm");
  config->filter = CSM_FILTER_VSSM;
  config->moment_levels = 12;
  add_filter(table, "pcss 16 + 32", CSM_FILTER_PCSS);
  config = add(table, "pcss 16 + 16");
  config->filter = CSM_FILTER_PCSS;
  config->soft_taps = 16;
  add_filter(table, "backprojection", CSM_FILTER_BACKPROJECTION);
}

void bench_table_floors(bench_table *out, const csm_config *config) {
  *out = (bench_table){.name = "floors",
                       .about = "the mask's pass alone, to one tap and to a bare pass that rebuilds positions",
                       .base = {.name = "nearest", .config = *config, .most_floors = 2.5}};
  out->base.config.filter = CSM_FILTER_NEAREST;
  out->base.config.filter_weights = CSM_WEIGHTS_UNIFORM;
  out->base.config.filter_early_out = 0;
  add_filter(out, "pcf_3x3", CSM_FILTER_PCF_3X3);
  out->rows[0].most_floors = 3.5;
  add_filter(out, "pcf_3x3, pages", CSM_FILTER_PCF_3X3);
  out->rows[1].config.map_layout = CSM_LAYOUT_PAGES;
}

void bench_table_filters(bench_table *out, const csm_config *config) {
  *out = (bench_table){.name = "filters",
                       .about = "the mask's pass alone, to one tap and to a bare pass that rebuilds positions",
                       .base = {.name = "nearest", .config = *config}};
  out->base.config.filter = CSM_FILTER_NEAREST;
  out->base.config.filter_weights = CSM_WEIGHTS_UNIFORM;
  out->base.config.filter_early_out = 0;
  csm_config *linear = add(out, "linear_depth");
  linear->filter = CSM_FILTER_LINEAR_DEPTH;
  linear->bias_mode = CSM_BIAS_SLOPE; /* one comparison has no plane to place texels on */
  add_filter(out, "pcf_2x2", CSM_FILTER_PCF_2X2);
  add_filter(out, "pcf_3x3", CSM_FILTER_PCF_3X3);
  add_filter(out, "pcf_5x5", CSM_FILTER_PCF_5X5);
  add_filter(out, "pcf_7x7", CSM_FILTER_PCF_7X7);
  add_early(out, "pcf_n 9", CSM_FILTER_PCF_N);
  out->rows[out->count - 1].config.filter_early_out = 0;
  add_early(out, "pcf_5x5 early", CSM_FILTER_PCF_5X5);
  add_early(out, "pcf_7x7 early", CSM_FILTER_PCF_7X7);
  add_early(out, "pcf_n 9 early", CSM_FILTER_PCF_N);
  add_filter(out, "poisson", CSM_FILTER_POISSON);
  add_filter(out, "vogel 16", CSM_FILTER_VOGEL);
  out->rows[out->count - 1].config.filter_taps = 16;
  add_filter(out, "grid_17", CSM_FILTER_GRID_17);
  add_weights(out, "pcf_3x3 gaussian", CSM_FILTER_PCF_3X3, CSM_WEIGHTS_GAUSSIAN);
  add_weights(out, "pcf_5x5 castano", CSM_FILTER_PCF_5X5, CSM_WEIGHTS_CASTANO);
  add_weights(out, "pcf_7x7 gaussian", CSM_FILTER_PCF_7X7, CSM_WEIGHTS_GAUSSIAN);
  csm_config *slope = add(out, "pcf_7x7 slope");
  slope->filter = CSM_FILTER_PCF_7X7;
  slope->bias_mode = CSM_BIAS_SLOPE;
  add_soft_filters(out);
}

void bench_table_modes(bench_table *out, const csm_config *config) {
  *out = (bench_table){.name = "modes",
                       .about = "the mask's pass with what else it may do, to the configuration without",
                       .base = {.name = "base", .config = *config}};
  csm_config *base = &out->base.config;
  base->depth_samples = CSM_DEPTH_SAMPLES_OFF;
  base->selection = CSM_SELECT_INTERVAL;
  base->blend_mode = CSM_BLEND_OFF;
  base->history = CSM_HISTORY_OFF;
  add(out, "samples splits")->depth_samples = CSM_DEPTH_SAMPLES_SPLITS;
  add(out, "samples bounds")->depth_samples = CSM_DEPTH_SAMPLES_BOUNDS;
  add(out, "selection map")->selection = CSM_SELECT_MAP;
  add(out, "selection best")->selection = CSM_SELECT_BEST;
  add(out, "blend linear")->blend_mode = CSM_BLEND_LINEAR;
  add(out, "blend dithered")->blend_mode = CSM_BLEND_DITHERED;
  csm_config *both = add(out, "map, blend linear");
  both->selection = CSM_SELECT_MAP;
  both->blend_mode = CSM_BLEND_LINEAR;
  both = add(out, "map, blend dithered");
  both->selection = CSM_SELECT_MAP;
  both->blend_mode = CSM_BLEND_DITHERED;
  add(out, "history")->history = CSM_HISTORY_ON;
}

static void add_fits(bench_table *out) {
  static const char *const fits[] = {"fit minimum_sphere", "fit centroid_sphere", "fit cascade",
                                     "fit cascade_square", "fit scene",           "fit scene_square"};
  static const char *const depths[] = {"depth casters", "depth slice", "depth scene", "depth scene_clipped"};
  for (uint32_t mode = CSM_FIT_CENTROID_SPHERE; mode <= CSM_FIT_SCENE_SQUARE; mode++)
    add(out, fits[mode])->fit_mode = mode;
  for (uint32_t mode = CSM_DEPTH_SLICE; mode <= CSM_DEPTH_SCENE_CLIPPED; mode++)
    add(out, depths[mode])->depth_mode = mode;
}

void bench_table_maps(bench_table *out, const csm_config *config) {
  *out = (bench_table){.name = "maps",
                       .about = "clear and all cascades, to the configuration as it is and to a bare loop",
                       .timed = BENCH_MAPS,
                       .base = {.name = "base", .config = *config}};
  csm_config *base = &out->base.config;
  base->map_layout = CSM_LAYOUT_ARRAY;
  base->map_format = CSM_MAP_D32;
  base->map_reversed = 0;
  base->face_culling = CSM_FACE_CULLING_NONE;
  base->fit_mode = CSM_FIT_MINIMUM_SPHERE;
  base->depth_mode = CSM_DEPTH_CASTERS;
  base->pancaking = CSM_PANCAKING_CLAMP;
  add(out, "atlas")->map_layout = CSM_LAYOUT_ATLAS;
  add(out, "d16")->map_format = CSM_MAP_D16;
  add(out, "reversed")->map_reversed = 1;
  add(out, "cull back")->face_culling = CSM_FACE_CULLING_BACK;
  add(out, "cull front")->face_culling = CSM_FACE_CULLING_FRONT;
  csm_config *raster = add(out, "raster bias");
  raster->polygon_offset_constant = 2.0;
  raster->polygon_offset_slope = 1.5;
  csm_config *sides = add(out, "resolutions halved");
  for (uint32_t i = 1; i < sides->cascade_count; i++)
    sides->resolutions[i] = sides->resolution >= 32 ? sides->resolution / 2 : sides->resolution;
  csm_config *clip = add(out, "pancaking clip");
  clip->pancaking = CSM_PANCAKING_CLIP;
  add_fits(out);
}

void bench_table_casters(bench_table *out, const csm_config *config, const char *scene) {
  *out = (bench_table){.name = "casters",
                       .about = "planning and drawing all cascades, to those of all that casts into the maps",
                       .timed = BENCH_PLANNED,
                       .base = {.name = "map", .config = *config}};
  out->base.config.caster_set = CSM_CASTER_SET_MAP;
  add(out, "view")->caster_set = CSM_CASTER_SET_VIEW;
  out->rows[0].most_bases = strcmp(scene, "valley") == 0 ? 0.6 : strcmp(scene, "town") == 0 ? 0.55 : 0.0;
  add(out, "view, by this frame's depth")->caster_set = CSM_CASTER_SET_VIEW;
  out->rows[1].most_bases = strcmp(scene, "valley") == 0 ? 0.55 : strcmp(scene, "town") == 0 ? 0.35 : 0.0;
  out->rows[1].depth = true;
}

void bench_moments_config(csm_config *config, uint32_t filter, uint32_t radius) {
  config->cascade_count = 4;
  config->resolution = 1024;
  config->filter = filter;
  config->moment_blur_texels = radius;
  config->moment_levels = 1;
  config->moment_sampling = CSM_SAMPLING_BILINEAR;
}

static csm_config *add_moments(bench_table *table, const char *name, uint32_t filter, uint32_t radius) {
  csm_config *config = add(table, name);
  bench_moments_config(config, filter, radius);
  return config;
}

void bench_table_moments(bench_table *out, const csm_config *config) {
  *out = (bench_table){.name = "moments",
                       .about = "moments of 4 maps of 1024 x 1024, made and blurred, to all maps of the configuration",
                       .timed = BENCH_MOMENTS,
                       .base = {.name = "maps", .config = *config}};
  add_moments(out, "evsm4, radius 3", CSM_FILTER_EVSM4, 3);
  add_moments(out, "evsm4, no blur", CSM_FILTER_EVSM4, 0);
  add_moments(out, "evsm4, radius 3, half", CSM_FILTER_EVSM4, 3)->moment_format = CSM_MOMENTS_FLOAT16;
  add_moments(out, "evsm4, radius 3, halved", CSM_FILTER_EVSM4, 3)->moment_halved = 1;
  add_moments(out, "evsm4, radius 3, seen", CSM_FILTER_EVSM4, 3)->caster_set = CSM_CASTER_SET_VIEW;
  add_moments(out, "evsm4, radius 3, 6 levels", CSM_FILTER_EVSM4, 3)->moment_levels = 6;
  add_moments(out, "evsm4, radius 8", CSM_FILTER_EVSM4, 8);
  add_moments(out, "evsm4, radius 32", CSM_FILTER_EVSM4, 32);
  add_moments(out, "vsm, radius 3", CSM_FILTER_VSM, 3);
  add_moments(out, "esm, radius 3", CSM_FILTER_ESM, 3);
  add_moments(out, "evsm2, radius 3", CSM_FILTER_EVSM2, 3);
  add_moments(out, "msm4, radius 3", CSM_FILTER_MSM4, 3);
}

/* What exact shadows are to take of the default's time at most: the mask; with an engine's normals; maps and mask; the same
 * with small maps. */
typedef struct ray_limits {
  const char *scene;
  double mask, normals, frame, small_frame;
} ray_limits;

static ray_limits limits_of(const char *scene) {
  static const ray_limits known[] = {{"valley", 5.0, 3.5, 1.4, 1.1}, {"town", 1.7, 1.4, 1.1, 1.1}};
  for (size_t i = 0; i < sizeof known / sizeof *known; i++)
    if (strcmp(known[i].scene, scene) == 0)
      return known[i];
  return (ray_limits){0};
}

void bench_exact(csm_config *config) {
  csm_config preset;
  preset_config(&preset, "exact", config->shadow_distance);
  config->filter = preset.filter;
  config->bias_constant_texels = preset.bias_constant_texels;
}

double bench_most_with_normals(const char *scene) {
  return limits_of(scene).normals;
}

static void add_exact(bench_table *out) {
  out->base.config.filter = CSM_FILTER_PCF_3X3;
  bench_exact(add(out, "exact"));
  csm_config *small = add(out, "exact, maps of 1024");
  bench_exact(small);
  small->resolution = 1024;
  memset(small->resolutions, 0, sizeof small->resolutions);
}

void bench_table_ray_masks(bench_table *out, const csm_config *config, const char *scene) {
  *out = (bench_table){.name = "masks of rays",
                       .about = "the mask's passes, rays among them, to the mask without",
                       .base = {.name = "pcf_3x3", .config = *config}};
  add_exact(out);
  out->rows[0].most_bases = limits_of(scene).mask;
}

void bench_table_ray_frames(bench_table *out, const csm_config *config, const char *scene) {
  *out = (bench_table){.name = "frames of rays",
                       .about = "maps and mask, rays among them, to those without",
                       .timed = BENCH_FRAME,
                       .base = {.name = "pcf_3x3", .config = *config}};
  add_exact(out);
  out->rows[0].most_bases = limits_of(scene).frame;
  out->rows[1].most_bases = limits_of(scene).small_frame;
}
