#include "bench/drawn_moments.h"
#include "base/host.h"
#include "bench/rows.h"
#include "bench/scene_plan.h"
#include "bench/shaders/drawn_moments.h"
#include <stdlib.h>

enum { warm_up = 2 };

/* What is drawn once in every round, and the sum of two of them. */
enum { LANE_DEPTH, LANE_DRAWN, LANE_MADE, LANE_SUM, LANE_COUNT };

typedef struct race {
  host_setup setup; /* as the stage's, but for its configuration */
  bench_plan plan;
  floor_loop *loops[2]; /* LANE_DEPTH, LANE_DRAWN */
  stage *stage;
  double *samples[LANE_COUNT];
} race;

static int open_loop(race *r, uint32_t lane, floor_moments moments, const char *device) {
  char error[512] = "";
  const floor_info info = {.scene = &r->setup.scene,
                           .frame = &r->plan.frame,
                           .plan_scene = &r->plan.scene,
                           .resolution = r->setup.config.resolution,
                           .moments = moments,
                           .device = device};
  const int code = floor_open(&r->loops[lane], &info, error, sizeof error);
  return code ? host_fail(code, "moments drawn: %s", error) : 0;
}

static int open_race(race *r, stage *s, floor_moments moments, const char *device) {
  r->stage = s;
  r->setup = *s->setup;
  bench_moments_config(&r->setup.config, moments == FLOOR_VSM ? CSM_FILTER_VSM : CSM_FILTER_EVSM4, 0);
  r->setup.config.moment_exponent = DRAWN_EXPONENT;
  r->setup.config.moment_exponent_negative = DRAWN_EXPONENT_NEGATIVE;
  int code = bench_plan_make(&r->plan, &r->setup, (uint32_t)r->setup.scene.instance_count);
  if (code == 0)
    code = open_loop(r, LANE_DEPTH, FLOOR_DEPTH, device);
  if (code == 0)
    code = open_loop(r, LANE_DRAWN, moments, device);
  return code ? code : stage_configure(s, &r->setup.config);
}

static void close_race(race *r) {
  floor_close(r->loops[LANE_DEPTH]);
  floor_close(r->loops[LANE_DRAWN]);
  bench_plan_free(&r->plan);
  for (int i = 0; i < LANE_COUNT; i++)
    free(r->samples[i]);
}

static double draw_bare(floor_loop *loop) {
  return floor_frame(loop) < 0.0 ? -1.0 : floor_gpu_ms(loop);
}

static double make_moments(stage *s) {
  csm_stats stats = {.struct_size = sizeof stats};
  s->frame.flags = CSM_FRAME_TIMESTAMPS;
  return stage_stir(s) || csm_render_cascades(s->cascades, &s->frame) || csm_get_stats(s->cascades, &stats)
             ? -1.0
             : stats.moments_gpu_ms;
}

static int draw_in_turn(race *r, uint32_t pairs) {
  for (uint32_t round = 0; round < warm_up + pairs; round++) {
    host_progress("moments, drawn and made");
    const double ms[] = {draw_bare(r->loops[LANE_DEPTH]), draw_bare(r->loops[LANE_DRAWN]), make_moments(r->stage)};
    for (int lane = 0; lane < LANE_SUM; lane++) {
      if (!(ms[lane] > 0.0))
        return host_fail(HOST_NO_DEVICE, "moments drawn: a frame failed, or was not timed");
      if (round >= warm_up)
        r->samples[lane][round - warm_up] = ms[lane];
    }
    if (round >= warm_up)
      r->samples[LANE_SUM][round - warm_up] = ms[LANE_DEPTH] + ms[LANE_MADE];
  }
  host_progress("");
  return 0;
}

int bench_drawn_run(bench_drawn *out, stage *s, floor_moments moments, const char *device, uint32_t pairs) {
  race *r = host_allocate(1, sizeof *r);
  for (int i = 0; i < LANE_COUNT; i++)
    r->samples[i] = host_allocate(pairs, sizeof *r->samples[i]);
  int code = open_race(r, s, moments, device);
  if (code == 0)
    code = draw_in_turn(r, pairs);
  if (code == 0)
    *out = (bench_drawn){.name = moments == FLOOR_VSM ? "vsm" : "evsm4",
                         .pairs = pairs,
                         .depth = estimate_median(r->samples[LANE_DEPTH], pairs),
                         .drawn = estimate_median(r->samples[LANE_DRAWN], pairs),
                         .made = estimate_median(r->samples[LANE_MADE], pairs),
                         .to_made = estimate_ratio(r->samples[LANE_DRAWN], r->samples[LANE_SUM], pairs),
                         .more_drawn = estimate_ratio(r->samples[LANE_DRAWN], r->samples[LANE_DEPTH], pairs),
                         .more_made = estimate_ratio(r->samples[LANE_SUM], r->samples[LANE_DEPTH], pairs)};
  close_race(r);
  free(r);
  return code;
}

void bench_drawn_print(FILE *to, const bench_drawn *drawn) {
  fprintf(to,
          "\n%s written while 4 maps of 1024 x 1024 are drawn, to making it of their depths; bare Vulkan, %u rounds in "
          "turn\n\n",
          drawn->name, drawn->pairs);
  bench_print_line(to, "depth alone, GPU ms", &drawn->depth);
  bench_print_line(to, "with moments, GPU ms", &drawn->drawn);
  bench_print_line(to, "csm's conversion, GPU ms", &drawn->made);
  bench_print_line(to, "with moments / depth", &drawn->more_drawn);
  bench_print_line(to, "(depth + conversion) / depth", &drawn->more_made);
  bench_print_line(to, "with moments / (depth + conversion)", &drawn->to_made);
}

json_t *bench_drawn_to_json(const bench_drawn *drawn) {
  json_t *object = json_object();
  json_object_set_new(object, "pairs", json_integer(drawn->pairs));
  json_object_set_new(object, "depth_ms", estimate_to_json(&drawn->depth));
  json_object_set_new(object, "drawn_ms", estimate_to_json(&drawn->drawn));
  json_object_set_new(object, "made_ms", estimate_to_json(&drawn->made));
  json_object_set_new(object, "drawn/depth", estimate_to_json(&drawn->more_drawn));
  json_object_set_new(object, "made/depth", estimate_to_json(&drawn->more_made));
  json_object_set_new(object, "drawn/made", estimate_to_json(&drawn->to_made));
  return object;
}
