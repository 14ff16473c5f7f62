#include "steady.h"

#include "heap_hook.h"

#include <stdlib.h>

csm_instance *steady_boxes(const csm_mesh meshes[2]) {
  csm_instance *boxes = calloc(STEADY_BOXES, sizeof *boxes);
  assert_non_null(boxes);
  for (int i = 0; i < STEADY_BOXES; ++i)
    boxes[i] = support_instance(meshes[i % 2], i % 50 - 25, 0.3, i / 50 - 20, 0.2, 0.3 + 0.01 * (i % 7), 0.2);
  return boxes;
}

void steady_render(csm_cascades *cascades, csm_frame frame, const csm_instance *boxes, const record *record,
                   int number) {
  frame.instances = boxes;
  frame.instance_count = STEADY_BOXES;
  const uint64_t before = record->allocations;
  heap_hook_start();
  assert_int_equal(csm_render_cascades(cascades, &frame), CSM_SUCCESS);
  const uint32_t heap_calls = heap_hook_stop();
  if (number < STEADY_WARM_UP)
    return;
  assert_int_equal(record->allocations - before, 0);
  assert_int_equal(heap_calls, 0);
}

void steady_hook_sees_allocations(void **state) {
  (void)state;
  const csm_create_info info = {.struct_size = sizeof info, .version = CSM_VERSION, .backend = support_backend()};
  csm_context *context;
  heap_hook_start();
  assert_int_equal(csm_create(&info, &context), CSM_SUCCESS);
  assert_true(heap_hook_stop() > 4);
  csm_destroy(context);
}
