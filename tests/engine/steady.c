/* steady.c: a steady frame asks for no memory, neither of the engine's allocator nor of the C library. */
#include "heap_hook.h"
#include "stage.h"

#include <stdlib.h>
#include <string.h>

enum { WARM_UP = 6, FRAMES = 20, BOXES = 2000 };

/* Of the two meshes by turns; the caller frees them. */
static csm_instance *make_boxes(const csm_mesh meshes[2]) {
  csm_instance *boxes = calloc(BOXES, sizeof *boxes);
  assert_non_null(boxes);
  for (int i = 0; i < BOXES; ++i)
    boxes[i] = support_instance(meshes[i % 2], i % 50 - 25, 0.3, i / 50 - 20, 0.2, 0.3 + 0.01 * (i % 7), 0.2);
  return boxes;
}

static void a_steady_frame_allocates_nothing(void **state) {
  (void)state;
  stage stage;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  csm_instance *boxes = make_boxes((const csm_mesh[]){stage.scene.instances[1].mesh, stage.scene.instances[2].mesh});
  for (int i = 0; i < WARM_UP + FRAMES; ++i) {
    rig_begin(rig);
    shot shot = stage_shot(&stage, 0.01 * i);
    shot.frame.instances = boxes;
    shot.frame.instance_count = BOXES;
    const uint64_t before = stage.record.allocations;
    heap_hook_start();
    stage_render(&stage, &shot);
    const uint32_t heap_calls = heap_hook_stop();
    if (i >= WARM_UP) {
      assert_int_equal(stage.record.allocations - before, 0);
      assert_int_equal(heap_calls, 0);
    }
    stage_finish(&stage);
  }
  free(boxes);
  stage_close(&stage);
  rig_close(rig);
}

/* A scene in which nothing moves, and in which some of the instances do. */
static void a_steady_scene_allocates_nothing(void **state) {
  (void)state;
  enum { MOVED = 100 };
  static csm_instance_id ids[BOXES];
  static double matrices[MOVED][16];
  stage stage;
  csm_scene *scene;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  csm_instance *boxes = make_boxes((const csm_mesh[]){stage.scene.instances[1].mesh, stage.scene.instances[2].mesh});
  assert_int_equal(csm_scene_create(stage.context, &scene), CSM_SUCCESS);
  assert_int_equal(
      csm_scene_add(
          scene,
          &(csm_scene_batch){.struct_size = sizeof(csm_scene_batch), .count = BOXES, .ids = ids, .instances = boxes}),
      CSM_SUCCESS);
  for (int i = 0; i < WARM_UP + FRAMES; ++i) {
    rig_begin(rig);
    shot shot = stage_shot(&stage, 0.01 * i);
    shot.frame.instances = NULL;
    shot.frame.instance_count = 0;
    shot.frame.scene = scene;
    for (int k = 0; k < MOVED; ++k) {
      memcpy(matrices[k], boxes[k * 7].transform, sizeof matrices[k]);
      matrices[k][13] += 0.01 * i;
    }
    csm_instance_id moved[MOVED];
    for (int k = 0; k < MOVED; ++k)
      moved[k] = ids[k * 7];
    const csm_scene_batch batch = {.struct_size = sizeof batch, .count = MOVED, .ids = moved, .matrices = matrices[0]};
    const uint64_t before = stage.record.allocations;
    heap_hook_start();
    if (i % 2)
      assert_int_equal(csm_scene_move(scene, &batch), CSM_SUCCESS);
    stage_render(&stage, &shot);
    const uint32_t heap_calls = heap_hook_stop();
    if (i >= WARM_UP) {
      assert_int_equal(stage.record.allocations - before, 0);
      assert_int_equal(heap_calls, 0);
    }
    stage_finish(&stage);
  }
  free(boxes);
  stage_close(&stage);
  rig_close(rig);
}

/* A mesh too large for the smallest staging is updated in every frame. */
static void a_steady_update_allocates_nothing(void **state) {
  (void)state;
  enum { VERTICES = 400000 };
  static float positions[VERTICES][3];
  static const uint16_t indices[3] = {0, 1, 2};
  stage stage;
  csm_mesh mesh;
  rig *rig = rig_open(RIG_TYPICAL);
  stage_open(&stage, rig);
  positions[1][0] = positions[2][2] = 1;
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = positions,
                              .vertex_count = VERTICES,
                              .indices = indices,
                              .index_count = 3,
                              .index_size = 2};
  const csm_mesh_update_info update = {.struct_size = sizeof update, .positions = positions};
  assert_int_equal(csm_mesh_create(stage.context, &info, &mesh), CSM_SUCCESS);
  for (int i = 0; i < WARM_UP + FRAMES; ++i) {
    rig_begin(rig);
    shot shot = stage_shot(&stage, 0);
    positions[1][1] = 0.1f * (float)(i % 3);
    const uint64_t before = stage.record.allocations;
    heap_hook_start();
    assert_int_equal(csm_mesh_update(stage.context, mesh, &update), CSM_SUCCESS);
    stage_render(&stage, &shot);
    stage_resolve(&stage, &shot, (picture_size){8, 8});
    const uint32_t heap_calls = heap_hook_stop();
    if (i >= WARM_UP) {
      assert_int_equal(stage.record.allocations - before, 0);
      assert_int_equal(heap_calls, 0);
    }
    stage_finish(&stage);
  }
  stage_close(&stage);
  rig_close(rig);
}

/* The hook sees a library of csm's that allocates, for no allocator is given there. */
static void the_hook_sees_allocations(void **state) {
  (void)state;
  const csm_create_info info = {.struct_size = sizeof info, .version = CSM_VERSION, .backend = support_backend()};
  csm_context *context;
  heap_hook_start();
  assert_int_equal(csm_create(&info, &context), CSM_SUCCESS);
  assert_true(heap_hook_stop() > 4);
  csm_destroy(context);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_steady_frame_allocates_nothing),
      cmocka_unit_test(a_steady_scene_allocates_nothing),
      cmocka_unit_test(a_steady_update_allocates_nothing),
      cmocka_unit_test(the_hook_sees_allocations),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
