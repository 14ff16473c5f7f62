/* vulkan_frames.c: frames in flight on an engine's Vulkan device, recorded long before they run. */
#include "vulkan_case.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { steps_count = 10 };

/* Settings, shapes of maps and sizes of masks change while earlier frames wait to run. */
static const case_step steps[steps_count] = {
    {0, 3, 256, 96, 64}, {1, 3, 256, 96, 64}, {2, 3, 128, 96, 64},  {3, 4, 128, 128, 96}, {4, 4, 128, 128, 96},
    {5, 1, 64, 160, 80}, {6, 2, 256, 64, 64}, {7, 2, 256, 160, 64}, {8, 3, 256, 96, 64},  {9, 3, 256, 96, 64},
};

typedef struct images {
  case_image drawn[steps_count], expected[steps_count];
} images;

static void record_frame(vulkan_case *c, const case_step *step) {
  case_configure(c, step);
  const csm_frame frame = case_frame(c, step->time);
  assert_int_equal(csm_render_cascades(c->cascades, &frame), CSM_SUCCESS);
  const csm_mask_info mask = {
      .struct_size = sizeof mask, .frame = &frame, .width = step->width, .height = step->height};
  assert_int_equal(csm_resolve_mask(c->cascades, &mask), CSM_SUCCESS);
  case_copy(c, step);
}

/* Keeps as many frames recorded and not run as there are slots. */
static void draw_steps(vulkan_case *c, case_image *drawn) {
  vulkan_engine *engine = c->engine;
  const uint64_t before = engine->frame;
  for (uint32_t i = 0; i < steps_count + VULKAN_ENGINE_FRAMES; ++i) {
    if (i >= VULKAN_ENGINE_FRAMES) {
      const uint32_t oldest = i - VULKAN_ENGINE_FRAMES;
      vulkan_engine_run(engine, before + 1 + oldest);
      case_read(c, before + 1 + oldest, &steps[oldest], &drawn[oldest]);
      assert_int_equal(csm_retire(c->context, before + 1 + oldest), CSM_SUCCESS);
    }
    if (i < steps_count) {
      vulkan_engine_begin(engine);
      record_frame(c, &steps[i]);
      vulkan_engine_end(engine);
    }
  }
}

static void draws_as_an_own_device(vulkan_engine_kind kind) {
  static images images;
  vulkan_engine engine;
  vulkan_case c;
  case_reference(steps, steps_count, images.expected);
  for (int i = 1; i < steps_count; ++i)
    assert_memory_not_equal(&images.expected[i], &images.expected[i - 1], sizeof(case_image));
  vulkan_engine_open(&engine, kind);
  case_open(&c, &engine);
  draw_steps(&c, images.drawn);
  for (int i = 0; i < steps_count; ++i)
    case_compare(&images.drawn[i], &images.expected[i], &steps[i]);
  case_close(&c);
  assert_int_equal(engine.pieces, 0);
  assert_int_equal(engine.most_pieces > 0, kind == VULKAN_ENGINE_MODERN);
  vulkan_engine_close(&engine);
}

static void frames_wait_on_a_typical_device(void **state) {
  (void)state;
  draws_as_an_own_device(VULKAN_ENGINE_TYPICAL);
}

static void frames_wait_on_a_bare_device(void **state) {
  (void)state;
  draws_as_an_own_device(VULKAN_ENGINE_BARE);
}

static void frames_wait_on_a_modern_device(void **state) {
  (void)state;
  draws_as_an_own_device(VULKAN_ENGINE_MODERN);
  assert_true(vulkan_engine_cached() > 0);
  assert_int_equal(vulkan_engine_uncached(), 0);
}

/* Everything that a frame uses may go before it runs; it goes when the frame is retired. */
static void destruction_waits_for_the_frame(void **state) {
  (void)state;
  static case_image drawn, expected;
  vulkan_engine engine;
  vulkan_case c;
  case_reference(steps, 1, &expected);
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  vulkan_engine_begin(&engine);
  record_frame(&c, &steps[0]);
  vulkan_engine_end(&engine);
  for (int i = 0; i < SUPPORT_INSTANCES; ++i)
    csm_mesh_destroy(c.context, c.scene.instances[i].mesh); /* instances share meshes */
  assert_int_equal(csm_cascades_destroy(c.cascades), CSM_SUCCESS);
  vulkan_engine_run(&engine, engine.frame);
  case_read(&c, engine.frame, &steps[0], &drawn);
  case_compare(&drawn, &expected, &steps[0]);
  const int64_t before = c.record.blocks;
  assert_int_equal(csm_retire(c.context, engine.frame), CSM_SUCCESS);
  assert_true(c.record.blocks < before);
  c.record.quiet = true; /* meshes that are destroyed twice */
  case_close(&c);
  vulkan_engine_close(&engine);
}

/* Two suns over one scene, in one command buffer, with timestamps. */
static void cascades_share_a_context(void **state) {
  (void)state;
  static case_image drawn[2], expected[2];
  static const case_step both[2] = {{0, 3, 256, 96, 64}, {6, 2, 128, 64, 64}};
  vulkan_engine engine;
  vulkan_case c;
  for (int i = 0; i < 2; ++i)
    case_reference(&both[i], 1, &expected[i]);
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  vulkan_case other = c;
  assert_int_equal(csm_cascades_create(c.context, &c.config, &other.cascades), CSM_SUCCESS);
  other.readback = vulkan_engine_buffer(&engine, VULKAN_ENGINE_FRAMES * sizeof(case_image));
  vulkan_case *const cases[] = {&c, &other};
  for (int round = 0; round < 2; ++round) {
    const VkCommandBuffer commands = vulkan_engine_begin(&engine);
    for (int i = 0; i < 2; ++i)
      case_configure(cases[i], &both[i]);
    for (int i = 0; i < 4; ++i) { /* both are rendered before either is resolved */
      vulkan_case *it = cases[i % 2];
      csm_frame frame = case_frame(it, both[i % 2].time);
      frame.command_buffer = commands;
      frame.flags = CSM_FRAME_TIMESTAMPS;
      const csm_mask_info mask = {
          .struct_size = sizeof mask, .frame = &frame, .width = both[i % 2].width, .height = both[i % 2].height};
      assert_int_equal(i < 2 ? csm_render_cascades(it->cascades, &frame) : csm_resolve_mask(it->cascades, &mask),
                       CSM_SUCCESS);
    }
    for (int i = 0; i < 2; ++i)
      case_copy(cases[i], &both[i]);
    vulkan_engine_end(&engine);
  }
  vulkan_engine_run(&engine, engine.frame);
  assert_int_equal(csm_retire(c.context, engine.frame), CSM_SUCCESS);
  for (int i = 0; i < 2; ++i) {
    csm_stats stats = {.struct_size = sizeof stats};
    case_read(cases[i], engine.frame, &both[i], &drawn[i]);
    case_compare(&drawn[i], &expected[i], &both[i]);
    assert_int_equal(csm_get_stats(cases[i]->cascades, &stats), CSM_SUCCESS);
    assert_true(stats.mask_gpu_ms > 0 && stats.cascades[0].gpu_ms > 0);
  }
  vulkan_engine_buffer_destroy(&engine, &other.readback);
  case_close(&c);
  vulkan_engine_close(&engine);
}

/* ---- two threads ---- */

typedef struct worker {
  pthread_t thread;
  vulkan_engine engine;
  vulkan_case c;
  case_image drawn[steps_count];
} worker;

static void *draw_on_thread(void *user) {
  worker *w = user;
  draw_steps(&w->c, w->drawn);
  return NULL;
}

/* Each with an engine's device of its own, since queues and command pools are the engine's to guard. */
static void contexts_on_two_threads(void **state) {
  (void)state;
  static worker workers[2];
  static case_image expected[steps_count];
  case_reference(steps, steps_count, expected);
  for (int i = 0; i < 2; ++i) {
    vulkan_engine_open(&workers[i].engine, VULKAN_ENGINE_TYPICAL);
    case_open(&workers[i].c, &workers[i].engine);
  }
  for (int i = 0; i < 2; ++i)
    assert_int_equal(pthread_create(&workers[i].thread, NULL, draw_on_thread, &workers[i]), 0);
  for (int i = 0; i < 2; ++i)
    assert_int_equal(pthread_join(workers[i].thread, NULL), 0);
  for (int i = 0; i < 2; ++i) {
    for (int step = 0; step < steps_count; ++step)
      case_compare(&workers[i].drawn[step], &expected[step], &steps[step]);
    case_close(&workers[i].c);
    vulkan_engine_close(&workers[i].engine);
  }
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(frames_wait_on_a_typical_device), cmocka_unit_test(frames_wait_on_a_bare_device),
      cmocka_unit_test(frames_wait_on_a_modern_device),  cmocka_unit_test(destruction_waits_for_the_frame),
      cmocka_unit_test(cascades_share_a_context),        cmocka_unit_test(contexts_on_two_threads),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
