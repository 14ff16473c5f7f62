/* Plans of a store that changes: with boxes that were kept, and without them, they are the same bytes. */
#include "support.h"

#include "scene/instances.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { mesh_count = 6, most = 300, frames = 100 };

static void *CSM_CALL give(void *user, size_t size, size_t align) {
  (void)user;
  return aligned_alloc(align, (size + align - 1) / align * align);
}

static void CSM_CALL take_back(void *user, void *memory) {
  (void)user;
  free(memory);
}

typedef struct world {
  random_state random;
  handle_place places[mesh_count];
  handle_table handles;
  plan_bounds bounds[mesh_count];
  uint32_t users[mesh_count];
  instances_meshes meshes;
  csm_mesh names[mesh_count];
  instances store;
  uint64_t ids[most];
  uint32_t count;
  void *memory[2];
} world;

static void world_begin(world *w, uint64_t seed) {
  memset(w, 0, sizeof *w);
  w->random.value = seed;
  w->handles = (handle_table){.places = w->places, .key = handles_key(w, seed), .capacity = mesh_count};
  w->meshes = (instances_meshes){.handles = &w->handles, .bounds = w->bounds, .users = w->users};
  for (int i = 0; i < mesh_count; ++i) {
    w->names[i] = handles_take(&w->handles);
    plan_bounds_make(&w->bounds[i], (float[]){-1, 0, -1}, (float[]){1, (float)i, 1});
  }
  instances_begin(&w->store, &(instances_memory){.allocate = give, .release = take_back}, handles_key(&w->store, seed));
  for (int i = 0; i < 2; ++i)
    w->memory[i] = malloc(plan_memory_size(2 * most, mesh_count, CSM_MAX_CASCADES));
}

static void world_end(world *w) {
  instances_end(&w->store, &w->meshes);
  free(w->memory[0]);
  free(w->memory[1]);
}

static void some_transforms(world *w, float (*rows)[12], uint32_t count) {
  for (uint32_t i = 0; i < count; ++i)
    for (int k = 0; k < 12; ++k)
      rows[i][k] =
          (float)(k % 4 == 3 ? random_between(&w->random, -60.0, 60.0) : random_between(&w->random, -2.0, 2.0));
}

/* Adds, moves, hides, removes, or gives a mesh new bounds. */
static void change_something(world *w) {
  float rows[most][12];
  csm_mesh meshes[most];
  uint32_t flags[most];
  instances_error error;
  const uint32_t kind = random_below(&w->random, 6), some = random_below(&w->random, 120);
  instances_batch batch = {.count = some < w->count ? some : w->count, .ids = w->ids};
  some_transforms(w, rows, most);
  for (int i = 0; i < most; ++i) {
    meshes[i] = w->names[random_below(&w->random, mesh_count)];
    flags[i] = (uint32_t[]){0, 0, PLAN_CASTS_ONLY, PLAN_RECEIVES_ONLY, PLAN_HIDDEN}[random_below(&w->random, 5)];
  }
  const instances_transforms transforms = {.first = rows, .stride = sizeof *rows, .floats = true};
  if (kind < 2 && w->count + some <= most) {
    batch.count = some;
    batch.transforms = transforms;
    batch.meshes = (instances_column){.first = meshes, .stride = sizeof *meshes};
    assert_int_equal(instances_add(&w->store, &w->meshes, &batch, &w->ids[w->count], &error), CSM_SUCCESS);
    w->count += some;
  } else if (kind < 4) {
    batch.transforms = transforms;
    if (kind == 3)
      batch.flags = (instances_column){.first = flags, .stride = sizeof *flags};
    assert_int_equal(instances_change(&w->store, &w->meshes, &batch, &error), CSM_SUCCESS);
  } else if (kind == 4) {
    assert_int_equal(instances_remove(&w->store, &w->meshes, &batch, &error), CSM_SUCCESS);
    w->count -= batch.count;
    memmove(w->ids, w->ids + batch.count, w->count * sizeof *w->ids);
  } else {
    const uint32_t mesh = random_below(&w->random, mesh_count);
    plan_bounds_make(&w->bounds[mesh], (float[]){-3, -1, -2}, (float[]){1, (float)some / 10.0f, 2});
    instances_mesh_changed(&w->store, &w->meshes, mesh);
  }
}

static plan_frame plan_once(const world *w, const plan_frame_info *base, plan_cache *cache, int memory) {
  plan_frame_info info = *base;
  plan_frame frame;
  const char *error = "";
  const plan_scene scene = instances_scene(&w->store, &w->meshes);
  info.cache = cache;
  info.scene = &scene;
  assert_true(scene.slot_count <= 2 * most);
  if (plan_traced(&frame, &info, w->memory[memory], &error))
    fail_msg("%s", error);
  return frame;
}

static void assert_same_plans(const world *w, const csm_config *config, const plan_frame *a, const plan_frame *b) {
  const plan_scene scene = instances_scene(&w->store, &w->meshes);
  assert_true(plan_hash(a, config, &scene) == plan_hash(b, config, &scene));
  assert_int_equal(a->slot_count, b->slot_count);
  if (a->slot_count)
    assert_memory_equal(a->drawn, b->drawn, a->slot_count);
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
      assert_true(listed == (frame->drawn[slot] >> c & 1));
    }
}

static void make_room(plan_cache *cache, uint32_t slots) {
  if (cache->slots >= slots)
    return;
  free(cache->memory);
  *cache = (plan_cache){.memory = give(NULL, plan_cache_size(slots), 64), .slots = slots};
}

/* `least`: slots that the cache has room for from the start. `bursts`: changes in a row, at most. */
static void check_warm_plans(uint64_t seed, uint32_t least, uint32_t bursts) {
  static world w;
  uint32_t drawn = 0;
  plan_cache cache = {0};
  world_begin(&w, seed);
  make_room(&cache, least);
  test_camera camera = plain_camera();
  csm_config config = default_config();
  double view[16], projection[16], light[3] = {0.3, -1.0, 0.2};
  for (int i = 0; i < frames; ++i) {
    for (uint32_t n = random_below(&w.random, bursts); n; --n)
      change_something(&w);
    camera.eye[0] = random_between(&w.random, -5.0, 5.0);
    camera_matrices(&camera, view, projection);
    if (i % 10 == 9)
      random_unit(&w.random, light);
    config.caster_set = (uint32_t)i / 3 % 2;
    config.depth_mode = (uint32_t)i % 4;
    const plan_frame_info info = {.config = &config, .view = view, .projection = projection, .light = light};
    make_room(&cache, w.store.ids.count);
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
    check_warm_plans(seed, 2 * most, 5);
}

/* More changes between two plans than the journal holds. */
static void a_journal_that_runs_over_leaves_the_cache_warm(void **state) {
  (void)state;
  check_warm_plans(2, 2 * most, 16);
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
    change_something(now);
    make_room(&cache, 2 * most);
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
    change_something(&w);
  plan_cache cache = {.memory = give(NULL, plan_cache_size(64), 64), .slots = 64};
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
