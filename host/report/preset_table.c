#include "report/preset_table.h"
#include "base/host.h"
#include "report/one_scene.h"
#include "setup/output.h"
#include <stdlib.h>

/* What the GPU takes for shadows alone. */
static double gpu_ms(const report_sweep *sweep, uint32_t point, uint32_t backend, uint32_t round) {
  const report_point *p = &sweep->points[point];
  return p->samples[backend][REPORT_MAPS_MS][round] + p->samples[backend][REPORT_MASK_MS][round];
}

typedef struct cost {
  estimate gpu_ms;
  estimate ratio; /* to the base in the same round */
} cost;

static cost cost_of(const report_sweep *sweep, uint32_t point, uint32_t backend) {
  double own[REPORT_MAX_ROUNDS], base[REPORT_MAX_ROUNDS];
  for (uint32_t round = 0; round < sweep->rounds; round++) {
    own[round] = gpu_ms(sweep, point, backend, round);
    base[round] = gpu_ms(sweep, sweep->base, backend, round);
  }
  return (cost){.gpu_ms = estimate_median(own, sweep->rounds), .ratio = estimate_ratio(own, base, sweep->rounds)};
}

/* ---- telling ---- */

static void print_row(FILE *to, const report_scene *s, uint32_t point, uint32_t backend) {
  const report_point *p = &s->sweep.points[point];
  const metrics *m = &p->metrics[backend];
  const cost c = cost_of(&s->sweep, point, backend);
  fprintf(to, "| %s | %.3f | %.3f | %.3f | %.3f | %.3f | ", p->name, 100.0 * m->false_lit, 100.0 * m->false_shadow,
          100.0 * (m->false_lit + m->false_shadow), 100.0 * m->leak, 100.0 * m->acne);
  if (m->edge_px < 0.0)
    fputs("none", to);
  else
    fprintf(to, "%.2f", m->edge_px);
  fprintf(to, " | %.1f | %.2f (%.2f to %.2f) |\n", c.gpu_ms.median, c.ratio.median, c.ratio.low, c.ratio.high);
}

static void print_scene(FILE *to, const report_scene *s) {
  for (uint32_t b = 0; b < s->stage_count; b++) {
    fprintf(to, "%s, %ux%u, shadows to %g m, %s on %s, %u round%s, %.0f s\n\n", s->setup.scene.name, s->setup.width,
            s->setup.height, s->setup.shadow_distance, s->stages[b].backend, s->stages[b].device, s->sweep.rounds,
            s->sweep.rounds == 1 ? "" : "s", s->seconds);
    fputs("| preset | false lit % | false shadow % | sum % | leak % | acne % | edge px | maps + mask ms | times the "
          "first |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
          to);
    for (uint32_t p = 0; p < s->sweep.count; p++)
      print_row(to, s, p, b);
    fputc('\n', to);
  }
}

static json_t *result_to_json(const report_scene *s, uint32_t point, uint32_t backend) {
  const cost c = cost_of(&s->sweep, point, backend);
  json_t *object = json_object();
  json_object_set_new(object, "metrics", metrics_to_json(&s->sweep.points[point].metrics[backend]));
  json_object_set_new(object, "gpu_ms", estimate_to_json(&c.gpu_ms));
  json_object_set_new(object, "ratio", estimate_to_json(&c.ratio));
  return object;
}

static json_t *preset_to_json(const report_scene *s, uint32_t point) {
  const report_point *p = &s->sweep.points[point];
  json_t *object = json_object(), *backends = json_object();
  for (uint32_t b = 0; b < s->stage_count; b++)
    json_object_set_new(backends, s->stages[b].backend, result_to_json(s, point, b));
  json_object_set_new(object, "preset", json_string(p->name));
  json_object_set_new(object, "map_bytes", json_integer((json_int_t)p->map_bytes));
  json_object_set_new(object, "backends", backends);
  if (s->stage_count == HOST_BACKENDS)
    json_object_set_new(object, "differing_pixels", json_integer((json_int_t)p->differing));
  return object;
}

static json_t *scene_to_json(const report_scene *s) {
  json_t *object = json_object(), *presets = json_array();
  for (uint32_t p = 0; p < s->sweep.count; p++)
    json_array_append_new(presets, preset_to_json(s, p));
  json_object_set_new(object, "scene", json_string(s->setup.scene.name));
  json_object_set_new(object, "width", json_integer(s->setup.width));
  json_object_set_new(object, "height", json_integer(s->setup.height));
  json_object_set_new(object, "shadow_distance", json_real(s->setup.shadow_distance));
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
    print_scene(output_table(options), s);
    json_array_append_new(scenes, scene_to_json(s));
    code = report_scene_differs(s) ? HOST_DIFFER : 0;
  }
  report_scene_free(s);
  free(s);
  return code;
}

int preset_table_command(const host_options *asked) {
  host_options options = *asked;
  const uint32_t count = asked->scene_count ? asked->scene_count : 1;
  const double end_ms = host_now_ms() + asked->minutes * 60e3;
  int code = 0;
  if (asked->camera_path || asked->light_path || asked->dump)
    return host_fail(HOST_BAD_INPUT, "--presets: takes no --camera-path, --light-path or --dump");
  json_t *scenes = json_array();
  for (uint32_t i = 0; (code == 0 || code == HOST_DIFFER) && i < count; i++) {
    const double now_ms = host_now_ms();
    options.scene = asked->scene_count ? asked->scenes[i] : asked->scene;
    const int last = measure_scene(&options, now_ms + (end_ms - now_ms) / (count - i), scenes);
    code = last ? last : code;
  }
  const int written = output_json(asked, scenes);
  return code ? code : written;
}
