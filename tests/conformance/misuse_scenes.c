/* misuse_scenes.c: a batch that is wrong in one instance changes none; handles of another scene or context are told. */
#include "misuse_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { INSTANCES = SUPPORT_INSTANCES, WRONG = 4 /* of a batch */ };

typedef struct stay {
  fixture f;
  csm_scene *scene;
  csm_instance_id ids[INSTANCES];
  snapshot before;
} stay;

static csm_result render(stay *s) {
  shot shot = s->f.scene.shot;
  shot.frame.instances = NULL;
  shot.frame.instance_count = 0;
  shot.frame.scene = s->scene;
  return csm_render_cascades(s->f.cascades, shot_frame(&shot));
}

static csm_scene_batch batch_of(stay *s, csm_instance_id *ids) {
  return (csm_scene_batch){
      .struct_size = sizeof(csm_scene_batch), .count = INSTANCES, .ids = ids, .instances = s->f.scene.instances};
}

static void stay_open(stay *s) {
  setup(&s->f);
  assert_int_equal(csm_scene_create(s->f.context, &s->scene), CSM_SUCCESS);
  const csm_scene_batch batch = batch_of(s, s->ids);
  assert_int_equal(csm_scene_add(s->scene, &batch), CSM_SUCCESS);
  assert_int_equal(render(s), CSM_SUCCESS);
  take(&s->f, &s->before);
}

/* What the scene draws is what it drew, and nothing in it has changed. */
static void stay_close(stay *s) {
  unchanged(&s->f, &s->before);
  assert_int_equal(render(s), CSM_SUCCESS);
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(s->f.cascades, &stats), CSM_SUCCESS);
  assert_true(stats.plan_hash == s->before.stats.plan_hash);
  assert_int_equal(stats.instances, INSTANCES);
  assert_int_equal(stats.instances_changed, 0);
  teardown(&s->f);
}

/* ---- an instance that is wrong ---- */

/* The fixture is the stay's first member. */
static csm_result change_or_add(fixture *f, const void *instance) {
  stay *s = (stay *)f;
  csm_instance instances[INSTANCES];
  csm_instance_id ids[INSTANCES];
  memcpy(instances, f->scene.instances, sizeof instances);
  for (int i = 0; i < INSTANCES; ++i)
    instances[i].transform[12] += 3; /* to be told, if it were taken */
  memcpy(&instances[WRONG], instance, sizeof instances[WRONG]);
  csm_scene_batch batch = batch_of(s, ids);
  batch.instances = instances;
  const csm_result added = csm_scene_add(s->scene, &batch);
  batch.ids = s->ids;
  const csm_result changed = csm_scene_change(s->scene, &batch);
  if (added != changed)
    fail_msg("adding says %s, changing %s", csm_result_name(added), csm_result_name(changed));
  return changed;
}

static void a_wrong_instance_spoils_the_batch(void **state) {
  (void)state;
  stay s;
  stay_open(&s);
  check_instances(&s.f, &s.f.scene.instances[WRONG], change_or_add);
  stay_close(&s);
}

/* What is not finite is told by that name in each of the sixteen places, in a scene and in a frame's list. */
static void every_number_must_be_finite(void **state) {
  (void)state;
  static const double wrong[] = {NAN, INFINITY, -INFINITY};
  stay s;
  stay_open(&s);
  for (uint32_t place = 0; place < 16; ++place)
    for (size_t i = 0; i < COUNT(wrong); ++i) {
      csm_instance instances[INSTANCES];
      memcpy(instances, s.f.scene.instances, sizeof instances);
      instances[WRONG].transform[place] = wrong[i];
      expect(&s.f, change_or_add(&s.f, &instances[WRONG]), CSM_ERROR_NOT_FINITE, "a scene");
      shot shot = s.f.scene.shot;
      shot.frame.instances = instances;
      expect(&s.f, csm_render_cascades(s.f.cascades, shot_frame(&shot)), CSM_ERROR_NOT_FINITE, "a list");
    }
  stay_close(&s);
}

/* Structs of any size at the end of their memory: those that end before their transform does are refused, unread. */
static void a_short_instance_is_not_read_past_its_end(void **state) {
  (void)state;
  static const uint32_t sizes[] = {4, 16, 136, 144, sizeof(csm_instance)};
  stay s;
  stay_open(&s);
  for (size_t i = 0; i < COUNT(sizes); ++i) {
    csm_instance whole = s.f.scene.instances[WRONG];
    whole.struct_size = sizes[i];
    csm_instance *cut = malloc(sizes[i]);
    assert_non_null(cut);
    memcpy(cut, &whole, sizes[i]);
    const csm_result expected = sizes[i] < offsetof(csm_instance, layers) ? CSM_ERROR_STRUCT_SIZE : CSM_SUCCESS;
    const csm_scene_batch batch = {.struct_size = sizeof batch, .count = 1, .ids = &s.ids[WRONG], .instances = cut};
    expect(&s.f, csm_scene_change(s.scene, &batch), expected, "a scene");
    if (expected) {
      shot shot = s.f.scene.shot;
      shot.frame.instances = cut;
      shot.frame.instance_count = 1;
      expect(&s.f, csm_render_cascades(s.f.cascades, shot_frame(&shot)), expected, "a list");
    }
    free(cut);
  }
  stay_close(&s);
}

/* ---- a batch that is wrong ---- */

static csm_result add_batch(fixture *f, const void *batch) {
  return csm_scene_add(((stay *)f)->scene, batch);
}

static csm_result change_batch(fixture *f, const void *batch) {
  return csm_scene_change(((stay *)f)->scene, batch);
}

static csm_result move_batch(fixture *f, const void *batch) {
  return csm_scene_move(((stay *)f)->scene, batch);
}

#define BATCH(field) FIELD(csm_scene_batch, field)

static void batches_are_checked(void **state) {
  (void)state;
  static const float rows_of_floats[INSTANCES][12] = {{1}}, bad_rows[INSTANCES][12] = {{1}, {0, 0, NAN}};
  static const misuse rows[] = {
      {"no size", BATCH(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "csm_scene_batch"},
      {"no ids", BATCH(ids), {0}, CSM_ERROR_NULL_POINTER, "ids"},
      {"no instances", BATCH(instances), {0}, CSM_ERROR_NULL_POINTER, "instances"},
  };
  stay s;
  csm_instance_id ids[INSTANCES];
  double matrices[INSTANCES][16];
  stay_open(&s);
  csm_scene_batch batch = batch_of(&s, ids);
  assert_int_equal(csm_scene_add(NULL, &batch), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_scene_move(NULL, &batch), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_scene_change(NULL, &batch), CSM_ERROR_NULL_POINTER);
  assert_int_equal(csm_scene_remove(NULL, 1, ids), CSM_ERROR_NULL_POINTER);
  expect(&s.f, csm_scene_add(s.scene, NULL), CSM_ERROR_NULL_POINTER, "no batch");
  expect(&s.f, csm_scene_remove(s.scene, 1, NULL), CSM_ERROR_NULL_POINTER, "no ids");
  check_rows(&s.f, &(row_table){rows, COUNT(rows), &batch, sizeof batch}, add_batch);
  batch.ids = s.ids;
  check_rows(&s.f, &(row_table){rows, COUNT(rows), &batch, sizeof batch}, change_batch);
  for (int i = 0; i < INSTANCES; ++i)
    memcpy(matrices[i], s.f.scene.instances[i].transform, sizeof matrices[i]);
  const csm_scene_batch moves = {
      .struct_size = sizeof moves, .count = INSTANCES, .ids = s.ids, .matrices = matrices[0]};
  const misuse of_moves[] = {
      {"no size", BATCH(struct_size), {0}, CSM_ERROR_STRUCT_SIZE, "csm_scene_batch"},
      {"no ids", BATCH(ids), {0}, CSM_ERROR_NULL_POINTER, "ids"},
      {"no transforms", BATCH(matrices), {0}, CSM_ERROR_NULL_POINTER, "matrices"},
      {"two kinds of transforms", BATCH(rows), {.pointer = rows_of_floats}, CSM_ERROR_INVALID_VALUE, "twice"},
      {"instances to move", BATCH(instances), {.pointer = s.f.scene.instances}, CSM_ERROR_INVALID_VALUE, "twice"},
  };
  check_rows(&s.f, &(row_table){of_moves, COUNT(of_moves), &moves, sizeof moves}, move_batch);
  csm_scene_batch wrong = moves;
  wrong = moves, wrong.matrices = NULL, wrong.rows = bad_rows[0];
  expect(&s.f, csm_scene_move(s.scene, &wrong), CSM_ERROR_NOT_FINITE, "NaN in rows");
  wrong = moves, wrong.matrices = NULL, wrong.rows = rows_of_floats[0], wrong.origin[1] = INFINITY;
  expect(&s.f, csm_scene_move(s.scene, &wrong), CSM_ERROR_NOT_FINITE, "an origin that is not finite");
  matrices[WRONG][7] = 0.25;
  expect(&s.f, csm_scene_move(s.scene, &moves), CSM_ERROR_INVALID_MATRIX, "a matrix that is not affine");
  stay_close(&s);
}

/* ---- ids ---- */

static void ids_are_checked(void **state) {
  (void)state;
  stay s;
  csm_instance_id ids[INSTANCES], more[INSTANCES];
  double matrices[INSTANCES][16];
  stay_open(&s);
  for (int i = 0; i < INSTANCES; ++i)
    memcpy(matrices[i], s.f.scene.instances[0].transform, sizeof matrices[i]);
  csm_scene *other;
  assert_int_equal(csm_scene_create(s.f.context, &other), CSM_SUCCESS);
  csm_scene_batch batch = batch_of(&s, more);
  assert_int_equal(csm_scene_add(other, &batch), CSM_SUCCESS);
  const csm_instance_id wrong[] = {0, 12345, s.ids[WRONG] + (1ull << 40), more[WRONG]};
  for (size_t i = 0; i < COUNT(wrong); ++i) {
    memcpy(ids, s.ids, sizeof ids);
    ids[WRONG] = wrong[i];
    batch = batch_of(&s, ids);
    expect(&s.f, csm_scene_change(s.scene, &batch), CSM_ERROR_INVALID_HANDLE, "changing what is not there");
    batch.instances = NULL;
    batch.matrices = matrices[0];
    expect(&s.f, csm_scene_move(s.scene, &batch), CSM_ERROR_INVALID_HANDLE, "moving what is not there");
    expect(&s.f, csm_scene_remove(s.scene, INSTANCES, ids), CSM_ERROR_INVALID_HANDLE, "removing what is not there");
  }
  memcpy(ids, s.ids, sizeof ids);
  ids[WRONG] = ids[1];
  expect(&s.f, csm_scene_remove(s.scene, INSTANCES, ids), CSM_ERROR_INVALID_HANDLE, "removing one twice");

  /* Ids that are gone are not given out again, and a mesh may go when its last instance has. */
  expect(&s.f, csm_mesh_destroy(s.f.context, s.f.scene.instances[1].mesh), CSM_ERROR_INVALID_STATE, "a mesh in use");
  assert_int_equal(csm_scene_remove(other, INSTANCES, more), CSM_SUCCESS);
  expect(&s.f, csm_scene_remove(other, 1, more), CSM_ERROR_INVALID_HANDLE, "removing again");
  const csm_mesh box = support_box(s.f.context, 2);
  const csm_instance brief = support_instance(box, 0, 0, 0, 1, 1, 1);
  for (int i = 0; i < 40; ++i) {
    csm_scene_batch one = {.struct_size = sizeof one, .count = 1, .ids = ids, .instances = &brief};
    assert_int_equal(csm_scene_add(other, &one), CSM_SUCCESS);
    for (int k = 0; k < INSTANCES; ++k)
      assert_true(ids[0] != more[k] && ids[0] != 0);
    assert_int_equal(csm_scene_remove(other, 1, ids), CSM_SUCCESS);
    more[i % INSTANCES] = ids[0];
  }
  assert_int_equal(csm_mesh_destroy(s.f.context, box), CSM_SUCCESS);
  assert_int_equal(csm_scene_destroy(other), CSM_SUCCESS);
  stay_close(&s);
}

/* ---- other contexts ---- */

/* Everything of one context is refused by another, on the same backend, whose own has the same place. */
static void contexts_do_not_share_handles(void **state) {
  (void)state;
  stay a, b;
  stay_open(&a);
  stay_open(&b);
  csm_instance_id ids[INSTANCES];
  csm_scene_batch batch = batch_of(&b, ids);
  assert_true(a.f.scene.instances[1].mesh != b.f.scene.instances[1].mesh);
  expect(&a.f, csm_mesh_destroy(a.f.context, b.f.scene.instances[1].mesh), CSM_ERROR_INVALID_HANDLE, "a mesh");
  expect(&a.f, csm_scene_add(a.scene, &batch), CSM_ERROR_INVALID_HANDLE, "instances of another's meshes");
  expect(&a.f, csm_scene_remove(a.scene, 1, b.ids), CSM_ERROR_INVALID_HANDLE, "another's id");
  static const float positions[24];
  const csm_mesh_update_info update = {.struct_size = sizeof update, .positions = positions};
  expect(&a.f, csm_mesh_update(a.f.context, b.f.scene.instances[1].mesh, &update), CSM_ERROR_INVALID_HANDLE, "a mesh");
  shot shot = a.f.scene.shot;
  shot.frame.instances = b.f.scene.instances;
  expect(&a.f, csm_render_cascades(a.f.cascades, shot_frame(&shot)), CSM_ERROR_INVALID_HANDLE, "a list of meshes");
  shot.frame.instances = NULL;
  shot.frame.instance_count = 0;
  shot.frame.scene = b.scene;
  expect(&a.f, csm_render_cascades(a.f.cascades, shot_frame(&shot)), CSM_ERROR_INVALID_HANDLE, "a scene");
  shot.frame.scene = a.scene;
  expect(&a.f, shot_resolve(&shot, b.f.view, a.f.cascades, SIDE, SIDE), CSM_ERROR_INVALID_HANDLE, "a view");
  csm_binding binding = {.struct_size = sizeof binding, .view = b.f.view};
  expect(&a.f, csm_bind(a.f.cascades, &binding), CSM_ERROR_INVALID_HANDLE, "a view to bind");
  float *data = malloc(RESOLUTION * RESOLUTION * sizeof *data);
  csm_read_info read = {.struct_size = sizeof read,
                        .cascades = b.f.cascades,
                        .data = data,
                        .size = RESOLUTION * RESOLUTION * sizeof *data};
  expect(&a.f, csm_read(a.f.context, &read), CSM_ERROR_INVALID_HANDLE, "cascades to read");
  read.source = CSM_READ_MASK;
  read.view = b.f.view;
  expect(&a.f, csm_read(a.f.context, &read), CSM_ERROR_INVALID_HANDLE, "a view to read");
  free(data);
  const uint8_t texel = 255;
  const csm_alpha_mask_info info = {.struct_size = sizeof info, .width = 1, .height = 1, .texels = &texel};
  csm_alpha_mask mask;
  assert_int_equal(csm_alpha_mask_create(b.f.context, &info, &mask), CSM_SUCCESS);
  expect(&a.f, csm_alpha_mask_destroy(a.f.context, mask), CSM_ERROR_INVALID_HANDLE, "an alpha mask");
  stay_close(&a);
  stay_close(&b);
}

/* A scene and a list in one frame. */
static void a_scene_or_a_list(void **state) {
  (void)state;
  stay s;
  stay_open(&s);
  shot shot = s.f.scene.shot;
  shot.frame.scene = s.scene;
  expect(&s.f, csm_render_cascades(s.f.cascades, shot_frame(&shot)), CSM_ERROR_INVALID_VALUE, "both");
  expect(&s.f, shot_resolve(&shot, s.f.view, s.f.cascades, SIDE, SIDE), CSM_ERROR_INVALID_VALUE, "both");
  csm_scene *none = (csm_scene *)&s;
  assert_int_equal(csm_scene_create(NULL, &none), CSM_ERROR_NULL_POINTER);
  assert_null(none);
  expect(&s.f, csm_scene_create(s.f.context, NULL), CSM_ERROR_NULL_POINTER, "no scene");
  stay_close(&s);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_wrong_instance_spoils_the_batch),
      cmocka_unit_test(every_number_must_be_finite),
      cmocka_unit_test(a_short_instance_is_not_read_past_its_end),
      cmocka_unit_test(batches_are_checked),
      cmocka_unit_test(ids_are_checked),
      cmocka_unit_test(contexts_do_not_share_handles),
      cmocka_unit_test(a_scene_or_a_list),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
