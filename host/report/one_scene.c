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

/* What no picture of that many pixels can tell from zero. */
static double least_error(const report_scene *s, const metrics *m) {
  return report_scene_is_soft(s) ? 1e-6 : 0.5 / (double)m->pixels;
}

static void judge(report_scene *s) {
  for (uint32_t b = 0; b < s->stage_count; b++) {
    s->scores[b] = host_allocate(s->sweep.count, sizeof *s->scores[b]);
    for (uint32_t p = 0; p < s->sweep.count; p++) {
      const metrics *m = &s->sweep.points[p].metrics[b];
      s->scores[b][p] = (report_score){.ms = report_time_of(&s->sweep, p, b, REPORT_SHADOW_MS),
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

static int take_picture(report_scene *s, const report_studio *studio, uint32_t point) {
  report_picture *out = &s->pictures[s->picture_count++];
  uint8_t *kinds = host_allocate((size_t)s->setup.width * s->setup.height, 1);
  stage_frame drawn;
  metrics unused;
  image picture;
  out->point = point;
  int code = report_draw(studio, 0, &s->sweep.points[point].config, &drawn);
  const metrics_frame frame = truth_frame_against(&s->truth, &s->setup, &drawn);
  if (code == 0)
    code = metrics_measure(&unused, &frame, kinds);
  if (code == 0) {
    measure_picture_lit(&picture, &s->truth.view, &s->setup.light, drawn.mask);
    out->drawn = small_uri(&picture, NULL);
    measure_picture_errors(&picture, &frame, kinds);
    out->errors = small_uri(&picture, kinds);
    code = out->drawn && out->errors ? 0 : HOST_BAD_INPUT;
  }
  stage_frame_free(&drawn);
  free(kinds);
  return code;
}

static int take_pictures(report_scene *s, const report_studio *studio) {
  const uint32_t chosen[REPORT_PICTURES] = {s->sweep.base, s->verdicts[0].knee, s->verdicts[0].least_error};
  int code = 0;
  image picture;
  host_progress("taking pictures");
  measure_picture_lit(&picture, &s->truth.view, &s->setup.light, s->truth.visibility);
  s->truth_picture = small_uri(&picture, NULL);
  for (int i = 0; code == 0 && i < REPORT_PICTURES; i++) {
    bool taken = false;
    for (uint32_t k = 0; k < s->picture_count; k++)
      taken = taken || s->pictures[k].point == chosen[i];
    if (!taken)
      code = take_picture(s, studio, chosen[i]);
  }
  host_progress("");
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
  report_sweep_make(&out->sweep, options, &out->setup.config);
  code = report_scene_sweep(out, options, deadline_ms);
  if (code == 0) {
    const report_studio studio = studio_of(out);
    judge(out);
    code = take_pictures(out, &studio);
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
  free(s->truth_picture);
  report_sweep_free(&s->sweep);
  *s = (report_scene){0};
}
