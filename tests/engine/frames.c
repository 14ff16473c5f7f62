/* frames.c: frames in flight on an engine's device, recorded long before they run, against what an own device draws. */
#include "stage.h"

#include <pthread.h>
#include <string.h>

enum { STEPS = 14 };

/* What a frame is drawn with, while earlier ones wait to run: settings, shapes of maps, sizes of masks and meshes
   change. */
typedef struct step {
  double time; /* moves the camera and the sun */
  uint32_t cascades, resolution;
  picture_size mask;
  uint32_t filter;
  bool hill; /* another mesh is there */
  bool anew; /* the cascades are destroyed and made again */
} step;

static const step steps[STEPS] = {
    {0, 3, 256, {96, 64}, CSM_FILTER_PCF_3X3, false, false},
    {1, 3, 256, {96, 64}, CSM_FILTER_PCF_3X3, false, false},
    {2, 3, 256, {192, 128}, CSM_FILTER_PCF_3X3, true, false},
    {3, 3, 128, {192, 128}, CSM_FILTER_PCF_3X3, true, false},
    {4, 4, 128, {128, 96}, CSM_FILTER_PCF_3X3, true, false},
    {5, 1, 64, {160, 80}, CSM_FILTER_PCF_3X3, true, false},
    {6, 2, 256, {64, 64}, CSM_FILTER_PCF_3X3, true, false},
    {7, 2, 256, {320, 200}, CSM_FILTER_PCF_3X3, false, false},
    {8, 3, 256, {320, 200}, CSM_FILTER_PCF_3X3, false, false},
    {9, 4, 128, {96, 64}, CSM_FILTER_PCF_2X2, false, false},
    {8, 4, 128, {96, 64}, CSM_FILTER_PCF_2X2, false, false},
    {7, 4, 128, {96, 64}, CSM_FILTER_PCF_2X2, false, true},
    {6, 4, 128, {96, 64}, CSM_FILTER_PCF_2X2, false, false},
    {5, 3, 256, {96, 64}, CSM_FILTER_PCF_3X3, false, false},
};

/* A stage that goes through steps. */
typedef struct walk {
  stage stage;
  bool rays; /* filter exact in place of pcf_3x3 */
  csm_instance instances[SUPPORT_INSTANCES + 1];
  csm_mesh hill; /* 0: not there */
} walk;

static void walk_open(walk *walk, rig *rig, bool rays) {
  stage_open_with(&walk->stage, rig, rays ? CSM_CREATE_RAYS : 0);
  walk->rays = rays;
  walk->hill = 0;
  memcpy(walk->instances, walk->stage.scene.instances, sizeof walk->stage.scene.instances);
}

static void change_hill(walk *walk, bool there) {
  if (there) {
    hill hill;
    hill_make(&hill);
    walk->hill = hill_mesh(walk->stage.context, &hill, 4);
    walk->instances[SUPPORT_INSTANCES] = support_instance(walk->hill, -2, 1, -2, 3, 1, 3);
  } else {
    assert_int_equal(csm_mesh_destroy(walk->stage.context, walk->hill), CSM_SUCCESS);
    walk->hill = 0;
  }
}

static void take_step(walk *walk, const step *step) {
  stage *stage = &walk->stage;
  const csm_config before = stage->config;
  stage->config.cascade_count = step->cascades;
  stage->config.resolution = step->resolution;
  stage->config.filter = walk->rays && step->filter == CSM_FILTER_PCF_3X3 ? CSM_FILTER_EXACT : step->filter;
  if (memcmp(&before, &stage->config, sizeof before))
    stage_configure(stage);
  if (step->anew) {
    assert_int_equal(csm_cascades_destroy(stage->cascades), CSM_SUCCESS);
    assert_int_equal(csm_cascades_create(stage->context, &stage->config, &stage->cascades), CSM_SUCCESS);
  }
  if (step->hill != (walk->hill != 0))
    change_hill(walk, step->hill);
}

static shot walk_shot(const walk *walk, const step *step) {
  shot shot = stage_shot(&walk->stage, step->time);
  shot.frame.instances = walk->instances;
  shot.frame.instance_count = SUPPORT_INSTANCES + (walk->hill != 0);
  return shot;
}

/* Odd frames resolve the mask in a command buffer of its own. */
static picture_copy record_step(walk *walk, const step *step) {
  rig *rig = walk->stage.rig;
  rig_begin(rig);
  take_step(walk, step);
  shot shot = walk_shot(walk, step);
  stage_render(&walk->stage, &shot);
  if (rig_frame(rig) % 2)
    shot.frame.command_buffer = rig_split(rig);
  stage_resolve(&walk->stage, &shot, step->mask);
  const picture_copy copy = stage_record(&walk->stage, step->mask);
  rig_end(rig);
  return copy;
}

/* Keeps as many frames recorded and not run as there may be. */
static void draw_ahead(walk *walk, picture *drawn) {
  rig *rig = walk->stage.rig;
  picture_copy copies[STEPS];
  const uint64_t before = rig_frame(rig);
  for (uint32_t i = 0; i < STEPS + RIG_FRAMES; ++i) {
    if (i >= RIG_FRAMES) {
      rig_run(rig, before + 1 + i - RIG_FRAMES);
      drawn[i - RIG_FRAMES] = picture_take(rig, &copies[i - RIG_FRAMES]);
      stage_retire(&walk->stage);
    }
    if (i < STEPS)
      copies[i] = record_step(walk, &steps[i]);
  }
}

/* What an own device draws at each step. */
static void draw_expected(picture *expected, bool rays) {
  walk own;
  walk_open(&own, NULL, rays);
  for (uint32_t i = 0; i < STEPS; ++i) {
    take_step(&own, &steps[i]);
    shot shot = walk_shot(&own, &steps[i]);
    expected[i] = stage_draw(&own.stage, &shot, steps[i].mask);
    assert_true(i == 0 || !picture_equal(&expected[i], &expected[i - 1]));
    if (steps[i].resolution > 64)
      picture_expect_casters(&expected[i], steps[i].cascades);
  }
  stage_close(&own.stage);
}

static void free_all(picture *pictures) {
  for (uint32_t i = 0; i < STEPS; ++i)
    picture_free(&pictures[i]);
}

static void frames_wait_on(rig_kind kind, bool rays) {
  picture expected[STEPS], drawn[STEPS];
  walk walk;
  draw_expected(expected, rays);
  rig *rig = rig_open(kind);
  walk_open(&walk, rig, rays);
  draw_ahead(&walk, drawn);
  for (uint32_t i = 0; i < STEPS; ++i)
    picture_expect_equal(&expected[i], &drawn[i]);
  free_all(expected);
  stage_close(&walk.stage);
  rig_close(rig);
}

static void frames_wait_on_a_typical_device(void **state) {
  (void)state;
  frames_wait_on(RIG_TYPICAL, false);
}

static void frames_wait_on_a_bare_device(void **state) {
  (void)state;
  frames_wait_on(RIG_BARE, false);
}

static void frames_wait_on_a_modern_device(void **state) {
  (void)state;
  frames_wait_on(RIG_MODERN, false);
}

/* Trees and lists of pixels are each frame's own. */
static void rays_wait_on_a_typical_device(void **state) {
  (void)state;
  frames_wait_on(RIG_TYPICAL, true);
}

static void rays_wait_on_a_modern_device(void **state) {
  (void)state;
  frames_wait_on(RIG_MODERN, true);
}

/* ---- what lives how long ---- */

static picture draw_own(double time, picture_size mask) {
  stage own;
  stage_open(&own, NULL);
  const picture out = stage_draw_at(&own, time, mask);
  stage_close(&own);
  return out;
}

/* Everything that a frame uses may go before it runs; it goes when the frame is retired. */
static void destruction_waits_for_the_frame(void **state) {
  (void)state;
  const picture_size mask = {96, 64};
  stage stage;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  rig_begin(rig);
  shot shot = stage_shot(&stage, 0);
  stage_render(&stage, &shot);
  stage_resolve(&stage, &shot, mask);
  picture_copy copy = stage_record(&stage, mask);
  rig_end(rig);
  stage.record.quiet = true; /* meshes that are destroyed twice */
  for (int i = 0; i < SUPPORT_INSTANCES; ++i)
    csm_mesh_destroy(stage.context, stage.scene.instances[i].mesh); /* instances share meshes */
  assert_int_equal(csm_cascades_destroy(stage.cascades), CSM_SUCCESS);
  assert_int_equal(csm_view_destroy(stage.view), CSM_SUCCESS);
  rig_run(rig, rig_frame(rig));
  picture drawn = picture_take(rig, &copy), expected = draw_own(0, mask);
  picture_expect_equal(&expected, &drawn);
  picture_free(&expected);
  const int64_t before = stage.record.blocks;
  stage_retire(&stage);
  assert_true(stage.record.blocks < before);
  stage_close(&stage);
  rig_close(rig);
}

/* Meshes that are uploaded by a frame without casters are drawn by the next. */
static void uploads_wait_for_nobody(void **state) {
  (void)state;
  const picture_size mask = {192, 128};
  stage stage;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  rig_begin(rig);
  shot full = stage_shot(&stage, 0);
  shot empty = full;
  empty.frame.instance_count = 0;
  stage_render(&stage, &empty);
  picture drawn = stage_draw(&stage, &full, mask), expected = draw_own(0, mask);
  picture_expect_equal(&expected, &drawn);
  picture_free(&expected);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- sharing ---- */

/* Two suns over one scene, in one command buffer, with timestamps; both are rendered before either is resolved. */
static void cascades_share_a_context(void **state) {
  (void)state;
  static const step both[2] = {{0, 3, 256, {96, 64}, CSM_FILTER_PCF_3X3, false, false},
                               {6, 2, 128, {64, 64}, CSM_FILTER_PCF_3X3, false, false}};
  picture expected[2];
  picture_copy copies[2];
  walk walks[2];
  for (int i = 0; i < 2; ++i) {
    walk_open(&walks[1], NULL, false);
    take_step(&walks[1], &both[i]);
    expected[i] = stage_draw_at(&walks[1].stage, both[i].time, both[i].mask);
    stage_close(&walks[1].stage);
  }
  rig *rig = rig_open(RIG_TYPICAL);
  walk_open(&walks[0], rig, false);
  walks[1] = walks[0];
  stage *first = &walks[0].stage, *second = &walks[1].stage;
  assert_int_equal(csm_cascades_create(first->context, &first->config, &second->cascades), CSM_SUCCESS);
  second->view = support_view(first->context);
  for (int round = 0; round < 2; ++round) {
    rig_begin(rig);
    for (int i = 0; i < 2; ++i)
      take_step(&walks[i], &both[i]);
    for (int i = 0; i < 4; ++i) {
      shot shot = stage_shot(&walks[i % 2].stage, both[i % 2].time);
      shot.frame.flags = CSM_FRAME_TIMESTAMPS;
      if (i < 2) {
        stage_render(&walks[i].stage, &shot);
        continue;
      }
      stage_resolve(&walks[i - 2].stage, &shot, both[i - 2].mask);
    }
    for (int i = 0; round && i < 2; ++i)
      copies[i] = stage_record(&walks[i].stage, both[i].mask);
    rig_end(rig);
  }
  rig_run(rig, rig_frame(rig));
  stage_retire(first);
  for (int i = 0; i < 2; ++i) {
    csm_stats stats = {.struct_size = sizeof stats};
    picture drawn = picture_take(rig, &copies[i]);
    picture_expect_equal(&expected[i], &drawn);
    picture_free(&expected[i]);
    csm_view_stats view = {.struct_size = sizeof view};
    assert_int_equal(csm_get_stats(walks[i].stage.cascades, &stats), CSM_SUCCESS);
    assert_int_equal(csm_get_view_stats(walks[i].stage.view, &view), CSM_SUCCESS);
    assert_true(view.mask_gpu_ms > 0 && stats.cascades[0].gpu_ms > 0);
  }
  stage_close(first);
  rig_close(rig);
}

static void two_contexts_share_a_device(void **state) {
  (void)state;
  const picture_size mask = {192, 128};
  stage stages[2];
  picture_copy copies[2];
  rig *rig = rig_open(RIG_TYPICAL);
  for (int i = 0; i < 2; ++i)
    stage_open(&stages[i], rig);
  rig_begin(rig);
  for (int i = 0; i < 2; ++i) {
    shot shot = stage_shot(&stages[i], 0);
    stage_render(&stages[i], &shot);
    stage_resolve(&stages[i], &shot, mask);
    copies[i] = stage_record(&stages[i], mask);
  }
  rig_end(rig);
  rig_run(rig, rig_frame(rig));
  picture one = picture_take(rig, &copies[0]), other = picture_take(rig, &copies[1]);
  picture_expect_equal(&one, &other);
  picture_expect_casters(&one, stages[0].config.cascade_count);
  picture_free(&one);
  for (int i = 0; i < 2; ++i)
    stage_close(&stages[i]);
  rig_close(rig);
}

/* ---- times ---- */

static void timestamps_are_those_of_retired_frames(void **state) {
  (void)state;
  stage stage;
  csm_stats stats = {.struct_size = sizeof stats};
  csm_view_stats view = {.struct_size = sizeof view};
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  for (uint32_t i = 0; i < 4; ++i) {
    rig_begin(rig);
    shot shot = stage_shot(&stage, 0);
    shot.frame.flags = i < 3 ? CSM_FRAME_TIMESTAMPS : 0;
    stage_render(&stage, &shot);
    stage_resolve(&stage, &shot, (picture_size){192, 128});
    rig_end(rig);
    assert_int_equal(csm_get_stats(stage.cascades, &stats), CSM_SUCCESS);
    assert_int_equal(csm_get_view_stats(stage.view, &view), CSM_SUCCESS);
    assert_true(i || (stats.cascades[0].gpu_ms < 0 && view.mask_gpu_ms < 0)); /* not done, so not known */
    rig_run(rig, rig_frame(rig));
    stage_retire(&stage);
  }
  assert_int_equal(csm_get_stats(stage.cascades, &stats), CSM_SUCCESS);
  assert_int_equal(csm_get_view_stats(stage.view, &view), CSM_SUCCESS);
  double sum = stats.clear_gpu_ms + view.mask_gpu_ms + view.camera_depth_gpu_ms;
  for (uint32_t i = 0; i < stats.cascade_count; ++i) {
    assert_true(stats.cascades[i].gpu_ms >= 0);
    sum += stats.cascades[i].gpu_ms;
  }
  assert_true(view.mask_gpu_ms > 0);
  assert_true(sum > 0.01 && sum < 10e3);
  stage_close(&stage);
  rig_close(rig);
}

/* A frame that the engine throws away measured nothing, which is no error. */
static void a_frame_that_never_ran_has_no_times(void **state) {
  (void)state;
  stage stage;
  csm_stats stats = {.struct_size = sizeof stats};
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  rig_begin(rig);
  shot shot = stage_shot(&stage, 0);
  shot.frame.flags = CSM_FRAME_TIMESTAMPS;
  stage_render(&stage, &shot);
  rig_end(rig);
  rig_drop(rig);
  assert_int_equal(csm_retire(stage.context, rig_frame(rig)), CSM_SUCCESS);
  assert_int_equal(csm_get_stats(stage.cascades, &stats), CSM_SUCCESS);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- two threads ---- */

typedef struct worker {
  pthread_t thread;
  rig *rig;
  walk walk;
  picture drawn[STEPS];
} worker;

static void *draw_on_thread(void *user) {
  worker *w = user;
  draw_ahead(&w->walk, w->drawn);
  return NULL;
}

/* Each with an engine's device of its own, since queues and command pools are the engine's to guard. */
static void contexts_on_two_threads(void **state) {
  (void)state;
  static worker workers[2];
  picture expected[STEPS];
  draw_expected(expected, false);
  for (int i = 0; i < 2; ++i) {
    workers[i].rig = rig_open(RIG_TYPICAL);
    walk_open(&workers[i].walk, workers[i].rig, false);
  }
  for (int i = 0; i < 2; ++i)
    assert_int_equal(pthread_create(&workers[i].thread, NULL, draw_on_thread, &workers[i]), 0);
  for (int i = 0; i < 2; ++i)
    assert_int_equal(pthread_join(workers[i].thread, NULL), 0);
  for (int i = 0; i < 2; ++i) {
    for (int step = 0; step < STEPS; ++step)
      picture_expect_equal(&expected[step], &workers[i].drawn[step]);
    stage_close(&workers[i].walk.stage);
    rig_close(workers[i].rig);
  }
  free_all(expected);
}

/* What shades no receiver in sight is left out where an engine says that it asks for no other, and the mask is the same. */
static void receivers_alone_need_fewer_casters(void **state) {
  (void)state;
  stage stage;
  picture drawn[2];
  uint32_t casters[2] = {0};
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  stage.config.caster_set = CSM_CASTER_SET_VIEW;
  stage_configure(&stage);
  for (int i = 0; i < 2; ++i) {
    csm_stats stats = {.struct_size = sizeof stats};
    rig_begin(rig);
    shot shot = stage_shot(&stage, 0);
    shot.frame.flags = i ? CSM_FRAME_RECEIVERS : 0;
    drawn[i] = stage_draw(&stage, &shot, (picture_size){192, 128});
    assert_int_equal(csm_get_stats(stage.cascades, &stats), CSM_SUCCESS);
    for (uint32_t c = 0; c < stats.cascade_count; ++c)
      casters[i] += stats.cascades[c].casters_drawn;
  }
  assert_true(casters[1] > 0 && casters[1] < casters[0]);
  assert_true(picture_mask_difference(&drawn[0], &drawn[1], 0.0) == 0.0);
  picture_free(&drawn[0]);
  picture_free(&drawn[1]);
  stage_close(&stage);
  rig_close(rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_wait_on_a_typical_device),
      cmocka_unit_test(frames_wait_on_a_bare_device),
      cmocka_unit_test(frames_wait_on_a_modern_device),
      cmocka_unit_test(rays_wait_on_a_typical_device),
      cmocka_unit_test(rays_wait_on_a_modern_device),
      cmocka_unit_test(destruction_waits_for_the_frame),
      cmocka_unit_test(uploads_wait_for_nobody),
      cmocka_unit_test(cascades_share_a_context),
      cmocka_unit_test(two_contexts_share_a_device),
      cmocka_unit_test(timestamps_are_those_of_retired_frames),
      cmocka_unit_test(a_frame_that_never_ran_has_no_times),
      cmocka_unit_test(contexts_on_two_threads),
      cmocka_unit_test(receivers_alone_need_fewer_casters),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
