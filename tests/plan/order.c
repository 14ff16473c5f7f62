/*
 * Instances in the order of where they lie: plans that walk it are those that look at every instance, byte for byte,
 * whatever moves, comes and goes; and the order itself.
 */
#include "world.h"

#include "plan/internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- plans ---- */

enum { most = 9000, begun = 5000, frames = 160 };

/* Some thousand instances on some hundred metres: tens of blocks, and more groups than one. */
typedef struct crowd {
  world world; /* of its meshes and its store */
  uint64_t ids[most];
  uint32_t count;
  float rows[most][12];
  csm_mesh meshes[most];
  uint32_t flags[most], layers[most];
  plan_memory *memory[2];
  plan_cache cache;
  double light[3];
  uint32_t drawn; /* by the last frame of pages */
} crowd;

/* Where an instance lies: most of them strewn, some far away, some in a heap. */
static void some_place(random_state *random, float row[12]) {
  const uint32_t kind = random_below(random, 40);
  const double far = kind == 0 ? 1e5 : kind < 4 ? 1.0 : 500.0;
  for (int k = 0; k < 12; ++k)
    row[k] = (float)(k % 4 == 3 ? random_between(random, -far, far) : random_between(random, -2.0, 2.0));
  row[7] = (float)random_between(random, -5.0, 20.0);
}

/* So many of a crowd's columns, anew. */
static instances_batch some_batch(crowd *c, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    some_place(&c->world.random, c->rows[i]);
    c->meshes[i] = c->world.names[random_below(&c->world.random, WORLD_MESHES)];
    c->flags[i] =
        (uint32_t[]){0, 0, 0, PLAN_CASTS_ONLY, PLAN_RECEIVES_ONLY, PLAN_HIDDEN}[random_below(&c->world.random, 6)];
    c->layers[i] = random_below(&c->world.random, 4);
  }
  return (instances_batch){.count = count,
                           .transforms = {.first = c->rows, .stride = sizeof *c->rows, .floats = true},
                           .meshes = {.first = c->meshes, .stride = sizeof *c->meshes},
                           .flags = {.first = c->flags, .stride = sizeof *c->flags},
                           .layers = {.first = c->layers, .stride = sizeof *c->layers}};
}

static void add(crowd *c, uint32_t count) {
  instances_error error;
  count = count < most - c->count ? count : most - c->count;
  const instances_batch batch = some_batch(c, count);
  assert_int_equal(instances_add(&c->world.store, &c->world.meshes, &batch, &c->ids[c->count], &error), CSM_SUCCESS);
  c->count += count;
}

/* From some instance on; `near`: they stay about where they are. */
static void move(crowd *c, uint32_t count, bool near) {
  instances_error error;
  const uint32_t first = random_below(&c->world.random, c->count - count);
  instances_batch batch = some_batch(c, count);
  batch.ids = &c->ids[first];
  for (uint32_t i = 0; i < count && near; ++i) {
    const uint32_t slot = instances_find(&c->world.store, c->ids[first + i]);
    for (int k = 0; k < 12; ++k)
      c->rows[i][k] = (float)c->world.store.slots[slot].transform[k] + (k % 4 == 3 ? 0.1f : 0.0f);
  }
  if (near)
    batch.meshes.first = batch.flags.first = batch.layers.first = NULL;
  assert_int_equal(instances_change(&c->world.store, &c->world.meshes, &batch, &error), CSM_SUCCESS);
}

static void drop(crowd *c, uint32_t count) {
  instances_error error;
  const uint32_t first = random_below(&c->world.random, c->count - count);
  const instances_batch batch = {.count = count, .ids = &c->ids[first]};
  assert_int_equal(instances_remove(&c->world.store, &c->world.meshes, &batch, &error), CSM_SUCCESS);
  c->count -= count;
  memmove(&c->ids[first], &c->ids[first + count], (c->count - first) * sizeof *c->ids);
}

static void change(crowd *c, int frame) {
  random_state *random = &c->world.random;
  const uint32_t some = random_below(random, 3) ? random_below(random, 60) : random_below(random, 1500);
  switch (random_below(random, 6)) {
  case 0:
    add(c, some);
    break;
  case 1:
    drop(c, some / 2);
    break;
  case 2:
    move(c, some, false);
    break;
  case 3:
    move(c, some, true);
    break;
  default: /* nothing moves */
    break;
  }
  if (frame % 8 == 7)
    random_unit(random, c->light);
}

static crowd *crowd_begin(uint64_t seed) {
  crowd *c = calloc(1, sizeof *c);
  assert_non_null(c);
  world_begin(&c->world, seed);
  for (int i = 0; i < 2; ++i)
    c->memory[i] = memory_make(2 * most, WORLD_MESHES, PLAN_WINDOWS_MOST);
  memcpy(c->light, (double[]){0.3, -1.0, 0.2}, sizeof c->light);
  add(c, begun);
  return c;
}

static void crowd_end(crowd *c) {
  for (int i = 0; i < 2; ++i)
    memory_free(c->memory[i]);
  free(c->cache.memory);
  world_end(&c->world);
  free(c);
}

static void assert_same_lists(const plan_list *a, const plan_list *b) {
  assert_int_equal(a->instance_count, b->instance_count);
  assert_int_equal(a->draw_count, b->draw_count);
  assert_int_equal(a->culled, b->culled);
  if (a->instance_count) {
    assert_memory_equal(a->instances, b->instances, a->instance_count * sizeof *a->instances);
    assert_memory_equal(a->draws, b->draws, a->draw_count * sizeof *a->draws);
  }
}

static void assert_same(const plan_frame *a, const plan_frame *b, const csm_config *config, const plan_scene *scene) {
  assert_true(plan_hash(a, config, scene) == plan_hash(b, config, scene));
  assert_memory_equal(a->cascades, b->cascades, a->cascade_count * sizeof *a->cascades);
  assert_int_equal(a->window_count, b->window_count);
  for (uint32_t i = 0; i < a->window_count; ++i)
    assert_same_lists(&a->windows[i].list, &b->windows[i].list);
  assert_int_equal(a->drawn_count, b->drawn_count);
  if (a->drawn_count)
    assert_memory_equal(a->drawn, b->drawn, a->drawn_count * sizeof *a->drawn);
}

/* What the matrices are written from, too: the cache's, and what is computed. */
static void assert_same_matrices(const plan_frame *a, const plan_frame *b, const plan_scene *scene) {
  float *rows[2] = {malloc(most * 12 * sizeof(float)), malloc(most * 12 * sizeof(float))};
  for (uint32_t i = 0; i < a->window_count; ++i) {
    const size_t size = (size_t)a->windows[i].list.instance_count * 12 * sizeof(float);
    plan_write_window_matrices(rows[0], a, i, scene);
    plan_write_window_matrices(rows[1], b, i, scene);
    if (size)
      assert_memory_equal(rows[0], rows[1], size);
  }
  free(rows[0]);
  free(rows[1]);
}

static csm_config some_config(random_state *random) {
  csm_config config = default_config();
  config.cascade_count = 1 + random_below(random, 4);
  config.shadow_distance = random_scale(random, 10.0, 1000.0);
  config.caster_set = random_below(random, 2);
  config.depth_mode = random_below(random, 4);
  config.map_layout = random_below(random, 3) ? CSM_LAYOUT_ARRAY : CSM_LAYOUT_PAGES;
  return config;
}

static void view_both(crowd *c, const plan_camera *camera, const plan_scene *scene) {
  plan_list cold, warm;
  assert_true(plan_view_make(&cold, camera, scene, NULL, c->memory[0]));
  assert_true(plan_view_make(&warm, camera, scene, &c->cache, c->memory[1]));
  assert_same_lists(&cold, &warm);
}

static uint32_t plan_both(crowd *c) {
  random_state *random = &c->world.random;
  const csm_config config = some_config(random);
  test_camera camera = random_camera(random, 300.0);
  double view[16], projection[16];
  const char *error = "";
  plan_frame cold, warm;
  camera.eye[1] = random_between(random, 0.0, 10.0);
  camera_matrices(&camera, view, projection);
  world_reserve_cache(&c->cache, c->world.store.ids.count);
  const plan_scene scene = instances_scene(&c->world.store, &c->world.meshes);
  plan_frame_info info = {.config = &config,
                          .view = view,
                          .projection = projection,
                          .reversed = camera_reversed(&camera),
                          .light = c->light,
                          .light_layers = random_below(random, 3),
                          .all_receivers = random_below(random, 2),
                          .scene = &scene};
  const csm_result result = plan_traced(&cold, &info, c->memory[0], &error);
  info.cache = &c->cache;
  assert_int_equal(plan_traced(&warm, &info, c->memory[1], &error), result);
  if (result)
    return 0;
  assert_same(&cold, &warm, &config, &scene);
  assert_same_matrices(&cold, &warm, &scene);
  const uint32_t drawn = cold.drawn_count;
  view_both(c, &cold.camera, &scene);
  return drawn;
}

static void a_plan_that_walks_is_one_that_looks_at_all(void **state) {
  (void)state;
  for (uint64_t seed = 1; seed < 4; ++seed) {
    crowd *c = crowd_begin(seed);
    uint32_t drawn = 0, few = 0;
    for (int frame = 0; frame < frames; ++frame) {
      change(c, frame);
      const uint32_t now = plan_both(c);
      drawn += now;
      few += now > 0 && now < c->count / 4;
    }
    assert_true(drawn > 20000 && few > frames / 4);
    crowd_end(c);
  }
}

/* ---- pages ---- */

/* How many pages a frame draws, whose history goes on. */
static int count_due(crowd *c, plan_history *history) {
  csm_config config = default_config();
  const test_camera camera = plain_camera();
  double view[16], projection[16];
  const char *error = "";
  plan_frame frame;
  int due = 0;
  config.map_layout = CSM_LAYOUT_PAGES;
  config.cascade_count = 2;
  config.resolution = 256;
  config.shadow_distance = 40.0;
  config.caster_set = CSM_CASTER_SET_MAP;
  camera_matrices(&camera, view, projection);
  world_reserve_cache(&c->cache, c->world.store.ids.count);
  const plan_scene scene = instances_scene(&c->world.store, &c->world.meshes);
  const plan_frame_info info = {.config = &config,
                                .view = view,
                                .projection = projection,
                                .light = c->light,
                                .scene = &scene,
                                .cache = &c->cache,
                                .maps_kept = true,
                                .before = history};
  assert_int_equal(plan_traced(&frame, &info, c->memory[0], &error), CSM_SUCCESS);
  *history = frame.history;
  c->drawn = frame.drawn_count;
  for (uint32_t i = 0; i < frame.cascade_count; ++i)
    for (int row = 0; row < PLAN_CELLS; ++row)
      due += __builtin_popcountll(frame.cascades[i].due[row]);
  return due;
}

static void move_to(crowd *c, uint32_t index, float x, float z) {
  instances_error error;
  const float row[12] = {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, z};
  const instances_batch batch = {
      .count = 1, .ids = &c->ids[index], .transforms = {.first = row, .stride = sizeof row, .floats = true}};
  assert_int_equal(instances_change(&c->world.store, &c->world.meshes, &batch, &error), CSM_SUCCESS);
}

/* What comes from where no plan has looked spoils the pages that it comes to, and those that it leaves. */
static void what_comes_from_afar_spoils_pages(void **state) {
  (void)state;
  crowd *c = crowd_begin(11);
  plan_history history = {0};
  uint32_t moved = 0;
  assert_int_equal(count_due(c, &history), 2 * PLAN_CELLS * PLAN_CELLS);
  const uint32_t drawn = c->drawn;
  assert_int_equal(count_due(c, &history), 0);
  assert_true(drawn > 20 && c->drawn == drawn); /* over pages that are read, though none is drawn now */
  for (uint32_t i = 0; i < c->count && moved < 20; ++i) {
    const plan_instance *instance = &c->world.store.slots[instances_find(&c->world.store, c->ids[i])];
    if (fabs(instance->transform[3]) < 300.0 || !plan_casts(instance))
      continue;
    move_to(c, i, 0.0f, -10.0f);
    assert_in_range(count_due(c, &history), 1, PLAN_CELLS * PLAN_CELLS / 2);
    move_to(c, i, 450.0f, -10.0f);
    assert_in_range(count_due(c, &history), 1, PLAN_CELLS * PLAN_CELLS / 2);
    assert_int_equal(count_due(c, &history), 0);
    ++moved;
  }
  assert_int_equal(moved, 20);
  crowd_end(c);
}

/* ---- memory ---- */

static void what_is_found_decides_how_much_memory_a_plan_needs(void **state) {
  (void)state;
  crowd *c = crowd_begin(7);
  csm_config config = default_config();
  test_camera camera = plain_camera();
  plan_frame frames_of[2];
  plan_list lists[2];
  plan_memory small = {0};
  double view[16], projection[16];
  const char *error = "";
  config.shadow_distance = 60.0;
  camera_matrices(&camera, view, projection);
  world_reserve_cache(&c->cache, c->world.store.ids.count);
  const plan_scene scene = instances_scene(&c->world.store, &c->world.meshes);
  const plan_frame_info info = {.config = &config,
                                .view = view,
                                .projection = projection,
                                .light = c->light,
                                .scene = &scene,
                                .cache = &c->cache};
  assert_int_equal(plan_traced(&frames_of[0], &info, c->memory[0], &error), CSM_SUCCESS);
  assert_false(plan_memory_short(c->memory[0]));
  const uint32_t found = c->memory[0]->found;
  assert_true(found > 20 && found < c->count / 8);
  for (uint32_t room = 0; room <= found + 1; room += room + 2 < found ? found / 3 : 1) {
    plan_memory *memory = memory_make(room, WORLD_MESHES, config.cascade_count);
    assert_int_equal(plan_traced(&frames_of[1], &info, memory, &error),
                     room < found ? CSM_ERROR_OUT_OF_MEMORY : CSM_SUCCESS);
    assert_int_equal(memory->found, found);
    if (room >= found)
      assert_same(&frames_of[0], &frames_of[1], &config, &scene);
    assert_true(plan_memory_short(memory) == (room < found));
    assert_true(memory->most >= found || room > found);
    memory->most = room;
    memory_free(memory);
  }
  assert_int_equal(plan_traced(&frames_of[1], &info, NULL, &error), CSM_ERROR_OUT_OF_MEMORY);
  assert_true(plan_view_make(&lists[0], &frames_of[0].camera, &scene, NULL, c->memory[0]));
  assert_false(plan_view_make(&lists[1], &frames_of[0].camera, &scene, NULL, &small));
  assert_int_equal(small.found, lists[0].instance_count);
  assert_int_equal(lists[1].instance_count, 0);
  crowd_end(c);
}

/* ---- the order ---- */

enum { places = 10000 };

typedef struct strewn {
  plan_instance instances[places];
  plan_box boxes[places];
  plan_scene scene;
  plan_order order;
  void *memory, *scratch;
} strewn;

static void put_at(strewn *s, uint32_t slot, double x, double y, double z) {
  const double size = 0.5 + slot % 7;
  s->boxes[slot] = (plan_box){{x, y, z}, {x + size, y + size, z + size}};
}

static strewn *strewn_begin(uint32_t count) {
  strewn *s = calloc(1, sizeof *s);
  assert_non_null(s);
  s->scene = (plan_scene){.instances = s->instances, .boxes = s->boxes, .slot_count = count};
  s->memory = malloc(plan_order_size(count));
  s->scratch = malloc(16 * (size_t)count);
  plan_order_find(&s->order, s->memory, count);
  return s;
}

static void strewn_end(strewn *s) {
  free(s->memory);
  free(s->scratch);
  free(s);
}

static bool counts(const plan_instance *instance) {
  return plan_casts(instance) || plan_receives(instance);
}

/* Every slot has a place of its own; each block's bounds, and each group's, are those of what is in it. */
static void check_order(const strewn *s) {
  const plan_order *order = &s->order;
  for (uint32_t slot = 0; slot < s->scene.slot_count; ++slot)
    assert_int_equal(order->slots[order->places[slot]], slot);
  for (uint32_t place = 0; place < order->block_count * PLAN_BLOCK; ++place)
    assert_int_equal(order->places[order->slots[place]], place);
  for (uint32_t i = 0; i < order->group_count * PLAN_BLOCK; ++i) {
    plan_box all = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t place = i * PLAN_BLOCK; place < (i + 1) * PLAN_BLOCK && i < order->block_count; ++place) {
      const uint32_t slot = order->slots[place];
      for (int axis = 0; axis < 3 && slot < s->scene.slot_count && counts(&s->instances[slot]); ++axis) {
        all.low[axis] = fmin(all.low[axis], s->boxes[slot].low[axis]);
        all.high[axis] = fmax(all.high[axis], s->boxes[slot].high[axis]);
      }
    }
    const plan_bounds_block *group = &order->groups[i / PLAN_BLOCK];
    for (int axis = 0; axis < 3; ++axis) {
      const double low = group->low[axis][i % PLAN_BLOCK], high = group->high[axis][i % PLAN_BLOCK];
      assert_true(all.low[0] <= all.high[0] ? low == all.low[axis] && high == all.high[axis] : low > high);
      assert_true(!(low <= high) ||
                  (order->tops[i / PLAN_BLOCK / PLAN_BLOCK].low[axis][i / PLAN_BLOCK % PLAN_BLOCK] <= low &&
                   order->tops[i / PLAN_BLOCK / PLAN_BLOCK].high[axis][i / PLAN_BLOCK % PLAN_BLOCK] >= high));
    }
  }
}

/* The sum of all blocks' sides along x and z. */
static double sum_widths(const strewn *s) {
  double sum = 0.0;
  for (uint32_t i = 0; i < s->order.block_count; ++i)
    for (int axis = 0; axis < 3; axis += 2)
      sum += s->order.groups[i / PLAN_BLOCK].high[axis][i % PLAN_BLOCK] -
             s->order.groups[i / PLAN_BLOCK].low[axis][i % PLAN_BLOCK];
  return sum;
}

static void any_number_is_put_in_order(void **state) {
  (void)state;
  static const uint32_t numbers[] = {1, 2, 63, 64, 65, 128, 4095, 4096, 4097, 9999};
  random_state random = {3};
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) {
    strewn *s = strewn_begin(numbers[i]);
    for (uint32_t slot = 0; slot < numbers[i]; ++slot) {
      put_at(s, slot, random_between(&random, -9.0, 9.0), 0.0, random_between(&random, -9.0, 9.0));
      s->instances[slot].flags = random_below(&random, 5) ? 0 : random_below(&random, 2) ? PLAN_HIDDEN : PLAN_FREE;
    }
    plan_order_make(&s->order, &s->scene, s->scratch);
    check_order(s);
    strewn_end(s);
  }
}

/* A block of 64 among n on a square of side a is about 8 a / sqrt(n) wide, here 80 of 1000 m. */
static void blocks_are_compact(void **state) {
  (void)state;
  random_state random = {4};
  strewn *s = strewn_begin(places);
  for (uint32_t slot = 0; slot < places; ++slot)
    put_at(s, slot, random_between(&random, -500.0, 500.0), 0.0, random_between(&random, -500.0, 500.0));
  put_at(s, 17, 1e30, 0.0, 0.0); /* one that is far away does not spoil the others */
  put_at(s, 18, -1e6, 0.0, 1e6);
  plan_order_make(&s->order, &s->scene, s->scratch);
  s->instances[17].flags = s->instances[18].flags = PLAN_HIDDEN;
  plan_order_note(&s->order, 17);
  plan_order_note(&s->order, 18);
  (void)plan_order_fit(&s->order, &s->scene);
  assert_true(sum_widths(s) < 2.0 * 130.0 * s->order.block_count);
  strewn_end(s);
}

/* A row, a ring, a grid, and all at one place: what Hoare's FIND takes long for with other pivots. */
static void what_stands_in_patterns_is_put_in_order(void **state) {
  (void)state;
  for (int pattern = 0; pattern < 4; ++pattern) {
    strewn *s = strewn_begin(places);
    for (uint32_t slot = 0; slot < places; ++slot) {
      const double turn = 2.0 * M_PI * slot / places;
      const double at[4][2] = {{slot, 0.0}, {cos(turn), sin(turn)}, {slot % 100, slot / 100}, {0.0, 0.0}};
      put_at(s, slot, 10.0 * at[pattern][0], 0.0, 10.0 * at[pattern][1]);
    }
    plan_order_make(&s->order, &s->scene, s->scratch);
    check_order(s);
    strewn_end(s);
  }
}

static double side_sum(const plan_bounds_block *group, uint32_t at) {
  double sum = 0.0;
  for (int axis = 0; axis < 3; ++axis)
    sum += fmax(group->high[axis][at] - group->low[axis][at], 0.0);
  return sum;
}

static void bounds_follow_what_changes(void **state) {
  (void)state;
  random_state random = {5};
  strewn *s = strewn_begin(places);
  double begun_with[(places + PLAN_BLOCK - 1) / PLAN_BLOCK];
  int64_t loose = 0;
  for (uint32_t slot = 0; slot < places; ++slot)
    put_at(s, slot, random_between(&random, -500.0, 500.0), 0.0, random_between(&random, -500.0, 500.0));
  plan_order_make(&s->order, &s->scene, s->scratch);
  for (uint32_t i = 0; i < s->order.block_count; ++i)
    begun_with[i] = side_sum(&s->order.groups[i / PLAN_BLOCK], i % PLAN_BLOCK);
  for (int round = 0; round < 30; ++round) {
    for (uint32_t n = random_below(&random, 20); n; --n) {
      const uint32_t slot = random_below(&random, places);
      put_at(s, slot, random_between(&random, -900.0, 900.0), 0.0, random_between(&random, -500.0, 500.0));
      s->instances[slot].flags = random_below(&random, 3) ? 0 : PLAN_HIDDEN;
      plan_order_note(&s->order, slot);
    }
    loose += plan_order_fit(&s->order, &s->scene);
    check_order(s);
    int64_t expected = 0;
    for (uint32_t i = 0; i < s->order.block_count; ++i)
      expected += side_sum(&s->order.groups[i / PLAN_BLOCK], i % PLAN_BLOCK) > 2.0 * begun_with[i];
    assert_int_equal(loose, expected);
  }
  assert_true(loose > 20);
  strewn_end(s);
}

/* What has strayed is put in order anew, once it is a quarter of all. */
static void what_strays_is_put_in_order_again(void **state) {
  (void)state;
  crowd *c = crowd_begin(9);
  uint32_t times = 0;
  uint64_t moved = 0, before = 0;
  for (int frame = 0; frame < 60; ++frame) {
    move(c, 300, frame % 20 < 10);
    (void)plan_both(c);
    times += c->cache.strayed < before;
    before = c->cache.strayed;
    assert_true(c->cache.loose <= (int64_t)(c->cache.slots / PLAN_BLOCK / 4) + 1 ||
                c->cache.strayed <= c->cache.slots / 4 + 300);
    moved += 300;
  }
  assert_true(times >= 1 && times <= moved / (c->cache.slots / 4));
  crowd_end(c);
}

/* ---- by slot again ---- */

static void what_is_found_is_sorted_by_slot(void **state) {
  (void)state;
  random_state random = {6};
  strewn *s = strewn_begin(places);
  static plan_found found[places], sorted[places];
  plan_order_make(&s->order, &s->scene, s->scratch);
  for (int round = 0; round < 50; ++round) {
    const uint32_t share = 1 + random_below(&random, 200);
    uint32_t count = 0;
    for (uint32_t place = 0; place < places; ++place)
      if (random_below(&random, share) == 0)
        found[count++] = (plan_found){.slot = s->order.slots[(place * 7919u + 13u) % places], .mask = place};
    memset(sorted, 0xff, sizeof sorted);
    plan_order_sort(&s->order, sorted, found, count);
    uint64_t masks[2] = {0};
    for (uint32_t i = 0; i < count; ++i) {
      assert_true(i == 0 || sorted[i - 1].slot < sorted[i].slot);
      masks[0] += found[i].mask * (found[i].slot + 1u);
      masks[1] += sorted[i].mask * (sorted[i].slot + 1u);
    }
    assert_true(masks[0] == masks[1] && (count == places || sorted[count].slot == UINT32_MAX));
  }
  strewn_end(s);
}

/* ---- what stays ---- */

/* Whether a cascade draws the same slots in two frames, none of which has changed. */
static bool draws_alike(const plan_frame frames_of[2], uint32_t cascade, const uint64_t *revisions, uint64_t revision) {
  bool alike = true;
  for (uint32_t slot = 0; slot < frames_of[0].slot_count; ++slot) {
    const bool was = plan_drawn_by(&frames_of[0], slot) >> cascade & 1;
    const bool is = plan_drawn_by(&frames_of[1], slot) >> cascade & 1;
    alike = alike && was == is && !(is && revisions[slot] > revision);
  }
  return alike;
}

static void shadows_rest_where_the_same_is_drawn(void **state) {
  (void)state;
  enum { slots = 6 };
  random_state random = {8};
  plan_instance instances[slots] = {0};
  uint64_t revisions[slots];
  uint32_t alike = 0, apart = 0;
  for (int round = 0; round < 20000; ++round) {
    plan_drawn_slot drawn[2][slots];
    plan_frame two[2] = {0};
    for (int i = 0; i < 2; ++i) {
      two[i] = (plan_frame){.cascade_count = 2, .slot_count = slots, .drawn = drawn[i]};
      for (uint32_t slot = 0; slot < slots; ++slot) {
        const uint32_t cascades = random_below(&random, 3) ? slot % 3 + 1 : random_below(&random, 4);
        if (cascades)
          drawn[i][two[i].drawn_count++] = (plan_drawn_slot){.slot = slot, .cascades = cascades};
        revisions[slot] = random_below(&random, 12) ? 5 : 6;
      }
    }
    const plan_scene scene = {.instances = instances, .revisions = revisions, .slot_count = slots, .revision = 6};
    const bool same[2] = {draws_alike(two, 0, revisions, 5), draws_alike(two, 1, revisions, 5)};
    for (uint32_t c = 0; c < 2; ++c)
      assert_true(plan_cascade_same(&two[0], &two[1], c, &scene, 5) == same[c]);
    assert_true(plan_frame_rests(&two[0], &two[1], &scene, 5) == (same[0] && same[1]));
    alike += same[0] && same[1];
    apart += !same[0] || !same[1];
  }
  assert_true(alike > 200 && apart > 200);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_plan_that_walks_is_one_that_looks_at_all),
      cmocka_unit_test(what_comes_from_afar_spoils_pages),
      cmocka_unit_test(what_is_found_decides_how_much_memory_a_plan_needs),
      cmocka_unit_test(any_number_is_put_in_order),
      cmocka_unit_test(blocks_are_compact),
      cmocka_unit_test(what_stands_in_patterns_is_put_in_order),
      cmocka_unit_test(bounds_follow_what_changes),
      cmocka_unit_test(what_strays_is_put_in_order_again),
      cmocka_unit_test(what_is_found_is_sorted_by_slot),
      cmocka_unit_test(shadows_rest_where_the_same_is_drawn),
  };
  return cmocka_run_group_tests_name("plan-order", tests, NULL, NULL);
}
