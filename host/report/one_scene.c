#include "report/one_scene.h"
#include "base/host.h"
#include "measure/error_picture.h"
#include "report/page_picture.h"
#include "stage/compare.h"
#include <math.h>
#include <stdlib.h>

#define PICTURE_WIDTH 640u

/* ---- judging ---- */

bool report_scene_is_soft(const report_scene *s) {
  return s->setup.light.disc_deg > 0.0;
}

double report_error(const report_scene *s, const metrics *m) {
  return report_scene_is_soft(s) ? m->rmse : m->false_lit + m->false_shadow;
}

double report_noise(const report_scene *s) {
  const truth_convergence *c = &s->truth.convergence;
  const double pixels = (double)s->sweep.points[s->sweep.base].metrics[0].pixels;
  return c->samples > 1 ? c->rms_half * sqrt((double)c->pixels / pixels) : 0.0;
}

/* What no picture of that many pixels can tell from zero. */
static double least_error(const report_scene *s, const metrics *m) {
  return report_scene_is_soft(s) ? 1e-6 : 0.5 / (double)m->pixels;
}

static void judge(report_scene *s) {
  const report_time time = report_scene_is_soft(s) ? REPORT_GPU_MS : REPORT_SHADOW_MS;
  for (uint32_t b = 0; b < s->stage_count; b++) {
    s->scores[b] = host_allocate(s->sweep.count, sizeof *s->scores[b]);
    for (uint32_t p = 0; p < s->sweep.count; p++) {
      const metrics *m = &s->sweep.points[p].metrics[b];
      s->scores[b][p] = (report_score){.ms = report_time_of(&s->sweep, p, b, time),
                                       .error = fmax(report_error(s, m), least_error(s, m))};
    }
    report_judge(&s->verdicts[b], s->scores[b], s->sweep.count, s->sweep.base);
  }
}

bool report_scene_differs(const report_scene *s) {
  const double pixels = (double)s->setup.width * s->setup.height;
  for (uint32_t p = 0; p < s->sweep.count; p++)
    if ((double)s->sweep.points[p].differing > compare_mask_share * pixels)
      return true;
  return false;
}

/* ---- pictures ---- */

/* Takes the picture over. */
static char *small_uri(image *picture, const uint8_t *rank) {
  image small;
  report_picture_shrink(&small, picture, rank, PICTURE_WIDTH);
  image_free(picture);
  char *uri = report_picture_uri(&small);
  image_free(&small);
  return uri;
}

/* A chosen configuration, drawn again and measured. */
typedef struct redrawn {
  stage_frame drawn;
  metrics_frame frame;
  uint8_t *kinds;
} redrawn;

/* 0, or a code after a message; redrawn_free is allowed in both cases. */
static int draw_again(redrawn *out, const report_scene *s, const report_studio *studio, uint32_t point) {
  metrics unused;
  *out = (redrawn){.kinds = host_allocate((size_t)s->setup.width * s->setup.height, 1)};
  const int code = report_draw(studio, 0, &s->sweep.points[point].config, &out->drawn);
  out->frame = truth_frame_against(&s->truth, &s->setup, &out->drawn);
  return code ? code : metrics_measure(&unused, &out->frame, out->kinds);
}

static void redrawn_free(redrawn *r) {
  stage_frame_free(&r->drawn);
  free(r->kinds);
}

static int take_picture(report_scene *s, const report_studio *studio, uint32_t point) {
  report_picture *out = &s->pictures[s->picture_count++];
  redrawn r;
  image picture;
  out->point = point;
  int code = draw_again(&r, s, studio, point);
  if (code == 0) {
    measure_picture_lit(&picture, &s->truth.view, &s->setup.light, r.drawn.mask);
    out->drawn = small_uri(&picture, NULL);
    measure_picture_errors(&picture, &r.frame, r.kinds);
    out->errors = small_uri(&picture, r.kinds);
    code = out->drawn && out->errors ? 0 : HOST_BAD_INPUT;
  }
  redrawn_free(&r);
  return code;
}

/* The filter's point with the least error; the sweep's count if it has none. */
static uint32_t best_of_filter(const report_scene *s, uint32_t filter) {
  uint32_t best = s->sweep.count;
  for (uint32_t p = 0; p < s->sweep.count; p++)
    if (s->sweep.points[p].config.filter == filter &&
        (best == s->sweep.count || s->scores[0][p].error < s->scores[0][best].error))
      best = p;
  return best;
}

static int take_technique(report_scene *s, const report_studio *studio, uint32_t point) {
  report_technique *out = &s->techniques[s->technique_count++];
  redrawn r;
  image strip, small;
  out->point = point;
  int code = draw_again(&r, s, studio, point);
  if (code == 0) {
    report_technique_picture(&strip, &r.frame, r.kinds, &s->crop);
    report_picture_shrink(&small, &strip, NULL, strip.width); /* to steps of grey */
    out->picture = report_picture_uri(&small);
    image_free(&strip);
    image_free(&small);
    code = out->picture ? 0 : HOST_BAD_INPUT;
  }
  redrawn_free(&r);
  return code;
}

/* The truth with the part marked that the techniques are shown of, and each of them. */
static int take_techniques(report_scene *s, const report_studio *studio) {
  const stage_frame nothing = {0};
  const metrics_frame frame = truth_frame_against(&s->truth, &s->setup, &nothing);
  const uint32_t filters = report_filter_count();
  int code = 0;
  image picture;
  s->crop = report_crop_choose(&frame);
  measure_picture_lit(&picture, &s->truth.view, &s->setup.light, s->truth.visibility);
  report_crop_mark(&picture, &s->crop);
  s->truth_picture = small_uri(&picture, NULL);
  s->techniques = host_allocate(filters, sizeof *s->techniques);
  for (uint32_t filter = 0; code == 0 && filter < filters; filter++) {
    const uint32_t best = best_of_filter(s, filter);
    if (best < s->sweep.count)
      code = take_technique(s, studio, best);
  }
  return s->truth_picture ? code : HOST_BAD_INPUT;
}

static int take_pictures(report_scene *s, const report_studio *studio) {
  const uint32_t chosen[REPORT_PICTURES] = {s->sweep.base, s->verdicts[0].knee, s->verdicts[0].least_error};
  int code = 0;
  image picture;
  measure_picture_lit(&picture, &s->truth.view, &s->setup.light, s->truth.visibility);
  s->truth_picture = small_uri(&picture, NULL);
  for (int i = 0; code == 0 && i < REPORT_PICTURES; i++) {
    bool taken = false;
    for (uint32_t k = 0; k < s->picture_count; k++)
      taken = taken || s->pictures[k].point == chosen[i];
    if (!taken)
      code = take_picture(s, studio, chosen[i]);
  }
  return s->truth_picture ? code : HOST_BAD_INPUT;
}

/* ---- a scene ---- */

static int open_stages(report_scene *s, const host_options *options) {
  int code = 0;
  for (int i = 0; code == 0 && i < HOST_BACKENDS; i++)
    if (options->backends[i]) {
      stage *opened[] = {&s->stages[s->stage_count], &s->references[s->stage_count]};
      s->stage_count++;
      for (int k = 0; code == 0 && k < 2; k++) {
        code = stage_open(opened[k], host_backend_names[i], options->device);
        if (code == 0)
          code = stage_load(opened[k], &s->setup);
      }
    }
  return code;
}

int report_scene_open(report_scene *out, const host_options *options) {
  *out = (report_scene){.begun_ms = host_now_ms()};
  int code = setup_load(&out->setup, options);
  if (code == 0)
    code = truth_store_open(&out->store, &out->setup.scene, true, options->cache);
  if (code == 0)
    code = truth_frame_cast(&out->truth, &out->store, &out->setup, options->sun_samples);
  return code ? code : open_stages(out, options);
}

static report_studio studio_of(report_scene *s) {
  return (report_studio){.setup = &s->setup,
                         .truth = &s->truth,
                         .stages = s->stages,
                         .references = s->references,
                         .stage_count = s->stage_count};
}

int report_scene_sweep(report_scene *s, const host_options *options, double deadline_ms) {
  const report_studio studio = studio_of(s);
  const int code =
      report_sweep_run(&s->sweep, &studio, options->quick ? REPORT_QUICK_ROUNDS : REPORT_MAX_ROUNDS, deadline_ms);
  s->seconds = (host_now_ms() - s->begun_ms) * 1e-3;
  return code;
}

int report_scene_run(report_scene *out, const host_options *options, double deadline_ms) {
  int code = report_scene_open(out, options);
  if (code)
    return code;
  const bool soft = report_scene_is_soft(out);
  if (soft)
    code = report_sweep_make_soft(&out->sweep, options, &out->setup);
  else
    report_sweep_make(&out->sweep, options, &out->setup.config);
  if (code == 0)
    code = report_scene_sweep(out, options, deadline_ms);
  if (code == 0) {
    const report_studio studio = studio_of(out);
    judge(out);
    host_progress("taking pictures");
    code = soft ? take_techniques(out, &studio) : take_pictures(out, &studio);
    host_progress("");
  }
  out->seconds = (host_now_ms() - out->begun_ms) * 1e-3;
  return code;
}

void report_scene_close(report_scene *s) {
  for (uint32_t b = 0; b < s->stage_count; b++) {
    stage_close(&s->stages[b]);
    stage_close(&s->references[b]);
  }
  truth_frame_free(&s->truth);
  truth_store_close(&s->store);
  setup_free(&s->setup);
}

void report_scene_free(report_scene *s) {
  report_scene_close(s);
  for (uint32_t b = 0; b < HOST_BACKENDS; b++) {
    report_verdict_free(&s->verdicts[b]);
    free(s->scores[b]);
  }
  for (uint32_t i = 0; i < s->picture_count; i++) {
    free(s->pictures[i].drawn);
    free(s->pictures[i].errors);
  }
  for (uint32_t i = 0; i < s->technique_count; i++)
    free(s->techniques[i].picture);
  free(s->techniques);
  free(s->truth_picture);
  report_sweep_free(&s->sweep);
  *s = (report_scene){0};
}
