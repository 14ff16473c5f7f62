/* threads.c: contexts are independent: two of them, on two threads, draw what each draws alone. */
#include "support.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { threads = 2, frames = 12, width = 96, height = 64 };

typedef struct worker {
  pthread_t thread;
  record record;
  float mask[width * height];
} worker;

static void draw_frames(worker *w) {
  csm_context *context = support_open(&w->record);
  support_scene scene;
  support_scene_make(&scene, context);
  const csm_config config = support_config();
  csm_cascades *cascades;
  csm_view *view = support_view(context);
  assert_int_equal(csm_cascades_create(context, &config, &cascades), CSM_SUCCESS);
  for (int i = frames; i-- > 0;) {
    shot shot = scene.shot;
    shot.camera.view[12] += 0.1 * i;
    assert_int_equal(csm_render_cascades(cascades, shot_frame(&shot)), CSM_SUCCESS);
    assert_int_equal(shot_resolve(&shot, view, cascades, width, height), CSM_SUCCESS);
  }
  float *read = support_image(context, view, CSM_READ_MASK, width, height);
  memcpy(w->mask, read, sizeof w->mask);
  free(read);
  support_close(context, &w->record);
}

static void *run(void *user) {
  draw_frames(user);
  return NULL;
}

static void contexts_do_not_disturb_each_other(void **state) {
  (void)state;
  static worker alone, together[threads];
  draw_frames(&alone);
  for (int i = 0; i < threads; ++i)
    assert_int_equal(pthread_create(&together[i].thread, NULL, run, &together[i]), 0);
  for (int i = 0; i < threads; ++i)
    assert_int_equal(pthread_join(together[i].thread, NULL), 0);
  for (int i = 0; i < threads; ++i)
    assert_memory_equal(together[i].mask, alone.mask, sizeof alone.mask);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(contexts_do_not_disturb_each_other)};
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
