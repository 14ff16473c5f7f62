/* d3d12_steady.c: a steady frame asks for no memory, neither of the engine's allocator nor of the C library. */
#include "d3d12_rig.h"
#include "steady.h"

#include <stdlib.h>

static void a_steady_frame_allocates_nothing(void **state) {
  (void)state;
  d3d12_rig rig;
  support_scene scene;
  csm_cascades *cascades;
  rig_open(&rig);
  support_scene_make(&scene, rig.context);
  const csm_config config = support_config();
  assert_int_equal(csm_cascades_create(rig.context, &config, &cascades), CSM_SUCCESS);
  csm_instance *boxes = steady_boxes((const csm_mesh[]){scene.instances[1].mesh, scene.instances[2].mesh});
  for (int i = 0; i < STEADY_WARM_UP + STEADY_FRAMES; ++i) {
    csm_frame frame = rig_frame(&rig, &scene, d3d12_engine_begin(&rig.engine));
    frame.view[12] += 0.01 * i;
    steady_render(cascades, frame, boxes, &rig.record, i);
    d3d12_engine_end(&rig.engine);
    d3d12_engine_run(&rig.engine, rig.engine.frame);
    rig_retire(&rig);
  }
  free(boxes);
  assert_int_equal(csm_cascades_destroy(cascades), CSM_SUCCESS);
  rig_close(&rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_steady_frame_allocates_nothing),
      cmocka_unit_test(steady_hook_sees_allocations),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
