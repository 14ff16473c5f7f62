/* memory.c: device memory from an engine's own allocator: all that csm makes lies there, and all of it goes back. */
#include "stage.h"

static const picture_size size = {192, 128};

/* What lies in the engine's memory is drawn as what lies in csm's own. */
static void the_engines_memory_holds_everything(void **state) {
  (void)state;
  stage own, stage;
  stage_open(&own, NULL);
  picture expected = stage_draw_at(&own, 0, size);
  stage_close(&own);
  picture_expect_casters(&expected, expected.count - 1);
  rig *rig = rig_open(RIG_MODERN);
  stage_open(&stage, rig);
  picture drawn = stage_draw_at(&stage, 0, size);
  picture_expect_equal(&expected, &drawn);
  picture_free(&expected);
  const uint32_t pieces = rig_lent_memory(rig)->pieces;
  assert_true(pieces > 4);
  assert_int_equal(csm_cascades_destroy(stage.cascades), CSM_SUCCESS);
  stage_retire(&stage);
  assert_true(rig_lent_memory(rig)->pieces < pieces);
  stage_close(&stage);
  assert_int_equal(rig_lent_memory(rig)->pieces, 0);
  rig_close(rig);
}

/* Staging of a mesh that no recording has seen goes with the mesh; its place waits for the next recording. */
static void staging_goes_with_what_waits_in_it(void **state) {
  (void)state;
  stage stage;
  hill hill;
  rig *rig = rig_open(RIG_MODERN);
  stage_open(&stage, rig);
  hill_make(&hill);
  picture drawn = stage_draw_at(&stage, 0, size);
  picture_free(&drawn);
  for (int i = 0; i < 40; ++i) { /* until what the first meshes lay in is given back */
    drawn = stage_draw_at(&stage, 0, size);
    picture_free(&drawn);
  }
  const uint32_t pieces = rig_lent_memory(rig)->pieces;
  const csm_mesh mesh = hill_mesh(stage.context, &hill, 2);
  assert_int_equal(rig_lent_memory(rig)->pieces, pieces + 1); /* the page has room */
  assert_int_equal(csm_mesh_destroy(stage.context, mesh), CSM_SUCCESS);
  assert_int_equal(rig_lent_memory(rig)->pieces, pieces);
  stage_close(&stage);
  rig_close(rig);
}

/* Each request is refused in turn, from the context's making to the first mask: told by name, and tried again. */
static void a_refusal_is_out_of_device_memory(void **state) {
  (void)state;
  rig *rig = rig_open(RIG_MODERN);
  rig_lent *lent = rig_lent_memory(rig);
  uint32_t refusals = 0;
  hill hill;
  hill_make(&hill);
  for (bool through = false; !through; ++refusals) {
    record record = {0};
    csm_context *context = NULL;
    csm_cascades *cascades = NULL;
    csm_view *view = NULL;
    support_scene scene;
    csm_mesh mesh = 0;
    const csm_mesh_info hills = hill_info(&hill, 2);
    const csm_config config = support_config();
    const csm_create_info info = stage_create_info(rig, &record);
    record.quiet = true;
    lent->refuse_at = lent->requests + 1 + refusals;
    rig_begin(rig);
    csm_result result = csm_create(&info, &context);
    if (!result)
      result = csm_mesh_create(context, &hills, &mesh);
    if (!result)
      result = csm_cascades_create(context, &config, &cascades);
    if (!result)
      result = csm_view_create(context, &view);
    support_scene_make(&scene, NULL);
    for (int i = 0; i < SUPPORT_INSTANCES; ++i)
      scene.instances[i].mesh = mesh;
    shot shot = scene.shot;
    shot.frame.frame = rig_frame(rig);
    shot.frame.command_buffer = rig_commands(rig);
    if (!result)
      result = csm_render_cascades(cascades, shot_frame(&shot));
    if (!result)
      result = shot_resolve(&shot, view, cascades, size.width, size.height);
    rig_end(rig);
    rig_run(rig, rig_frame(rig));
    csm_destroy(context);
    through = !result;
    assert_int_equal(result, through ? CSM_SUCCESS : CSM_ERROR_OUT_OF_DEVICE_MEMORY);
    assert_int_equal(lent->pieces, 0);
    assert_int_equal(record.blocks, 0);
  }
  assert_true(refusals > 4);
  rig_close(rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_engines_memory_holds_everything),
      cmocka_unit_test(staging_goes_with_what_waits_in_it),
      cmocka_unit_test(a_refusal_is_out_of_device_memory),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
