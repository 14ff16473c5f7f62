/* command.c: csm-host hard: runs cases, and tells their figures. */
#include "base/host.h"
#include "base/image.h"
#include "base/output_file.h"
#include "hard/cases.h"
#include "setup/output.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

/* ---- figures ---- */

bool hard_figure_holds(const hard_figure *figure) {
  return figure->value <= figure->bound;
}

/* What is no number is worst; then what is farthest over its bound, for bounds may follow from what was drawn. */
static bool is_worse(const hard_figure *a, const hard_figure *b) {
  if (isnan(a->value) || isnan(b->value))
    return isnan(a->value);
  if (a->bound == INFINITY && b->bound == INFINITY)
    return a->value > b->value;
  return a->value - a->bound > b->value - b->bound;
}

void hard_figure_add(hard_run *run, double value, double bound, const char *unit, const char *format, ...) {
  hard_figure figure = {.value = value, .bound = bound, .unit = unit};
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(figure.what, sizeof figure.what, format, arguments);
  va_end(arguments);
  for (size_t i = 0; i < run->figure_count; i++) {
    hard_figure *old = &run->figures[i];
    if (strcmp(old->what, figure.what) != 0)
      continue;
    if (is_worse(&figure, old))
      *old = figure;
    return;
  }
  run->figures = host_grow(run->figures, &run->figure_capacity, run->figure_count + 1, sizeof *run->figures);
  run->figures[run->figure_count++] = figure;
}

/* ---- one case ---- */

int hard_run_case(hard_run *out, const hard_case *which, const host_options *options) {
  const double begun_ms = host_now_ms();
  *out = (hard_run){.options = options, .hard_case = which, .sweep = options->sweep, .worst = {.severity = -1.0}};
  host_progress(which->name);
  const int code = which->run(out);
  host_progress("");
  out->seconds = (host_now_ms() - begun_ms) * 1e-3;
  return code;
}

bool hard_run_holds(const hard_run *run) {
  for (size_t i = 0; i < run->figure_count; i++)
    if (!hard_figure_holds(&run->figures[i]))
      return false;
  return true;
}

void hard_run_close(hard_run *run) {
  hard_unload(run);
  for (uint32_t i = 0; i < run->stage_count; i++)
    stage_close(&run->stages[i]);
  free(run->figures);
  free(run->worst.expected);
  free(run->worst.drawn);
  *run = (hard_run){0};
}

/* ---- telling ---- */

static void print_figures(FILE *to, const hard_run *run, bool markdown) {
  if (markdown)
    fprintf(to, "**%s**: %s\n\n| figure | value | bound | unit | |\n|---|---|---|---|---|\n", run->hard_case->name,
            run->hard_case->about);
  for (size_t i = 0; i < run->figure_count; i++) {
    const hard_figure *figure = &run->figures[i];
    const char *verdict = !hard_figure_holds(figure) ? "BROKEN" : figure->bound == INFINITY ? "stated" : "ok";
    char bound[32] = "-";
    if (figure->bound != INFINITY)
      snprintf(bound, sizeof bound, "%.4g", figure->bound);
    if (markdown)
      fprintf(to, "| %s | %.4g | %s | %s | %s |\n", figure->what, figure->value, bound, figure->unit, verdict);
    else
      fprintf(to, "%-14s %-64s %10.4g  %10s %-7s %s\n", run->hard_case->name, figure->what, figure->value, bound,
              figure->unit, verdict);
  }
  if (markdown)
    fputc('\n', to);
}

json_t *hard_run_to_json(const hard_run *run) {
  json_t *object = json_object(), *figures = json_array();
  for (size_t i = 0; i < run->figure_count; i++) {
    const hard_figure *figure = &run->figures[i];
    json_array_append_new(figures, json_pack("{s:s, s:o, s:o, s:s, s:b}", "what", figure->what, "value",
                                             isfinite(figure->value) ? json_real(figure->value) : json_null(), "bound",
                                             isfinite(figure->bound) ? json_real(figure->bound) : json_null(), "unit",
                                             figure->unit, "holds", (int)hard_figure_holds(figure)));
  }
  json_object_set_new(object, "case", json_string(run->hard_case->name));
  json_object_set_new(object, "about", json_string(run->hard_case->about));
  json_object_set_new(object, "seconds", json_real(run->seconds));
  json_object_set_new(object, "figures", figures);
  return object;
}

static int save_worst(const hard_run *run, const char *folder) {
  char path[OUTPUT_PATH_SIZE];
  image picture;
  if (!run->worst.expected)
    return 0;
  int code = output_path(path, folder, "%s.png", run->hard_case->name);
  if (code)
    return code;
  hard_worst_picture(&picture, &run->worst);
  code = image_write_png(&picture, path);
  image_free(&picture);
  return code;
}

/* ---- the command ---- */

static int run_and_tell(const hard_case *which, const host_options *options, json_t *told) {
  hard_run run;
  int code = hard_run_case(&run, which, options);
  if (code == 0) {
    print_figures(output_table(options), &run, options->markdown);
    fflush(output_table(options));
    json_array_append_new(told, hard_run_to_json(&run));
  }
  if (code == 0 && options->has_out)
    code = save_worst(&run, options->out);
  if (code == 0 && !hard_run_holds(&run))
    code = HOST_DIFFER;
  hard_run_close(&run);
  return code;
}

int hard_command(const host_options *options) {
  const hard_case *chosen[OPTIONS_MAX_CASES];
  uint32_t count = 0;
  bool broken = false;
  json_t *told = json_array();
  int code = hard_cases_choose(chosen, &count, options);
  if (code == 0 && options->has_out)
    code = host_make_folder(options->out);
  for (uint32_t i = 0; code == 0 && i < count; i++) {
    code = run_and_tell(chosen[i], options, told);
    broken = broken || code == HOST_DIFFER;
    code = code == HOST_DIFFER ? 0 : code;
  }
  if (code == 0)
    code = output_json(options, json_incref(told));
  json_decref(told);
  return code == 0 && broken ? HOST_DIFFER : code;
}
