/*
 * threads.c: 32 threads with contexts of their own, on every backend at once, which draw, switch to the next backend and
 * draw again: each gets what a thread alone gets, and what any thread may ask is answered meanwhile. They do so at will,
 * and once more under validation, where devices come and go while no thread draws: the Khronos layer, and a loader that
 * names objects, look a device up in a list of all devices without a lock.
 *
 *   hard_threads BACKEND...
 */
#include "../conformance/support.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { THREADS = 32, FRAMES = 3, WIDTH = 96, HEIGHT = 64, MOST_BACKENDS = 8 };

static const char *const *backends; /* from the command line, before any thread runs */
static uint32_t backend_count;

typedef struct crowd {
  pthread_barrier_t all;
  pthread_mutex_t one;
  bool validated;
} crowd;

typedef struct worker {
  pthread_t thread;
  crowd *crowd;   /* NULL: alone */
  uint32_t first; /* the backend that it begins with */
  record record;
  float masks[2][WIDTH * HEIGHT]; /* before the switch, and after it */
} worker;

/* Between these a thread makes and destroys devices: of a validated crowd one at a time, while no other draws. */
static void begin_devices(const worker *w) {
  if (w->crowd && w->crowd->validated) {
    pthread_barrier_wait(&w->crowd->all);
    pthread_mutex_lock(&w->crowd->one);
  }
}

static void end_devices(const worker *w) {
  if (w->crowd && w->crowd->validated) {
    pthread_mutex_unlock(&w->crowd->one);
    pthread_barrier_wait(&w->crowd->all);
  }
}

/* The last of some frames. */
static void draw_frames(csm_context *context, csm_cascades *cascades, csm_view *view, shot from, float *mask) {
  for (int i = FRAMES; i-- > 0;) {
    shot shot = from;
    shot.camera.view[12] += 0.1 * i;
    assert_int_equal(csm_render_cascades(cascades, shot_frame(&shot)), CSM_SUCCESS);
    assert_int_equal(shot_resolve(&shot, view, cascades, WIDTH, HEIGHT), CSM_SUCCESS);
  }
  float *read = support_image(context, view, CSM_READ_MASK, WIDTH, HEIGHT);
  memcpy(mask, read, WIDTH * HEIGHT * sizeof *read);
  free(read);
}

static void ask(void) {
  csm_config config = {.struct_size = sizeof config};
  csm_preset_info preset = {.struct_size = sizeof preset};
  for (uint32_t i = 0; csm_config_preset_describe(i, &preset) == CSM_SUCCESS; ++i)
    assert_int_equal(csm_config_preset(preset.name, &config), CSM_SUCCESS);
  csm_backend_info infos[2] = {{.struct_size = sizeof infos[0]}};
  uint32_t count = 2;
  assert_int_equal(csm_query_backends(&count, infos), CSM_SUCCESS);
}

static void *work(void *user) {
  worker *w = user;
  support_scene scene;
  const csm_config config = support_config();
  csm_cascades *cascades;
  w->record = (record){.backend = backends[w->first], .allocations_left = -1};
  if (w->crowd)
    pthread_barrier_wait(&w->crowd->all);
  csm_create_info info = support_create_info(&w->record);
  info.flags = CSM_CREATE_KEEP_GEOMETRY | (!w->crowd || w->crowd->validated ? info.flags : 0);
  csm_context *context;
  begin_devices(w);
  assert_int_equal(csm_create(&info, &context), CSM_SUCCESS);
  end_devices(w);
  support_scene_make(&scene, context);
  csm_view *view = support_view(context);
  assert_int_equal(csm_cascades_create(context, &config, &cascades), CSM_SUCCESS);
  draw_frames(context, cascades, view, scene.shot, w->masks[0]);
  info.backend = backends[(w->first + 1) % backend_count];
  begin_devices(w);
  ask(); /* it opens devices too */
  assert_int_equal(csm_switch_backend(context, &info), CSM_SUCCESS);
  end_devices(w);
  draw_frames(context, cascades, view, scene.shot, w->masks[1]);
  begin_devices(w);
  support_close(context, &w->record);
  end_devices(w);
  return NULL;
}

static void expect_each_alone(bool validated) {
  static worker alone[MOST_BACKENDS], together[THREADS];
  crowd crowd = {.one = PTHREAD_MUTEX_INITIALIZER, .validated = validated};
  assert_int_equal(pthread_barrier_init(&crowd.all, NULL, THREADS), 0);
  for (uint32_t i = 0; i < backend_count; ++i) {
    alone[i] = (worker){.first = i};
    work(&alone[i]);
  }
  for (uint32_t i = 0; i < THREADS; ++i) {
    together[i] = (worker){.first = i % backend_count, .crowd = &crowd};
    assert_int_equal(pthread_create(&together[i].thread, NULL, work, &together[i]), 0);
  }
  for (uint32_t i = 0; i < THREADS; ++i)
    assert_int_equal(pthread_join(together[i].thread, NULL), 0);
  for (uint32_t i = 0; i < THREADS; ++i)
    assert_memory_equal(together[i].masks, alone[together[i].first].masks, sizeof together[i].masks);
  pthread_barrier_destroy(&crowd.all);
}

static void contexts_of_many_threads_are_their_own(void **state) {
  (void)state;
  expect_each_alone(false);
}

static void many_threads_draw_validly_at_once(void **state) {
  (void)state;
  expect_each_alone(true);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(contexts_of_many_threads_are_their_own),
                                     cmocka_unit_test(many_threads_draw_validly_at_once)};
  if (argc < 2 || argc > MOST_BACKENDS) {
    fprintf(stderr, "usage: %s BACKEND...\n", argv[0]);
    return 2;
  }
  backends = (const char *const *)argv + 1;
  backend_count = (uint32_t)argc - 1;
  return cmocka_run_group_tests(tests, NULL, NULL);
}
