/* d3d12_steady.c: a steady frame asks for no memory, neither of the engine's allocator nor of the C library. */
#include "d3d12_rig.h"
#include "heap_hook.h"

#include <stdlib.h>

enum { warm_up = 6, steady = 20, boxes = 2000 };

static void a_steady_frame_allocates_nothing(void **state) {
  (void)state;
  d3d12_rig rig;
  support_scene scene;
  csm_cascades *cascades;
  rig_open(&rig);
  support_scene_make(&scene, rig.context);
  const csm_config config = support_config();
  assert_int_equal(csm_cascades_create(rig.context, &config, &cascades), CSM_SUCCESS);
  csm_instance *instances = calloc(boxes, sizeof *instances);
  for (int i = 0; i < boxes; ++i)
    instances[i] = support_instance(scene.instances[1 + i % 2].mesh, i % 50 - 25, 0.3, i / 50 - 20, 0.2,
                                    0.3 + 0.01 * (i % 7), 0.2);
  uint64_t asked = 0;
  uint32_t heap = 0;
  for (int i = 0; i < warm_up + steady; ++i) {
    csm_frame frame = rig_frame(&rig, &scene, d3d12_engine_begin(&rig.engine));
    frame.view[12] += 0.01 * i;
    frame.instances = instances;
    frame.instance_count = boxes;
    const uint64_t before = rig.record.allocations;
    heap_hook_start();
    assert_int_equal(csm_render_cascades(cascades, &frame), CSM_SUCCESS);
    const uint32_t calls = heap_hook_stop();
    if (i >= warm_up) {
      heap += calls;
      asked += rig.record.allocations - before;
    }
    d3d12_engine_end(&rig.engine);
    d3d12_engine_run(&rig.engine, rig.engine.frame);
    rig_retire(&rig);
  }
  assert_int_equal(asked, 0);
  assert_int_equal(heap, 0);
  free(instances);
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  rig_close(&rig);
}

/* The hook sees what it is there to see: a library of csm's that allocates, for no allocator is given here. */
static void the_hook_sees_allocations(void **state) {
  (void)state;
  const csm_create_info info = {.struct_size = sizeof info, .version = CSM_VERSION, .backend = support_backend()};
  csm_context *context;
  heap_hook_start();
  assert_int_equal(csm_create(&info, &context), CSM_SUCCESS);
  assert_true(heap_hook_stop() > 10);
  csm_destroy(context);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_steady_frame_allocates_nothing),
      cmocka_unit_test(the_hook_sees_allocations),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
