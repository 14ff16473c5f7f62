/* report_json.c: a scene of a report as JSON: for programs, and for the page. */
#include "report/one_scene.h"
#include "scene/camera_json.h"
#include "setup/config_json.h"

static const char *const time_names[REPORT_TIMES] = {
    [REPORT_PLAN_MS] = "plan_ms",       [REPORT_RECORD_MS] = "record_ms", [REPORT_MAPS_MS] = "maps_ms",
    [REPORT_MOMENTS_MS] = "moments_ms", [REPORT_MASK_MS] = "mask_ms",     [REPORT_HISTORY_MS] = "history_ms",
    [REPORT_GPU_MS] = "gpu_ms",         [REPORT_SHADOW_MS] = "shadow_ms"};

json_t *report_verdict_to_json(const report_verdict *v) {
  json_t *object = json_object(), *front = json_array();
  for (uint32_t i = 0; i < v->front_count; i++)
    json_array_append_new(front, json_integer(v->front[i]));
  json_object_set_new(object, "least_error", json_integer(v->least_error));
  json_object_set_new(object, "knee", json_integer(v->knee));
  json_object_set_new(object, "base_error_rank", json_integer(v->error_rank));
  json_object_set_new(object, "base_time_rank", json_integer(v->time_rank));
  json_object_set_new(object, "better_than_base", json_integer(v->better));
  json_object_set_new(object, "front", front);
  return object;
}

/* ---- for programs ---- */

/* The fields that a sweep changes, and the point's name if it has one. */
static void add_swept_fields(json_t *object, const report_point *point) {
  static const char *const keys[] = {"cascade_count", "resolution", "filter", "bias_mode"};
  json_t *all = config_to_json(&point->config);
  for (size_t i = 0; i < sizeof keys / sizeof keys[0]; i++)
    json_object_set(object, keys[i], json_object_get(all, keys[i]));
  json_decref(all);
  if (point->name) {
    json_object_set_new(object, "name", json_string(point->name));
    json_object_set_new(object, "preset", json_boolean(point->is_preset));
  }
}

static json_t *result_to_json(const report_scene *s, uint32_t p, uint32_t b) {
  json_t *object = json_object();
  json_object_set_new(object, "error", json_real(report_error(s, &s->sweep.points[p].metrics[b])));
  for (int t = 0; t < REPORT_TIMES; t++) {
    const estimate ms = report_time_of(&s->sweep, p, b, (report_time)t);
    json_object_set_new(object, time_names[t], estimate_to_json(&ms));
  }
  json_object_set_new(object, "metrics", metrics_to_json(&s->sweep.points[p].metrics[b]));
  return object;
}

static json_t *point_to_json(const report_scene *s, uint32_t p) {
  const report_point *point = &s->sweep.points[p];
  json_t *object = json_object(), *results = json_object();
  add_swept_fields(object, point);
  json_object_set_new(object, "map_bytes", json_integer((json_int_t)point->map_bytes));
  json_object_set_new(object, "moment_bytes", json_integer((json_int_t)point->moment_bytes));
  json_object_set_new(object, "view_bytes", json_integer((json_int_t)point->view_bytes));
  for (uint32_t b = 0; b < s->stage_count; b++)
    json_object_set_new(results, s->stages[b].backend, result_to_json(s, p, b));
  json_object_set_new(object, "backends", results);
  if (s->stage_count == HOST_BACKENDS) {
    const estimate ratio = report_ratio_of(&s->sweep, p);
    json_object_set_new(object, "ratio", estimate_to_json(&ratio));
    json_object_set_new(object, "differing_pixels", json_integer((json_int_t)point->differing));
  }
  return object;
}

static json_t *truth_to_json(const report_scene *s) {
  const truth_convergence *convergence = &s->truth.convergence;
  json_t *object = json_object();
  json_object_set_new(object, "rays", json_integer(convergence->samples));
  json_object_set_new(object, "cached", json_boolean(s->store.cast == 0));
  json_object_set_new(object, "cast_s", json_real(s->store.cast_ms * 1e-3));
  if (convergence->samples > 1) {
    json_object_set_new(object, "rms_half", json_real(convergence->rms_half));
    json_object_set_new(object, "noise", json_real(report_noise(s)));
  }
  return object;
}

/* What both kinds of JSON hold. */
static json_t *head_to_json(const report_scene *s) {
  const host_setup *setup = &s->setup;
  json_t *object = json_object(), *verdicts = json_object();
  json_object_set_new(object, "scene", json_string(setup->scene.name));
  json_object_set_new(object, "triangles", json_integer((json_int_t)scene_triangles(&setup->scene)));
  json_object_set_new(object, "width", json_integer(setup->width));
  json_object_set_new(object, "height", json_integer(setup->height));
  json_object_set_new(object, "shadow_distance", json_real(setup->shadow_distance));
  json_object_set_new(object, "light", light_to_json(&setup->light));
  json_object_set_new(object, "truth", truth_to_json(s));
  json_object_set_new(object, "error", json_string(report_scene_is_soft(s) ? "rmse" : "wrong"));
  json_object_set_new(object, "rounds", json_integer(s->sweep.rounds));
  json_object_set_new(object, "seconds", json_real(s->seconds));
  json_object_set_new(object, "base", json_integer(s->sweep.base));
  for (uint32_t b = 0; b < s->stage_count; b++)
    json_object_set_new(verdicts, s->stages[b].backend, report_verdict_to_json(&s->verdicts[b]));
  json_object_set_new(object, "verdicts", verdicts);
  if (s->stage_count == HOST_BACKENDS) {
    const estimate ratio = report_ratio_of_all(&s->sweep);
    json_object_set_new(object, "ratio", estimate_to_json(&ratio));
    json_object_set_new(object, "differs", json_boolean(report_scene_differs(s)));
  }
  return object;
}

json_t *report_scene_to_json(const report_scene *s) {
  json_t *object = head_to_json(s), *points = json_array();
  json_object_set_new(object, "camera", camera_to_json(&s->setup.camera));
  json_object_set_new(object, "base_config", config_to_json(&s->setup.config));
  for (uint32_t p = 0; p < s->sweep.count; p++)
    json_array_append_new(points, point_to_json(s, p));
  json_object_set_new(object, "configurations", points);
  return object;
}

/* ---- for the page ---- */

/* In the order of the page's own list of columns. */
static json_t *result_to_row(const report_scene *s, uint32_t p, uint32_t b) {
  const metrics *m = &s->sweep.points[p].metrics[b];
  const double numbers[] = {m->false_lit, m->false_shadow, m->leak, m->acne, m->rmse, m->mean_absolute};
  json_t *row = json_array();
  for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
    json_array_append_new(row, json_real(numbers[i]));
  json_array_append_new(row, m->edge_px < 0.0 ? json_null() : json_real(m->edge_px));
  for (int t = 0; t < REPORT_TIMES; t++)
    json_array_append_new(row, json_real(report_time_of(&s->sweep, p, b, (report_time)t).median));
  const estimate ms = s->scores[b][p].ms;
  json_array_append_new(row, json_real(ms.low));
  json_array_append_new(row, json_real(ms.high));
  return row;
}

static json_t *point_to_row(const report_scene *s, uint32_t p) {
  const report_point *point = &s->sweep.points[p];
  json_t *row = json_array(), *swept = json_object();
  add_swept_fields(swept, point);
  json_array_append_new(row, swept);
  json_array_append_new(
      row, json_real((double)(point->map_bytes + point->moment_bytes + point->view_bytes) / (1024.0 * 1024.0)));
  json_array_append_new(row, s->stage_count == HOST_BACKENDS ? json_real(report_ratio_of(&s->sweep, p).median)
                                                             : json_null());
  for (uint32_t b = 0; b < s->stage_count; b++)
    json_array_append_new(row, result_to_row(s, p, b));
  return row;
}

json_t *report_scene_to_page(const report_scene *s) {
  json_t *object = head_to_json(s), *rows = json_array(), *pictures = json_array(), *techniques = json_array();
  for (uint32_t p = 0; p < s->sweep.count; p++)
    json_array_append_new(rows, point_to_row(s, p));
  for (uint32_t i = 0; i < s->picture_count; i++)
    json_array_append_new(pictures, json_pack("{s:i, s:s, s:s}", "point", (int)s->pictures[i].point, "drawn",
                                              s->pictures[i].drawn, "errors", s->pictures[i].errors));
  for (uint32_t i = 0; i < s->technique_count; i++)
    json_array_append_new(
        techniques, json_pack("{s:i, s:s}", "point", (int)s->techniques[i].point, "picture", s->techniques[i].picture));
  json_object_set_new(object, "rows", rows);
  json_object_set_new(object, "truth_picture", json_string(s->truth_picture));
  json_object_set_new(object, "pictures", pictures);
  json_object_set_new(object, "techniques", techniques);
  return object;
}
