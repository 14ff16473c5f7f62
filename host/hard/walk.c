/* walk.c: flicker from frame to frame. */
#include "base/host.h"
#include "hard/hard.h"
#include "measure/path.h"

int hard_walk(hard_run *run, const hard_path *path) {
  truth_store store = {0}; /* keeps nothing */
  path_result results[HOST_BACKENDS] = {0};
  const measure_path measured = {.count = path->count,
                                 .cameras = (camera *)path->cameras,
                                 .lights = (scene_light *)path->lights,
                                 .each = path->each,
                                 .user = path->user};
  if (!run->truth)
    run->truth = truth_create(&run->setup->scene, true);
  store.caster = run->truth;
  const uint32_t count = path->alone ? 1 : run->stage_count;
  const int code = measure_path_run(results, &measured, &store, run->stages, count, 256);
  for (uint32_t i = 0; i < count; i++)
    path_result_free(&results[i]);
  return code;
}
