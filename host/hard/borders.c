/*
 * borders.c: where one cascade ends and the next begins, and where the last one ends, for filters, biases, blends,
 * selections and layouts. On a bare plane all is lit, under a thick lid all is dark: a seam, or a texel of another map,
 * would show in one of the two.
 */
#include "hard/hard.h"
#include <math.h>

enum { FILTERS = 10, BIASES = 4, BLENDS = 3, SELECTIONS = 3, LAYOUTS = 3, ENDS = 3, SPLITS = 4 };

static const double splits[SPLITS] = {8.0, 16.0, 32.0, 64.0};

/* ---- settings ---- */

/* One of each, by numbers that are taken modulo how many there are. */
typedef struct borders_setting {
  uint32_t filter, bias, blend, selection, layout, end; /* from FILTERS on a filter is one of hard_filters */
  bool wide; /* filters, offsets, bands and grids as large as they may be, with texels for them */
} borders_setting;

/* Pages keep none. */
static bool reads_moments(const csm_config *config) {
  return (config->filter >= CSM_FILTER_VSM && config->filter <= CSM_FILTER_MSM4) || config->filter == CSM_FILTER_VSSM;
}

static csm_config make_config(const csm_config *from, borders_setting s) {
  csm_config config = *from;
  config.cascade_count = SPLITS;
  config.split_mode = CSM_SPLIT_MANUAL;
  for (int i = 0; i < SPLITS; i++) {
    config.split_distances[i] = splits[i];
    config.resolutions[i] = s.layout == CSM_LAYOUT_ATLAS ? 128 - 16 * (uint32_t)i : 128;
  }
  if (s.filter < FILTERS)
    config.filter = s.filter;
  else
    hard_filter_set(&config, &hard_filters[s.filter - FILTERS]);
  config.filter_taps = config.filter == CSM_FILTER_VOGEL ? 16 : 9;
  config.filter_radius_texels = 3.0;
  /* One comparison has no texels to place a plane under. */
  config.bias_mode = config.filter == CSM_FILTER_LINEAR_DEPTH ? CSM_BIAS_SLOPE : s.bias % 2;
  config.bias_normal_texels = s.bias % BIASES / 2 * 1.5;
  config.blend_mode = s.blend % BLENDS;
  config.selection = s.selection % SELECTIONS;
  config.map_layout = s.layout % LAYOUTS;
  if (config.map_layout == CSM_LAYOUT_PAGES && reads_moments(&config))
    config.map_layout = CSM_LAYOUT_ARRAY;
  config.out_of_range = s.end % ENDS;
  config.fade_share = 0.25;
  if (s.wide) {
    for (int i = 0; i < SPLITS; i++)
      config.resolutions[i] *= 4;
    config.filter_taps = config.filter == CSM_FILTER_VOGEL ? 64 : 31;
    config.filter_radius_texels = 16.0;
    config.bias_normal_texels *= 2.5;
    config.blend_share = 1.0;
    config.snap_mode = CSM_SNAP_FLOOR;
    config.snap_power = config.map_layout == CSM_LAYOUT_PAGES ? 0 : 4;
  }
  return config;
}

/* ---- what must be seen ---- */

/*
 * Pixels of the ground that are neither lit nor dark as they must be. Past the end of shadows they are what
 * out_of_range says. A depth in floats does not tell on which side of the end a point lies that is there to a millionth,
 * and shadows that fade do so from a share before the end on.
 */
static uint64_t count_wrong(const hard_truth *truth, const float *mask, const csm_config *config, bool lid) {
  const double end = splits[SPLITS - 1];
  const double fades = config->out_of_range == CSM_OUT_OF_RANGE_FADED && lid ? end * (1.0 - config->fade_share) : end;
  uint64_t wrong = 0;
  for (size_t i = 0; i < (size_t)truth->view.width * truth->view.height; i++) {
    const truth_surface *surface = &truth->view.surfaces[i];
    if (surface->triangle == TRUTH_NOTHING || !(truth_facing(surface, &truth->light) > 0.0))
      continue;
    if (surface->view_depth > fades * (1.0 - 1e-6) && surface->view_depth < end * (1.0 + 1e-6))
      continue;
    const bool past = surface->view_depth > end;
    const float right = (past ? config->out_of_range == CSM_OUT_OF_RANGE_DARK : lid) ? 0.0f : 1.0f;
    wrong += !(fabsf(mask[i] - right) <= 1.0f / 255.0f);
  }
  return wrong;
}

/* ---- scenes ---- */

/* From above, straight down: the whole ground lies at one view depth. */
static void look_down(host_setup *setup, double height) {
  hard_look(setup, (const double[3]){0.0, height, 0.0}, (const double[3]){0.0, height - 1.0, 0.0}, 50.0);
}

static void make_scene(host_setup *out, bool lid) {
  mesh_builder b = {0};
  hard_setup_begin(out, 96, 54);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 200.0, 8);
  hard_add(out, &b, "ground", NULL);
  if (lid) {
    builder_box(&b, (const double[3]){-400.0, 200.0, -400.0}, (const double[3]){400.0, 208.0, 400.0});
    hard_add(out, &b, "lid", NULL);
  }
  out->light = hard_sun(50.0, 25.0);
  hard_reach(out, splits[SPLITS - 1]);
}

/* Eye level, so that all borders are seen at once; then each split, and both sides of the end, all over the picture. */
typedef enum view_kind {
  VIEW_EYE,
  VIEW_SPLIT,
  VIEW_BEFORE_END = VIEW_SPLIT + SPLITS - 1,
  VIEW_PAST_END,
  VIEWS
} view_kind;

static void make_view(host_setup *setup, int view) {
  const double end = splits[SPLITS - 1];
  if (view == VIEW_EYE)
    hard_look(setup, (const double[3]){0.0, 1.75, 0.0}, (const double[3]){8.0, 0.0, 3.0}, 60.0);
  else if (view < VIEW_BEFORE_END)
    look_down(setup, splits[view - VIEW_SPLIT]);
  else
    look_down(setup, view == VIEW_BEFORE_END ? end * (1.0 - 1e-5) : end * (1.0 + 1e-5));
}

static const char *view_name(int view) {
  return view == VIEW_EYE ? "at eye level" : view < VIEW_BEFORE_END ? "at a split's very depth" : "at the end";
}

typedef struct borders_scene {
  bool lid;
  host_setup setup;
  camera cameras[VIEWS];
  hard_truth truths[VIEWS];
} borders_scene;

static int open_scene(borders_scene *out, hard_run *run, bool lid) {
  int code;
  *out = (borders_scene){.lid = lid};
  make_scene(&out->setup, lid);
  code = hard_load(run, &out->setup);
  for (int i = 0; code == 0 && i < VIEWS; i++) {
    make_view(&out->setup, i);
    out->cameras[i] = out->setup.camera;
    code = hard_cast(run, &out->cameras[i], &out->setup.light, &out->truths[i]);
  }
  return code;
}

static void close_scene(hard_run *run, borders_scene *scene) {
  for (int i = 0; i < VIEWS; i++)
    hard_truth_free(&scene->truths[i]);
  hard_unload(run);
  setup_free(&scene->setup);
}

/* The short form looks at one split and one side of the end, in turn. */
static bool is_looked_at(const hard_run *run, int view, uint32_t turn) {
  if (run->sweep || view == VIEW_EYE)
    return true;
  return view < VIEW_BEFORE_END ? (uint32_t)(view - VIEW_SPLIT) == turn % (SPLITS - 1)
                                : (uint32_t)(view - VIEW_BEFORE_END) == turn / ENDS % 2;
}

static int draw_setting(hard_run *run, const borders_scene *scene, borders_setting setting, uint32_t turn) {
  const csm_config config = make_config(&scene->setup.config, setting);
  hard_picture drawn = {0};
  int code = hard_restart(run, &config);
  for (int i = 0; code == 0 && i < VIEWS; i++) {
    if (!is_looked_at(run, i, turn))
      continue;
    code = hard_draw(run, &scene->cameras[i], &scene->setup.light, 0, &drawn);
    if (code)
      break;
    /* The one plane and the one lid leave nothing to chance. */
    hard_figure_add(run, (double)count_wrong(&scene->truths[i], drawn.mask, &config, scene->lid), 0.0, "px",
                    "wrong pixels %s, %s", scene->lid ? "under a lid" : "on a lit plane", view_name(i));
    hard_judge(run, &scene->truths[i], drawn.mask, (hard_margin){.edge_px = 0.0});
  }
  hard_picture_free(&drawn);
  return code;
}

/*
 * All of them, or each filter with each selection, and of the rest some that go round. Filters on moments and soft ones
 * take only some of the selections then.
 */
static int draw_settings(hard_run *run, const borders_scene *scene) {
  const uint32_t filters = run->sweep ? FILTERS + HARD_FILTERS : FILTERS, rest = BIASES * BLENDS * LAYOUTS;
  const uint32_t pairs = filters * SELECTIONS, short_count = pairs + HARD_FILTERS;
  const uint32_t count = run->sweep ? pairs * rest : short_count;
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < count; i++) {
    const uint32_t pair = run->sweep ? i % pairs : i;
    const uint32_t other = run->sweep ? i / pairs : 7 * pair + pair / FILTERS;
    code = draw_setting(run, scene,
                        (borders_setting){.filter = pair < pairs ? pair % filters : FILTERS + pair - pairs,
                                          .selection = pair < pairs ? pair / filters : pair % SELECTIONS,
                                          .bias = other % BIASES,
                                          .blend = other / BIASES % BLENDS,
                                          .layout = other / (BIASES * BLENDS) % LAYOUTS,
                                          .end = i % ENDS,
                                          .wide = run->sweep && i / 7 % 2},
                        i);
  }
  return code;
}

static int run_case(hard_run *run) {
  int code = 0;
  for (int lid = 0; code == 0 && lid < 2; lid++) {
    borders_scene scene;
    code = open_scene(&scene, run, lid);
    if (code == 0)
      code = draw_settings(run, &scene);
    close_scene(run, &scene);
  }
  return code;
}

const hard_case hard_borders = {
    .name = "borders",
    .about = "where cascades end, for filters, biases, blends, selections and layouts, on a plane and under a lid",
    .run = run_case};
