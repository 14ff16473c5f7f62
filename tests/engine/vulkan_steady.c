/* vulkan_steady.c: a steady frame asks for no memory, neither of the engine's allocator nor of the C library. */
#include "steady.h"
#include "vulkan_case.h"

#include <stdlib.h>

static void a_steady_frame_allocates_nothing(void **state) {
  (void)state;
  vulkan_engine engine;
  vulkan_case c;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  csm_instance *boxes = steady_boxes((const csm_mesh[]){c.scene.instances[1].mesh, c.scene.instances[2].mesh});
  for (int i = 0; i < STEADY_WARM_UP + STEADY_FRAMES; ++i) {
    vulkan_engine_begin(&engine);
    steady_render(c.cascades, case_frame(&c, 0.01 * i), boxes, &c.record, i);
    vulkan_engine_end(&engine);
    vulkan_engine_run(&engine, engine.frame);
    assert_int_equal(csm_retire(c.context, engine.frame), CSM_SUCCESS);
  }
  free(boxes);
  case_close(&c);
  vulkan_engine_close(&engine);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_steady_frame_allocates_nothing),
      cmocka_unit_test(steady_hook_sees_allocations),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
