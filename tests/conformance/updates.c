/*
 * updates.c: meshes whose vertices move: a mesh that was updated draws what a mesh made with those positions draws, in
 * frames after the update and not in those before; for lists and scenes; after a switch as well.
 */
#include "outcome.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 9, VERTICES = SIDE * SIDE, INDICES = (SIDE - 1) * (SIDE - 1) * 6 };

/* A cloth over the ground at a time, as rows of four floats. */
typedef struct cloth {
  float positions[VERTICES][4];
  uint16_t indices[INDICES];
} cloth;

static void cloth_at(cloth *cloth, double time, double away) {
  for (int i = 0; i < VERTICES; ++i) {
    const double x = (double)(i % SIDE) / (SIDE - 1) * 2 - 1, z = (double)(i / SIDE) / (SIDE - 1) * 2 - 1;
    cloth->positions[i][0] = (float)(x * (1 + 0.1 * time) + away);
    cloth->positions[i][1] = (float)(cos(2 * x + time) * cos(1.7 * z - 0.5 * time) + time);
    cloth->positions[i][2] = (float)z;
    cloth->positions[i][3] = NAN;
  }
  uint16_t *out = cloth->indices;
  for (uint16_t row = 0; row + 1 < SIDE; ++row)
    for (uint16_t column = 0; column + 1 < SIDE; ++column) {
      const uint16_t a = (uint16_t)(row * SIDE + column), b = (uint16_t)(a + SIDE);
      const uint16_t corners[6] = {a, b, (uint16_t)(a + 1), (uint16_t)(a + 1), b, (uint16_t)(b + 1)};
      memcpy(out, corners, sizeof corners);
      out += 6;
    }
}

static csm_mesh make_cloth(csm_context *context, const cloth *cloth) {
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .flags = CSM_MESH_TWO_SIDED,
                              .positions = cloth->positions,
                              .position_stride = sizeof cloth->positions[0],
                              .vertex_count = VERTICES,
                              .indices = cloth->indices,
                              .index_count = INDICES,
                              .index_size = 2};
  csm_mesh mesh;
  assert_int_equal(csm_mesh_create(context, &info, &mesh), CSM_SUCCESS);
  return mesh;
}

static void update_cloth(csm_context *context, csm_mesh mesh, const cloth *cloth) {
  const csm_mesh_update_info info = {
      .struct_size = sizeof info, .positions = cloth->positions, .position_stride = sizeof cloth->positions[0]};
  const csm_result result = csm_mesh_update(context, mesh, &info);
  if (result)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(context));
}

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades, *fresh; /* of what is updated; of meshes that are made with those positions */
  csm_view *view;
  support_scene scene;
  cloth cloth;
  csm_mesh mesh;
} fixture;

static csm_config config_of_all(void) {
  csm_config config = support_config();
  config.resolution = 128;
  config.filter = CSM_FILTER_EXACT; /* trees are updated, too */
  return config;
}

static void setup(fixture *f, uint32_t flags) {
  memset(f, 0, sizeof *f);
  csm_create_info info = support_create_info(&f->record);
  info.flags |= flags | CSM_CREATE_RAYS;
  assert_int_equal(csm_create(&info, &f->context), CSM_SUCCESS);
  const csm_config config = config_of_all();
  f->view = support_view(f->context);
  support_scene_make(&f->scene, f->context);
  cloth_at(&f->cloth, 0, 0);
  f->mesh = make_cloth(f->context, &f->cloth);
  assert_int_equal(csm_cascades_create(f->context, &config, &f->cascades), CSM_SUCCESS);
  assert_int_equal(csm_cascades_create(f->context, &config, &f->fresh), CSM_SUCCESS);
}

static shot shot_of(fixture *f, csm_mesh mesh, double away) {
  shot shot = f->scene.shot;
  f->scene.instances[1] = support_instance(mesh, -3 - 3 * away, 1, 0, 3, 1, 3);
  f->scene.instances[2] = support_instance(mesh, 6 - 2 * away, 4, -8, 2, 1, 2);
  shot.frame.instances = f->scene.instances;
  return shot;
}

static outcome draw(fixture *f, csm_cascades *cascades, csm_mesh mesh, double away) {
  shot shot = shot_of(f, mesh, away);
  return outcome_draw(f->context, cascades, f->view, &shot);
}

static void expect_fresh(fixture *f, double away, const char *what) {
  const csm_mesh fresh = make_cloth(f->context, &f->cloth);
  outcome expected = draw(f, f->fresh, fresh, away), drawn = draw(f, f->cascades, f->mesh, away);
  outcome_expect_same(&expected, &drawn, what);
  outcome_free(&expected);
  assert_int_equal(csm_mesh_destroy(f->context, fresh), CSM_SUCCESS);
}

static void an_update_is_as_a_new_mesh(void **state) {
  (void)state;
  fixture f;
  setup(&f, 0);
  outcome first = draw(&f, f.cascades, f.mesh, 0);
  for (int step = 1; step <= 6; ++step) {
    cloth_at(&f.cloth, 0.4 * step, 0);
    update_cloth(f.context, f.mesh, &f.cloth);
    if (step % 2) /* twice before a frame: the last counts */
      update_cloth(f.context, f.mesh, &f.cloth);
    expect_fresh(&f, 0, "updated");
  }
  outcome last = draw(&f, f.cascades, f.mesh, 0);
  assert_true(!strcmp(support_backend(), "null") || !outcome_same_maps(&first, &last));
  outcome_free(&first);
  outcome_free(&last);
  support_close(f.context, &f.record);
}

/* The middle of the positions moves by 400 km: instances bring them back, and precision stays. */
static void an_update_may_go_far(void **state) {
  (void)state;
  static const double away[] = {0, 2e5, -2e5, 0};
  fixture f;
  setup(&f, 0);
  for (int i = 0; i < 4; ++i) {
    cloth_at(&f.cloth, 0.4, away[i]);
    update_cloth(f.context, f.mesh, &f.cloth);
    expect_fresh(&f, away[i], "far away");
  }
  support_close(f.context, &f.record);
}

/* A frame that was submitted before the update draws what it had, though nothing waited for it. */
static void frames_in_flight_keep_what_they_had(void **state) {
  (void)state;
  enum { FRAMES = 8 };
  fixture f;
  csm_cascades *each[FRAMES];
  setup(&f, 0);
  const csm_config config = config_of_all();
  for (int i = 0; i < FRAMES; ++i)
    assert_int_equal(csm_cascades_create(f.context, &config, &each[i]), CSM_SUCCESS);
  for (int i = 0; i < FRAMES; ++i) {
    cloth_at(&f.cloth, 0.3 * i, 0);
    update_cloth(f.context, f.mesh, &f.cloth);
    shot shot = shot_of(&f, f.mesh, 0);
    assert_int_equal(csm_render_cascades(each[i], shot_frame(&shot)), CSM_SUCCESS);
  }
  for (int i = 0; i < FRAMES; ++i) {
    cloth_at(&f.cloth, 0.3 * i, 0);
    const csm_mesh fresh = make_cloth(f.context, &f.cloth);
    shot shot = shot_of(&f, fresh, 0);
    assert_int_equal(csm_render_cascades(f.fresh, shot_frame(&shot)), CSM_SUCCESS);
    for (uint32_t k = 0; k < config.cascade_count; ++k) {
      float *expected = support_map(f.context, f.fresh, k, 128), *drawn = support_map(f.context, each[i], k, 128);
      assert_memory_equal(expected, drawn, 128 * 128 * sizeof *drawn);
      free(expected);
      free(drawn);
    }
    assert_int_equal(csm_mesh_destroy(f.context, fresh), CSM_SUCCESS);
  }
  support_close(f.context, &f.record);
}

/* A scene's instances count as moved, and no others. */
static void a_scene_takes_an_update_over(void **state) {
  (void)state;
  fixture f;
  csm_scene *scene;
  csm_instance_id ids[SUPPORT_INSTANCES];
  setup(&f, 0);
  shot shot = shot_of(&f, f.mesh, 0);
  assert_int_equal(csm_scene_create(f.context, &scene), CSM_SUCCESS);
  assert_int_equal(csm_scene_add(scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                           .count = SUPPORT_INSTANCES,
                                                           .ids = ids,
                                                           .instances = f.scene.instances}),
                   CSM_SUCCESS);
  for (int step = 0; step < 4; ++step) {
    cloth_at(&f.cloth, 0.5 * step, 0);
    update_cloth(f.context, f.mesh, &f.cloth);
    const csm_mesh fresh = make_cloth(f.context, &f.cloth);
    outcome expected = draw(&f, f.fresh, fresh, 0);
    shot.frame.instances = NULL;
    shot.frame.instance_count = 0;
    shot.frame.scene = scene;
    outcome drawn = outcome_draw(f.context, f.cascades, f.view, &shot);
    csm_stats stats = {.struct_size = sizeof stats};
    assert_int_equal(csm_get_stats(f.cascades, &stats), CSM_SUCCESS);
    assert_int_equal(stats.instances_changed, step ? 2 : SUPPORT_INSTANCES);
    outcome_expect_same(&expected, &drawn, "a scene after an update");
    outcome_free(&expected);
    assert_int_equal(csm_mesh_destroy(f.context, fresh), CSM_SUCCESS);
  }
  support_close(f.context, &f.record);
}

static uint64_t plan_hash(const fixture *f) {
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(f->cascades, &stats), CSM_SUCCESS);
  return stats.plan_hash;
}

/* A plan of a list has no hash once a mesh that it looks into has moved or is gone. */
static void a_plan_of_a_list_knows_its_meshes(void **state) {
  (void)state;
  fixture f;
  setup(&f, 0);
  outcome drawn = draw(&f, f.cascades, f.mesh, 0);
  outcome_free(&drawn);
  assert_true(plan_hash(&f) != 0);
  cloth_at(&f.cloth, 0.7, 0);
  update_cloth(f.context, f.mesh, &f.cloth);
  assert_true(plan_hash(&f) == 0);
  drawn = draw(&f, f.cascades, f.mesh, 0);
  outcome_free(&drawn);
  assert_true(plan_hash(&f) != 0);
  assert_int_equal(csm_mesh_destroy(f.context, f.mesh), CSM_SUCCESS);
  assert_true(plan_hash(&f) == 0);
  support_close(f.context, &f.record);
}

/* The copy that is kept for a switch is the updated one. */
static void a_switch_takes_an_update_along(void **state) {
  (void)state;
  const char *mine = support_backend();
  fixture f;
  setup(&f, CSM_CREATE_KEEP_GEOMETRY);
  outcome before = draw(&f, f.cascades, f.mesh, 0);
  outcome_free(&before);
  cloth_at(&f.cloth, 1.1, 0);
  update_cloth(f.context, f.mesh, &f.cloth);
  csm_create_info info = support_create_info(&f.record);
  info.backend = !strcmp(mine, "vulkan") ? "d3d12" : !strcmp(mine, "d3d12") ? "vulkan" : mine;
  assert_int_equal(csm_switch_backend(f.context, &info), CSM_SUCCESS);
  expect_fresh(&f, 0, "after a switch");
  cloth_at(&f.cloth, 1.7, 0);
  update_cloth(f.context, f.mesh, &f.cloth);
  expect_fresh(&f, 0, "updated after a switch");
  support_close(f.context, &f.record);
}

/* Each allocation fails: the mesh is as it was, and the update is taken when it is tried again. */
static void an_update_may_fail(void **state) {
  (void)state;
  fixture f;
  setup(&f, CSM_CREATE_KEEP_GEOMETRY);
  f.record.quiet = true;
  outcome before = draw(&f, f.cascades, f.mesh, 0);
  cloth_at(&f.cloth, 0.9, 0);
  csm_result result;
  int64_t failures = 0;
  do {
    const csm_mesh_update_info info = {
        .struct_size = sizeof info, .positions = f.cloth.positions, .position_stride = sizeof f.cloth.positions[0]};
    f.record.allocations_left = failures++;
    result = csm_mesh_update(f.context, f.mesh, &info);
    f.record.allocations_left = -1;
    if (result) {
      assert_true(result == CSM_ERROR_OUT_OF_MEMORY || result == CSM_ERROR_OUT_OF_DEVICE_MEMORY);
      outcome same = draw(&f, f.cascades, f.mesh, 0);
      outcome_expect_same(&before, &same, "a failed update");
    }
  } while (result);
  outcome_free(&before);
  f.record.errors = 0;
  expect_fresh(&f, 0, "tried again");
  support_close(f.context, &f.record);
}

/* Triangles that have no area are left out as long as they have none: here all, which lie along a line. */
static void what_had_no_area_may_get_one(void **state) {
  (void)state;
  fixture f;
  setup(&f, CSM_CREATE_KEEP_GEOMETRY);
  cloth flat = f.cloth;
  csm_stats stats = {.struct_size = sizeof stats};
  for (int i = 0; i < VERTICES; ++i)
    flat.positions[i][1] = flat.positions[i][2] = 0;
  assert_int_equal(csm_mesh_destroy(f.context, f.mesh), CSM_SUCCESS);
  f.mesh = make_cloth(f.context, &flat);
  outcome none = draw(&f, f.cascades, f.mesh, 0);
  assert_int_equal(csm_get_stats(f.cascades, &stats), CSM_SUCCESS);
  const uint64_t others = stats.cascades[0].triangles_drawn;
  update_cloth(f.context, f.mesh, &f.cloth);
  expect_fresh(&f, 0, "an area");
  assert_int_equal(csm_get_stats(f.cascades, &stats), CSM_SUCCESS);
  assert_true(stats.cascades[0].triangles_drawn >= others + INDICES / 3);
  outcome_free(&none);
  support_close(f.context, &f.record);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(an_update_is_as_a_new_mesh),
      cmocka_unit_test(an_update_may_go_far),
      cmocka_unit_test(frames_in_flight_keep_what_they_had),
      cmocka_unit_test(a_scene_takes_an_update_over),
      cmocka_unit_test(a_plan_of_a_list_knows_its_meshes),
      cmocka_unit_test(a_switch_takes_an_update_along),
      cmocka_unit_test(an_update_may_fail),
      cmocka_unit_test(what_had_no_area_may_get_one),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
