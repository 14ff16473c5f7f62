/*
 * What a frame costs the CPU with instances that stay, beside the same ones in a list that is read anew: reading,
 * checking, boxes, culling, lists, matrices. Pairs in turn; prints medians and the median of ratios. No test: it
 * asserts nothing.
 */
#define _POSIX_C_SOURCE 200809L
#include "support.h"

#include "scene/instances.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { instance_count = 10000, mesh_count = 40, pairs = 201, most_moved = 100 };

typedef struct side {
  instances store;
  plan_cache cache;
  plan_memory *memory;
} side;

typedef struct bench {
  random_state random;
  handle_place places[mesh_count];
  handle_table handles;
  plan_bounds bounds[mesh_count];
  uint32_t users[mesh_count];
  instances_meshes meshes;
  csm_instance list[instance_count];
  uint64_t ids[instance_count];
  float *matrices;
  csm_config config;
  side list_side, kept_side;
} bench;

static double now_ms(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (double)time.tv_sec * 1e3 + (double)time.tv_nsec * 1e-6;
}

static instances_batch batch_of(const bench *b, uint32_t count) {
  return (instances_batch){.count = count,
                           .ids = b->ids,
                           .transforms = {.first = b->list[0].transform, .stride = sizeof *b->list},
                           .meshes = {.first = &b->list[0].mesh, .stride = sizeof *b->list}};
}

static void stop(const char *text) {
  fprintf(stderr, "%s\n", text);
  exit(1);
}

/* A town of turned boxes on a square of 600 m. */
static void fill(bench *b) {
  b->handles = (handle_table){.places = b->places, .key = handles_key(b, 1), .capacity = mesh_count};
  b->meshes = (instances_meshes){.handles = &b->handles, .bounds = b->bounds, .users = b->users};
  uint64_t meshes[mesh_count];
  for (uint32_t i = 0; i < mesh_count; ++i) {
    const float half = (float)random_between(&b->random, 0.3, 4.0);
    meshes[i] = handles_take(&b->handles);
    plan_bounds_make(&b->bounds[i], (float[]){-half, 0, -half}, (float[]){half, 2 * half, half});
  }
  for (uint32_t i = 0; i < instance_count; ++i) {
    const double angle = random_between(&b->random, 0.0, 2.0 * M_PI), c = cos(angle), s = sin(angle);
    const double m[16] = {c,
                          0,
                          -s,
                          0,
                          0,
                          1,
                          0,
                          0,
                          s,
                          0,
                          c,
                          0,
                          [12] = random_between(&b->random, -300.0, 300.0),
                          [14] = random_between(&b->random, -300.0, 300.0),
                          [15] = 1.0};
    b->list[i] = (csm_instance){.struct_size = sizeof *b->list, .mesh = meshes[random_below(&b->random, mesh_count)]};
    memcpy(b->list[i].transform, m, sizeof m);
  }
}

/* One frame's plan and matrices. */
static uint64_t plan(const bench *b, side *side, bool cached, int frame) {
  test_camera camera = plain_camera();
  camera.eye[0] = 0.05 * frame;
  camera.eye[1] = 1.7;
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  const plan_scene scene = instances_scene(&side->store, &b->meshes);
  const plan_frame_info info = {.config = &b->config,
                                .view = view,
                                .projection = projection,
                                .light = (double[]){0.4, -1.0, 0.3},
                                .scene = &scene,
                                .cache = cached ? &side->cache : NULL};
  plan_frame made;
  const char *error = "";
  if (plan_frame_make(&made, &info, side->memory, &error))
    stop(error);
  uint64_t drawn = 0;
  for (uint32_t c = 0; c < made.cascade_count; ++c) {
    plan_write_window_matrices(b->matrices, &made, c, &scene);
    drawn += made.windows[c].list.instance_count;
  }
  return drawn;
}

static double time_list(bench *b, int frame, uint64_t *drawn) {
  instances_error error;
  const double begin = now_ms();
  const instances_batch all = batch_of(b, instance_count);
  if (instances_replace(&b->list_side.store, &b->meshes, &all, &error))
    stop(error.text);
  *drawn = plan(b, &b->list_side, false, frame);
  return now_ms() - begin;
}

static double time_kept(bench *b, uint32_t moved, int frame, uint64_t *drawn) {
  instances_error error;
  const double begin = now_ms();
  const instances_batch some = batch_of(b, moved);
  if (moved && instances_change(&b->kept_side.store, &b->meshes, &some, &error))
    stop(error.text);
  *drawn = plan(b, &b->kept_side, true, frame);
  return now_ms() - begin;
}

static int by_value(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median(double *values) {
  qsort(values, pairs, sizeof *values, by_value);
  return values[pairs / 2];
}

static void compare(bench *b, uint32_t moved) {
  double list[pairs], kept[pairs], ratio[pairs];
  uint64_t drawn[2] = {0};
  for (int i = 0; i < pairs; ++i) {
    for (uint32_t k = 0; k < moved; ++k)
      b->list[k].transform[12] += 0.01;
    if (i % 2) {
      list[i] = time_list(b, i, &drawn[0]);
      kept[i] = time_kept(b, moved, i, &drawn[1]);
    } else {
      kept[i] = time_kept(b, moved, i, &drawn[1]);
      list[i] = time_list(b, i, &drawn[0]);
    }
    if (drawn[0] != drawn[1])
      stop("the two draw different instances");
    ratio[i] = kept[i] / list[i];
  }
  printf("%u of %u moved: kept %.3f ms, list %.3f ms, ratio %.3f; %llu drawn\n", moved, instance_count, median(kept),
         median(list), median(ratio), (unsigned long long)drawn[0]);
}

static void begin_side(side *side, uint64_t key) {
  instances_begin(&side->store, &(instances_memory){.allocate = support_allocate, .release = support_release},
                  handles_key(side, key));
  side->memory = memory_make(instance_count, mesh_count, PLAN_WINDOWS_MOST);
  side->cache =
      (plan_cache){.memory = support_allocate(NULL, plan_cache_size(instance_count), 64), .slots = instance_count};
  if (!side->cache.memory)
    stop("out of memory");
}

static void end_side(side *side) {
  instances_end(&side->store, NULL);
  memory_free(side->memory);
  free(side->cache.memory);
}

int main(void) {
  static bench b;
  instances_error error;
  b.random.value = 5;
  b.config = default_config();
  b.matrices = malloc((size_t)instance_count * 12 * sizeof *b.matrices);
  fill(&b);
  begin_side(&b.list_side, 1);
  begin_side(&b.kept_side, 2);
  const instances_batch all = batch_of(&b, instance_count);
  if (instances_add(&b.kept_side.store, &b.meshes, &all, b.ids, &error))
    stop(error.text);
  compare(&b, 0);
  compare(&b, most_moved);
  end_side(&b.list_side);
  end_side(&b.kept_side);
  free(b.matrices);
  return 0;
}
