/* Plans of a store that changes: with boxes that were kept, and without them, they are the same bytes. */
#include "world.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { frames = 100 };

static plan_frame plan_once(const world *w, const plan_frame_info *base, plan_cache *cache, int memory) {
  plan_frame_info info = *base;
  plan_frame frame;
  const char *error = "";
  const plan_scene scene = instances_scene(&w->store, &w->meshes);
  info.cache = cache;
  info.scene = &scene;
  assert_true(scene.slot_count <= 2 * WORLD_MOST);
  if (plan_traced(&frame, &info, w->memory[memory], &error))
    fail_msg("%s", error);
  return frame;
}

static void assert_same_plans(const world *w, const csm_config *config, const plan_frame *a, const plan_frame *b) {
  const plan_scene scene = instances_scene(&w->store, &w->meshes);
  assert_true(plan_hash(a, config, &scene) == plan_hash(b, config, &scene));
  assert_int_equal(a->slot_count, b->slot_count);
  assert_int_equal(a->drawn_count, b->drawn_count);
  if (a->drawn_count)
    assert_memory_equal(a->drawn, b->drawn, a->drawn_count * sizeof *a->drawn);
  for (uint32_t c = 0; c < a->cascade_count; ++c) {
    const plan_list *one = &a->windows[c].list, *other = &b->windows[c].list;
    assert_memory_equal(&a->cascades[c].info, &b->cascades[c].info, sizeof a->cascades[c].info);
    assert_memory_equal(a->cascades[c].to_clip, b->cascades[c].to_clip, sizeof a->cascades[c].to_clip);
    assert_int_equal(one->instance_count, other->instance_count);
    assert_int_equal(one->culled, other->culled);
    if (one->instance_count)
      assert_memory_equal(one->instances, other->instances, one->instance_count * sizeof *one->instances);
  }
}

/* The bits of `drawn` say what the lists do. */
static void check_drawn(const plan_frame *frame) {
  for (uint32_t slot = 0; slot < frame->slot_count; ++slot)
    for (uint32_t c = 0; c < CSM_MAX_CASCADES; ++c) {
      const plan_list *list = &frame->windows[c].list;
      bool listed = false;
      for (uint32_t i = 0; i < list->instance_count; ++i)
        listed |= list->instances[i] == slot;
      assert_true(listed == (plan_drawn_by(frame, slot) >> c & 1));
    }
}

/* `least`: slots that the cache has room for from the start. `bursts`: changes in a row, at most. */
static void check_warm_plans(uint64_t seed, uint32_t least, uint32_t bursts) {
  static world w;
  uint32_t drawn = 0;
  plan_cache cache = {0};
  world_begin(&w, seed);
  world_reserve_cache(&cache, least);
  test_camera camera = plain_camera();
  csm_config config = default_config();
  double view[16], projection[16], light[3] = {0.3, -1.0, 0.2};
  for (int i = 0; i < frames; ++i) {
    for (uint32_t n = random_below(&w.random, bursts); n; --n)
      world_change(&w);
    camera.eye[0] = random_between(&w.random, -5.0, 5.0);
    camera_matrices(&camera, view, projection);
    if (i % 10 == 9)
      random_unit(&w.random, light);
    config.caster_set = (uint32_t)i / 3 % 2;
    config.depth_mode = (uint32_t)i % 4;
    const plan_frame_info info = {.config = &config, .view = view, .projection = projection, .light = light};
    world_reserve_cache(&cache, w.store.ids.count);
    const plan_frame cold = plan_once(&w, &info, NULL, 0), warm = plan_once(&w, &info, &cache, 1);
    assert_same_plans(&w, &config, &cold, &warm);
    assert_true(!w.store.ids.count || (cache.keeps && cache.revision == w.store.revision));
    check_drawn(&warm);
    drawn += warm.windows[1].list.instance_count;
  }
  assert_true(drawn > 1000);
  free(cache.memory);
  world_end(&w);
}

static void a_warm_plan_is_a_cold_one(void **state) {
  (void)state;
  check_warm_plans(1, 0, 4);
}

/* The journal is made anew while the cache stays. */
static void a_store_that_grows_leaves_the_cache_warm(void **state) {
  (void)state;
  for (uint64_t seed = 10; seed < 20; ++seed)
    check_warm_plans(seed, 2 * WORLD_MOST, 5);
}

/* More changes between two plans than the journal holds. */
static void a_journal_that_runs_over_leaves_the_cache_warm(void **state) {
  (void)state;
  check_warm_plans(2, 2 * WORLD_MOST, 16);
}

/* One cache, as of cascades that are drawn with one scene and then with another. */
static void a_cache_tells_scenes_apart(void **state) {
  (void)state;
  static world w[2];
  world_begin(&w[0], 2);
  world_begin(&w[1], 3);
  plan_cache cache = {0};
  const test_camera camera = plain_camera();
  const csm_config config = default_config();
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  const plan_frame_info info = {
      .config = &config, .view = view, .projection = projection, .light = (double[]){0.3, -1.0, 0.2}};
  for (int i = 0; i < 60; ++i) {
    world *now = &w[random_below(&w[0].random, 2)];
    world_change(now);
    world_reserve_cache(&cache, 2 * WORLD_MOST);
    const plan_frame cold = plan_once(now, &info, NULL, 0), warm = plan_once(now, &info, &cache, 1);
    assert_same_plans(now, &config, &cold, &warm);
  }
  free(cache.memory);
  world_end(&w[0]);
  world_end(&w[1]);
}

/* A cache that has no room for all slots is left alone. */
static void a_small_cache_is_not_used(void **state) {
  (void)state;
  static world w;
  world_begin(&w, 4);
  while (w.store.ids.count < 100)
    world_change(&w);
  plan_cache cache = {0};
  world_reserve_cache(&cache, 64);
  const test_camera camera = plain_camera();
  const csm_config config = default_config();
  double view[16], projection[16];
  camera_matrices(&camera, view, projection);
  const plan_frame_info info = {
      .config = &config, .view = view, .projection = projection, .light = (double[]){0.3, -1.0, 0.2}};
  const plan_frame cold = plan_once(&w, &info, NULL, 0), warm = plan_once(&w, &info, &cache, 1);
  assert_same_plans(&w, &config, &cold, &warm);
  assert_false(cache.keeps);
  free(cache.memory);
  world_end(&w);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_warm_plan_is_a_cold_one),
      cmocka_unit_test(a_store_that_grows_leaves_the_cache_warm),
      cmocka_unit_test(a_journal_that_runs_over_leaves_the_cache_warm),
      cmocka_unit_test(a_cache_tells_scenes_apart),
      cmocka_unit_test(a_small_cache_is_not_used),
  };
  return cmocka_run_group_tests_name("plan-cache", tests, NULL, NULL);
}
