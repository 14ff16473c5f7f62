/*
 * moment_borders.c: borders between cascades, at every level of the moments' images, on ground seen at a grazing angle.
 * Levels follow from how fast a place in the map changes from pixel to pixel. Where two neighbours take different
 * cascades, their places lie in different maps: whoever takes the difference of these gets the smallest level, and a
 * line along the border; whoever takes that of one map for another's texels gets a step.
 *
 * With fit_mode scene_square every slice begins at the camera, so that a cascade is the same whether there are others
 * or not. So each is drawn alone too, and a pixel of all together must be what its own cascade alone gives there.
 */
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>

/* LEVELS: those that the largest maps have room for. */
enum { SPLITS = 4, WIDTH = 160, HEIGHT = 90, LEVELS = 7 };

static const double splits[SPLITS] = {8.0, 16.0, 32.0, 64.0};
static const float mask_step = 1.0f / 255.0f;

/* ---- the scene ---- */

/* Slats over the whole ground: of any size, some of them are narrower than a texel of that level. */
static void make_scene(host_setup *out) {
  mesh_builder b = {0};
  hard_setup_begin(out, WIDTH, HEIGHT);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 160.0, 8);
  hard_add(out, &b, "ground", NULL);
  for (int i = -60; i < 60; i++) {
    const double from = i + 0.25 * sin(i * i), width = 0.2 + 0.5 * (i * i % 7) / 7.0;
    builder_box(&b, (const double[3]){from, 3.0, -140.0}, (const double[3]){from + width, 3.0625, 20.0});
    builder_box(&b, (const double[3]){-60.0, 5.0, from - 50.0}, (const double[3]){60.0, 5.0625, from - 50.0 + width});
  }
  hard_add(out, &b, "slats", NULL);
  hard_look(out, (const double[3]){0.0, 1.75, 0.0}, (const double[3]){9.0, 0.0, -30.0}, 60.0);
  out->light = hard_sun(55.0, 35.0);
  hard_reach(out, splits[SPLITS - 1]);
  csm_config *config = &out->config;
  config->split_mode = CSM_SPLIT_MANUAL;
  config->fit_mode = CSM_FIT_SCENE_SQUARE;
  config->depth_mode = CSM_DEPTH_SCENE;
  config->selection = CSM_SELECT_INTERVAL;
  config->blend_mode = CSM_BLEND_OFF;
  config->cascade_count = SPLITS;
  for (int i = 0; i < SPLITS; i++)
    config->split_distances[i] = splits[i];
}

/* ---- settings ---- */

typedef struct setting {
  uint32_t filter;     /* of hard_filters */
  uint32_t resolution; /* of maps: the fewer texels, the finer the level */
  uint32_t sampling, anisotropy;
  uint32_t blend_mode;
} setting;

static const char *const sampling_names[] = {"bilinear", "trilinear", "anisotropic"};

/* Cascades from `first` to `last`, of those that are there with the setting. */
static csm_config make_config(const host_setup *setup, const setting *s, uint32_t first, uint32_t last) {
  csm_config config = setup->config;
  config.cascade_count = last - first + 1;
  for (uint32_t i = first; i <= last; i++)
    config.split_distances[i - first] = splits[i];
  config.resolution = s->resolution;
  hard_filter_set(&config, &hard_filters[s->filter]);
  config.moment_levels = config.filter == CSM_FILTER_VSSM ? 8 : s->sampling ? 12 : 1;
  config.moment_sampling = s->sampling;
  config.moment_anisotropy = s->anisotropy;
  config.blend_mode = s->blend_mode;
  config.soft_radius_max_texels =
      fmin(config.soft_radius_max_texels, s->resolution / 8.0); /* small maps have no more room */
  return config;
}

/* ---- levels ---- */

/* The level at which a step to the next pixel is a texel, along the longer of the two ways; NAN next to a silhouette. */
static double level_at(const hard_truth *truth, const csm_cascade_info *cascade, uint32_t resolution, size_t i) {
  const uint32_t width = truth->view.width;
  const size_t beside[2] = {i + 1, i + width};
  camera_rays rays;
  double places[3][4], longest = 0.0;
  camera_rays_make(&rays, &truth->camera, width, truth->view.height);
  for (int k = 0; k < 3; k++) {
    const size_t at = k ? beside[k - 1] : i;
    double point[3];
    if (at >= (size_t)width * truth->view.height || truth->view.surfaces[at].triangle == TRUTH_NOTHING ||
        truth->silhouette_squares[at] < 4)
      return NAN;
    camera_point(&rays, &truth->camera, camera_pixel_x(&rays, (uint32_t)(at % width)),
                 camera_pixel_y(&rays, (uint32_t)(at / width)), truth->view.surfaces[at].view_depth, point);
    for (int axis = 0; axis < 3; axis++)
      point[axis] += truth->camera.position[axis];
    mat_transform(places[k], cascade->world_to_shadow, point, 1.0);
  }
  for (int k = 1; k < 3; k++)
    longest = fmax(longest, hypot(places[k][0] - places[0][0], places[k][1] - places[0][1]) * resolution);
  return log2(fmax(longest, 1e-9));
}

/* ---- all together, and each alone ---- */

typedef struct borders {
  host_setup setup;
  hard_truth truth;
  hard_picture together, alone[SPLITS];
  hard_picture finest; /* all together, of level 0 everywhere */
  csm_binding binding; /* of all together */
  uint32_t levels;     /* at which a fault would have been seen */
} borders;

/* The cascade of a pixel whose neighbour on the right or below takes another one; negative: there is no such border. */
static int cascade_at_border(const hard_picture *drawn, size_t i) {
  if (i + WIDTH >= (size_t)WIDTH * HEIGHT ||
      (drawn->cascades[i] == drawn->cascades[i + 1] && drawn->cascades[i] == drawn->cascades[i + WIDTH]))
    return -1;
  return (int)lrintf(drawn->cascades[i] * 255.0f) - 1;
}

/* The highest level in the middle of a map: one and a half texels of the next one fit into half of what is left. */
static double highest_level(uint32_t resolution) {
  return log2((resolution / 2.0 + 1.0) / 3.0) - 1.0;
}

/* Which levels are seen next to borders: bit n for n to n + 1. From 1 on, where level 0 gives something else by more than a
   step, so that a level that is lost there is among what is counted. */
static uint32_t levels_at_borders(const borders *b) {
  uint32_t levels = 0;
  for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
    const int cascade = cascade_at_border(&b->together, i);
    if (cascade < 0)
      continue;
    const uint32_t resolution = b->binding.resolutions[cascade];
    const double wanted = level_at(&b->truth, &b->binding.cascades[cascade], resolution, i);
    const double level = isnan(wanted) ? wanted : fmin(wanted, highest_level(resolution));
    const bool tells = fabsf(b->together.mask[i] - b->finest.mask[i]) > mask_step;
    if (level >= 0.0 && level < (tells ? 32.0 : 1.0))
      levels |= 1u << (int)level;
  }
  return levels;
}

/* Pixels next to borders at which the next cascade gives something else, so that a wrong cascade would be counted. */
static uint32_t cascades_told_at_borders(const borders *b) {
  uint32_t told = 0;
  for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
    const int cascade = cascade_at_border(&b->together, i);
    told += cascade >= 0 && cascade + 1 < SPLITS &&
            fabsf(b->alone[cascade].mask[i] - b->alone[cascade + 1].mask[i]) > mask_step;
  }
  return told;
}

/* Alone it is the same cascade, or nothing is compared. */
static double apart(const csm_cascade_info *a, const csm_cascade_info *b) {
  double largest = fabs(a->texel_size / b->texel_size - 1.0);
  for (int i = 0; i < 16; i++)
    largest = fmax(largest, fabs(a->world_to_shadow[i] - b->world_to_shadow[i]));
  return largest;
}

static int draw_alone(borders *b, hard_run *run, const setting *s, uint32_t cascade) {
  const csm_config config = make_config(&b->setup, s, cascade, cascade);
  csm_binding binding;
  int code = hard_restart(run, &config);
  if (code == 0)
    code = hard_draw(run, &b->setup.camera, &b->setup.light, 0, &b->alone[cascade]);
  if (code == 0)
    code = hard_bind(run, &binding);
  if (code == 0)
    hard_figure_add(run, apart(&binding.cascades[0], &b->binding.cascades[cascade]), 1e-12, "1",
                    "cascades that are other ones alone");
  return code;
}

/* Level 0 alone, for who samples levels. */
static int draw_finest(borders *b, hard_run *run, const setting *s) {
  setting finest = *s;
  finest.sampling = CSM_SAMPLING_BILINEAR;
  const csm_config config = make_config(&b->setup, &finest, 0, SPLITS - 1);
  const int code = hard_restart(run, &config);
  return code ? code : hard_draw(run, &b->setup.camera, &b->setup.light, 0, &b->finest);
}

/*
 * Pixels that are more than a step of a mask off what their cascade alone gives, or, where two blend, off what lies
 * between the two.
 */
static uint64_t count_wrong(const borders *b, uint32_t blend_mode) {
  uint64_t wrong = 0;
  for (size_t i = 0; i < (size_t)WIDTH * HEIGHT; i++) {
    const int cascade = (int)lrintf(b->together.cascades[i] * 255.0f) - 1;
    if (cascade < 0)
      continue;
    const float drawn = b->together.mask[i], alone = b->alone[cascade].mask[i];
    const bool two = blend_mode != CSM_BLEND_OFF && cascade + 1 < SPLITS;
    const float next = two ? b->alone[cascade + 1].mask[i] : alone;
    wrong += !(drawn >= fminf(alone, next) - mask_step && drawn <= fmaxf(alone, next) + mask_step);
  }
  return wrong;
}

static int draw_setting(borders *b, hard_run *run, const setting *s) {
  const csm_config config = make_config(&b->setup, s, 0, SPLITS - 1);
  int code = hard_restart(run, &config);
  if (code == 0)
    code = hard_draw(run, &b->setup.camera, &b->setup.light, HARD_CASCADES, &b->together);
  if (code == 0)
    code = hard_bind(run, &b->binding);
  for (uint32_t i = 0; code == 0 && i < SPLITS; i++)
    code = draw_alone(b, run, s, i);
  if (code == 0)
    code = draw_finest(b, run, s);
  if (code)
    return code;
  const uint64_t wrong = count_wrong(b, s->blend_mode);
  if (config.filter != CSM_FILTER_VSSM) /* whose levels follow from its search */
    b->levels |= levels_at_borders(b);
  hard_figure_add(run, (double)wrong, 0.0, "px", "other than the cascade alone, %s, %s", hard_filters[s->filter].name,
                  sampling_names[s->sampling]);
  hard_figure_add(run, cascades_told_at_borders(b) ? 0.0 : 1.0, 0.0, "1",
                  "borders at which all cascades give the same");
  return 0;
}

/* ---- the case ---- */

/* Each resolution has four borders, whose levels are an octave apart. The long form has every filter with each. */
static int draw_all(borders *b, hard_run *run) {
  static const uint32_t resolutions[] = {128, 64, 256, 1024, 512}, anisotropies[] = {16, 2, 8, 4};
  const uint32_t count = run->sweep ? HARD_FILTERS * 4 * 3 : 8;
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < count; i++) {
    const setting s = {.filter = run->sweep ? i % HARD_FILTERS : i % HARD_MOMENT_FILTERS,
                       .resolution = resolutions[run->sweep ? i / HARD_FILTERS % 4 : i % 5],
                       .sampling = run->sweep ? i / HARD_FILTERS / 4 : 1 + i / 2 % 2,
                       .anisotropy = anisotropies[i % 4],
                       .blend_mode = i % 3};
    code = draw_setting(b, run, &s);
  }
  return code;
}

static int run_case(hard_run *run) {
  borders b = {0};
  make_scene(&b.setup);
  int code = hard_load(run, &b.setup);
  if (code == 0)
    code = hard_cast(run, &b.setup.camera, &b.setup.light, &b.truth);
  if (code == 0)
    code = draw_all(&b, run);
  for (int level = 0; code == 0 && level < LEVELS; level++)
    hard_figure_add(run, b.levels >> level & 1 ? 0.0 : 1.0, 0.0, "1", "levels that no border was seen at: %d", level);
  hard_truth_free(&b.truth);
  hard_picture_free(&b.together);
  hard_picture_free(&b.finest);
  for (int i = 0; i < SPLITS; i++)
    hard_picture_free(&b.alone[i]);
  hard_unload(run);
  setup_free(&b.setup);
  return code;
}

const hard_case hard_moment_borders = {
    .name = "moment_borders",
    .about = "borders between cascades at every level of moments' images, on ground seen at a grazing angle",
    .run = run_case};
