/*
 * lasting.c: what lasts from frame to frame on an engine's device, and changes while frames wait to run: scenes, meshes
 * whose vertices move, and views.
 */
#include "stage.h"

#include <math.h>
#include <string.h>

enum { STEPS = 9 };

static const picture_size size = {96, 64};

/* Draws a step into the open frame of an engine, or on an own device. */
typedef void (*draw_step)(stage *stage, void *user, uint32_t step);

/* Draws steps, as many of which as may be wait to run, and compares with an own device that draws them at once. Each
   side has its own user data. */
static void compare_steps(rig_kind kind, draw_step draw, void *own_user, void *user, size_t count) {
  stage own, stage;
  picture expected[STEPS];
  picture_copy copies[STEPS];
  stage_open(&own, NULL);
  for (uint32_t i = 0; i < count; ++i) {
    draw(&own, own_user, i);
    expected[i] = picture_read(own.context, own.cascades, own.view, size);
    assert_true(i == 0 || !picture_equal(&expected[i], &expected[i - 1]));
  }
  stage_close(&own);
  rig *rig = rig_open(kind);
  stage_open(&stage, rig);
  const uint64_t first = rig_frame(rig) + 1;
  for (uint32_t i = 0; i < count + RIG_FRAMES; ++i) {
    if (i >= RIG_FRAMES) {
      rig_run(rig, first + i - RIG_FRAMES);
      picture drawn = picture_take(rig, &copies[i - RIG_FRAMES]);
      picture_expect_equal(&expected[i - RIG_FRAMES], &drawn);
      picture_free(&expected[i - RIG_FRAMES]);
      stage_retire(&stage);
    }
    if (i >= count)
      continue;
    rig_begin(rig);
    draw(&stage, user, i);
    copies[i] = stage_record(&stage, size);
    rig_end(rig);
  }
  stage_close(&stage);
  rig_close(rig);
}

static void render_and_resolve(stage *stage, shot *shot) {
  stage_render(stage, shot);
  stage_resolve(stage, shot, size);
}

/* ---- scenes ---- */

typedef struct kept_scene {
  csm_scene *scene;
  csm_instance_id ids[SUPPORT_INSTANCES];
} kept_scene;

static void move_one(stage *stage, kept_scene *kept, uint32_t place, uint32_t step) {
  csm_instance *instance = &stage->scene.instances[place];
  instance->transform[12] += 0.5;
  instance->transform[13] += step % 2 ? 0.25 : 0;
  assert_int_equal(csm_scene_move(kept->scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                                  .count = 1,
                                                                  .ids = &kept->ids[place],
                                                                  .matrices = instance->transform}),
                   CSM_SUCCESS);
}

/* On an own device a list, on an engine's a scene: what changes is what lies between two frames. */
static void draw_kept(stage *stage, void *user, uint32_t step) {
  kept_scene *kept = user;
  shot shot = stage_shot(stage, 0.2 * step);
  if (step == 0) {
    assert_int_equal(csm_scene_create(stage->context, &kept->scene), CSM_SUCCESS);
    assert_int_equal(csm_scene_add(kept->scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                                   .count = SUPPORT_INSTANCES,
                                                                   .ids = kept->ids,
                                                                   .instances = stage->scene.instances}),
                     CSM_SUCCESS);
  } else {
    move_one(stage, kept, 1 + step % 5, step);
  }
  if (step == 5) { /* one goes, with its scene's last word on it */
    stage->scene.instances[2].flags = CSM_INSTANCE_HIDDEN;
    assert_int_equal(csm_scene_remove(kept->scene, 1, &kept->ids[2]), CSM_SUCCESS);
    assert_int_equal(csm_scene_add(kept->scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                                   .count = 1,
                                                                   .ids = &kept->ids[2],
                                                                   .instances = &stage->scene.instances[2]}),
                     CSM_SUCCESS);
  }
  if (stage->rig) {
    shot.frame.instances = NULL;
    shot.frame.instance_count = 0;
    shot.frame.scene = kept->scene;
  }
  render_and_resolve(stage, &shot);
}

static void scenes_change_while_frames_wait(void **state) {
  (void)state;
  kept_scene own = {0}, kept = {0};
  compare_steps(RIG_TYPICAL, draw_kept, &own, &kept, STEPS);
}

/* ---- meshes ---- */

typedef struct moving {
  hill hill;
  csm_mesh mesh;
} moving;

static void shape(hill *hill, uint32_t step) {
  hill_make(hill);
  for (uint32_t i = 0; i < HILL_VERTICES; ++i) {
    hill->positions[i][1] = hill->positions[i][1] * (1 + 0.2f * (float)step) + 0.3f * (float)(step % 3);
    hill->positions[i][0] *= 1 + 0.05f * (float)step;
  }
}

/* On an own device a new mesh each time, on an engine's an update of the one. */
static void draw_moving(stage *stage, void *user, uint32_t step) {
  moving *it = user;
  shape(&it->hill, step);
  if (stage->rig && it->mesh) {
    const csm_mesh_update_info info = {.struct_size = sizeof info, .positions = it->hill.positions};
    assert_int_equal(csm_mesh_update(stage->context, it->mesh, &info), CSM_SUCCESS);
  } else {
    it->mesh = hill_mesh(stage->context, &it->hill, 2);
  }
  stage->scene.instances[1] = support_instance(it->mesh, -1, 2, 1, 3, 2, 3);
  stage->scene.instances[3] = support_instance(it->mesh, -6, 5, -9, 2, 1, 2);
  shot shot = stage_shot(stage, 0);
  render_and_resolve(stage, &shot);
}

static void meshes_move_while_frames_wait(void **state) {
  (void)state;
  static const rig_kind kinds[] = {RIG_TYPICAL, RIG_MODERN};
  for (int i = 0; i < 2; ++i) {
    static moving own, kept;
    own = kept = (moving){.mesh = 0};
    compare_steps(kinds[i], draw_moving, &own, &kept, STEPS);
  }
}

/* The engine writes its own buffers, and says so: bounds that grew are drawn, though the first ones were culled. */
static void engines_buffers_may_change(void **state) {
  (void)state;
  stage own, stage;
  hill hill;
  rig_native native;
  csm_mesh mesh;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&own, NULL);
  stage_open(&stage, rig);
  rig_buffer vertices = rig_buffer_make(rig, RIG_GEOMETRY, sizeof hill.positions);
  rig_buffer indices = rig_buffer_make(rig, RIG_GEOMETRY, sizeof hill.indices);
  shape(&hill, 0);
  for (uint32_t i = 0; i < HILL_VERTICES; ++i)
    hill.positions[i][1] -= 500; /* far below: no map has it */
  memcpy(vertices.mapped, hill.positions, sizeof hill.positions);
  memcpy(indices.mapped, hill.indices, sizeof hill.indices);
  csm_mesh_info info = hill_info(&hill, 2);
  info.positions = info.indices = NULL;
  memcpy(info.bounds_min, (const float[]){-1, -501, -1}, sizeof info.bounds_min);
  memcpy(info.bounds_max, (const float[]){1, -499, 1}, sizeof info.bounds_max);
  rig_mesh_give(&(rig_mesh){.vertices = &vertices, .indices = &indices, .vertex_stride = 12}, &native, &info);
  assert_int_equal(csm_mesh_create(stage.context, &info, &mesh), CSM_SUCCESS);
  for (uint32_t step = 0; step < 3; ++step) {
    if (step) {
      shape(&hill, step);
      memcpy(vertices.mapped, hill.positions, sizeof hill.positions); /* no frame is in flight */
      const csm_mesh_update_info update = {
          .struct_size = sizeof update, .bounds_min = {-2, -4, -1}, .bounds_max = {2, 4, 1}};
      assert_int_equal(csm_mesh_update(stage.context, mesh, &update), CSM_SUCCESS);
    }
    own.scene.instances[1] = support_instance(hill_mesh(own.context, &hill, 2), -1, 2, 1, 3, 2, 3);
    stage.scene.instances[1] = support_instance(mesh, -1, 2, 1, 3, 2, 3);
    picture expected = stage_draw_at(&own, 0, size), drawn = stage_draw_at(&stage, 0, size);
    picture_expect_equal(&expected, &drawn);
    picture_free(&expected);
  }
  stage_close(&own);
  assert_int_equal(csm_mesh_destroy(stage.context, mesh), CSM_SUCCESS);
  stage_retire(&stage);
  rig_buffer_free(rig, &vertices);
  rig_buffer_free(rig, &indices);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- views ---- */

/* Two eyes and a mirror in one frame; those that were made for it go before it runs. */
static void views_go_before_their_frame_runs(void **state) {
  (void)state;
  enum { VIEWS = 3 };
  static const picture_size sizes[VIEWS] = {{96, 64}, {96, 64}, {160, 33}};
  stage own, stage;
  picture expected[VIEWS];
  picture_copy copies[VIEWS];
  csm_view *views[VIEWS];
  stage_open(&own, NULL);
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  for (int side = 0; side < 2; ++side) {
    struct stage *it = side ? &stage : &own;
    if (side)
      rig_begin(rig);
    shot rendered = stage_shot(it, 0);
    stage_render(it, &rendered);
    for (int i = 0; i < VIEWS; ++i) {
      shot eye = stage_shot(it, 0.5 * i);
      views[i] = support_view(it->context);
      assert_int_equal(shot_resolve(&eye, views[i], it->cascades, sizes[i].width, sizes[i].height), CSM_SUCCESS);
      if (side)
        copies[i] = picture_record(rig, it->cascades, views[i], sizes[i], sizeof(float));
      else
        expected[i] = picture_read(it->context, it->cascades, views[i], sizes[i]);
    }
    for (int i = 0; i < VIEWS; ++i)
      assert_int_equal(csm_view_destroy(views[i]), CSM_SUCCESS);
  }
  rig_end(rig);
  rig_run(rig, rig_frame(rig));
  for (int i = 0; i < VIEWS; ++i) {
    picture drawn = picture_take(rig, &copies[i]);
    picture_expect_equal(&expected[i], &drawn);
    picture_free(&expected[i]);
  }
  const int64_t blocks = stage.record.blocks;
  stage_retire(&stage);
  assert_true(stage.record.blocks < blocks);
  stage_close(&own);
  stage_close(&stage);
  rig_close(rig);
}

/* ---- a switch ---- */

/* Scenes and views go along to a device that is opened anew, while the last frame on the old one waits to run. */
static void a_switch_takes_all_along(void **state) {
  (void)state;
  stage stage;
  kept_scene kept;
  rig *rigs[2] = {rig_open(RIG_TYPICAL), rig_open(RIG_BARE)};
  stage_open(&stage, rigs[0]);
  csm_destroy(stage.context);
  csm_create_info info = stage_create_info(rigs[0], &stage.record);
  info.flags |= CSM_CREATE_KEEP_GEOMETRY;
  assert_int_equal(csm_create(&info, &stage.context), CSM_SUCCESS);
  assert_int_equal(csm_cascades_create(stage.context, &stage.config, &stage.cascades), CSM_SUCCESS);
  stage.view = support_view(stage.context);
  support_scene_make(&stage.scene, stage.context);
  assert_int_equal(csm_scene_create(stage.context, &kept.scene), CSM_SUCCESS);
  assert_int_equal(csm_scene_add(kept.scene, &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch),
                                                                .count = SUPPORT_INSTANCES,
                                                                .ids = kept.ids,
                                                                .instances = stage.scene.instances}),
                   CSM_SUCCESS);
  picture_copy copies[2];
  for (int i = 0; i < 2; ++i) {
    stage.rig = rigs[i];
    rig_begin(rigs[i]);
    if (i) { /* frames go on counting */
      rig_end(rigs[i]);
      rig_begin(rigs[i]);
      info = stage_create_info(rigs[i], &stage.record);
      assert_int_equal(csm_switch_backend(stage.context, &info), CSM_SUCCESS);
    }
    shot shot = stage_shot(&stage, 0);
    shot.frame.instances = NULL;
    shot.frame.instance_count = 0;
    shot.frame.scene = kept.scene;
    render_and_resolve(&stage, &shot);
    copies[i] = stage_record(&stage, size);
    rig_end(rigs[i]);
  }
  for (int i = 0; i < 2; ++i)
    rig_run(rigs[i], rig_frame(rigs[i]));
  picture first = picture_take(rigs[0], &copies[0]), second = picture_take(rigs[1], &copies[1]);
  picture_expect_casters(&first, stage.config.cascade_count);
  picture_expect_equal(&first, &second);
  picture_free(&first);
  stage_retire(&stage);
  stage_close(&stage);
  for (int i = 0; i < 2; ++i)
    rig_close(rigs[i]);
}

/* With every frame retired, the switch is the end of the old device: the engine may destroy it at once. */
static void a_switch_lets_an_idle_device_go(void **state) {
  (void)state;
  stage stage;
  rig *rigs[2] = {rig_open(RIG_TYPICAL), rig_open(RIG_TYPICAL)};
  stage_open(&stage, rigs[0]);
  csm_destroy(stage.context);
  csm_create_info info = stage_create_info(rigs[0], &stage.record);
  info.flags |= CSM_CREATE_KEEP_GEOMETRY;
  assert_int_equal(csm_create(&info, &stage.context), CSM_SUCCESS);
  assert_int_equal(csm_cascades_create(stage.context, &stage.config, &stage.cascades), CSM_SUCCESS);
  stage.view = support_view(stage.context);
  support_scene_make(&stage.scene, stage.context);
  picture first = stage_draw_at(&stage, 0, size);
  info = stage_create_info(rigs[1], &stage.record);
  assert_int_equal(csm_switch_backend(stage.context, &info), CSM_SUCCESS);
  rig_close(rigs[0]);
  stage.rig = rigs[1];
  picture second = stage_draw_at(&stage, 0, size);
  picture_expect_equal(&first, &second);
  picture_free(&first);
  stage_close(&stage);
  rig_close(rigs[1]);
}

/* ---- the ring ---- */

/* Maps of an empty list ask for nothing of the ring, and begin their frame all the same. */
static void frames_of_nothing_keep_their_memory(void **state) {
  (void)state;
  enum { FRAMES = 256 };
  stage stage;
  csm_stats stats = {.struct_size = sizeof stats};
  uint64_t bytes = 0;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  for (uint32_t i = 0; i < FRAMES; ++i) {
    rig_begin(rig);
    shot shot = stage_shot(&stage, 0);
    shot.frame.instances = NULL;
    shot.frame.instance_count = 0;
    stage_render(&stage, &shot);
    stage_resolve(&stage, &shot, (picture_size){8, 8});
    stage_finish(&stage);
    assert_int_equal(csm_get_stats(stage.cascades, &stats), CSM_SUCCESS);
    bytes = i < RIG_FRAMES ? stats.frame_bytes : bytes;
    assert_true(bytes > 0 && stats.frame_bytes == bytes);
  }
  stage_close(&stage);
  rig_close(rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(scenes_change_while_frames_wait),
      cmocka_unit_test(meshes_move_while_frames_wait),
      cmocka_unit_test(engines_buffers_may_change),
      cmocka_unit_test(views_go_before_their_frame_runs),
      cmocka_unit_test(a_switch_takes_all_along),
      cmocka_unit_test(a_switch_lets_an_idle_device_go),
      cmocka_unit_test(frames_of_nothing_keep_their_memory),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
