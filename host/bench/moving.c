#include "bench/moving.h"
#include "base/host.h"
#include <stdlib.h>
#include <string.h>

enum { most_moved = 100 };

static void fill_instance(csm_instance *to, const plan_instance *from, const assets *assets) {
  *to = (csm_instance){.struct_size = sizeof *to, .mesh = assets->meshes[from->mesh], .transform = {[15] = 1}};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      to->transform[column * 4 + row] = from->transform[row * 4 + column];
}

void bench_moving_make(bench_moving *out, const bench_plan *many, const assets *assets) {
  const uint32_t count = many->scene.slot_count, moved = count < most_moved ? count : most_moved;
  *out = (bench_moving){.instances = host_allocate(count, sizeof *out->instances),
                        .count = count,
                        .moved = moved,
                        .ids = host_allocate(count, sizeof *out->ids),
                        .moved_ids = host_allocate(moved, sizeof *out->moved_ids),
                        .places = host_allocate(moved, sizeof *out->places)};
  for (uint32_t i = 0; i < count; ++i)
    fill_instance(&out->instances[i], &many->instances[i], assets);
}

void bench_moving_free(bench_moving *m) {
  free(m->instances);
  free(m->ids);
  free(m->moved_ids);
  free(m->places);
}

csm_result bench_moving_scene(bench_moving *m, csm_context *context, csm_scene **out) {
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = m->count, .ids = m->ids, .instances = m->instances};
  const csm_result result = csm_scene_create(context, out);
  return result ? result : csm_scene_add(*out, &batch);
}

csm_scene_batch bench_moving_next(bench_moving *m, uint64_t frame) {
  for (uint32_t i = 0; i < m->moved; ++i) {
    const uint32_t from = (uint32_t)((uint64_t)i * m->count / m->moved);
    m->moved_ids[i] = m->ids[from];
    memcpy(m->places[i], m->instances[from].transform, sizeof m->places[i]);
    m->places[i][13] += (double)(frame % 2);
  }
  return (csm_scene_batch){
      .struct_size = sizeof(csm_scene_batch), .count = m->moved, .ids = m->moved_ids, .matrices = m->places[0]};
}
