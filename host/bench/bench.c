#include "bench/bench.h"
#include "base/host.h"
#include "base/statistics.h"
#include "bench/bare.h"
#include "bench/drawn_moments.h"
#include "bench/engine.h"
#include "bench/floor.h"
#include "bench/pages.h"
#include "bench/rays.h"
#include "bench/rows.h"
#include "bench/scene_plan.h"
#include "bench/switching.h"
#include "setup/config_json.h"
#include "setup/output.h"
#include "stage/stage.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PAIRS 31u
#define QUICK_PAIRS 5u
#define WARM_UP 3u
#define MANY_INSTANCES 10000u
#define SWITCH_ROUNDS 7u
#define ENGINE_ROUNDS 201u
#define QUICK_ROUNDS 31u
#define BENCH_TABLES 6
#define MAX_CONTENDERS (HOST_BACKENDS + 1)

/* Filters that look at the size of the light have something to look at. */
static const double sun_deg = 0.53;

/* What is timed: a backend's depth pass, or the bare loop where stage is NULL. */
typedef struct contender {
  const char *name;
  stage *stage;
  double *samples; /* ms, one for each round */
} contender;

typedef struct bench {
  const host_options *options;
  host_setup setup;
  bench_plan plan;
  floor_loop *floor;
  stage stages[HOST_BACKENDS];
  uint32_t stage_count;
  contender contenders[MAX_CONTENDERS];
  uint32_t contender_count;
  uint32_t pairs;
  estimate many_plan; /* planning MANY_INSTANCES */
  bench_switch switching;
  bench_engine engine; /* drawing them on an engine's Vulkan device */
  bench_bare bare;
  bench_drawn drawn[2];          /* VSM, EVSM4 */
  bench_rows rows[BENCH_TABLES]; /* as many as were wanted */
  uint32_t table_count;
  bench_rays rays;
  bench_pages pages[HOST_BACKENDS]; /* as many as there are stages, if they are wanted */
} bench;

/* ---- setting up ---- */

static void add_contender(bench *b, const char *name, stage *s) {
  b->contenders[b->contender_count++] =
      (contender){.name = name, .stage = s, .samples = host_allocate(b->pairs, sizeof(double))};
}

/* The bare loop is there to compare Vulkan with. */
static int open_floor(bench *b) {
  char error[512] = "";
  if (!b->options->backends[0])
    return 0;
  const floor_info info = {.scene = &b->setup.scene,
                           .frame = &b->plan.frame,
                           .plan_scene = &b->plan.scene,
                           .resolution = b->setup.config.resolution,
                           .device = b->options->device};
  const int code = floor_open(&b->floor, &info, error, sizeof error);
  if (code)
    return host_fail(code, "floor: %s", error);
  add_contender(b, "floor", NULL);
  return 0;
}

static int open_stages(bench *b) {
  for (int i = 0; i < HOST_BACKENDS; i++)
    if (b->options->backends[i]) {
      stage *s = &b->stages[b->stage_count++];
      int code = stage_open(s, host_backend_names[i], b->options->device);
      if (code == 0)
        code = stage_load(s, &b->setup);
      if (code)
        return code;
      add_contender(b, host_backend_names[i], s);
    }
  return 0;
}

static int open_all(bench *b) {
  b->pairs = b->options->quick ? QUICK_PAIRS : PAIRS;
  int code = setup_load(&b->setup, b->options);
  if (!b->options->has_light && !b->options->has_disc)
    b->setup.light.disc_deg = sun_deg;
  if (code == 0)
    code = bench_plan_make(&b->plan, &b->setup, (uint32_t)b->setup.scene.instance_count);
  if (code == 0)
    code = open_floor(b);
  return code ? code : open_stages(b);
}

static void close_all(bench *b) {
  for (uint32_t i = 0; i < b->contender_count; i++)
    free(b->contenders[i].samples);
  for (uint32_t i = 0; i < b->stage_count; i++)
    stage_close(&b->stages[i]);
  floor_close(b->floor);
  bench_plan_free(&b->plan);
  setup_free(&b->setup);
}

/* ---- timing ---- */

/* Wall-clock time of one frame of maps: planned, recorded, submitted and waited for. Negative after an error. */
static double time_frame(const bench *b, const contender *c) {
  if (!c->stage)
    return floor_frame(b->floor);
  const double start = host_now_ms();
  return stage_render(c->stage) == 0 ? host_now_ms() - start : -1.0;
}

static int time_all(bench *b) {
  for (uint32_t round = 0; round < WARM_UP + b->pairs; round++) {
    char text[64];
    snprintf(text, sizeof text, "round %u of %u", round + 1, WARM_UP + b->pairs);
    host_progress(text);
    for (uint32_t i = 0; i < b->contender_count; i++) {
      const contender *c = &b->contenders[i];
      const double ms = time_frame(b, c);
      if (ms < 0.0)
        return host_fail(HOST_NO_DEVICE, "%s: a frame failed", c->name);
      if (round >= WARM_UP)
        c->samples[round - WARM_UP] = ms;
    }
  }
  host_progress("");
  return 0;
}

static estimate time_of(const bench *b, const contender *c) {
  return estimate_median(c->samples, b->pairs);
}

static estimate ratio_of(const bench *b, const contender *top, const contender *bottom) {
  return estimate_ratio(top->samples, bottom->samples, b->pairs);
}

static int time_planning(bench *b) {
  bench_plan many;
  int code = bench_plan_make(&many, &b->setup, MANY_INSTANCES);
  if (code == 0)
    b->many_plan = bench_plan_time(&many, &b->setup, b->pairs);
  if (code == 0 && b->floor)
    code = bench_engine_run(&b->engine, &b->setup, &many, b->options->device,
                            b->options->quick ? QUICK_ROUNDS : ENGINE_ROUNDS);
  bench_plan_free(&many);
  return code;
}

static int time_switching(bench *b) {
  if (b->stage_count < HOST_BACKENDS)
    return 0;
  return bench_switch_run(&b->switching, &b->setup, b->options->device, b->options->quick ? 2 : SWITCH_ROUNDS);
}

/* ---- tables of configurations ---- */

static bool wanted(const bench *b, const char *part) {
  return !b->options->only || strcmp(b->options->only, part) == 0;
}

static double draw_floor(void *user) {
  return floor_frame(user) < 0.0 ? -1.0 : floor_gpu_ms(user);
}

static double draw_bare_floor(void *user) {
  return bare_mask_draw(user, BARE_FLOOR);
}

static int time_table(bench *b, const bench_table *table, bench_floor floor) {
  if (!wanted(b, table->name))
    return 0;
  return bench_rows_run(&b->rows[b->table_count++], table, b->stages, b->stage_count, floor, b->pairs);
}

/* The bare pass's device is open only while it is needed. */
static int time_masks(bench *b) {
  bench_table table;
  bare_mask *bare = NULL;
  int code = 0;
  if (b->floor && (wanted(b, "floors") || wanted(b, "filters") || wanted(b, "modes")))
    code = bench_bare_open(&bare, &b->stages[0], &b->setup.config, &b->plan, b->options->device);
  const bench_floor floor = {bare ? draw_bare_floor : NULL, bare};
  bench_table_floors(&table, &b->setup.config);
  if (code == 0)
    code = time_table(b, &table, floor);
  bench_table_filters(&table, &b->setup.config);
  if (code == 0)
    code = time_table(b, &table, floor);
  bench_table_modes(&table, &b->setup.config);
  if (code == 0)
    code = time_table(b, &table, floor);
  bare_mask_close(bare);
  return code;
}

static int time_drawn(bench *b) {
  const int code = bench_drawn_run(&b->drawn[0], &b->stages[0], FLOOR_VSM, b->options->device, b->pairs);
  return code ? code : bench_drawn_run(&b->drawn[1], &b->stages[0], FLOOR_EVSM4, b->options->device, b->pairs);
}

static int time_tables(bench *b) {
  bench_table table;
  int code = time_masks(b);
  bench_table_maps(&table, &b->setup.config);
  if (code == 0)
    code = time_table(b, &table, (bench_floor){b->floor ? draw_floor : NULL, b->floor});
  bench_table_casters(&table, &b->setup.config, b->setup.scene.name);
  if (code == 0)
    code = time_table(b, &table, (bench_floor){0});
  if (code == 0 && b->floor && (wanted(b, "moments") || wanted(b, "drawn")))
    code = time_drawn(b);
  bench_table_moments(&table, &b->setup.config);
  if (code == 0)
    code = time_table(b, &table, (bench_floor){0});
  if (code == 0 && b->floor && wanted(b, "bare"))
    code = bench_bare_run(&b->bare, &b->stages[0], &b->setup.config, &b->plan, b->options->device, b->pairs);
  return code;
}

static int time_rays(bench *b) {
  bench_plan many;
  if (!wanted(b, "rays"))
    return 0;
  int code = bench_plan_make(&many, &b->setup, MANY_INSTANCES);
  if (code == 0)
    code = bench_rays_run(&b->rays, b->stages, b->stage_count, &many, b->options, b->pairs);
  bench_plan_free(&many);
  return code;
}

static int time_pages(bench *b) {
  int code = 0;
  for (uint32_t i = 0; i < b->stage_count && wanted(b, "pages") && code == 0; i++)
    code = bench_pages_run(&b->pages[i], &b->stages[i], b->options->device, b->pairs);
  return code;
}

/* ---- results ---- */

/* What a contender may take at most, as a multiple of the one before it: Vulkan of the bare loop, D3D12 of Vulkan. */
static double ratio_limit(const contender *top) {
  return strcmp(top->name, "vulkan") == 0 ? 1.05 : 1.1;
}

static const char *device_of(const bench *b, const contender *c) {
  return c->stage ? c->stage->device : b->stages[0].device;
}

static void print_setup(FILE *to, const bench *b) {
  const host_setup *setup = &b->setup;
  fprintf(to, "scene %s: %u maps of %u x %u, %zu instances, %" PRIu64 " triangles; %u rounds in turn, %ld cores\n",
          setup->scene.name, setup->config.cascade_count, setup->config.resolution, setup->config.resolution,
          setup->scene.instance_count, scene_triangles(&setup->scene), b->pairs, sysconf(_SC_NPROCESSORS_ONLN));
}

static void print_results(FILE *to, const bench *b) {
  fprintf(to, "\n  %-14s %9s   %-21s device\n", "", "median ms", "95 % interval");
  for (uint32_t i = 0; i < b->contender_count; i++) {
    const contender *c = &b->contenders[i];
    const estimate ms = time_of(b, c);
    fprintf(to, "  %-14s %9.2f   %8.2f .. %-8.2f  %s; %s\n", c->name, ms.median, ms.low, ms.high, device_of(b, c),
            c->stage ? c->stage->driver : "the same driver");
  }
  if (b->contender_count > 1)
    fprintf(to, "\n  %-14s %9s   %-21s at most\n", "ratio", "median", "95 % interval");
  for (uint32_t i = 1; i < b->contender_count; i++) {
    const contender *top = &b->contenders[i], *bottom = top - 1;
    const estimate ratio = ratio_of(b, top, bottom);
    char name[64];
    snprintf(name, sizeof name, "%s / %s", top->name, bottom->name);
    fprintf(to, "  %-14s %9.3f   %8.3f .. %-8.3f  %.2f: %s\n", name, ratio.median, ratio.low, ratio.high,
            ratio_limit(top), ratio.median <= ratio_limit(top) ? "yes" : "NO");
  }
  const double frame = time_of(b, &b->contenders[b->contender_count - b->stage_count]).median;
  fprintf(to, "\n  planning %u instances for %u cascades: %.3f ms (%.3f .. %.3f), %.2f %% of a %s frame\n",
          MANY_INSTANCES, b->setup.config.cascade_count, b->many_plan.median, b->many_plan.low, b->many_plan.high,
          100.0 * b->many_plan.median / frame, b->stages[0].backend);
}

static void print_switching(FILE *to, const bench *b) {
  const bench_switch *s = &b->switching;
  for (int i = 0; i < HOST_BACKENDS && s->rounds; i++)
    fprintf(to, "  csm_switch_backend to %s: %.1f ms (%.1f .. %.1f), %u times\n", host_backend_names[i],
            s->switch_ms[i].median, s->switch_ms[i].low, s->switch_ms[i].high, s->rounds);
}

static json_t *named_estimate(const char *name, const estimate *value) {
  json_t *object = estimate_to_json(value);
  json_object_set_new(object, "name", json_string(name));
  return object;
}

static json_t *time_to_json(const bench *b, const contender *c) {
  const estimate ms = time_of(b, c);
  json_t *object = named_estimate(c->name, &ms), *samples = json_array();
  for (uint32_t i = 0; i < b->pairs; i++)
    json_array_append_new(samples, json_real(c->samples[i]));
  json_object_set_new(object, "samples", samples);
  json_object_set_new(object, "device", json_string(device_of(b, c)));
  if (c->stage)
    json_object_set_new(object, "driver", json_string(c->stage->driver));
  return object;
}

static void depth_to_json(json_t *object, const bench *b) {
  json_t *times = json_array(), *ratios = json_array();
  for (uint32_t i = 0; i < b->contender_count; i++)
    json_array_append_new(times, time_to_json(b, &b->contenders[i]));
  for (uint32_t i = 1; i < b->contender_count; i++) {
    const contender *top = &b->contenders[i], *bottom = top - 1;
    const estimate value = ratio_of(b, top, bottom);
    char name[64];
    snprintf(name, sizeof name, "%s/%s", top->name, bottom->name);
    json_t *ratio = named_estimate(name, &value);
    json_object_set_new(ratio, "at_most", json_real(ratio_limit(top)));
    json_array_append_new(ratios, ratio);
  }
  json_t *planning = named_estimate("plan_ms", &b->many_plan);
  json_object_set_new(planning, "instances", json_integer(MANY_INSTANCES));
  json_object_set_new(object, "depth_ms", times);
  json_object_set_new(object, "ratios", ratios);
  json_object_set_new(object, "planning", planning);
  for (int i = 0; i < HOST_BACKENDS && b->switching.rounds; i++)
    json_object_set_new(object, i ? "switch_to_d3d12_ms" : "switch_to_vulkan_ms",
                        named_estimate(host_backend_names[i], &b->switching.switch_ms[i]));
  if (b->engine.rounds)
    json_object_set_new(object, "engine", bench_engine_to_json(&b->engine));
}

static json_t *results_to_json(const bench *b) {
  json_t *object = json_object(), *drivers = json_object();
  for (uint32_t i = 0; i < b->stage_count; i++)
    json_object_set_new(drivers, b->stages[i].backend, json_string(b->stages[i].driver));
  json_object_set_new(object, "scene", json_string(b->setup.scene.name));
  json_object_set_new(object, "cores", json_integer(sysconf(_SC_NPROCESSORS_ONLN)));
  json_object_set_new(object, "pairs", json_integer(b->pairs));
  json_object_set_new(object, "config", config_to_json(&b->setup.config));
  json_object_set_new(object, "drivers", drivers);
  if (wanted(b, "depth"))
    depth_to_json(object, b);
  for (uint32_t i = 0; i < b->table_count; i++)
    json_object_set_new(object, b->rows[i].table.name, bench_rows_to_json(&b->rows[i]));
  if (b->drawn[0].pairs)
    json_object_set_new(object, "drawn",
                        json_pack("{s:o,s:o}", b->drawn[0].name, bench_drawn_to_json(&b->drawn[0]), b->drawn[1].name,
                                  bench_drawn_to_json(&b->drawn[1])));
  if (b->bare.pairs)
    json_object_set_new(object, "bare", bench_bare_to_json(&b->bare));
  if (b->rays.pairs)
    json_object_set_new(object, "rays", bench_rays_to_json(&b->rays));
  if (b->pages[0].frames)
    json_object_set_new(object, "pages", json_array());
  for (uint32_t i = 0; i < b->stage_count && b->pages[i].frames; i++)
    json_array_append_new(json_object_get(object, "pages"), bench_pages_to_json(&b->pages[i]));
  return object;
}

static void print_all(FILE *to, const bench *b) {
  print_setup(to, b);
  if (wanted(b, "depth")) {
    print_results(to, b);
    if (b->engine.rounds)
      bench_engine_print(to, &b->engine);
    print_switching(to, b);
  } else {
    for (uint32_t i = 0; i < b->stage_count; i++)
      fprintf(to, "  %-8s %s; %s\n", b->stages[i].backend, b->stages[i].device, b->stages[i].driver);
  }
  for (uint32_t i = 0; i < b->table_count; i++)
    bench_rows_print(to, &b->rows[i]);
  for (int i = 0; i < 2 && b->drawn[i].pairs; i++)
    bench_drawn_print(to, &b->drawn[i]);
  if (b->bare.pairs)
    bench_bare_print(to, &b->bare);
  if (b->rays.pairs)
    bench_rays_print(to, &b->rays);
  for (uint32_t i = 0; i < b->stage_count && b->pages[i].frames; i++)
    bench_pages_print(to, &b->pages[i]);
}

static int time_depth(bench *b) {
  int code = time_all(b);
  if (code == 0)
    code = time_planning(b);
  return code ? code : time_switching(b);
}

int bench_command(const host_options *options) {
  bench *b = host_allocate(1, sizeof *b);
  b->options = options;
  int code = open_all(b);
  if (code == 0 && wanted(b, "depth"))
    code = time_depth(b);
  if (code == 0)
    code = time_tables(b);
  if (code == 0)
    code = time_rays(b);
  if (code == 0)
    code = time_pages(b);
  if (code == 0) {
    print_all(output_table(options), b);
    code = output_json(options, results_to_json(b));
  }
  close_all(b);
  free(b);
  return code;
}
