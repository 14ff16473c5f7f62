/*
 * settings.c: every field of the configuration at its ends, and all at random, drawn: numbers in every map and mask, and
 * the same ones from both backends. Most of these settings draw nothing that is of use; whether shadows are right is
 * other cases' to tell. Fields come from csm_config_describe, so that one that is added is looked at, too.
 */
#include "base/host.h"
#include "hard/hard.h"
#include "stage/compare.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Texels of all maps together: 16 MiB of them on each backend, or, of 16 bits, 512 MiB. */
static const double most_texels = 0x1p22, most_texels_of_sweep = 0x1p28;

typedef struct tally {
  uint32_t drawn, refused, too_large;
  csm_config *configs; /* that were drawn */
  size_t capacity;     /* of these */
} tally;

/* ---- one configuration ---- */

static double count_texels(const csm_config *config) {
  double sum = 0.0, largest = 0.0;
  for (uint32_t k = 0; k < config->cascade_count; k++) {
    const double side = config->resolutions[k] ? config->resolutions[k] : config->resolution;
    largest = fmax(largest, side * side);
    sum += side * side;
  }
  return config->map_layout == CSM_LAYOUT_ARRAY ? largest * config->cascade_count : 2.0 * sum;
}

static uint64_t count_odd(const float *values, size_t count) {
  uint64_t odd = 0;
  for (size_t i = 0; i < count; i++)
    odd += !(values[i] >= 0.0f && values[i] <= 1.0f);
  return odd;
}

/* Depths and visibilities are from 0 to 1, and none is no number. */
static void count_numbers(hard_run *run, const stage_frame *frame) {
  const size_t pixels = (size_t)run->setup->width * run->setup->height;
  uint64_t odd = 0;
  for (uint32_t k = 0; k < frame->binding.cascade_count; k++)
    odd += count_odd(frame->maps[k], stage_map_texels(frame, k));
  hard_figure_add(run, (double)odd, 0.0, "texels", "no depth in a map");
  hard_figure_add(run, (double)count_odd(frame->mask, pixels), 0.0, "px", "no visibility in a mask");
}

static void compare_sides(hard_run *run, const stage_frame *frames) {
  agreement result;
  uint64_t depths = 0;
  compare_frames(&result, &run->stages[0], &frames[0], &run->stages[1], &frames[1]);
  for (uint32_t k = 0; k < result.cascade_count; k++)
    depths += result.maps[k].max_ulp > result.allowed_ulp ? result.maps[k].differing : 0;
  hard_figure_add(run, result.plans_equal ? 0.0 : 1.0, 0.0, "1", "plans that backends differ in");
  hard_figure_add(run, (double)depths, 0.0, "texels", "depths that backends differ in");
  hard_figure_add(run, (double)result.mask_beyond / (double)result.mask_pixels, compare_mask_share, "1",
                  "mask pixels that backends differ in");
}

/* A frame after another one, whose sun stood elsewhere. */
static int draw_frames(hard_run *run, stage *s, stage_frame *out) {
  scene_light earlier = run->setup->light;
  earlier.direction[0] += 0.01;
  stage_stats stats;
  int code = stage_draw_from(s, &run->setup->camera, &earlier);
  if (code == 0)
    code = stage_draw_from(s, &run->setup->camera, &run->setup->light);
  if (code == 0)
    code = stage_draw(s, &stats);
  return code ? code : stage_read(s, true, out);
}

static bool is_taken(const csm_config *config) {
  uint64_t size = 0;
  return csm_shader_defines(config, NULL, &size) == CSM_SUCCESS;
}

/* An end of many a field is its default: the same settings are drawn once. */
static bool was_drawn(const tally *tally, const csm_config *config) {
  for (uint32_t i = 0; i < tally->drawn; i++)
    if (memcmp(&tally->configs[i], config, sizeof *config) == 0)
      return true;
  return false;
}

static void note_drawn(tally *tally, const csm_config *config) {
  tally->configs = host_grow(tally->configs, &tally->capacity, tally->drawn + 1, sizeof *config);
  tally->configs[tally->drawn++] = *config;
}

/* What csm refuses for a contradiction is left out: every refusal by name is a test of its own. */
static int draw_settings(hard_run *run, const csm_config *config, tally *tally) {
  if (was_drawn(tally, config))
    return 0;
  if (!is_taken(config)) {
    tally->refused++;
    return 0;
  }
  if (count_texels(config) > (run->sweep ? most_texels_of_sweep : most_texels)) {
    tally->too_large++;
    return 0;
  }
  stage_frame *frames = host_allocate(HOST_BACKENDS, sizeof *frames);
  note_drawn(tally, config);
  int code = hard_restart(run, config);
  for (uint32_t i = 0; code == 0 && i < run->stage_count; i++) {
    code = draw_frames(run, &run->stages[i], &frames[i]);
    if (code == 0)
      count_numbers(run, &frames[i]);
  }
  if (code == 0 && run->stage_count == 2)
    compare_sides(run, frames);
  for (uint32_t i = 0; i < run->stage_count; i++)
    stage_frame_free(&frames[i]);
  free(frames);
  return code;
}

/* ---- values ---- */

static bool is_double(const csm_config_field *field) {
  return field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES;
}

static void set(csm_config *config, const csm_config_field *field, uint32_t element, double value) {
  char *at = (char *)config + field->offset;
  if (is_double(field))
    memcpy(at + element * sizeof value, &value, sizeof value);
  else
    memcpy(at + element * sizeof(uint32_t), &(uint32_t){(uint32_t)value}, sizeof(uint32_t));
}

/* Between the ends, of every order of magnitude that there is. */
static double between(const csm_config_field *field, double share) {
  const double low = field->minimum, high = field->maximum;
  if (!is_double(field) && field->maximum < 100.0)
    return low + floor(share * (high - low + 1.0));
  return low > 0.0 ? low * pow(high / low, share) : low + (high - low) * pow(share, 8.0);
}

static double choose(const csm_config_field *field, double kind, double share) {
  if (field->type != CSM_FIELD_ENUM && kind < 0.4)
    return field->default_value;
  if (kind < 0.6)
    return kind < 0.5 ? field->minimum : field->maximum;
  return between(field, share);
}

/* Distances rise, and maps stay small: the largest are drawn at the ends. */
static csm_config any_settings(const csm_config *plain, uint32_t seed) {
  csm_config config = *plain;
  csm_config_field field = {.struct_size = sizeof field};
  for (uint32_t i = 0; csm_config_describe(i, &field) == CSM_SUCCESS; i++)
    for (uint32_t k = 0; k < field.length; k++)
      set(&config, &field, k, choose(&field, noise_hash(seed, i, 1), noise_hash(seed, i, k + 2)));
  config.resolution = 16 + (uint32_t)(240.0 * noise_hash(seed, 98, 1));
  for (uint32_t k = 0; k < CSM_MAX_CASCADES; k++) {
    const double share = noise_hash(seed, 99, k), last = k ? config.split_distances[k - 1] : 0.0;
    config.resolutions[k] = share < 0.5 ? 0 : 16 + (uint32_t)(300.0 * share);
    config.split_distances[k] = config.split_mode == CSM_SPLIT_FRACTIONS ? last + (1.0 - last) * (0.1 + 0.8 * share)
                                                                         : last + 40.0 * share + 1e-3;
  }
  return config;
}

/* Some that do not contradict themselves, if a few tries find such. */
static csm_config random_settings(const csm_config *plain, uint32_t seed) {
  const uint32_t tries = 32;
  csm_config config = any_settings(plain, seed * tries);
  for (uint32_t i = 1; i < tries && !is_taken(&config); i++)
    config = any_settings(plain, seed * tries + i);
  return config;
}

/* ---- the case ---- */

static bool begins_with(const char *text, const char *begin) {
  return strncmp(text, begin, strlen(begin)) == 0;
}

/* A filter that reads the field, in turns if there are several. */
static void set_reader(csm_config *config, const csm_config_field *field, uint32_t turn) {
  const bool moments = begins_with(field->name, "moment_") || begins_with(field->name, "bleeding_");
  static const uint32_t of_moments[] = {CSM_FILTER_EVSM4, CSM_FILTER_VSM, CSM_FILTER_MSM4, CSM_FILTER_VSM};
  static const uint32_t of_light[] = {CSM_FILTER_PCSS, CSM_FILTER_VSSM, CSM_FILTER_BACKPROJECTION, CSM_FILTER_PCSS};
  if (moments)
    config->filter = of_moments[turn % 4];
  else if (begins_with(field->name, "ray_"))
    config->filter = turn % 2 ? CSM_FILTER_EXACT : CSM_FILTER_EXACT_SOFT;
  else if (begins_with(field->name, "soft_"))
    config->filter = of_light[turn % 4];
  if (moments || config->filter == CSM_FILTER_VSSM)
    config->moment_levels = 4;
  if (begins_with(field->name, "history"))
    config->history = CSM_HISTORY_ON;
}

static int draw_ends(hard_run *run, tally *tally) {
  csm_config_field field = {.struct_size = sizeof field};
  int code = 0;
  for (uint32_t i = 0; code == 0 && csm_config_describe(i, &field) == CSM_SUCCESS; i++)
    for (uint32_t end = 0; code == 0 && end < 2; end++) {
      csm_config config = run->setup->config;
      set_reader(&config, &field, 2 * (i % 2) + end);
      for (uint32_t k = 0; k < field.length; k++)
        set(&config, &field, k, end ? field.maximum : field.minimum);
      if (count_texels(&config) > most_texels_of_sweep) { /* reading takes as much again */
        config.cascade_count = 1;
        config.map_format = CSM_MAP_D16;
      }
      code = draw_settings(run, &config, tally);
    }
  return code;
}

/* Every enumerator is an end of its own. */
static int draw_enumerators(hard_run *run, tally *tally) {
  csm_config_field field = {.struct_size = sizeof field};
  int code = 0;
  for (uint32_t i = 0; code == 0 && csm_config_describe(i, &field) == CSM_SUCCESS; i++)
    for (uint32_t value = 1; code == 0 && field.type == CSM_FIELD_ENUM && value < (uint32_t)field.maximum; value++) {
      csm_config config = run->setup->config;
      set(&config, &field, 0, value);
      code = draw_settings(run, &config, tally);
    }
  return code;
}

/* The short form leaves the enumerators between to the test `table`. */
static int draw_all(hard_run *run, tally *tally) {
  const uint32_t count = run->sweep ? 1500 : 12;
  int code = draw_ends(run, tally);
  if (code == 0 && run->sweep)
    code = draw_enumerators(run, tally);
  for (uint32_t seed = 0; code == 0 && seed < count; seed++) {
    const csm_config config = random_settings(&run->setup->config, seed);
    code = draw_settings(run, &config, tally);
  }
  return code;
}

static int run_case(hard_run *run) {
  host_setup setup;
  tally tally = {0};
  hard_setup_begin(&setup, 64, 36);
  hard_yard(&setup, true);
  setup.config.resolution = 128;
  int code = hard_load(run, &setup);
  if (code == 0)
    code = draw_all(run, &tally);
  hard_figure_add(run, tally.drawn, INFINITY, "1", "configurations drawn");
  hard_figure_add(run, tally.too_large, INFINITY, "1", "left out: maps too large for this machine");
  /* A field's end may contradict the default of another one; each field has at least an end that does not. */
  hard_figure_add(run, tally.refused, tally.drawn, "1", "configurations that contradict themselves");
  free(tally.configs);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_settings = {
    .name = "settings", .about = "every field of the configuration at its ends, and all at random", .run = run_case};
