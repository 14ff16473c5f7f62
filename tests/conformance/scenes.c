/*
 * scenes.c: scenes whose instances stay: after any changes they draw what a list of the same instances draws, bit for
 * bit, for all cascades and views that use them; what did not change costs nothing.
 */
#include "outcome.h"
#include "telling.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct fixture {
  record record;
  csm_context *context;
  telling telling;
  csm_cascades *of_scene, *of_list;
  csm_view *view;
  csm_scene *scene;
  /* What the scene should hold. */
  uint32_t count;
  csm_instance model[2 * TELLING_INSTANCES];
  csm_instance_id ids[2 * TELLING_INSTANCES];
} fixture;

static csm_config small_config(void) {
  csm_config config = support_config();
  config.resolution = 128;
  return config;
}

static void setup_with(fixture *f, const csm_config *config) {
  memset(f, 0, sizeof *f);
  f->context = support_open_with(&f->record, CSM_CREATE_RAYS);
  telling_make(&f->telling, f->context);
  f->view = support_view(f->context);
  assert_int_equal(csm_cascades_create(f->context, config, &f->of_scene), CSM_SUCCESS);
  assert_int_equal(csm_cascades_create(f->context, config, &f->of_list), CSM_SUCCESS);
  assert_int_equal(csm_scene_create(f->context, &f->scene), CSM_SUCCESS);
}

static void setup(fixture *f) {
  const csm_config config = small_config();
  setup_with(f, &config);
}

static void teardown(fixture *f) {
  support_close(f->context, &f->record);
}

static void succeed(const fixture *f, csm_result result) {
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(f->context));
}

/* Adds instances to the scene and the model alike. */
static void add(fixture *f, const csm_instance *instances, uint32_t count) {
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = count, .ids = f->ids + f->count, .instances = instances};
  succeed(f, csm_scene_add(f->scene, &batch));
  memcpy(f->model + f->count, instances, count * sizeof *instances);
  f->count += count;
}

static void remove_at(fixture *f, uint32_t place) {
  succeed(f, csm_scene_remove(f->scene, 1, &f->ids[place]));
  --f->count;
  memmove(f->model + place, f->model + place + 1, (f->count - place) * sizeof *f->model);
  memmove(f->ids + place, f->ids + place + 1, (f->count - place) * sizeof *f->ids);
}

static outcome draw_scene(fixture *f, csm_cascades *cascades, uint32_t camera) {
  shot shot = telling_shot(&f->telling, camera, 0, 1.5);
  shot.frame.instances = NULL;
  shot.frame.instance_count = 0;
  shot.frame.scene = f->scene;
  return outcome_draw(f->context, cascades, f->view, &shot);
}

static outcome draw_list(fixture *f, const csm_instance *instances, uint32_t count, uint32_t camera) {
  shot shot = telling_shot(&f->telling, camera, 0, 1.5);
  shot.frame.instances = count ? instances : NULL;
  shot.frame.instance_count = count;
  return outcome_draw(f->context, f->of_list, f->view, &shot);
}

/* The scene draws what a list of the model draws. */
static void expect_model(fixture *f, const char *what) {
  outcome list = draw_list(f, f->model, f->count, 0), scene = draw_scene(f, f->of_scene, 0);
  outcome_expect_same(&list, &scene, what);
  outcome_free(&list);
}

/* ---- a scene and a list ---- */

/* Plans are equal as well, where instances were added in the list's order. */
static void a_scene_equals_the_same_list(void **state) {
  (void)state;
  csm_config configs[6];
  for (int i = 0; i < 6; ++i)
    configs[i] = small_config();
  configs[1].caster_set = CSM_CASTER_SET_VIEW;
  configs[2].depth_mode = CSM_DEPTH_SCENE_CLIPPED;
  configs[3].map_layout = CSM_LAYOUT_ATLAS;
  configs[4].fit_mode = CSM_FIT_SCENE;
  configs[5].filter = CSM_FILTER_EXACT;
  for (size_t i = 0; i < sizeof configs / sizeof configs[0]; ++i) {
    fixture f;
    setup_with(&f, &configs[i]);
    add(&f, f.telling.instances, 5); /* in several batches */
    add(&f, f.telling.instances + 5, TELLING_INSTANCES - 5);
    for (uint32_t camera = 0; camera < TELLING_CAMERAS; ++camera) {
      outcome list = draw_list(&f, f.telling.instances, TELLING_INSTANCES, camera);
      outcome scene = draw_scene(&f, f.of_scene, camera);
      assert_true(list.plan_hash != 0 && list.plan_hash == scene.plan_hash);
      outcome_expect_same(&list, &scene, "a scene and a list");
      outcome_free(&list);
    }
    teardown(&f);
  }
}

static void move_some(fixture *f) {
  double matrices[2][16];
  const uint32_t moved[2] = {3, 7};
  csm_instance_id ids[2];
  for (int i = 0; i < 2; ++i) {
    f->model[moved[i]].transform[12] += 1.5;
    f->model[moved[i]].transform[14] -= 2.25;
    memcpy(matrices[i], f->model[moved[i]].transform, sizeof matrices[i]);
    ids[i] = f->ids[moved[i]];
  }
  succeed(f,
          csm_scene_move(f->scene,
                         &(csm_scene_batch){
                             .struct_size = sizeof(csm_scene_batch), .count = 2, .ids = ids, .matrices = matrices[0]}));
}

/* By floats about an origin that is far away; all numbers are exact. */
static void move_by_rows(fixture *f) {
  const double origin[3] = {1048576, -2048, 524288.5};
  static const float rows[12] = {0, 0, 2, 3.25f, 0, 1.5f, 0, 0.5f, -2, 0, 0, -6};
  double *m = f->model[5].transform;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      m[column * 4 + row] = (double)rows[row * 4 + column];
  float about[12];
  memcpy(about, rows, sizeof about);
  for (int row = 0; row < 3; ++row)
    about[row * 4 + 3] = (float)(m[12 + row] - origin[row]);
  csm_scene_batch batch = {.struct_size = sizeof batch, .count = 1, .ids = &f->ids[5], .rows = about};
  memcpy(batch.origin, origin, sizeof origin);
  for (int row = 0; row < 3; ++row)
    m[12 + row] = origin[row] + (double)about[row * 4 + 3];
  succeed(f, csm_scene_move(f->scene, &batch));
}

static void change_some(fixture *f) {
  f->model[2].mesh = f->telling.wedge;
  f->model[2].transform[13] += 0.5;
  f->model[9].flags = CSM_INSTANCE_RECEIVE_ONLY;
  const csm_instance changed[2] = {f->model[2], f->model[9]};
  csm_instance_id ids[2] = {f->ids[2], f->ids[9]};
  succeed(f, csm_scene_change(
                 f->scene, &(csm_scene_batch){
                               .struct_size = sizeof(csm_scene_batch), .count = 2, .ids = ids, .instances = changed}));
}

/* After each batch, and after several without a frame between. */
static void changes_come_one_after_another(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  expect_model(&f, "an empty scene");
  add(&f, f.telling.instances, TELLING_INSTANCES);
  expect_model(&f, "added");
  move_some(&f);
  expect_model(&f, "moved");
  move_by_rows(&f);
  expect_model(&f, "moved by rows");
  change_some(&f);
  expect_model(&f, "changed");
  remove_at(&f, 12);
  remove_at(&f, 3);
  expect_model(&f, "removed");
  add(&f, f.telling.instances + 10, 3);
  expect_model(&f, "added again");
  move_some(&f);
  change_some(&f);
  remove_at(&f, 0);
  add(&f, f.telling.instances, 2);
  move_by_rows(&f);
  expect_model(&f, "all at once");
  while (f.count)
    remove_at(&f, f.count / 2);
  expect_model(&f, "all gone");
  teardown(&f);
}

/* The same on every machine and run: a number below `limit`. */
static uint32_t chance(uint64_t *state, uint32_t limit) {
  *state = *state * 6364136223846793005ull + 1442695040888963407ull;
  return (uint32_t)((*state >> 33) % limit);
}

static void move_by_chance(fixture *f, uint64_t *state) {
  const uint32_t place = chance(state, f->count);
  double *m = f->model[place].transform;
  for (int axis = 0; axis < 3; ++axis)
    m[12 + axis] += (int)chance(state, 9) - 4;
  for (int i = 0; chance(state, 8) == 0 && i < 12; ++i) /* now and then it shrinks to nothing */
    m[i] = 0;
  succeed(f, csm_scene_move(f->scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                         .count = 1,
                                                         .ids = &f->ids[place],
                                                         .matrices = m}));
}

static void change_by_chance(fixture *f, uint64_t *state) {
  const uint32_t place = chance(state, f->count);
  const csm_mesh meshes[4] = {f->telling.square, f->telling.box, f->telling.wedge, f->telling.leaf};
  csm_instance *instance = &f->model[place];
  instance->mesh = meshes[chance(state, 4)];
  instance->flags = (const uint32_t[]){0, 0, CSM_INSTANCE_CAST_ONLY, CSM_INSTANCE_RECEIVE_ONLY,
                                       CSM_INSTANCE_HIDDEN}[chance(state, 5)];
  succeed(f, csm_scene_change(f->scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                           .count = 1,
                                                           .ids = &f->ids[place],
                                                           .instances = instance}));
}

/* Many small changes, of which some frames see one and others a dozen. */
static void changes_of_every_kind_come_at_random(void **state) {
  (void)state;
  enum { FRAMES = 40, FEW = 4, MANY = 2 * TELLING_INSTANCES - 4 };
  csm_config config = small_config();
  config.resolution = 64;
  config.depth_mode = CSM_DEPTH_SCENE_CLIPPED;
  config.filter = CSM_FILTER_EXACT;
  fixture f;
  uint64_t numbers = 7;
  setup_with(&f, &config);
  add(&f, f.telling.instances, TELLING_INSTANCES);
  for (int frame = 0; frame < FRAMES; ++frame) {
    for (uint32_t changes = chance(&numbers, frame % 4 ? 3 : 13); changes > 0; --changes) {
      const uint32_t kind = chance(&numbers, 6);
      if (kind == 0 && f.count > FEW)
        remove_at(&f, chance(&numbers, f.count));
      else if (kind == 1 && f.count < MANY)
        add(&f, f.telling.instances + chance(&numbers, TELLING_INSTANCES - 2), 2);
      else if (kind == 2)
        change_by_chance(&f, &numbers);
      else
        move_by_chance(&f, &numbers);
    }
    char what[32];
    snprintf(what, sizeof what, "frame %d", frame);
    expect_model(&f, what);
  }
  teardown(&f);
}

/* Of two transforms for one instance in a batch the last stays. */
static void the_last_of_a_batch_stays(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  add(&f, f.telling.instances, TELLING_INSTANCES);
  double matrices[2][16];
  csm_instance_id ids[2] = {f.ids[4], f.ids[4]};
  for (int i = 0; i < 2; ++i) {
    f.model[4].transform[12] += 1;
    memcpy(matrices[i], f.model[4].transform, sizeof matrices[i]);
  }
  succeed(&f,
          csm_scene_move(f.scene,
                         &(csm_scene_batch){
                             .struct_size = sizeof(csm_scene_batch), .count = 2, .ids = ids, .matrices = matrices[0]}));
  expect_model(&f, "moved twice");
  teardown(&f);
}

/* ---- who casts, and who is seen ---- */

/* With and without one instance, as lists. */
typedef struct contrast {
  outcome with, without;
} contrast;

static contrast draw_contrast(fixture *f, uint32_t one) {
  csm_instance others[TELLING_INSTANCES];
  memcpy(others, f->telling.instances, one * sizeof *others);
  memcpy(others + one, f->telling.instances + one + 1, (TELLING_INSTANCES - one - 1) * sizeof *others);
  contrast out = {draw_list(f, f->telling.instances, TELLING_INSTANCES, 0),
                  draw_list(f, others, TELLING_INSTANCES - 1, 0)};
  const bool drawn = strcmp(support_backend(), "null");
  assert_true(!drawn || !outcome_same_maps(&out.with, &out.without));
  assert_true(!drawn || !outcome_same_depth(&out.with, &out.without));
  return out;
}

static void flags_say_who_casts_and_who_is_seen(void **state) {
  (void)state;
  enum { ONE = 1 };
  static const struct {
    uint32_t flags;
    bool casts, seen;
  } cases[] = {{0, true, true},
               {CSM_INSTANCE_CAST_ONLY, true, false},
               {CSM_INSTANCE_RECEIVE_ONLY, false, true},
               {CSM_INSTANCE_HIDDEN, false, false},
               {CSM_INSTANCE_HIDDEN | CSM_INSTANCE_CAST_ONLY, false, false},
               {0, true, true}};
  fixture f;
  setup(&f);
  contrast known = draw_contrast(&f, ONE);
  add(&f, f.telling.instances, TELLING_INSTANCES);
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    f.model[ONE].flags = cases[i].flags;
    succeed(&f, csm_scene_change(f.scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                             .count = 1,
                                                             .ids = &f.ids[ONE],
                                                             .instances = &f.model[ONE]}));
    outcome scene = draw_scene(&f, f.of_scene, 0), list = draw_list(&f, f.model, TELLING_INSTANCES, 0);
    assert_true(outcome_same_maps(&scene, cases[i].casts ? &known.with : &known.without));
    assert_true(outcome_same_depth(&scene, cases[i].seen ? &known.with : &known.without));
    outcome_expect_same(&list, &scene, "flags in a list");
    outcome_free(&list);
  }
  outcome_free(&known.with);
  outcome_free(&known.without);
  teardown(&f);
}

/* An instance casts for a light that shares a layer; it is seen whatever its layers. */
static void layers_are_those_of_the_light(void **state) {
  (void)state;
  enum { ONE = 1 };
  static const struct {
    uint32_t instance, light;
    bool casts;
  } cases[] = {{0, 0, true}, {0, 4, true}, {2, 0, true}, {2, 4, false}, {6, 4, true}, {1u << 31, 1u << 31, true}};
  fixture f;
  setup(&f);
  contrast known = draw_contrast(&f, ONE);
  add(&f, f.telling.instances, TELLING_INSTANCES);
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    f.model[ONE].layers = cases[i].instance;
    succeed(&f, csm_scene_change(f.scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                             .count = 1,
                                                             .ids = &f.ids[ONE],
                                                             .instances = &f.model[ONE]}));
    shot shot = telling_shot(&f.telling, 0, 0, 1.5);
    shot.light.layers = cases[i].light;
    shot.frame.instances = f.model;
    outcome list = outcome_draw(f.context, f.of_list, f.view, &shot);
    shot.frame.instances = NULL;
    shot.frame.instance_count = 0;
    shot.frame.scene = f.scene;
    outcome scene = outcome_draw(f.context, f.of_scene, f.view, &shot);
    assert_true(outcome_same_maps(&scene, cases[i].casts ? &known.with : &known.without));
    assert_true(outcome_same_depth(&scene, &known.with));
    outcome_expect_same(&list, &scene, "layers in a list");
    outcome_free(&list);
  }
  outcome_free(&known.with);
  outcome_free(&known.without);
  teardown(&f);
}

/* What is scaled to nothing draws nothing, and refuses no frame; scaled up again, it is there. */
static void nothing_is_drawn_of_what_is_scaled_to_nothing(void **state) {
  (void)state;
  enum { ONE = 1 };
  fixture f;
  setup(&f);
  contrast known = draw_contrast(&f, ONE);
  add(&f, f.telling.instances, TELLING_INSTANCES);
  for (int step = 0; step < 2; ++step) {
    double matrix[16];
    memcpy(matrix, f.telling.instances[ONE].transform, sizeof matrix);
    for (int i = 0; step == 0 && i < 12; ++i)
      matrix[i] = 0;
    memcpy(f.model[ONE].transform, matrix, sizeof matrix);
    succeed(&f, csm_scene_move(f.scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                           .count = 1,
                                                           .ids = &f.ids[ONE],
                                                           .matrices = matrix}));
    outcome scene = draw_scene(&f, f.of_scene, 0), list = draw_list(&f, f.model, TELLING_INSTANCES, 0);
    outcome_expect_same(step ? &known.with : &known.without, &scene, "a scene");
    outcome_expect_same(step ? &known.with : &known.without, &list, "a list");
  }
  outcome_free(&known.with);
  outcome_free(&known.without);
  teardown(&f);
}

/* Nor does it count among what maps reach as far as. */
static void nothing_reaches_nowhere(void **state) {
  (void)state;
  csm_config config = small_config();
  config.depth_mode = CSM_DEPTH_SCENE;
  fixture f;
  setup_with(&f, &config);
  csm_instance instances[TELLING_INSTANCES + 1];
  memcpy(instances, f.telling.instances, sizeof f.telling.instances);
  instances[TELLING_INSTANCES] = support_instance(f.telling.box, 300, 5000, 0, 0, 0, 0);
  outcome without = draw_list(&f, instances, TELLING_INSTANCES, 0);
  outcome list = draw_list(&f, instances, TELLING_INSTANCES + 1, 0);
  add(&f, instances, TELLING_INSTANCES + 1);
  outcome scene = draw_scene(&f, f.of_scene, 0);
  outcome_expect_same(&without, &list, "a list");
  outcome_expect_same(&without, &scene, "a scene");
  outcome_free(&without);
  teardown(&f);
}

/* ---- sharing ---- */

/* Cascades that look away for some frames see what happened meanwhile; each has its own light and settings. */
static void cascades_and_views_share_a_scene(void **state) {
  (void)state;
  fixture f;
  csm_cascades *second, *second_list;
  csm_view *other;
  csm_config config = small_config();
  config.cascade_count = 2;
  config.fit_mode = CSM_FIT_CASCADE;
  setup(&f);
  other = support_view(f.context);
  assert_int_equal(csm_cascades_create(f.context, &config, &second), CSM_SUCCESS);
  assert_int_equal(csm_cascades_create(f.context, &config, &second_list), CSM_SUCCESS);
  add(&f, f.telling.instances, TELLING_INSTANCES - 2);
  for (int step = 0; step < 6; ++step) {
    expect_model(&f, "the first cascades");
    if (step % 3 == 0) {
      shot shot = telling_shot(&f.telling, 1, 0, 1.5);
      shot.frame.instances = f.model;
      shot.frame.instance_count = f.count;
      outcome list = outcome_draw(f.context, second_list, other, &shot);
      shot.frame.instances = NULL;
      shot.frame.instance_count = 0;
      shot.frame.scene = f.scene;
      outcome scene = outcome_draw(f.context, second, other, &shot);
      outcome_expect_same(&list, &scene, "the second cascades");
      outcome_free(&list);
    }
    move_some(&f);
    if (step == 1)
      remove_at(&f, 4);
    if (step == 3)
      add(&f, f.telling.instances + TELLING_INSTANCES - 2, 2);
  }
  teardown(&f);
}

/* The scene that was drawn last is gone, so nothing more is told of it. */
static void forgotten(fixture *f) {
  uint8_t drawn[1];
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(f->of_scene, &stats), CSM_SUCCESS);
  assert_true(stats.plan_hash == 0);
  f->record.quiet = true;
  assert_int_equal(csm_get_casters(f->of_scene, 1, f->ids, drawn), CSM_ERROR_INVALID_STATE);
}

/* Two scenes do not know each other; one that is destroyed leaves the cascades that drew it, and its meshes. */
static void scenes_are_apart(void **state) {
  (void)state;
  fixture f;
  csm_scene *second;
  setup(&f);
  add(&f, f.telling.instances, TELLING_INSTANCES);
  expect_model(&f, "the first scene");
  assert_int_equal(csm_scene_create(f.context, &second), CSM_SUCCESS);
  csm_scene *const first = f.scene;
  f.scene = second;
  f.count = 0;
  expect_model(&f, "the second scene, which is empty");
  add(&f, f.telling.instances, 4);
  expect_model(&f, "the second scene");
  assert_int_equal(csm_scene_destroy(first), CSM_SUCCESS);
  expect_model(&f, "the second scene, alone");
  assert_int_equal(csm_scene_destroy(second), CSM_SUCCESS);
  forgotten(&f);
  assert_int_equal(csm_scene_create(f.context, &f.scene), CSM_SUCCESS); /* perhaps where the other one was */
  forgotten(&f);
  f.count = 0;
  csm_instance list[TELLING_INSTANCES];
  memcpy(list, f.telling.instances, sizeof list);
  outcome after = draw_list(&f, list, TELLING_INSTANCES, 0);
  outcome_free(&after);
  teardown(&f);
}

/* ---- what it costs, and what is told ---- */

static csm_stats stats_of(csm_cascades *cascades) {
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(cascades, &stats), CSM_SUCCESS);
  return stats;
}

static void render(fixture *f, csm_cascades *cascades) {
  shot shot = telling_shot(&f->telling, 0, 0, 1.5);
  shot.frame.instances = NULL;
  shot.frame.instance_count = 0;
  shot.frame.scene = f->scene;
  assert_int_equal(csm_render_cascades(cascades, shot_frame(&shot)), CSM_SUCCESS);
}

static void changes_are_counted_and_cost_no_memory(void **state) {
  (void)state;
  fixture f;
  setup(&f);
  add(&f, f.telling.instances, TELLING_INSTANCES);
  render(&f, f.of_scene);
  assert_int_equal(stats_of(f.of_scene).instances, TELLING_INSTANCES);
  assert_int_equal(stats_of(f.of_scene).instances_changed, TELLING_INSTANCES);
  for (int i = 0; i < 8; ++i) {
    const uint64_t allocations = f.record.allocations;
    const uint32_t changed = i % 2 ? 2 : 0;
    if (changed)
      move_some(&f);
    render(&f, f.of_scene);
    assert_int_equal(stats_of(f.of_scene).instances_changed, changed);
    assert_true(i < 4 || f.record.allocations == allocations);
  }
  for (int i = 0; i < 200; ++i) { /* each counts once, however often it moved, and beyond the journal's end */
    move_some(&f);
    if (i != 3 && i != 199)
      continue;
    render(&f, f.of_scene);
    assert_int_equal(stats_of(f.of_scene).instances_changed, 2);
  }
  remove_at(&f, 2);
  render(&f, f.of_scene);
  assert_int_equal(stats_of(f.of_scene).instances, TELLING_INSTANCES - 1);
  assert_int_equal(stats_of(f.of_scene).instances_changed, 1);
  teardown(&f);
}

static void casters_are_told_by_id(void **state) {
  (void)state;
  fixture f;
  uint8_t by_id[TELLING_INSTANCES + 1], by_place[TELLING_INSTANCES];
  csm_instance_id turned[TELLING_INSTANCES];
  setup(&f);
  f.telling.instances[6].flags = CSM_INSTANCE_RECEIVE_ONLY;
  add(&f, f.telling.instances, TELLING_INSTANCES);
  render(&f, f.of_scene);
  outcome list = draw_list(&f, f.telling.instances, TELLING_INSTANCES, 0);
  outcome_free(&list);
  assert_int_equal(csm_get_casters(f.of_list, TELLING_INSTANCES, NULL, by_place), CSM_SUCCESS);
  for (int i = 0; i < TELLING_INSTANCES; ++i)
    turned[i] = f.ids[TELLING_INSTANCES - 1 - i];
  memset(by_id, 0xaa, sizeof by_id);
  assert_int_equal(csm_get_casters(f.of_scene, TELLING_INSTANCES, turned, by_id), CSM_SUCCESS);
  assert_int_equal(by_id[TELLING_INSTANCES], 0xaa);
  for (int i = 0; i < TELLING_INSTANCES; ++i)
    assert_int_equal(by_id[i], by_place[TELLING_INSTANCES - 1 - i]);
  assert_true(by_place[0] == 7 && by_place[6] == 0);
  assert_int_equal(csm_get_casters(f.of_scene, 1, &f.ids[0], by_id), CSM_SUCCESS);
  assert_int_equal(by_id[0], 7);

  f.record.quiet = true;
  const csm_instance_id wrong = f.ids[0] + (1ull << 40);
  assert_int_equal(csm_get_casters(f.of_scene, 1, &wrong, by_id), CSM_ERROR_INVALID_HANDLE);
  assert_int_equal(csm_get_casters(f.of_scene, TELLING_INSTANCES, NULL, by_id), CSM_ERROR_INVALID_VALUE);
  move_some(&f);
  assert_int_equal(csm_get_casters(f.of_scene, 1, &f.ids[0], by_id), CSM_ERROR_INVALID_STATE);
  teardown(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_scene_equals_the_same_list),
      cmocka_unit_test(changes_come_one_after_another),
      cmocka_unit_test(changes_of_every_kind_come_at_random),
      cmocka_unit_test(the_last_of_a_batch_stays),
      cmocka_unit_test(flags_say_who_casts_and_who_is_seen),
      cmocka_unit_test(layers_are_those_of_the_light),
      cmocka_unit_test(nothing_is_drawn_of_what_is_scaled_to_nothing),
      cmocka_unit_test(nothing_reaches_nowhere),
      cmocka_unit_test(cascades_and_views_share_a_scene),
      cmocka_unit_test(scenes_are_apart),
      cmocka_unit_test(changes_are_counted_and_cost_no_memory),
      cmocka_unit_test(casters_are_told_by_id),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
