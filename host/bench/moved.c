#include "bench/moved.h"
#include "base/host.h"
#include "bench/moving.h"
#include "bench/rows.h"
#include <stdlib.h>

enum { warm_up = 2 }; /* in the first frame all of them are new */

typedef struct side {
  host_setup setup; /* as the stage's, but for its filter */
  stage stage;
  bench_moving moving;
  double *frame_ms, *call_ms, *tree_ms;
} side;

static int open_side(side *o, int which, const stage *like, const bench_plan *many, const char *device) {
  o->setup = *like->setup;
  o->setup.config.filter = which == MOVED_RAYS ? CSM_FILTER_EXACT : CSM_FILTER_PCF_3X3;
  int code = stage_open_as(&o->stage, like->backend, device, which == MOVED_RAYS ? CSM_CREATE_RAYS : 0);
  if (code == 0)
    code = stage_load(&o->stage, &o->setup);
  if (code)
    return code;
  csm_scene *scene = NULL;
  bench_moving_make(&o->moving, many, &o->stage.assets);
  if (bench_moving_scene(&o->moving, o->stage.context, &scene))
    return host_fail(HOST_NO_DEVICE, "%s: %s", like->backend, csm_last_error(o->stage.context));
  o->stage.frame.scene = scene;
  return 0;
}

static void close_side(side *o) {
  stage_close(&o->stage);
  bench_moving_free(&o->moving);
  free(o->frame_ms);
  free(o->call_ms);
  free(o->tree_ms);
}

static csm_result draw(side *o, uint32_t round) {
  const csm_scene_batch batch = bench_moving_next(&o->moving, round);
  csm_stats stats = {.struct_size = sizeof stats};
  const double start_ms = host_now_ms();
  csm_result result = csm_scene_move(o->stage.frame.scene, &batch);
  const double call_ms = host_cpu_ms();
  if (!result)
    result = csm_render_cascades(o->stage.cascades, &o->stage.frame);
  o->call_ms[round] = host_cpu_ms() - call_ms;
  if (!result)
    result = csm_get_stats(o->stage.cascades, &stats);
  o->frame_ms[round] = host_now_ms() - start_ms;
  o->tree_ms[round] = stats.instance_tree_ms;
  return result;
}

static int draw_in_turn(side sides[MOVED_SIDES], uint32_t rounds) {
  for (uint32_t round = 0; round < rounds; round++) {
    host_progress("frames in which some instances moved");
    for (int i = 0; i < MOVED_SIDES; i++)
      if (draw(&sides[i], round))
        return host_fail(HOST_NO_DEVICE, "%s: %s", sides[i].stage.backend, csm_last_error(sides[i].stage.context));
  }
  host_progress("");
  return 0;
}

static void take_results(bench_moved *out, const side sides[MOVED_SIDES], uint32_t pairs) {
  const side *plain = &sides[MOVED_PLAIN], *rays = &sides[MOVED_RAYS];
  *out = (bench_moved){.rounds = pairs,
                       .instances = rays->moving.count,
                       .moved = rays->moving.moved,
                       .frame_ratio = estimate_ratio(rays->frame_ms + warm_up, plain->frame_ms + warm_up, pairs),
                       .call_ratio = estimate_ratio(rays->call_ms + warm_up, plain->call_ms + warm_up, pairs),
                       .tree_ms = estimate_median(rays->tree_ms + warm_up, pairs),
                       .first_tree_ms = rays->tree_ms[0]};
  for (int i = 0; i < MOVED_SIDES; i++) {
    out->frame_ms[i] = estimate_median(sides[i].frame_ms + warm_up, pairs);
    out->call_ms[i] = estimate_median(sides[i].call_ms + warm_up, pairs);
  }
}

int bench_moved_run(bench_moved *out, const stage *s, const bench_plan *many, const char *device, uint32_t pairs) {
  side *sides = host_allocate(MOVED_SIDES, sizeof *sides);
  int code = 0;
  for (int i = 0; i < MOVED_SIDES; i++) {
    sides[i].frame_ms = host_allocate(warm_up + pairs, sizeof(double));
    sides[i].call_ms = host_allocate(warm_up + pairs, sizeof(double));
    sides[i].tree_ms = host_allocate(warm_up + pairs, sizeof(double));
    if (code == 0)
      code = open_side(&sides[i], i, s, many, device);
  }
  if (code == 0)
    code = draw_in_turn(sides, warm_up + pairs);
  if (code == 0)
    take_results(out, sides, pairs);
  for (int i = 0; i < MOVED_SIDES; i++)
    close_side(&sides[i]);
  free(sides);
  return code;
}

void bench_moved_print(FILE *to, const bench_moved *moved) {
  fprintf(to,
          "  frames of maps in which %u of %u instances moved, exact to pcf_3x3 without CSM_CREATE_RAYS, %u rounds in "
          "turn:\n",
          moved->moved, moved->instances, moved->rounds);
  bench_print_line(to, "frame without, ms", &moved->frame_ms[MOVED_PLAIN]);
  bench_print_line(to, "frame with, ms", &moved->frame_ms[MOVED_RAYS]);
  bench_print_line(to, "frame with / without", &moved->frame_ratio);
  bench_print_line(to, "csm_render_cascades, CPU ms", &moved->call_ms[MOVED_RAYS]);
  bench_print_line(to, "csm_render_cascades / without", &moved->call_ratio);
  bench_print_line(to, "instances' tree refitted, ms", &moved->tree_ms);
  fprintf(to, "  %-32s %9.3f\n", "instances' tree made, ms", moved->first_tree_ms);
}

json_t *bench_moved_to_json(const bench_moved *moved) {
  json_t *object = json_object();
  json_object_set_new(object, "rounds", json_integer(moved->rounds));
  json_object_set_new(object, "instances", json_integer(moved->instances));
  json_object_set_new(object, "moved", json_integer(moved->moved));
  json_object_set_new(object, "frame_ms", estimate_to_json(&moved->frame_ms[MOVED_RAYS]));
  json_object_set_new(object, "plain_frame_ms", estimate_to_json(&moved->frame_ms[MOVED_PLAIN]));
  json_object_set_new(object, "frame/plain", estimate_to_json(&moved->frame_ratio));
  json_object_set_new(object, "call_ms", estimate_to_json(&moved->call_ms[MOVED_RAYS]));
  json_object_set_new(object, "plain_call_ms", estimate_to_json(&moved->call_ms[MOVED_PLAIN]));
  json_object_set_new(object, "call/plain", estimate_to_json(&moved->call_ratio));
  json_object_set_new(object, "tree_ms", estimate_to_json(&moved->tree_ms));
  json_object_set_new(object, "first_tree_ms", json_real(moved->first_tree_ms));
  return object;
}
