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
  report_scene scenes[OPTIONS_MAX_SCENES]; /* finished: results alone are kept */
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

/* Geometric means over the scenes, on the first backend. Nothing where devices left out different configurations. */
static json_t *judge_all(const report *r) {
  const report_sweep *first = &r->scenes[0].sweep;
  for (uint32_t i = 1; i < r->scene_count; i++)
    if (r->scenes[i].sweep.count != first->count)
      return json_null();
  report_score *scores = host_allocate(first->count, sizeof *scores);
  report_verdict verdict;
  for (uint32_t p = 0; p < first->count; p++) {
    double sums[4] = {0};
    for (uint32_t i = 0; i < r->scene_count; i++) {
      const report_score *score = &r->scenes[i].scores[0][p];
      const double values[4] = {score->ms.median, score->ms.low, score->ms.high, score->error};
      for (int k = 0; k < 4; k++)
        sums[k] += log(values[k]) / r->scene_count;
    }
    scores[p] = (report_score){.ms = {.median = exp(sums[0]), .low = exp(sums[1]), .high = exp(sums[2])},
                               .error = exp(sums[3])};
  }
  report_judge(&verdict, scores, first->count, first->base);
  json_t *object = report_verdict_to_json(&verdict);
  report_verdict_free(&verdict);
  free(scores);
  return object;
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

static void print_choice(FILE *to, const report_scene *s, const char *what, uint32_t p) {
  json_t *config = config_to_json(&s->sweep.points[p].config);
  const report_score *score = &s->scores[0][p];
  fprintf(to, "  %-12s %" JSON_INTEGER_FORMAT " x %4" JSON_INTEGER_FORMAT "^2  %-8s %-15s %8.2f ms  ", what,
          json_integer_value(json_object_get(config, "cascade_count")),
          json_integer_value(json_object_get(config, "resolution")),
          json_string_value(json_object_get(config, "filter")), json_string_value(json_object_get(config, "bias_mode")),
          score->ms.median);
  if (report_scene_is_soft(s))
    fprintf(to, "rmse %.4f\n", score->error);
  else
    fprintf(to, "%.3f %% of pixels wrong\n", 100.0 * score->error);
  json_decref(config);
}

static void print_scene(FILE *to, const report_scene *s, const char *base) {
  const report_verdict *v = &s->verdicts[0];
  fprintf(to, "%s, %s: %u configurations, %u round%s, %.0f s\n", s->setup.scene.name, s->stages[0].backend,
          s->sweep.count, s->sweep.rounds, s->sweep.rounds == 1 ? "" : "s", s->seconds);
  print_choice(to, s, "best value", v->knee);
  print_choice(to, s, "least error", v->least_error);
  print_choice(to, s, base, s->sweep.base);
}

/* ---- doing it ---- */

static int choose_scenes(report *r) {
  const host_options *options = r->options;
  const bool named = options->scene_count > 0;
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

static int add_scene(report *r, uint32_t i) {
  host_options options = *r->options;
  report_scene *s = &r->scenes[r->scene_count];
  const double end_ms = r->begun_ms + options.minutes * 60e3, now_ms = host_now_ms();
  options.scene = r->names[i];
  int code = report_scene_run(s, &options,
                              options.minutes > 0.0 ? now_ms + (end_ms - now_ms) / (r->name_count - i) : INFINITY);
  if (code == HOST_BAD_INPUT && s->stage_count == 0 && may_be_left_out(r, i)) {
    json_array_append_new(json_object_get(r->head, "left_out"), json_string(r->names[i]));
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
  return 0;
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
  if (code == 0)
    code = host_make_folder(options->out);
  for (uint32_t i = 0; code == 0 && i < r->name_count; i++) {
    code = add_scene(r, i);
    if (code == 0)
      code = write_all(r);
  }
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
  for (uint32_t i = 0; i < OPTIONS_MAX_SCENES; i++)
    report_scene_free(&r->scenes[i]);
  json_decref(r->head);
  json_decref(r->full);
  json_decref(r->page);
  json_decref(r->full_hard);
  json_decref(r->page_hard);
  free(r);
  return code;
}
