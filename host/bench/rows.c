#include "bench/rows.h"
#include "base/host.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* More rows in a group share the base's time, and hold maps at the same time. */
enum { group_rows = 4, warm_up = 1, most_lanes = 1 + HOST_BACKENDS * (1 + group_rows) };

/* What is drawn once in every round. */
typedef struct lane {
  const bench_row *row;
  stage *stage; /* NULL: the floor */
  csm_cascades *cascades;
  csm_view *view; /* its own, for its own history */
  double *samples;
} lane;

typedef struct group {
  lane lanes[most_lanes];
  uint32_t count;
  bench_floor floor;
  const bench_table *table;
} group;

static csm_mask_info mask_of(const lane *l, uint32_t flags) {
  return (csm_mask_info){.struct_size = sizeof(csm_mask_info),
                         .flags = flags,
                         .frame = &l->stage->frame,
                         .width = l->stage->setup->width,
                         .height = l->stage->setup->height};
}

static csm_result resolve(const lane *l, uint32_t flags) {
  const csm_mask_info info = mask_of(l, flags);
  return csm_resolve_mask(l->view, l->cascades, &info);
}

/* Draws the cascades, after a look at the depth if they are drawn for it. */
static csm_result render(const lane *l) {
  const csm_mask_info info = mask_of(l, 0);
  csm_frame frame = l->stage->frame;
  frame.depth_view = l->row->depth ? l->view : NULL;
  const csm_result result = l->row->depth ? csm_reduce_depth(l->view, &info) : CSM_SUCCESS;
  return result ? result : csm_render_cascades(l->cascades, &frame);
}

static int add_lane(group *g, stage *s, const bench_row *row, uint32_t pairs) {
  lane *l = &g->lanes[g->count++];
  *l = (lane){.row = row, .stage = s, .samples = host_allocate(pairs, sizeof *l->samples)};
  if (!s)
    return 0;
  s->frame.flags = 0;
  if (csm_view_create(s->context, &l->view) || csm_cascades_create(s->context, &row->config, &l->cascades) || render(l))
    return host_fail(HOST_NO_DEVICE, "%s: %s: %s", s->backend, row->name, csm_last_error(s->context));
  return 0;
}

static int open_group(group *g, const bench_table *table, uint32_t first, stage *stages, uint32_t stage_count,
                      uint32_t pairs) {
  const uint32_t last = first + group_rows < table->count ? first + group_rows : table->count;
  int code = g->floor.draw ? add_lane(g, NULL, &table->base, pairs) : 0;
  for (uint32_t s = 0; s < stage_count && code == 0; s++) {
    code = add_lane(g, &stages[s], &table->base, pairs);
    for (uint32_t i = first; i < last && code == 0; i++)
      code = add_lane(g, &stages[s], &table->rows[i], pairs);
  }
  return code;
}

static void close_group(group *g) {
  for (uint32_t i = 0; i < g->count; i++) {
    csm_cascades_destroy(g->lanes[i].cascades);
    csm_view_destroy(g->lanes[i].view);
    free(g->lanes[i].samples);
  }
}

static double timed_ms(bench_timed timed, bool is_base, const stage_stats *stats) {
  switch (timed) {
  case BENCH_MASK:
    return stage_mask_ms(stats) + stage_history_ms(stats);
  case BENCH_PLANNED:
    return stage_maps_ms(stats) + stats->maps.plan_ms + fmax(stats->mask.reduce_gpu_ms, 0.0);
  case BENCH_FRAME:
    return stage_shadows_ms(stats);
  case BENCH_MOMENTS:
    return is_base ? stage_maps_ms(stats) : stats->maps.moments_gpu_ms;
  default:
    return stage_maps_ms(stats);
  }
}

static double draw_once(const group *g, const lane *l) {
  if (!l->stage)
    return g->floor.draw(g->floor.user);
  const bench_timed timed = g->table->timed;
  l->stage->frame.flags = timed == BENCH_MASK ? 0 : CSM_FRAME_TIMESTAMPS;
  if (timed == BENCH_MOMENTS) /* what does not change is not made anew */
    l->stage->light.direction[0] += 1e-3;
  stage_stats stats = {.maps.struct_size = sizeof stats.maps, .mask.struct_size = sizeof stats.mask};
  csm_result result = CSM_SUCCESS;
  if (timed != BENCH_MASK)
    result = render(l);
  if (!result && (timed == BENCH_MASK || timed == BENCH_FRAME))
    result = resolve(l, CSM_FRAME_TIMESTAMPS);
  if (result || csm_get_stats(l->cascades, &stats.maps) || csm_get_view_stats(l->view, &stats.mask))
    return -1.0;
  return timed_ms(timed, l->row == &g->table->base, &stats);
}

static int time_group(const group *g, const bench_table *table, uint32_t pairs) {
  for (uint32_t round = 0; round < warm_up + pairs; round++) {
    char text[96];
    snprintf(text, sizeof text, "%s: %s and on, round %u of %u", table->name, g->lanes[g->count - 1].row->name,
             round + 1, warm_up + pairs);
    host_progress(text);
    for (uint32_t i = 0; i < g->count; i++) {
      const double ms = draw_once(g, &g->lanes[i]);
      if (!(ms > 0.0))
        return host_fail(HOST_NO_DEVICE, "%s: %s: a frame failed, or was not timed", table->name,
                         g->lanes[i].row->name);
      if (round >= warm_up)
        g->lanes[i].samples[round - warm_up] = ms;
    }
  }
  host_progress("");
  return 0;
}

/* The lane of the same row on the first stage. */
static const lane *first_of(const group *g, const lane *l) {
  for (uint32_t i = 0; i < g->count; i++)
    if (g->lanes[i].stage && g->lanes[i].row == l->row)
      return &g->lanes[i];
  return l;
}

static void take_results(bench_rows *out, const group *g, bool with_base) {
  const lane *base = NULL;
  for (uint32_t i = 0; i < g->count; i++) {
    const lane *l = &g->lanes[i];
    const bool is_base = l->stage && (!base || base->stage != l->stage);
    if (is_base)
      base = l;
    if (!l->stage || (is_base && !with_base))
      continue;
    bench_result *result = &out->results[out->count++];
    *result = (bench_result){.row = l->row->name,
                             .backend = l->stage->backend,
                             .ms = estimate_median(l->samples, out->pairs),
                             .to_first = estimate_ratio(l->samples, first_of(g, l)->samples, out->pairs),
                             .to_base = estimate_ratio(l->samples, base->samples, out->pairs),
                             .most_floors = l->row->most_floors,
                             .most_bases = l->row->most_bases};
    if (out->has_floor)
      result->to_floor = estimate_ratio(l->samples, g->lanes[0].samples, out->pairs);
  }
}

int bench_rows_run(bench_rows *out, const bench_table *table, stage *stages, uint32_t stage_count, bench_floor floor,
                   uint32_t pairs) {
  int code = 0;
  *out = (bench_rows){.table = *table, .pairs = pairs, .has_floor = floor.draw != NULL};
  for (uint32_t first = 0; first < table->count && code == 0; first += group_rows) {
    group g = {.floor = floor, .table = &out->table};
    code = open_group(&g, &out->table, first, stages, stage_count, pairs);
    if (code == 0)
      code = time_group(&g, &out->table, pairs);
    if (code == 0)
      take_results(out, &g, first == 0);
    close_group(&g);
  }
  return code;
}

void bench_print_line(FILE *to, const char *name, const estimate *value) {
  fprintf(to, "  %-32s %9.3f   %8.3f .. %-8.3f\n", name, value->median, value->low, value->high);
}

void bench_rows_print(FILE *to, const bench_rows *rows) {
  char base[64];
  snprintf(base, sizeof base, "/ %s", rows->table.base.name);
  fprintf(to, "\n%s: %s; GPU time, %u rounds in turn\n\n  %-24s %-8s %9s   %-9s %-18s", rows->table.name,
          rows->table.about, rows->pairs, "", "backend", "median ms", base, "95 % interval");
  fprintf(to, " / first");
  fprintf(to, rows->has_floor ? "  / floor   95 %% interval\n" : "\n");
  for (uint32_t i = 0; i < rows->count; i++) {
    const bench_result *r = &rows->results[i];
    fprintf(to, "  %-24s %-8s %9.2f   %9.3f %7.3f .. %-7.3f", r->row, r->backend, r->ms.median, r->to_base.median,
            r->to_base.low, r->to_base.high);
    fprintf(to, "  %6.3f", r->to_first.median);
    if (rows->has_floor)
      fprintf(to, " %8.3f %7.3f .. %-7.3f", r->to_floor.median, r->to_floor.low, r->to_floor.high);
    if (rows->has_floor && r->most_floors > 0.0)
      fprintf(to, "  at most %.1f: %s", r->most_floors, r->to_floor.median <= r->most_floors ? "yes" : "NO");
    if (r->most_bases > 0.0)
      fprintf(to, "  at most %.2f: %s", r->most_bases, r->to_base.median <= r->most_bases ? "yes" : "NO");
    fprintf(to, "\n");
  }
}

json_t *bench_rows_to_json(const bench_rows *rows) {
  json_t *object = json_object(), *list = json_array();
  for (uint32_t i = 0; i < rows->count; i++) {
    const bench_result *r = &rows->results[i];
    json_t *row = json_object();
    json_object_set_new(row, "name", json_string(r->row));
    json_object_set_new(row, "backend", json_string(r->backend));
    json_object_set_new(row, "gpu_ms", estimate_to_json(&r->ms));
    json_object_set_new(row, "to_base", estimate_to_json(&r->to_base));
    json_object_set_new(row, "to_first", estimate_to_json(&r->to_first));
    if (rows->has_floor)
      json_object_set_new(row, "to_floor", estimate_to_json(&r->to_floor));
    if (r->most_floors > 0.0)
      json_object_set_new(row, "at_most_floors", json_real(r->most_floors));
    if (r->most_bases > 0.0)
      json_object_set_new(row, "at_most_bases", json_real(r->most_bases));
    json_array_append_new(list, row);
  }
  json_object_set_new(object, "about", json_string(rows->table.about));
  json_object_set_new(object, "base", json_string(rows->table.base.name));
  json_object_set_new(object, "pairs", json_integer(rows->pairs));
  json_object_set_new(object, "rows", list);
  return object;
}
