/* The store of instances: batches that are done as a whole or not at all, ids, counts, and what changed. */
#include "support.h"

#include "scene/instances.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { mesh_count = 5, most = 700 };

/* ---- memory that counts, and that can run out ---- */

typedef struct heap {
  uint32_t given, live;
  bool empty;
} heap;

static void *CSM_CALL give(void *user, size_t size, size_t align) {
  heap *heap = user;
  if (heap->empty)
    return NULL;
  ++heap->given;
  ++heap->live;
  void *memory = aligned_alloc(align, (size + align - 1) / align * align);
  memset(memory, 0xaa, size);
  return memory;
}

static void CSM_CALL take_back(void *user, void *memory) {
  --((heap *)user)->live;
  free(memory);
}

/* ---- a store beside its meshes ---- */

typedef struct rig {
  heap heap;
  handle_place places[mesh_count];
  handle_table handles;
  plan_bounds bounds[mesh_count];
  uint32_t users[mesh_count];
  instances_meshes meshes;
  csm_mesh names[mesh_count];
  instances store;
} rig;

/* As an engine keeps it, so that columns have strides. */
typedef struct item {
  char name;
  csm_mesh mesh;
  uint32_t flags, layers;
  double transform[16];
} item;

static void rig_begin(rig *rig, uint64_t key) {
  memset(rig, 0, sizeof *rig);
  rig->handles = (handle_table){.places = rig->places, .key = handles_key(rig, key), .capacity = mesh_count};
  rig->meshes = (instances_meshes){.handles = &rig->handles, .bounds = rig->bounds, .users = rig->users};
  for (int i = 0; i < mesh_count; ++i) {
    rig->names[i] = handles_take(&rig->handles);
    plan_bounds_make(&rig->bounds[i], (float[]){-1, 0, -2}, (float[]){1, 3, (float)i});
  }
  instances_begin(&rig->store, &(instances_memory){.allocate = give, .release = take_back, .user = &rig->heap},
                  handles_key(&rig->store, key));
}

static void rig_end(rig *rig) {
  instances_end(&rig->store, &rig->meshes);
  for (int i = 0; i < mesh_count; ++i)
    assert_int_equal(rig->users[i], 0);
  assert_int_equal(rig->heap.live, 0);
}

/* All that make sense: nothing can both only cast and only receive. */
static uint32_t random_flags(random_state *random) {
  static const uint32_t allowed[] = {0, PLAN_CASTS_ONLY, PLAN_RECEIVES_ONLY};
  return allowed[random_below(random, 3)] | (random_below(random, 4) ? 0 : PLAN_HIDDEN);
}

static item random_item(const rig *rig, random_state *random) {
  item made = {.mesh = rig->names[random_below(random, mesh_count)],
               .flags = random_flags(random),
               .layers = random_below(random, 4)};
  for (int i = 0; i < 15; ++i)
    made.transform[i] = i % 4 == 3 ? 0.0 : random_between(random, -9.0, 9.0);
  made.transform[15] = 1.0;
  return made;
}

static instances_batch batch_of(const item *items, const uint64_t *ids, uint32_t count) {
  return (instances_batch){.count = count,
                           .ids = ids,
                           .transforms = {.first = items->transform, .stride = sizeof *items},
                           .meshes = {.first = &items->mesh, .stride = sizeof *items},
                           .flags = {.first = &items->flags, .stride = sizeof *items},
                           .layers = {.first = &items->layers, .stride = sizeof *items}};
}

static void add(rig *rig, const item *items, uint64_t *ids, uint32_t count) {
  instances_error error;
  const instances_batch batch = batch_of(items, NULL, count);
  const uint64_t known = rig->store.revision;
  assert_int_equal(instances_add(&rig->store, &rig->meshes, &batch, ids, &error), CSM_SUCCESS);
  assert_int_equal(instances_changed_since(&rig->store, known), count);
}

/* What the store must hold for an item, found by its own arithmetic. */
static void check_item(const rig *rig, uint64_t id, const item *item) {
  const uint32_t slot = instances_find(&rig->store, id);
  assert_true(slot != UINT32_MAX);
  const plan_instance *held = &rig->store.slots[slot];
  const plan_bounds *bounds = &rig->bounds[held->mesh];
  assert_true(rig->names[held->mesh] == item->mesh);
  assert_int_equal(held->flags & PLAN_FLAGS, item->flags);
  assert_int_equal(held->layers, item->layers);
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int corner = 0; corner < 8; ++corner) {
    double object[3], world[3];
    for (int k = 0; k < 3; ++k)
      object[k] = bounds->center[k] + (corner >> k & 1 ? 1.0 : -1.0) * bounds->extent[k];
    transform_point(item->transform, object, world);
    for (int k = 0; k < 3; ++k) {
      low[k] = fmin(low[k], world[k]);
      high[k] = fmax(high[k], world[k]);
    }
  }
  for (int k = 0; k < 3; ++k) {
    assert_near(rig->store.boxes[slot].low[k], low[k], 1e-12);
    assert_near(rig->store.boxes[slot].high[k], high[k], 1e-12);
    for (int column = 0; column < 4; ++column)
      assert_true(held->transform[k * 4 + column] == item->transform[column * 4 + k]);
  }
}

static void check_counts(const rig *rig, const item *items, uint32_t count) {
  uint32_t casters = 0, receivers = 0, users[mesh_count] = {0};
  for (uint32_t i = 0; i < count; ++i) {
    casters += !(items[i].flags & (PLAN_HIDDEN | PLAN_RECEIVES_ONLY));
    receivers += !(items[i].flags & (PLAN_HIDDEN | PLAN_CASTS_ONLY));
    for (int m = 0; m < mesh_count; ++m)
      users[m] += items[i].mesh == rig->names[m];
  }
  assert_int_equal(rig->store.live, count);
  const plan_scene scene = instances_scene(&rig->store, &rig->meshes);
  assert_int_equal(scene.caster_count, casters);
  assert_int_equal(scene.receiver_count, receivers);
  assert_memory_equal(users, rig->users, sizeof users);
}

/* Against a plain array, through many batches of every kind. */
static void holds_what_was_added_changed_and_not_removed(void **state) {
  (void)state;
  random_state random = {1};
  static item items[most], fresh[most];
  static uint64_t ids[most];
  rig rig;
  uint32_t count = 0;
  rig_begin(&rig, 1);
  for (int step = 0; step < 400; ++step) {
    instances_error error;
    const uint32_t kind = random_below(&random, 3), some = random_below(&random, 40);
    if (kind == 0 && count + some <= most) {
      for (uint32_t i = 0; i < some; ++i)
        items[count + i] = random_item(&rig, &random);
      add(&rig, &items[count], &ids[count], some);
      count += some;
    } else if (kind == 1 && some <= count) {
      for (uint32_t i = 0; i < some; ++i)
        fresh[i] = random_item(&rig, &random);
      const instances_batch batch = batch_of(fresh, &ids[count - some], some);
      assert_int_equal(instances_change(&rig.store, &rig.meshes, &batch, &error), CSM_SUCCESS);
      memcpy(&items[count - some], fresh, some * sizeof *fresh);
    } else if (kind == 2 && some <= count) {
      const instances_batch batch = {.count = some, .ids = ids};
      uint64_t gone = some ? ids[0] : 0;
      assert_int_equal(instances_remove(&rig.store, &rig.meshes, &batch, &error), CSM_SUCCESS);
      count -= some;
      memmove(ids, ids + some, count * sizeof *ids);
      memmove(items, items + some, count * sizeof *items);
      assert_int_equal(instances_find(&rig.store, gone), UINT32_MAX);
    }
    const uint32_t mesh = random_below(&random, mesh_count); /* its instances follow, and no others change */
    const uint64_t known = rig.store.revision;
    plan_bounds_make(&rig.bounds[mesh], (float[]){-1, (float)-step, -2}, (float[]){1, 3, (float)step});
    instances_mesh_changed(&rig.store, &rig.meshes, mesh);
    assert_int_equal(rig.store.revision - known, rig.users[mesh]);
    assert_int_equal(instances_changed_since(&rig.store, known), rig.users[mesh]);
    for (uint32_t i = 0; i < count; ++i)
      check_item(&rig, ids[i], &items[i]);
    check_counts(&rig, items, count);
  }
  assert_true(count > 10);
  rig_end(&rig);
}

/* ---- ids ---- */

static void ids_are_of_one_store_and_one_time(void **state) {
  (void)state;
  random_state random = {2};
  static rig a, b;
  item items[50];
  uint64_t old[50], ids[50], others[50];
  instances_error error;
  rig_begin(&a, 1);
  rig_begin(&b, 2);
  for (int i = 0; i < 50; ++i)
    items[i] = random_item(&a, &random);
  add(&a, items, old, 50);
  const instances_batch gone = {.count = 50, .ids = old};
  assert_int_equal(instances_remove(&a.store, &a.meshes, &gone, &error), CSM_SUCCESS);
  add(&a, items, ids, 50);
  for (int i = 0; i < 50; ++i)
    items[i].mesh = b.names[0];
  add(&b, items, others, 50);
  for (int i = 0; i < 50; ++i) {
    assert_true(ids[i] != 0 && others[i] != 0);
    assert_int_equal(instances_find(&a.store, old[i]), UINT32_MAX);
    assert_int_equal(instances_find(&a.store, others[i]), UINT32_MAX);
    assert_int_equal(instances_find(&b.store, ids[i]), UINT32_MAX);
    assert_true(instances_find(&a.store, ids[i]) < 50);
    assert_int_equal(handles_find(&a.handles, b.names[i % mesh_count]), UINT32_MAX);
  }
  assert_int_equal(instances_find(&a.store, 0), UINT32_MAX);
  rig_end(&a);
  rig_end(&b);
}

/* A table of the other kind with the same key, as meshes and alpha masks of one context have it. */
static void handles_of_two_kinds_are_told_apart(void **state) {
  (void)state;
  for (uint64_t clock = 0; clock < 1000; ++clock) {
    handle_place places[2][4] = {{{0}}};
    handle_table tables[2];
    uint64_t made[2][4];
    for (uint32_t kind = 0; kind < 2; ++kind) {
      tables[kind] =
          (handle_table){.places = places[kind], .kind = kind, .key = handles_key(tables, clock), .capacity = 4};
      for (int i = 0; i < 4; ++i)
        made[kind][i] = handles_take(&tables[kind]);
    }
    for (uint32_t kind = 0; kind < 2; ++kind)
      for (uint32_t i = 0; i < 4; ++i) {
        assert_true(made[kind][i] != 0);
        assert_int_equal(handles_find(&tables[kind], made[kind][i]), i);
        assert_int_equal(handles_find(&tables[!kind], made[kind][i]), UINT32_MAX);
      }
  }
}

/* ---- transforms ---- */

static void floats_with_an_origin_are_as_doubles(void **state) {
  (void)state;
  random_state random = {3};
  static rig rig;
  float rows[30][12];
  item items[30];
  uint64_t ids[30];
  instances_error error;
  rig_begin(&rig, 3);
  const double origin[3] = {1e9 + 0.125, -3e8, 0.5};
  for (int i = 0; i < 30; ++i) {
    items[i] = random_item(&rig, &random);
    for (int k = 0; k < 12; ++k) {
      rows[i][k] = (float)random_between(&random, -9.0, 9.0);
      items[i].transform[k % 4 * 4 + k / 4] = rows[i][k] + (k % 4 == 3 ? origin[k / 4] : 0.0);
    }
  }
  instances_batch batch = batch_of(items, NULL, 30);
  batch.transforms = (instances_transforms){
      .first = rows, .stride = sizeof *rows, .floats = true, .origin = {origin[0], origin[1], origin[2]}};
  assert_int_equal(instances_add(&rig.store, &rig.meshes, &batch, ids, &error), CSM_SUCCESS);
  for (int i = 0; i < 30; ++i)
    for (int k = 0; k < 12; ++k)
      assert_true(rig.store.slots[instances_find(&rig.store, ids[i])].transform[k] ==
                  items[i].transform[k % 4 * 4 + k / 4]);
  rig_end(&rig);
}

/* Of no size, or along one line, an instance draws nothing; flat, it still casts. */
static void scaled_to_nothing_is_no_error(void **state) {
  (void)state;
  random_state random = {4};
  static rig rig;
  rig_begin(&rig, 4);
  const double scales[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 0, 2}, {1e-200, 1e-200, 1e-200}, {1, 0, 1}, {1, 1, 1}};
  for (int i = 0; i < 6; ++i) {
    item made = random_item(&rig, &random);
    uint64_t id;
    made.flags = 0;
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row)
        made.transform[column * 4 + row] *= scales[i][column];
    add(&rig, &made, &id, 1);
    check_item(&rig, id, &made);
    assert_int_equal(rig.store.casters, i < 4 ? 0 : i - 3);
    assert_int_equal(rig.store.receivers, i < 4 ? 0 : i - 3);
  }
  rig_end(&rig);
}

/* ---- errors ---- */

/* All that a batch could have touched. */
typedef struct snapshot {
  instances store;
  plan_instance slots[most];
  plan_box boxes[most];
  uint64_t revisions[most];
  uint32_t users[mesh_count];
} snapshot;

static void snap(snapshot *out, const rig *rig) {
  memset(out, 0, sizeof *out);
  const uint32_t count = rig->store.ids.count;
  out->store = rig->store;
  out->store.stamp = 0;
  memcpy(out->slots, rig->store.slots, count * sizeof *out->slots);
  memcpy(out->boxes, rig->store.boxes, count * sizeof *out->boxes);
  memcpy(out->revisions, rig->store.revisions, count * sizeof *out->revisions);
  memcpy(out->users, rig->users, sizeof out->users);
}

typedef struct wrong {
  const char *what;
  csm_result result;
  void (*spoil)(item *item, uint64_t *id);
} wrong;

static void no_mesh(item *item, uint64_t *id) {
  (void)id;
  item->mesh = 0;
}
static void unknown_flags(item *item, uint64_t *id) {
  (void)id;
  item->flags = PLAN_FREE;
}
static void both_alone(item *item, uint64_t *id) {
  (void)id;
  item->flags = PLAN_CASTS_ONLY | PLAN_RECEIVES_ONLY;
}
static void not_finite(item *item, uint64_t *id) {
  (void)id;
  item->transform[5] = NAN;
}
static void infinite(item *item, uint64_t *id) {
  (void)id;
  item->transform[13] = -INFINITY;
}
static void not_affine(item *item, uint64_t *id) {
  (void)id;
  item->transform[7] = 0.1;
}
static void too_large(item *item, uint64_t *id) {
  (void)id;
  item->transform[12] = 1e31;
}
static void no_instance(item *item, uint64_t *id) {
  (void)item;
  *id = 0;
}

static void a_batch_with_an_error_changes_nothing(void **state) {
  (void)state;
  const wrong cases[] = {
      {"no mesh", CSM_ERROR_INVALID_HANDLE, no_mesh},      {"unknown flags", CSM_ERROR_INVALID_VALUE, unknown_flags},
      {"both alone", CSM_ERROR_INVALID_VALUE, both_alone}, {"NaN", CSM_ERROR_NOT_FINITE, not_finite},
      {"infinity", CSM_ERROR_NOT_FINITE, infinite},        {"not affine", CSM_ERROR_INVALID_MATRIX, not_affine},
      {"too large", CSM_ERROR_INVALID_MATRIX, too_large},  {"no instance", CSM_ERROR_INVALID_HANDLE, no_instance},
  };
  random_state random = {5};
  static rig rig;
  static snapshot before, after;
  item items[20];
  uint64_t ids[20], spoilt_ids[20], more[20];
  rig_begin(&rig, 5);
  for (int i = 0; i < 20; ++i)
    items[i] = random_item(&rig, &random);
  add(&rig, items, ids, 20);
  snap(&before, &rig);
  for (size_t c = 0; c < sizeof cases / sizeof *cases; ++c) {
    item spoilt[20];
    instances_error error = {0};
    for (int i = 0; i < 20; ++i)
      spoilt[i] = random_item(&rig, &random);
    memcpy(spoilt_ids, ids, sizeof ids);
    cases[c].spoil(&spoilt[19], &spoilt_ids[19]);
    const instances_batch batch = batch_of(spoilt, spoilt_ids, 20);
    csm_result result = instances_change(&rig.store, &rig.meshes, &batch, &error);
    if (result != cases[c].result || error.index != 19 || !error.text[0])
      fail_msg("%s: %d at %u", cases[c].what, result, error.index);
    if (cases[c].spoil == no_instance)
      result = instances_remove(&rig.store, &rig.meshes, &batch, &error);
    else
      result = instances_add(&rig.store, &rig.meshes, &batch, more, &error);
    if (result != cases[c].result || error.index != 19)
      fail_msg("%s: %d at %u", cases[c].what, result, error.index);
    snap(&after, &rig);
    assert_memory_equal(&before, &after, sizeof before);
  }
  rig_end(&rig);
}

static void names_what_is_missing_and_what_comes_twice(void **state) {
  (void)state;
  random_state random = {6};
  static rig rig;
  static snapshot before, after;
  item items[2];
  uint64_t ids[2];
  instances_error error = {0};
  rig_begin(&rig, 6);
  items[0] = random_item(&rig, &random);
  items[1] = random_item(&rig, &random);
  add(&rig, items, ids, 2);
  snap(&before, &rig);
  const instances_batch twice = {.count = 2, .ids = (uint64_t[]){ids[1], ids[1]}};
  assert_int_equal(instances_remove(&rig.store, &rig.meshes, &twice, &error), CSM_ERROR_INVALID_HANDLE);
  assert_int_equal(error.index, 1);
  const instances_batch none = {.count = 1};
  assert_int_equal(instances_remove(&rig.store, &rig.meshes, &none, &error), CSM_ERROR_NULL_POINTER);
  assert_int_equal(instances_change(&rig.store, &rig.meshes, &none, &error), CSM_ERROR_NULL_POINTER);
  assert_int_equal(instances_add(&rig.store, &rig.meshes, &none, ids, &error), CSM_ERROR_NULL_POINTER);
  const instances_batch endless = batch_of(items, NULL, UINT32_MAX);
  assert_int_equal(instances_add(&rig.store, &rig.meshes, &endless, ids, &error), CSM_ERROR_LIMIT_EXCEEDED);
  snap(&after, &rig);
  assert_memory_equal(&before, &after, sizeof before);
  rig_end(&rig);
}

static void without_memory_all_stays(void **state) {
  (void)state;
  random_state random = {7};
  static rig rig;
  static snapshot before, after;
  static item items[most];
  static uint64_t ids[most];
  instances_error error = {0};
  rig_begin(&rig, 7);
  for (int i = 0; i < most; ++i)
    items[i] = random_item(&rig, &random);
  add(&rig, items, ids, 10);
  snap(&before, &rig);
  rig.heap.empty = true;
  const instances_batch batch = batch_of(items, NULL, most);
  assert_int_equal(instances_add(&rig.store, &rig.meshes, &batch, &ids[10], &error), CSM_ERROR_OUT_OF_MEMORY);
  snap(&after, &rig);
  assert_memory_equal(&before, &after, sizeof before);
  rig_end(&rig);
}

/* ---- what changed ---- */

static void what_stays_as_it_was_has_not_changed(void **state) {
  (void)state;
  random_state random = {8};
  static rig rig;
  item items[30];
  uint64_t ids[30];
  instances_error error;
  rig_begin(&rig, 8);
  for (int i = 0; i < 30; ++i)
    items[i] = random_item(&rig, &random);
  add(&rig, items, ids, 30);
  const uint64_t known = rig.store.revision;
  items[7].transform[12] += 1.0;
  items[20].layers ^= 8;
  const instances_batch batch = batch_of(items, ids, 30);
  assert_int_equal(instances_change(&rig.store, &rig.meshes, &batch, &error), CSM_SUCCESS);
  assert_int_equal(instances_changed_since(&rig.store, known), 2);
  for (int i = 0; i < 30; ++i)
    assert_true((rig.store.revisions[instances_find(&rig.store, ids[i])] > known) == (i == 7 || i == 20));
  rig_end(&rig);
}

static void a_mesh_with_new_bounds_changes_its_instances(void **state) {
  (void)state;
  random_state random = {9};
  static rig rig;
  item items[60];
  uint64_t ids[60];
  rig_begin(&rig, 9);
  for (int i = 0; i < 60; ++i)
    items[i] = random_item(&rig, &random);
  add(&rig, items, ids, 60);
  const uint64_t known = rig.store.revision;
  plan_bounds_make(&rig.bounds[2], (float[]){-5, -5, -5}, (float[]){50, 5, 5});
  instances_mesh_changed(&rig.store, &rig.meshes, 2);
  for (int i = 0; i < 60; ++i) {
    check_item(&rig, ids[i], &items[i]);
    assert_true((rig.store.revisions[instances_find(&rig.store, ids[i])] > known) == (items[i].mesh == rig.names[2]));
  }
  rig_end(&rig);
}

/* ---- a list ---- */

static void a_list_takes_the_place_of_the_one_before(void **state) {
  (void)state;
  random_state random = {10};
  static rig rig;
  item items[100];
  instances_error error = {0};
  rig_begin(&rig, 10);
  for (uint32_t count = 100; count > 80; --count) {
    for (uint32_t i = 0; i < count; ++i)
      items[i] = random_item(&rig, &random);
    const instances_batch batch = batch_of(items, NULL, count);
    assert_int_equal(instances_replace(&rig.store, &rig.meshes, &batch, &error), CSM_SUCCESS);
    const plan_scene scene = instances_scene(&rig.store, &rig.meshes);
    assert_int_equal(scene.slot_count, count);
    assert_true(scene.identity == 0);
    for (uint32_t i = 0; i < count; ++i) {
      assert_true(rig.names[scene.instances[i].mesh] == items[i].mesh);
      assert_true(scene.instances[i].transform[3] == items[i].transform[12]);
      assert_int_equal(scene.instances[i].flags & PLAN_FLAGS, items[i].flags);
    }
    assert_int_equal(rig.heap.given, 1);
  }
  items[50].transform[0] = NAN;
  const instances_batch bad = batch_of(items, NULL, 80);
  assert_int_equal(instances_replace(&rig.store, &rig.meshes, &bad, &error), CSM_ERROR_NOT_FINITE);
  assert_int_equal(error.index, 50);
  assert_int_equal(instances_scene(&rig.store, &rig.meshes).slot_count, 0);
  rig_end(&rig);
}

/* ---- no allocation ---- */

static void what_comes_and_goes_takes_no_new_memory(void **state) {
  (void)state;
  random_state random = {11};
  static rig rig;
  item items[64];
  uint64_t ids[64];
  instances_error error;
  rig_begin(&rig, 11);
  for (int i = 0; i < 64; ++i)
    items[i] = random_item(&rig, &random);
  for (int step = 0; step < 100; ++step) {
    add(&rig, items, ids, 64);
    const instances_batch batch = batch_of(items, ids, 64);
    assert_int_equal(instances_change(&rig.store, &rig.meshes, &batch, &error), CSM_SUCCESS);
    assert_int_equal(instances_remove(&rig.store, &rig.meshes, &batch, &error), CSM_SUCCESS);
  }
  assert_int_equal(rig.heap.given, 2); /* the instances, and where each mesh's begin */
  rig_end(&rig);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(holds_what_was_added_changed_and_not_removed),
      cmocka_unit_test(ids_are_of_one_store_and_one_time),
      cmocka_unit_test(handles_of_two_kinds_are_told_apart),
      cmocka_unit_test(floats_with_an_origin_are_as_doubles),
      cmocka_unit_test(scaled_to_nothing_is_no_error),
      cmocka_unit_test(a_batch_with_an_error_changes_nothing),
      cmocka_unit_test(names_what_is_missing_and_what_comes_twice),
      cmocka_unit_test(without_memory_all_stays),
      cmocka_unit_test(what_stays_as_it_was_has_not_changed),
      cmocka_unit_test(a_mesh_with_new_bounds_changes_its_instances),
      cmocka_unit_test(a_list_takes_the_place_of_the_one_before),
      cmocka_unit_test(what_comes_and_goes_takes_no_new_memory),
  };
  return cmocka_run_group_tests_name("plan-instances", tests, NULL, NULL);
}
