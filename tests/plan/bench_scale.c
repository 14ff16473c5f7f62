/*
 * What planning a frame costs with 10^3 to 10^6 instances that stand still, at one density, while the camera moves on
 * from a corner of the square that they stand on: so about as many are drawn from 10^4 on. Prints medians, and their ratio to those of 10^4. No test: it asserts nothing.
 */
#define _POSIX_C_SOURCE 200809L
#include "support.h"

#include "scene/instances.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { mesh_count = 40, frames = 101, wanted = 4000, sizes = 4 };

typedef struct bench {
  random_state random;
  handle_place places[mesh_count];
  handle_table handles;
  plan_bounds bounds[mesh_count];
  uint32_t users[mesh_count];
  uint64_t names[mesh_count];
  instances_meshes meshes;
  instances store;
  plan_cache cache;
  plan_history history;
  plan_memory *memory;
  float *matrices;
} bench;

typedef struct mode {
  const char *name;
  uint32_t caster_set, layout;
} mode;

static double now_ms(void) {
  struct timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return (double)time.tv_sec * 1e3 + (double)time.tv_nsec * 1e-6;
}

static void stop(const char *text) {
  fprintf(stderr, "%s\n", text);
  exit(1);
}

static void make_meshes(bench *b) {
  b->handles = (handle_table){.places = b->places, .key = handles_key(b, 1), .capacity = mesh_count};
  b->meshes = (instances_meshes){.handles = &b->handles, .bounds = b->bounds, .users = b->users};
  for (uint32_t i = 0; i < mesh_count; ++i) {
    const float half = (float)random_between(&b->random, 0.3, 4.0);
    b->names[i] = handles_take(&b->handles);
    plan_bounds_make(&b->bounds[i], (float[]){-half, 0, -half}, (float[]){half, 2 * half, half});
  }
}

/* Turned boxes on a square of 6 m by 6 m for each. */
static void add_instances(bench *b, uint32_t count) {
  const double half = 3.0 * sqrt(count);
  float(*rows)[12] = malloc(count * sizeof *rows);
  csm_mesh *meshes = malloc(count * sizeof *meshes);
  uint64_t *ids = malloc(count * sizeof *ids);
  instances_error error;
  for (uint32_t i = 0; i < count; ++i) {
    const double angle = random_between(&b->random, 0.0, 2.0 * M_PI);
    const float c = (float)cos(angle), s = (float)sin(angle);
    const float x = (float)random_between(&b->random, -half, half), z = (float)random_between(&b->random, -half, half);
    memcpy(rows[i], (float[12]){c, 0, s, x, 0, 1, 0, 0, -s, 0, c, z}, sizeof rows[i]);
    meshes[i] = b->names[random_below(&b->random, mesh_count)];
  }
  const instances_batch batch = {.count = count,
                                 .ids = ids,
                                 .transforms = {.first = rows, .stride = sizeof *rows, .floats = true},
                                 .meshes = {.first = meshes, .stride = sizeof *meshes}};
  if (instances_add(&b->store, &b->meshes, &batch, ids, &error))
    stop(error.text);
  free(rows);
  free(meshes);
  free(ids);
}

static void begin(bench *b, uint32_t count) {
  *b = (bench){.random = {5}};
  make_meshes(b);
  instances_begin(&b->store, &(instances_memory){.allocate = support_allocate, .release = support_release},
                  handles_key(&b->store, 1));
  add_instances(b, count);
  b->memory = memory_make(count, mesh_count, PLAN_WINDOWS_MOST);
  b->cache = (plan_cache){.memory = support_allocate(NULL, plan_cache_size(count), 64), .slots = count};
  b->matrices = malloc((size_t)count * 12 * sizeof *b->matrices);
  if (!b->cache.memory || !b->matrices)
    stop("out of memory");
}

static void end(bench *b) {
  instances_end(&b->store, NULL);
  memory_free(b->memory);
  free(b->cache.memory);
  free(b->matrices);
}

/* One frame's plan and matrices; returns how many instances cast. */
static uint32_t plan(bench *b, const mode *mode, double distance, int frame, double *ms) {
  test_camera camera = plain_camera();
  csm_config config = default_config();
  double view[16], projection[16];
  const double corner = -3.0 * sqrt(b->store.live), ahead = 0.03 * frame;
  camera.eye[0] = corner + ahead;
  camera.eye[1] = 1.7;
  camera.eye[2] = corner + ahead;
  camera_look(&camera, (double[]){sqrt(0.5), 0.0, sqrt(0.5)}, 0.0);
  camera_matrices(&camera, view, projection);
  config.caster_set = mode->caster_set;
  config.map_layout = mode->layout;
  config.shadow_distance = distance;
  const plan_scene scene = instances_scene(&b->store, &b->meshes);
  const plan_frame_info info = {.config = &config,
                                .view = view,
                                .projection = projection,
                                .light = (double[]){0.4, -1.0, 0.3},
                                .scene = &scene,
                                .maps_kept = true,
                                .all_receivers = true,
                                .before = &b->history,
                                .cache = &b->cache};
  plan_frame made;
  const char *error = "";
  const double start = now_ms();
  if (plan_frame_make(&made, &info, b->memory, &error))
    stop(error);
  for (uint32_t i = 0; i < made.window_count; ++i)
    plan_write_window_matrices(b->matrices, &made, i, &scene);
  *ms = now_ms() - start;
  b->history = made.history;
  return made.drawn_count;
}

/* The end of shadows at which about as many cast as are wanted. */
static double find_distance(bench *b, const mode *mode) {
  double low = 1.0, high = 400.0, ms;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    b->history = (plan_history){0};
    if (plan(b, mode, middle, 0, &ms) < wanted)
      low = middle;
    else
      high = middle;
  }
  return high;
}

static int by_value(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double median_ms(bench *b, const mode *mode, double distance, uint32_t *drawn, double *first_ms) {
  double samples[frames];
  b->history = (plan_history){0};
  b->cache.keeps = false;
  (void)plan(b, mode, distance, 0, first_ms);
  for (int i = 0; i < frames; ++i)
    *drawn = plan(b, mode, distance, i + 1, &samples[i]);
  qsort(samples, frames, sizeof *samples, by_value);
  return samples[frames / 2];
}

int main(int argc, char **argv) {
  static const mode modes[] = {{"map", CSM_CASTER_SET_MAP, CSM_LAYOUT_ARRAY},
                               {"view", CSM_CASTER_SET_VIEW, CSM_LAYOUT_ARRAY},
                               {"pages", CSM_CASTER_SET_VIEW, CSM_LAYOUT_PAGES}};
  static const uint32_t counts[sizes] = {1000, 10000, 100000, 1000000};
  static bench benches[sizes];
  const unsigned long largest = argc > 1 ? strtoul(argv[1], NULL, 10) : counts[sizes - 1];
  int used = 0;
  for (; used < sizes && counts[used] <= largest; ++used)
    begin(&benches[used], counts[used]);
  if (used < 2)
    stop("plan-bench-scale [LARGEST]: the most instances, from 10000 on");
  for (size_t i = 0; i < sizeof modes / sizeof *modes; ++i) {
    const double distance = find_distance(&benches[1], &modes[i]);
    double base = 0.0;
    for (int k = 0; k < used; ++k) {
      double first;
      uint32_t drawn = 0;
      const double ms = median_ms(&benches[k], &modes[i], distance, &drawn, &first);
      base = k == 1 ? ms : base;
      printf("%-5s %7u instances, shadows to %.0f m, %5u cast: %.3f ms, the first plan %.1f ms", modes[i].name,
             counts[k], distance, drawn, ms, first);
      if (k > 1)
        printf(", %.2f of 10^4's", ms / base);
      printf("\n");
    }
  }
  for (int k = 0; k < used; ++k)
    end(&benches[k]);
  return 0;
}
