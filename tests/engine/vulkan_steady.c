/* vulkan_steady.c: a steady frame asks for no memory, neither of the engine's allocator nor of the C library. */
#include "heap_hook.h"
#include "vulkan_case.h"

#include <stdlib.h>

enum { warm_up = 6, steady = 20, boxes = 2000 };

static void a_steady_frame_allocates_nothing(void **state) {
  (void)state;
  vulkan_engine engine;
  vulkan_case c;
  vulkan_engine_open(&engine, VULKAN_ENGINE_TYPICAL);
  case_open(&c, &engine);
  csm_instance *instances = calloc(boxes, sizeof *instances);
  for (int i = 0; i < boxes; ++i)
    instances[i] = support_instance(c.scene.instances[1 + i % 2].mesh, i % 50 - 25, 0.3, i / 50 - 20, 0.2,
                                    0.3 + 0.01 * (i % 7), 0.2);
  uint64_t asked = 0;
  uint32_t heap = 0;
  for (int i = 0; i < warm_up + steady; ++i) {
    VkCommandBuffer commands = vulkan_engine_begin(&engine);
    csm_frame frame = case_frame(&c, 0.01 * i);
    frame.command_buffer = commands;
    frame.instances = instances;
    frame.instance_count = boxes;
    const uint64_t before = c.record.allocations;
    heap_hook_start();
    assert_int_equal(csm_render_cascades(c.cascades, &frame), CSM_SUCCESS);
    const uint32_t calls = heap_hook_stop();
    if (i >= warm_up) {
      heap += calls;
      asked += c.record.allocations - before;
    }
    vulkan_engine_end(&engine);
    vulkan_engine_run(&engine, engine.frame);
    assert_int_equal(csm_retire(c.context, engine.frame), CSM_SUCCESS);
  }
  assert_int_equal(asked, 0);
  assert_int_equal(heap, 0);
  free(instances);
  case_close(&c);
  vulkan_engine_close(&engine);
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
