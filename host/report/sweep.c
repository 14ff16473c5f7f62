#include "report/sweep.h"
#include "base/host.h"
#include "plan.h"
#include "setup/config_json.h"
#include "stage/compare.h"
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- configurations ---- */

static uint32_t count_values(const char *name) {
  csm_config_field field = {.struct_size = sizeof field};
  uint32_t count = 0;
  for (uint32_t i = 0; csm_config_describe(i, &field) == CSM_SUCCESS; i++)
    if (strcmp(field.name, name) == 0)
      for (; field.values[count]; count++)
        ;
  return count;
}

uint32_t report_filter_count(void) {
  return count_values("filter");
}

static uint32_t count_ways(void) {
  return report_filter_count() * count_values("bias_mode");
}

/*
 * The base with another filter and bias mode. False where they contradict each other, or what else the base says, or
 * where the smallest map that is swept has no room for the filter: shapes have the same ways.
 */
static bool change_way(csm_config *out, const csm_config *base, uint32_t least_resolution, uint32_t way) {
  const uint32_t bias_modes = count_values("bias_mode");
  const char *error;
  *out = *base;
  out->filter = way / bias_modes;
  out->bias_mode = way % bias_modes;
  csm_config smallest = *out;
  smallest.resolution = least_resolution < base->resolution ? least_resolution : base->resolution;
  return plan_config_check(out, &error) == CSM_SUCCESS && plan_config_check(&smallest, &error) == CSM_SUCCESS;
}

static uint32_t least_of(const options_list *list) {
  uint32_t least = list->values[0];
  for (uint32_t i = 1; i < list->count; i++)
    least = list->values[i] < least ? list->values[i] : least;
  return least;
}

static uint32_t count_sound_ways(const csm_config *base, uint32_t least_resolution) {
  csm_config unused;
  uint32_t count = 0;
  for (uint32_t way = 0; way < count_ways(); way++)
    count += change_way(&unused, base, least_resolution, way);
  return count;
}

/* A shape of maps, and the smallest there is. */
typedef struct shape {
  uint32_t cascades, resolution, least_resolution;
} shape;

static void add_shape(report_sweep *out, const csm_config *base, const shape *s) {
  for (uint32_t way = 0; way < count_ways(); way++) {
    csm_config config;
    if (!change_way(&config, base, s->least_resolution, way))
      continue;
    config.cascade_count = s->cascades;
    config.resolution = s->resolution;
    if (memcmp(&config, base, sizeof *base) == 0)
      out->base = out->count;
    out->points[out->count++].config = config;
  }
}

void report_sweep_make(report_sweep *out, const host_options *options, const csm_config *base) {
  const uint32_t shapes = options->cascades.count * options->resolutions.count + 1;
  const uint32_t least = least_of(&options->resolutions);
  bool has_base = false;
  *out = (report_sweep){.per_shape = count_sound_ways(base, least)};
  out->points = host_allocate((size_t)shapes * out->per_shape, sizeof *out->points);
  for (uint32_t c = 0; c < options->cascades.count; c++)
    for (uint32_t r = 0; r < options->resolutions.count; r++) {
      const shape s = {options->cascades.values[c], options->resolutions.values[r], least};
      has_base = has_base || (s.cascades == base->cascade_count && s.resolution == base->resolution);
      add_shape(out, base, &s);
    }
  if (!has_base)
    add_shape(out, base, &(shape){base->cascade_count, base->resolution, least});
}

void report_sweep_free(report_sweep *sweep) {
  free(sweep->points);
  *sweep = (report_sweep){0};
}

/* ---- drawing ---- */

static int time_point(report_point *point, stage *s, uint32_t backend, uint32_t round) {
  stage_stats stats;
  int code = stage_configure(s, &point->config);
  if (code == 0 && plan_has_moments(&point->config))
    code = stage_stir(s);
  if (code == 0)
    code = stage_draw(s, &stats);
  if (code)
    return code;
  const double gpu_ms = stage_shadows_ms(&stats), cpu_ms = stats.maps.plan_ms + stats.maps.record_ms;
  const double times[REPORT_TIMES] = {[REPORT_PLAN_MS] = stats.maps.plan_ms,
                                      [REPORT_RECORD_MS] = stats.maps.record_ms,
                                      [REPORT_MAPS_MS] = stage_maps_ms(&stats),
                                      [REPORT_MOMENTS_MS] = stage_moments_ms(&stats),
                                      [REPORT_MASK_MS] = stage_mask_ms(&stats),
                                      [REPORT_HISTORY_MS] = stage_history_ms(&stats),
                                      [REPORT_GPU_MS] = gpu_ms,
                                      [REPORT_SHADOW_MS] = cpu_ms + gpu_ms};
  for (int i = 0; i < REPORT_TIMES; i++)
    point->samples[backend][i][round] = times[i];
  if (backend == 0) {
    point->map_bytes = stats.maps.map_bytes;
    point->moment_bytes = stats.maps.moment_bytes + stats.maps.range_bytes;
    point->view_bytes = stats.mask.bytes;
  }
  return 0;
}

/* A mask with a history is judged once it has one. */
static int fill_history(const csm_config *config, stage *s) {
  const uint32_t frames = config->history == CSM_HISTORY_ON ? config->history_frames : 0;
  stage_stats unused;
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < frames; i++)
    code = stage_draw(s, &unused);
  return code;
}

/* Masks that are the same have the same metrics: those are not computed again. */
static int measure_point(report_point *point, const report_studio *studio) {
  stage_frame frames[HOST_BACKENDS] = {0};
  const size_t pixels = (size_t)studio->setup->width * studio->setup->height;
  uint8_t *kinds = host_allocate(pixels, 1);
  int code = 0;
  for (uint32_t b = 0; code == 0 && b < studio->stage_count; b++) {
    code = fill_history(&point->config, &studio->stages[b]);
    if (code == 0)
      code = stage_read(&studio->stages[b], false, &frames[b]);
    if (code)
      break;
    const bool same = b > 0 && memcmp(frames[0].mask, frames[b].mask, pixels * sizeof(float)) == 0 &&
                      memcmp(frames[0].view_depth, frames[b].view_depth, pixels * sizeof(float)) == 0;
    const metrics_frame frame = truth_frame_against(studio->truth, studio->setup, &frames[b]);
    if (same)
      point->metrics[b] = point->metrics[0];
    else
      code = metrics_measure(&point->metrics[b], &frame, kinds);
  }
  for (size_t i = 0; code == 0 && studio->stage_count > 1 && i < pixels; i++)
    point->differing += !(fabsf(frames[0].mask[i] - frames[1].mask[i]) <= compare_mask_tolerance);
  for (uint32_t b = 0; b < studio->stage_count; b++)
    stage_frame_free(&frames[b]);
  free(kinds);
  return code;
}

/* The base on every backend. */
static int draw_reference(const report_studio *studio, double *ms) {
  int code = 0;
  *ms = 0.0;
  for (uint32_t b = 0; code == 0 && b < studio->stage_count; b++) {
    stage_stats stats;
    code = stage_draw(&studio->references[b], &stats);
    if (code == 0)
      *ms += stats.maps.plan_ms + stats.maps.record_ms + stage_shadows_ms(&stats);
  }
  return code;
}

/* The second of two draws counts. Maps on fresh memory are slow once, and so is a program's first use; a driver that keeps some
   programs alone may have thrown this one out for those of other points. */
static int draw_shape(report_sweep *sweep, const report_studio *studio, uint32_t first, uint32_t round) {
  int code = 0;
  for (uint32_t p = first; code == 0 && p < first + sweep->per_shape; p++) {
    for (uint32_t draw = 0; code == 0 && draw < 2 * studio->stage_count; draw++)
      code = time_point(&sweep->points[p], &studio->stages[draw / 2], draw / 2, round);
    if (code == 0 && round == 0)
      code = measure_point(&sweep->points[p], studio);
  }
  return code;
}

/* ---- the sweep ---- */

static void show_progress(const report_sweep *sweep, const report_studio *studio, uint32_t point, uint32_t rounds,
                          double deadline_ms) {
  char text[200];
  snprintf(text, sizeof text, "%.60s: round %u of %u at most, configuration %u of %u; %.0f min left for it",
           studio->setup->scene.name, sweep->rounds + 1, rounds, point + 1, sweep->count,
           ceil(fmax((deadline_ms - host_now_ms()) / 60e3, 0.0)));
  host_progress(text);
}

/* The shape that the base has stays: without it there is nothing to compare with. */
static bool take_out(report_sweep *sweep, uint32_t first) {
  report_point *at = &sweep->points[first];
  if (sweep->base >= first && sweep->base < first + sweep->per_shape)
    return false;
  host_fail(0, "%s%s%u maps of %u x %u are left out", at->name ? at->name : "", at->name ? ": " : "",
            at->config.cascade_count, at->config.resolution, at->config.resolution);
  sweep->count -= sweep->per_shape;
  memmove(at, at + sweep->per_shape, (sweep->count - first) * sizeof *at);
  if (sweep->base > first)
    sweep->base -= sweep->per_shape;
  return true;
}

/* Whether the devices can hold maps of that shape: 0, or a code after a message. */
static int try_shape(const report_point *point, const report_studio *studio) {
  int code = 0;
  for (uint32_t b = 0; code == 0 && b < studio->stage_count; b++)
    code = stage_configure(&studio->stages[b], &point->config);
  return code;
}

/* A shape's reference is the mean of the one before it and the one after it. */
static int end_round(report_sweep *sweep, const report_studio *studio) {
  const uint32_t round = sweep->rounds, per_shape = sweep->per_shape;
  double last;
  const int code = draw_reference(studio, &last);
  for (uint32_t p = 0; p < sweep->count; p += per_shape) {
    const double after = p + per_shape < sweep->count ? sweep->points[p + per_shape].reference_ms[round] : last;
    sweep->points[p].reference_ms[round] = 0.5 * (sweep->points[p].reference_ms[round] + after);
  }
  sweep->rounds++;
  return code;
}

static int draw_round(report_sweep *sweep, const report_studio *studio, uint32_t rounds, double deadline_ms) {
  for (uint32_t p = 0; p < sweep->count;) {
    show_progress(sweep, studio, p, rounds, deadline_ms);
    int code = sweep->rounds == 0 ? try_shape(&sweep->points[p], studio) : 0;
    if (code == HOST_BAD_INPUT && take_out(sweep, p))
      continue;
    if (code == 0)
      code = draw_reference(studio, &sweep->points[p].reference_ms[sweep->rounds]);
    if (code == 0)
      code = draw_shape(sweep, studio, p, sweep->rounds);
    if (code)
      return code;
    p += sweep->per_shape;
  }
  return end_round(sweep, studio);
}

/* What every time is multiplied with, so that the base's stays as it is in the middle of the run. */
static void steady(report_sweep *sweep) {
  const uint32_t shapes = sweep->count / sweep->per_shape;
  double *all = host_allocate((size_t)shapes * sweep->rounds, sizeof *all);
  for (uint32_t i = 0; i < shapes * sweep->rounds; i++)
    all[i] = sweep->points[i / sweep->rounds * sweep->per_shape].reference_ms[i % sweep->rounds];
  const double median = estimate_median(all, shapes * sweep->rounds).median;
  free(all);
  for (uint32_t p = 0; p < sweep->count; p++)
    for (uint32_t round = 0; round < sweep->rounds; round++) {
      const double factor = median / sweep->points[p - p % sweep->per_shape].reference_ms[round];
      for (int b = 0; b < HOST_BACKENDS; b++)
        for (int t = 0; t < REPORT_TIMES; t++)
          sweep->points[p].samples[b][t][round] *= factor;
    }
}

int report_sweep_run(report_sweep *sweep, const report_studio *studio, uint32_t rounds, double deadline_ms) {
  double longest = 0.0, unused;
  int code = draw_reference(studio, &unused); /* warms it up */
  while (code == 0 && sweep->rounds < rounds && (sweep->rounds == 0 || host_now_ms() + longest <= deadline_ms)) {
    const double begun = host_now_ms();
    code = draw_round(sweep, studio, rounds, deadline_ms);
    longest = fmax(sweep->rounds > 1 ? longest : 0.0, host_now_ms() - begun);
  }
  host_progress("");
  if (code == 0)
    steady(sweep);
  return code;
}

int report_draw(const report_studio *studio, uint32_t backend, const csm_config *config, stage_frame *out) {
  stage *s = &studio->stages[backend];
  stage_stats stats;
  *out = (stage_frame){0};
  int code = stage_configure(s, config);
  if (code == 0)
    code = stage_draw(s, &stats);
  if (code == 0)
    code = fill_history(config, s);
  return code ? code : stage_read(s, false, out);
}

/* ---- times ---- */

estimate report_time_of(const report_sweep *sweep, uint32_t point, uint32_t backend, report_time time) {
  return estimate_median(sweep->points[point].samples[backend][time], sweep->rounds);
}

estimate report_ratio_of(const report_sweep *sweep, uint32_t point) {
  const report_point *p = &sweep->points[point];
  return estimate_ratio(p->samples[1][REPORT_SHADOW_MS], p->samples[0][REPORT_SHADOW_MS], sweep->rounds);
}

estimate report_ratio_of_all(const report_sweep *sweep) {
  const uint32_t count = sweep->count * sweep->rounds;
  double *samples[2] = {host_allocate(count, sizeof(double)), host_allocate(count, sizeof(double))};
  for (uint32_t p = 0; p < sweep->count; p++)
    for (int b = 0; b < 2; b++)
      memcpy(samples[b] + p * sweep->rounds, sweep->points[p].samples[b][REPORT_SHADOW_MS],
             sweep->rounds * sizeof(double));
  const estimate result = estimate_ratio(samples[1], samples[0], count);
  free(samples[0]);
  free(samples[1]);
  return result;
}
