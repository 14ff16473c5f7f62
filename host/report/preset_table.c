#include "report/preset_table.h"
#include "base/host.h"
#include "report/one_scene.h"
#include "setup/output.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- held against others ---- */

/* What a preset of ours may have of the best that it is held against: of its error, and of its time. */
typedef struct bound {
  const char *preset;
  double error, ms;
} bound;

static const bound bounds[] = {{"soft", 0.5, 1.0}, {"soft_high", 0.25, INFINITY}};

static const bound *bound_of(const char *preset) {
  for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++)
    if (strcmp(bounds[i].preset, preset) == 0)
      return &bounds[i];
  return NULL;
}

static bool is_named(const options_presets *presets, const char *name) {
  for (uint32_t i = 0; i < presets->count; i++)
    if (strcmp(presets->names[i], name) == 0)
      return true;
  return false;
}

/* The point of `against` with the least error; the base where there is none. */
static uint32_t find_best(const report_scene *s, const options_presets *against, uint32_t backend) {
  uint32_t best = s->sweep.base;
  bool found = false;
  for (uint32_t p = 0; p < s->sweep.count; p++)
    if (is_named(against, s->sweep.points[p].name) &&
        (!found || report_error(s, &s->sweep.points[p].metrics[backend]) <
                       report_error(s, &s->sweep.points[best].metrics[backend]))) {
      best = p;
      found = true;
    }
  return best;
}

/* What a point has of another one's, on a backend. */
typedef struct share {
  double error;
  estimate ms; /* of what the GPU takes for shadows, in the same rounds */
} share;

static share share_of(const report_scene *s, uint32_t point, uint32_t other, uint32_t backend) {
  const report_point *own = &s->sweep.points[point], *to = &s->sweep.points[other];
  const double error = report_error(s, &own->metrics[backend]);
  return (share){
      .error = error > 0.0 ? error / report_error(s, &to->metrics[backend]) : 0.0, /* none is any share of none */
      .ms = estimate_ratio(own->samples[backend][REPORT_GPU_MS], to->samples[backend][REPORT_GPU_MS], s->sweep.rounds)};
}

static bool within(const share *part, const bound *most) {
  return part->error <= most->error && part->ms.median <= most->ms;
}

/* ---- telling ---- */

static void print_edge(FILE *to, const metrics *m) {
  if (m->edge_px < 0.0)
    fputs("none", to);
  else
    fprintf(to, "%.2f", m->edge_px);
}

static double total_mib(const report_point *p) {
  return (double)(p->map_bytes + p->moment_bytes + p->view_bytes) / (1024.0 * 1024.0);
}

static void print_row(FILE *to, const report_scene *s, uint32_t point, uint32_t backend) {
  const report_point *p = &s->sweep.points[point];
  const metrics *m = &p->metrics[backend];
  const share base = share_of(s, point, s->sweep.base, backend);
  const double ms = report_time_of(&s->sweep, point, backend, REPORT_GPU_MS).median;
  if (report_scene_is_soft(s)) {
    fprintf(to, "| %s | %.4f | %.4f | %+.4f | %.1f", p->name, m->rmse, m->mean_absolute, m->mean, ms);
    for (int t = REPORT_MAPS_MS; t <= REPORT_HISTORY_MS; t++)
      fprintf(to, "%s%.1f", t == REPORT_MAPS_MS ? " = " : " + ",
              report_time_of(&s->sweep, point, backend, (report_time)t).median);
    fprintf(to, " | %.2f (%.2f to %.2f) | %.1f |\n", base.ms.median, base.ms.low, base.ms.high, total_mib(p));
    return;
  }
  fprintf(to, "| %s | %.3f | %.3f | %.3f | %.3f | %.3f | ", p->name, 100.0 * m->false_lit, 100.0 * m->false_shadow,
          100.0 * (m->false_lit + m->false_shadow), 100.0 * m->leak, 100.0 * m->acne);
  print_edge(to, m);
  fprintf(to, " | %.1f | %.2f (%.2f to %.2f) | %.1f |\n", ms, base.ms.median, base.ms.low, base.ms.high, total_mib(p));
}

static void print_against(FILE *to, const report_scene *s, const options_presets *against, uint32_t backend) {
  const uint32_t best = find_best(s, against, backend);
  fprintf(to, "against %s, the best of %u:\n\n| preset | its error | its time | asked |\n|---|---:|---:|---|\n",
          s->sweep.points[best].name, against->count);
  for (uint32_t p = 0; p < s->sweep.count; p++) {
    const char *name = s->sweep.points[p].name;
    const share part = share_of(s, p, best, backend);
    const bound *most = bound_of(name);
    fprintf(to, "| %s | %.2f | %.2f (%.2f to %.2f) | ", name, part.error, part.ms.median, part.ms.low, part.ms.high);
    if (most && isfinite(most->ms))
      fprintf(to, "at most %.2f at %.2f: %s", most->error, most->ms, within(&part, most) ? "yes" : "NO");
    else if (most)
      fprintf(to, "at most %.2f: %s", most->error, within(&part, most) ? "yes" : "NO");
    fputs(" |\n", to);
  }
  fputc('\n', to);
}

static void print_head(FILE *to, const report_scene *s, uint32_t backend) {
  fprintf(to, "%s, %ux%u, shadows to %g m, %s on %s, %u round%s, %.0f s\n", s->setup.scene.name, s->setup.width,
          s->setup.height, s->setup.shadow_distance, s->stages[backend].backend, s->stages[backend].device,
          s->sweep.rounds, s->sweep.rounds == 1 ? "" : "s", s->seconds);
  if (report_scene_is_soft(s)) {
    fprintf(to, "a sun of %g degrees, %u rays a pixel; at most %.5f of an rmse is the truth's own noise\n\n",
            s->setup.light.disc_deg, s->truth.convergence.samples, report_noise(s));
    fputs("| preset | rmse | mean absolute | mean | maps + moments + mask + history, ms | times the first | MiB "
          "|\n|---|---:|---:|---:|---:|---:|---:|\n",
          to);
  } else {
    fputs("\n| preset | false lit % | false shadow % | sum % | leak % | acne % | edge px | GPU ms | times the first | "
          "MiB |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
          to);
  }
}

static void print_scene(FILE *to, const report_scene *s, const options_presets *against) {
  for (uint32_t b = 0; b < s->stage_count; b++) {
    print_head(to, s, b);
    for (uint32_t p = 0; p < s->sweep.count; p++)
      print_row(to, s, p, b);
    fputc('\n', to);
    if (against->count)
      print_against(to, s, against, b);
  }
}

static json_t *against_to_json(const report_scene *s, uint32_t point, uint32_t backend,
                               const options_presets *against) {
  const uint32_t best = find_best(s, against, backend);
  const share part = share_of(s, point, best, backend);
  const bound *most = bound_of(s->sweep.points[point].name);
  json_t *object = json_object();
  json_object_set_new(object, "preset", json_string(s->sweep.points[best].name));
  json_object_set_new(object, "error",
                      isfinite(part.error) ? json_real(part.error) : json_null()); /* the best has none */
  json_object_set_new(object, "gpu_ms", estimate_to_json(&part.ms));
  if (most) {
    json_object_set_new(object, "most_error", json_real(most->error));
    json_object_set_new(object, "most_ms", isfinite(most->ms) ? json_real(most->ms) : json_null());
    json_object_set_new(object, "holds", json_boolean(within(&part, most)));
  }
  return object;
}

static json_t *result_to_json(const report_scene *s, uint32_t point, uint32_t backend, const options_presets *against) {
  const share base = share_of(s, point, s->sweep.base, backend);
  const estimate ms = report_time_of(&s->sweep, point, backend, REPORT_GPU_MS);
  json_t *object = json_object();
  json_object_set_new(object, "metrics", metrics_to_json(&s->sweep.points[point].metrics[backend]));
  json_object_set_new(object, "gpu_ms", estimate_to_json(&ms));
  json_object_set_new(object, "ratio", estimate_to_json(&base.ms));
  if (against->count)
    json_object_set_new(object, "against", against_to_json(s, point, backend, against));
  return object;
}

static json_t *preset_to_json(const report_scene *s, uint32_t point, const options_presets *against) {
  const report_point *p = &s->sweep.points[point];
  json_t *object = json_object(), *backends = json_object();
  for (uint32_t b = 0; b < s->stage_count; b++)
    json_object_set_new(backends, s->stages[b].backend, result_to_json(s, point, b, against));
  json_object_set_new(object, "preset", json_string(p->name));
  json_object_set_new(object, "map_bytes", json_integer((json_int_t)p->map_bytes));
  json_object_set_new(object, "moment_bytes", json_integer((json_int_t)p->moment_bytes));
  json_object_set_new(object, "view_bytes", json_integer((json_int_t)p->view_bytes));
  json_object_set_new(object, "backends", backends);
  if (s->stage_count == HOST_BACKENDS)
    json_object_set_new(object, "differing_pixels", json_integer((json_int_t)p->differing));
  return object;
}

static json_t *scene_to_json(const report_scene *s, const options_presets *against) {
  json_t *object = json_object(), *presets = json_array();
  for (uint32_t p = 0; p < s->sweep.count; p++)
    json_array_append_new(presets, preset_to_json(s, p, against));
  json_object_set_new(object, "scene", json_string(s->setup.scene.name));
  json_object_set_new(object, "width", json_integer(s->setup.width));
  json_object_set_new(object, "height", json_integer(s->setup.height));
  json_object_set_new(object, "shadow_distance", json_real(s->setup.shadow_distance));
  json_object_set_new(object, "disc_deg", json_real(s->setup.light.disc_deg));
  json_object_set_new(object, "noise", json_real(report_noise(s)));
  json_object_set_new(object, "rounds", json_integer(s->sweep.rounds));
  json_object_set_new(object, "presets", presets);
  return object;
}

/* ---- doing it ---- */

static int measure_scene(const host_options *options, double deadline_ms, json_t *scenes) {
  report_scene *s = host_allocate(1, sizeof *s);
  int code = report_scene_open(s, options);
  if (code == 0)
    code = report_sweep_make_presets(&s->sweep, options, &s->setup);
  if (code == 0)
    code = report_scene_sweep(s, options, deadline_ms);
  if (code == 0) {
    print_scene(output_table(options), s, &options->against);
    json_array_append_new(scenes, scene_to_json(s, &options->against));
    code = report_scene_differs(s) ? HOST_DIFFER : 0;
  }
  report_scene_free(s);
  free(s);
  return code;
}

int preset_table_command(const host_options *asked) {
  host_options options = *asked;
  const uint32_t suns = asked->sun_count ? asked->sun_count : 1;
  const uint32_t count = (asked->scene_count ? asked->scene_count : 1) * suns;
  const double end_ms = host_now_ms() + asked->minutes * 60e3;
  int code = 0;
  if (asked->camera_path || asked->light_path || asked->dump)
    return host_fail(HOST_BAD_INPUT, "--presets: takes no --camera-path, --light-path or --dump");
  json_t *scenes = json_array();
  for (uint32_t i = 0; (code == 0 || code == HOST_DIFFER) && i < count; i++) {
    const double now_ms = host_now_ms();
    options.scene = asked->scene_count ? asked->scenes[i / suns] : asked->scene;
    options.has_disc = asked->sun_count > 0;
    options.disc_deg = asked->suns[i % suns];
    const int last = measure_scene(&options, now_ms + (end_ms - now_ms) / (count - i), scenes);
    code = last ? last : code;
  }
  const int written = output_json(asked, scenes);
  return code ? code : written;
}
