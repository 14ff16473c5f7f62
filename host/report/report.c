#include "report/report.h"
#include "base/host.h"
#include "base/interrupt.h"
#include "report/hard_cases.h"
#include "report/machine.h"
#include "report/one_scene.h"
#include "report/page.h"
#include "setup/config_json.h"
#include "setup/output.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static const char *const standard_scenes[] = {"valley", "town", "oaks"};

typedef struct report {
  const host_options *options;
  const char *names[OPTIONS_MAX_SCENES];
  uint32_t name_count;
  uint32_t sun_count;   /* of each: those that the options name, or the light's own */
  report_scene *scenes; /* under every sun; finished: results alone are kept */
  uint32_t scene_count;
  json_t *head;                  /* what does not belong to one scene */
  json_t *full, *page;           /* each scene, as report.json and as the page has it */
  json_t *full_hard, *page_hard; /* likewise, of hard cases */
  bool broken;                   /* a figure of a hard case does not hold */
  double begun_ms;
} report;

/* ---- what it says ---- */

static char *join_arguments(const host_options *options) {
  size_t size = sizeof "csm-host";
  for (int i = 1; i < options->argument_count; i++)
    size += strlen(options->arguments[i]) + 3;
  char *text = host_allocate(size, 1), *at = text + sprintf(text, "csm-host");
  for (int i = 1; i < options->argument_count; i++) {
    const char *argument = options->arguments[i];
    at += sprintf(at, strpbrk(argument, " \t'\"$&|;<>()*?") ? " '%s'" : " %s", argument);
  }
  return text;
}

static void make_head(report *r) {
  const host_options *options = r->options;
  const uint32_t version = csm_version();
  const time_t now = time(NULL);
  char date[32] = "", *command = join_arguments(options);
  struct tm utc;
  if (gmtime_r(&now, &utc))
    strftime(date, sizeof date, "%Y-%m-%d", &utc);
  r->head = json_object();
  json_object_set_new(r->head, "csm", json_sprintf("%u.%u.%u", version >> 22, version >> 12 & 1023, version & 4095));
  json_object_set_new(r->head, "date", json_string(date));
  json_object_set_new(r->head, "command", json_string(command));
  json_object_set_new(r->head, "quick", json_boolean(options->quick));
  json_object_set_new(r->head, "minutes", json_real(options->minutes));
  json_object_set_new(r->head, "base_name", json_string(options_base_name(options)));
  json_object_set_new(r->head, "machine", report_machine_to_json());
  json_object_set_new(r->head, "load_at_start", report_machine_load());
  json_object_set_new(r->head, "left_out", json_array());
  free(command);
}

static void note_backends(report *r, const report_scene *s) {
  json_t *backends = json_array();
  for (uint32_t b = 0; b < s->stage_count; b++) {
    json_t *backend = json_object();
    json_object_set_new(backend, "name", json_string(s->stages[b].backend));
    json_object_set_new(backend, "device", json_string(s->stages[b].device));
    json_object_set_new(backend, "driver", json_string(s->stages[b].driver));
    json_array_append_new(backends, backend);
  }
  json_object_set_new(r->head, "backends", backends);
}

/* Whether two scenes were swept alike, under suns of the same kind: then their points can be compared one by one. */
static bool alike(const report_scene *a, const report_scene *b) {
  return a->setup.light.disc_deg == b->setup.light.disc_deg && a->sweep.count == b->sweep.count;
}

/* The point's geometric mean over the scenes that are like the first. */
static report_score mean_score(const report *r, const report_scene *first, uint32_t p) {
  double sums[4] = {0};
  uint32_t count = 0;
  for (const report_scene *s = first; s < r->scenes + r->scene_count; s++) {
    if (!alike(s, first))
      continue;
    const report_score *score = &s->scores[0][p];
    const double values[4] = {score->ms.median, score->ms.low, score->ms.high, score->error};
    for (int k = 0; k < 4; k++)
      sums[k] += log(values[k]);
    count++;
  }
  return (report_score){
      .ms = {.median = exp(sums[0] / count), .low = exp(sums[1] / count), .high = exp(sums[2] / count)},
      .error = exp(sums[3] / count)};
}

/* On the first backend, over all scenes that are like the first. */
static json_t *judge_group(const report *r, const report_scene *first) {
  report_score *scores = host_allocate(first->sweep.count, sizeof *scores);
  report_verdict verdict;
  json_t *scenes = json_array();
  for (uint32_t p = 0; p < first->sweep.count; p++)
    scores[p] = mean_score(r, first, p);
  for (uint32_t i = 0; i < r->scene_count; i++)
    if (alike(&r->scenes[i], first))
      json_array_append_new(scenes, json_integer(i));
  report_judge(&verdict, scores, first->sweep.count, first->sweep.base);
  json_t *object = report_verdict_to_json(&verdict);
  json_object_set_new(object, "disc_deg", json_real(first->setup.light.disc_deg));
  json_object_set_new(object, "scenes", scenes);
  report_verdict_free(&verdict);
  free(scores);
  return object;
}

/* A verdict for each sun. Where devices left out different configurations, scenes stand by themselves. */
static json_t *judge_all(const report *r) {
  json_t *all = json_array();
  for (uint32_t i = 0; i < r->scene_count; i++) {
    bool judged = false;
    for (uint32_t k = 0; k < i; k++)
      judged = judged || alike(&r->scenes[k], &r->scenes[i]);
    if (!judged)
      json_array_append_new(all, judge_group(r, &r->scenes[i]));
  }
  return all;
}

static json_t *with_scenes(const report *r, json_t *scenes, json_t *hard) {
  json_t *object = json_copy(r->head);
  json_object_set_new(object, "seconds", json_real((host_now_ms() - r->begun_ms) * 1e-3));
  json_object_set_new(object, "load_at_end", report_machine_load());
  json_object_set_new(object, "all", judge_all(r));
  json_object_set(object, "scenes", scenes);
  json_object_set(object, "hard", hard);
  return object;
}

/* After each scene, so that what is done is there whatever comes. */
static int write_all(const report *r) {
  interrupt_hold hold;
  interrupt_hold_begin(&hold);
  json_t *page = with_scenes(r, r->page, r->page_hard), *full = with_scenes(r, r->full, r->full_hard);
  int code = report_page_write(r->options->out, page);
  if (code == 0)
    code = report_json_write(r->options->out, full);
  interrupt_hold_end(&hold);
  json_decref(page);
  json_decref(full);
  return code;
}

/* What a point is called: by its name, or by its shape. */
static void print_point(FILE *to, const report_point *point) {
  json_t *config = config_to_json(&point->config);
  if (point->name)
    fprintf(to, "%-36s", point->name);
  else
    fprintf(to, "%" JSON_INTEGER_FORMAT " x %4" JSON_INTEGER_FORMAT "^2  %-8s %-15s",
            json_integer_value(json_object_get(config, "cascade_count")),
            json_integer_value(json_object_get(config, "resolution")),
            json_string_value(json_object_get(config, "filter")),
            json_string_value(json_object_get(config, "bias_mode")));
  json_decref(config);
}

static void print_choice(FILE *to, const report_scene *s, const char *what, uint32_t p) {
  const report_score *score = &s->scores[0][p];
  fprintf(to, "  %-12s ", what);
  print_point(to, &s->sweep.points[p]);
  fprintf(to, " %8.2f ms  ", score->ms.median);
  if (report_scene_is_soft(s))
    fprintf(to, "rmse %.4f\n", score->error);
  else
    fprintf(to, "%.3f %% of pixels wrong\n", 100.0 * score->error);
}

static void print_scene(FILE *to, const report_scene *s, const char *base) {
  const report_verdict *v = &s->verdicts[0];
  fprintf(to, "%s, ", s->setup.scene.name);
  if (report_scene_is_soft(s))
    fprintf(to, "a sun of %g degrees, ", s->setup.light.disc_deg);
  fprintf(to, "%s: %u configurations, %u round%s, %.0f s\n", s->stages[0].backend, s->sweep.count, s->sweep.rounds,
          s->sweep.rounds == 1 ? "" : "s", s->seconds);
  if (report_scene_is_soft(s))
    for (uint32_t i = 0; i < v->front_count; i++)
      print_choice(to, s, i ? "" : "front", v->front[i]);
  print_choice(to, s, "best value", v->knee);
  print_choice(to, s, "least error", v->least_error);
  print_choice(to, s, base, s->sweep.base);
}

/* ---- doing it ---- */

static int choose_scenes(report *r) {
  const host_options *options = r->options;
  const bool named = options->scene_count > 0;
  r->sun_count = options->sun_count ? options->sun_count : 1;
  r->name_count = named ? options->scene_count : sizeof standard_scenes / sizeof standard_scenes[0];
  for (uint32_t i = 0; i < r->name_count; i++)
    r->names[i] = named ? options->scenes[i] : standard_scenes[i];
  if (options->camera_text && r->name_count > 1)
    return host_fail(HOST_BAD_INPUT, "--camera: name one scene with it: one camera does not suit %u scenes",
                     r->name_count);
  if (options->camera_path || options->light_path || options->dump)
    return host_fail(HOST_BAD_INPUT, "report: takes no --camera-path, --light-path or --dump");
  return report_hard_check(options);
}

/* The oaks' files may not be there; unless they were asked for, that is no error. */
static bool may_be_left_out(const report *r, uint32_t i) {
  return r->options->scene_count == 0 && strcmp(r->names[i], "oaks") == 0 && r->scene_count > 0;
}

/* The scene's i-th sun. */
static int add_scene(report *r, uint32_t index, uint32_t sun) {
  host_options options = *r->options;
  report_scene *s = &r->scenes[r->scene_count];
  const uint32_t left = (r->name_count - index) * r->sun_count - sun;
  const double end_ms = r->begun_ms + options.minutes * 60e3, now_ms = host_now_ms();
  options.scene = r->names[index];
  options.has_disc = options.sun_count > 0;
  options.disc_deg = options.suns[sun];
  int code = report_scene_run(s, &options, options.minutes > 0.0 ? now_ms + (end_ms - now_ms) / left : INFINITY);
  if (code == HOST_BAD_INPUT && s->stage_count == 0 && may_be_left_out(r, index)) {
    if (sun == 0)
      json_array_append_new(json_object_get(r->head, "left_out"), json_string(r->names[index]));
    return 0;
  }
  if (code)
    return code;
  r->scene_count++;
  note_backends(r, s);
  json_array_append_new(r->full, report_scene_to_json(s));
  json_array_append_new(r->page, report_scene_to_page(s));
  print_scene(output_table(&options), s, options_base_name(&options));
  report_scene_close(s);
  return write_all(r);
}

static bool any_differs(const report *r) {
  for (uint32_t i = 0; i < r->scene_count; i++)
    if (report_scene_differs(&r->scenes[i]))
      return true;
  return false;
}

int report_command(const host_options *options) {
  report *r = host_allocate(1, sizeof *r);
  *r = (report){.options = options,
                .begun_ms = host_now_ms(),
                .full = json_array(),
                .page = json_array(),
                .full_hard = json_array(),
                .page_hard = json_array()};
  make_head(r);
  int code = choose_scenes(r);
  const uint32_t scenes = r->name_count * r->sun_count;
  r->scenes = host_allocate(scenes ? scenes : 1, sizeof *r->scenes);
  if (code == 0)
    code = host_make_folder(options->out);
  for (uint32_t i = 0; code == 0 && i < scenes; i++)
    code = add_scene(r, i / r->sun_count, i % r->sun_count);
  if (code == 0)
    code = report_hard_run(r->full_hard, r->page_hard, &r->broken, options);
  if (code == 0)
    code = write_all(r);
  if (code == 0) {
    fprintf(output_table(options), "page: %s/report.html\n", options->out);
    code = output_json(options, with_scenes(r, r->full, r->full_hard));
  }
  if (code == 0 && (r->broken || any_differs(r)))
    code = HOST_DIFFER;
  for (uint32_t i = 0; i < scenes; i++)
    report_scene_free(&r->scenes[i]);
  free(r->scenes);
  json_decref(r->head);
  json_decref(r->full);
  json_decref(r->page);
  json_decref(r->full_hard);
  json_decref(r->page_hard);
  free(r);
  return code;
}
