/* allocations.c: each allocation of host memory fails in turn: a named error, and nothing is kept. */
#include "support.h"

#include <string.h>

enum { SIDE = 16 };

/* What one frame needs, in the order in which it is made. */
typedef struct frame_parts {
  csm_context *context;
  csm_mesh mesh;
  csm_scene *scene;
  csm_cascades *cascades;
  csm_view *view;
} frame_parts;

static csm_result make_parts(const csm_create_info *info, frame_parts *out) {
  static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  static const uint16_t indices[3] = {0, 1, 2};
  const csm_mesh_info triangle = {.struct_size = sizeof triangle,
                                  .positions = positions,
                                  .vertex_count = 3,
                                  .indices = indices,
                                  .index_count = 3,
                                  .index_size = 2};
  csm_config config = support_config();
  config.resolution = SIDE;
  config.filter = CSM_FILTER_EXACT;
  csm_result result = csm_create(info, &out->context);
  if (!result)
    result = csm_mesh_create(out->context, &triangle, &out->mesh);
  if (!result)
    result = csm_scene_create(out->context, &out->scene);
  if (!result)
    result = csm_cascades_create(out->context, &config, &out->cascades);
  if (!result)
    result = csm_view_create(out->context, &out->view);
  return result;
}

/* Frames of pages, over which one instance moves; stops at the first error. */
static csm_result move_over_pages(const frame_parts *parts, shot *shot, const csm_instance *instance,
                                  csm_instance_id id) {
  csm_config config = support_config();
  csm_stats stats = {.struct_size = sizeof stats};
  double moved[16];
  memcpy(moved, instance->transform, sizeof moved);
  config.resolution = 64;
  config.map_layout = CSM_LAYOUT_PAGES;
  csm_result result = csm_cascades_configure(parts->cascades, &config);
  for (int i = 0; i < 4 && !result; ++i) {
    moved[12] += 0.1;
    const csm_scene_batch one = {.struct_size = sizeof one, .count = 1, .ids = &id, .matrices = moved};
    result = csm_scene_move(parts->scene, &one);
    if (!result)
      result = csm_render_cascades(parts->cascades, shot_frame(shot));
  }
  if (!result)
    result = csm_get_stats(parts->cascades, &stats);
  if (!result)
    assert_true(stats.pages_copied > 0);
  return result;
}

/* Frames with everything in them; stops at the first error. */
static csm_result run_all(record *record) {
  frame_parts parts = {0};
  support_scene scene;
  csm_instance_id ids[SUPPORT_INSTANCES];
  float data[SIDE * SIDE];
  csm_create_info info = support_create_info(record);
  info.flags = CSM_CREATE_RAYS;
  csm_result result = make_parts(&info, &parts);
  support_scene_make(&scene, NULL);
  for (int i = 0; i < SUPPORT_INSTANCES; ++i)
    scene.instances[i].mesh = parts.mesh;
  const csm_scene_batch batch = {
      .struct_size = sizeof batch, .count = SUPPORT_INSTANCES, .ids = ids, .instances = scene.instances};
  if (!result)
    result = csm_scene_add(parts.scene, &batch);
  scene.shot.frame.scene = parts.scene;
  scene.shot.frame.instances = NULL;
  scene.shot.frame.instance_count = 0;
  if (!result)
    result = csm_render_cascades(parts.cascades, shot_frame(&scene.shot));
  if (!result)
    result = shot_resolve(&scene.shot, parts.view, parts.cascades, SIDE, SIDE);
  const csm_read_info read = {
      .struct_size = sizeof read, .source = CSM_READ_MASK, .view = parts.view, .data = data, .size = sizeof data};
  if (!result)
    result = csm_read(parts.context, &read);
  if (!result)
    result = move_over_pages(&parts, &scene.shot, &scene.instances[1], ids[1]);
  csm_destroy(parts.context);
  return result;
}

static void allocations_may_fail(void **state) {
  (void)state;
  record record = {0};
  support_create_info(&record);
  record.quiet = true;
  csm_result result;
  int64_t failures = 0;
  do {
    record.allocations_left = failures;
    result = run_all(&record);
    if (result && result != CSM_ERROR_OUT_OF_MEMORY && result != CSM_ERROR_OUT_OF_DEVICE_MEMORY)
      fail_msg("allocation %d: %s", (int)failures, csm_result_name(result));
    assert_int_equal(record.blocks, 0);
    ++failures;
  } while (result);
  assert_true(failures > 10);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {cmocka_unit_test(allocations_may_fail)};
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
