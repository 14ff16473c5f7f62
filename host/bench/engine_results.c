#include "bench/engine.h"

/* What a way takes of the list's time at most. */
static const double limits[ENGINE_WAYS] = {[ENGINE_LIST] = 1.0, [ENGINE_STILL] = 0.5, [ENGINE_MOVED] = 0.6};
static const char *const way_names[ENGINE_WAYS] = {"list", "scene, none moved", "scene, some moved"};
static const char *const way_keys[ENGINE_WAYS] = {"list", "still", "moved"};

void bench_engine_print(FILE *to, const bench_engine *engine) {
  fprintf(to, "\n  csm_render_cascades on an engine's device, %u instances, %u allocations in %u rounds\n",
          engine->instances, engine->allocations, engine->rounds);
  fprintf(to, "  %-18s %9s   %-21s / list     95 %% interval       at most\n", "", "CPU ms", "95 % interval");
  for (int way = 0; way < ENGINE_WAYS; ++way) {
    const estimate *ms = &engine->call_ms[way], *ratio = &engine->to_list[way];
    fprintf(to, "  %-18s %9.3f   %8.3f .. %-8.3f  %7.3f  %7.3f .. %-7.3f", way_names[way], ms->median, ms->low,
            ms->high, ratio->median, ratio->low, ratio->high);
    if (way != ENGINE_LIST)
      fprintf(to, "  %.2f: %s", limits[way], ratio->median <= limits[way] ? "yes" : "NO");
    fputc('\n', to);
  }
  fprintf(to, "  csm_scene_move of %u of them: %.3f ms (%.3f .. %.3f)\n", engine->moved, engine->move_ms.median,
          engine->move_ms.low, engine->move_ms.high);
}

json_t *bench_engine_to_json(const bench_engine *engine) {
  json_t *object = json_object();
  json_object_set_new(object, "instances", json_integer(engine->instances));
  json_object_set_new(object, "moved", json_integer(engine->moved));
  json_object_set_new(object, "allocations", json_integer(engine->allocations));
  json_object_set_new(object, "rounds", json_integer(engine->rounds));
  for (int way = 0; way < ENGINE_WAYS; ++way) {
    json_t *one = json_object();
    json_object_set_new(one, "call_ms", estimate_to_json(&engine->call_ms[way]));
    json_object_set_new(one, "to_list", estimate_to_json(&engine->to_list[way]));
    if (way != ENGINE_LIST)
      json_object_set_new(one, "at_most", json_real(limits[way]));
    json_object_set_new(object, way_keys[way], one);
  }
  json_object_set_new(object, "move_ms", estimate_to_json(&engine->move_ms));
  return object;
}
