/* rays_rules.c: what filter exact asks for by name, and that what fails with it leaves everything as it was. */
#include "rays_model.h"
#include "rows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PIXELS = RAYS_WIDTH * RAYS_HEIGHT };

static csm_config exact_config(uint32_t filter) {
  csm_config config = support_config();
  config.filter = filter;
  config.resolution = 128;
  config.soft_radius_max_texels = 8;
  return config;
}

/* ---- what is refused ---- */

static void trees_must_have_been_asked_for(void **state) {
  (void)state;
  rays_model m = {0};
  support_scene scene;
  m.context = support_open(&m.record);
  m.view = support_view(m.context);
  support_scene_make(&scene, m.context);
  csm_config config = exact_config(CSM_FILTER_PCF_3X3);
  csm_cascades *cascades = rays_cascades(&m, &config);
  assert_int_equal(csm_render_cascades(cascades, shot_frame(&scene.shot)), CSM_SUCCESS);
  assert_int_equal(shot_resolve(&scene.shot, m.view, cascades, RAYS_WIDTH, RAYS_HEIGHT), CSM_SUCCESS);
  float *before = support_image(m.context, m.view, CSM_READ_MASK, RAYS_WIDTH, RAYS_HEIGHT);
  m.record.quiet = true;
  for (uint32_t filter = CSM_FILTER_EXACT; filter <= CSM_FILTER_EXACT_SOFT; ++filter) {
    csm_cascades *none = cascades;
    config.filter = filter;
    assert_int_equal(csm_cascades_create(m.context, &config, &none), CSM_ERROR_INVALID_STATE);
    assert_null(none);
    assert_non_null(strstr(csm_last_error(m.context), "CSM_CREATE_RAYS"));
    assert_int_equal(csm_cascades_configure(cascades, &config), CSM_ERROR_INVALID_STATE);
    assert_non_null(strstr(csm_last_error(m.context), "CSM_CREATE_RAYS"));
  }
  /* Still drawn, and not to be drawn anew first */
  assert_int_equal(shot_resolve(&scene.shot, m.view, cascades, RAYS_WIDTH, RAYS_HEIGHT), CSM_SUCCESS);
  float *after = support_image(m.context, m.view, CSM_READ_MASK, RAYS_WIDTH, RAYS_HEIGHT);
  assert_memory_equal(before, after, PIXELS * sizeof *before);
  free(before);
  free(after);
  support_close(m.context, &m.record);
}

static const misuse refused[] = {
    {"a blend", FIELD(csm_config, blend_mode), {CSM_BLEND_LINEAR}, CSM_ERROR_INVALID_VALUE, "blend_mode"},
    {"a dithered blend", FIELD(csm_config, blend_mode), {CSM_BLEND_DITHERED}, CSM_ERROR_INVALID_VALUE, "blend_mode"},
    {"a bias by slope", FIELD(csm_config, bias_mode), {CSM_BIAS_SLOPE}, CSM_ERROR_INVALID_VALUE, "bias_mode"},
    {"no ray", FIELD(csm_config, ray_taps), {0}, CSM_ERROR_INVALID_VALUE, "ray_taps"},
    {"too many rays", FIELD(csm_config, ray_taps), {65}, CSM_ERROR_INVALID_VALUE, "ray_taps"},
    {"rays shared twice", FIELD(csm_config, ray_share), {2}, CSM_ERROR_INVALID_VALUE, "ray_share"},
    {"a cosine", FIELD(csm_config, ray_unsure_cosine), {.real = 1.5}, CSM_ERROR_INVALID_VALUE, "ray_unsure_cosine"},
    {"one below 0", FIELD(csm_config, ray_unsure_cosine), {.real = -0.1}, CSM_ERROR_INVALID_VALUE, "ray_unsure_cosine"},
    {"no number", FIELD(csm_config, ray_unsure_cosine), {.real = NAN}, CSM_ERROR_NOT_FINITE, "ray_unsure_cosine"},
    {"another cosine",
     FIELD(csm_config, ray_grazing_cosine),
     {.real = 2},
     CSM_ERROR_INVALID_VALUE,
     "ray_grazing_cosine"},
    {"no end", FIELD(csm_config, ray_grazing_cosine), {.real = INFINITY}, CSM_ERROR_NOT_FINITE, "ray_grazing_cosine"},
    {"the most rays", FIELD(csm_config, ray_taps), {64}, CSM_SUCCESS, NULL},
    {"one ray", FIELD(csm_config, ray_taps), {1}, CSM_SUCCESS, NULL},
    {"shared rays", FIELD(csm_config, ray_share), {1}, CSM_SUCCESS, NULL},
    {"every pixel", FIELD(csm_config, ray_grazing_cosine), {.real = 1}, CSM_SUCCESS, NULL},
};

static void misuse_is_named(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  m.record.quiet = true;
  for (uint32_t filter = CSM_FILTER_EXACT; filter <= CSM_FILTER_EXACT_SOFT; ++filter) {
    const csm_config good = exact_config(filter);
    const rays_picture picture = {.cascades = rays_cascades(&m, &good)};
    float *before = rays_mask(&m, &picture);
    for (size_t i = 0; i < sizeof refused / sizeof *refused; ++i) {
      csm_config config = good;
      csm_cascades *made;
      misuse_apply(&refused[i], &config);
      misuse_expect(&refused[i], csm_cascades_create(m.context, &config, &made), csm_last_error(m.context));
      assert_true((made != NULL) == !refused[i].expected);
      assert_int_equal(csm_cascades_destroy(made), CSM_SUCCESS);
      if (refused[i].expected)
        misuse_expect(&refused[i], csm_cascades_configure(picture.cascades, &config), csm_last_error(m.context));
    }
    float *after = rays_mask(&m, &picture);
    assert_memory_equal(before, after, PIXELS * sizeof *before);
    free(before);
    free(after);
  }
  rays_close(&m);
}

/* ---- what fails ---- */

/* A call that may fail; what it changed when it did not, the test does not look at. */
typedef csm_result (*attempt)(rays_model *m, csm_cascades *cascades);

static csm_result make_mesh(rays_model *m, csm_cascades *cascades) {
  const csm_mesh_info info = rays_mesh_info(m, SHAPE_LEAF);
  csm_mesh mesh;
  (void)cascades;
  return csm_mesh_create(m->context, &info, &mesh);
}

static csm_result make_alpha_mask(rays_model *m, csm_cascades *cascades) {
  const csm_alpha_mask_info info = {.struct_size = sizeof info, .width = 7, .height = 5, .texels = m->texels};
  csm_alpha_mask mask;
  (void)cascades;
  return csm_alpha_mask_create(m->context, &info, &mask);
}

static csm_result update_mesh(rays_model *m, csm_cascades *cascades) {
  rays_shape moved = m->shapes[SHAPE_CLOTH];
  rays_move_cloth(&moved, 1.3, 0.5);
  const csm_mesh_update_info info = {.struct_size = sizeof info, .positions = moved.positions};
  (void)cascades;
  return csm_mesh_update(m->context, moved.mesh, &info);
}

/* Another scene, and more than there is room for. */
static csm_result draw_a_list(rays_model *m, csm_cascades *cascades) {
  enum { COUNT = 200 };
  static csm_instance instances[COUNT];
  shot shot = m->shot;
  for (int i = 0; i < COUNT; ++i)
    instances[i] = support_instance(m->shapes[SHAPE_BOX].mesh, i % 20 - 10, 1, i / 20 - 9, 0.3, 1, 0.3);
  shot.frame.instances = instances;
  shot.frame.instance_count = COUNT;
  return csm_render_cascades(cascades, shot_frame(&shot));
}

static csm_result resolve_larger(rays_model *m, csm_cascades *cascades) {
  shot shot = m->shot;
  shot.frame.scene = m->scene;
  return shot_resolve(&shot, m->view, cascades, 2 * RAYS_WIDTH, RAYS_HEIGHT);
}

static csm_result make_soft(rays_model *m, csm_cascades *cascades) {
  const csm_config config = exact_config(CSM_FILTER_EXACT_SOFT);
  (void)m;
  return csm_cascades_configure(cascades, &config);
}

static csm_result switch_backend(rays_model *m, csm_cascades *cascades) {
  csm_create_info info = support_create_info(&m->record);
  info.flags = 0;
  info.backend = !strcmp(support_backend(), "vulkan") ? "d3d12" : rays_draw() ? "vulkan" : "null";
  (void)cascades;
  return csm_switch_backend(m->context, &info);
}

/* As often as there is an allocation to fail; what a failure leaves room for is tried again first. */
static void fail_each_allocation(attempt attempt, const char *what) {
  rays_model m = {0};
  rays_open(&m, CSM_CREATE_KEEP_GEOMETRY, NULL);
  const csm_config config = exact_config(CSM_FILTER_EXACT);
  const rays_picture picture = {.cascades = rays_cascades(&m, &config)};
  float *before = rays_mask(&m, &picture);
  free(rays_mask(&m, &picture));
  m.record.quiet = true;
  uint32_t failures = 0;
  for (int64_t left = 0;; ++failures) {
    const int64_t blocks = m.record.blocks;
    m.record.allocations_left = left;
    const csm_result result = attempt(&m, picture.cascades);
    m.record.allocations_left = -1;
    if (!result)
      break;
    if (result != CSM_ERROR_OUT_OF_MEMORY && result != CSM_ERROR_OUT_OF_DEVICE_MEMORY)
      fail_msg("%s, allocation %u: %s", what, (unsigned)left, csm_result_name(result));
    left += m.record.blocks <= blocks;
    float *after = rays_mask(&m, &picture);
    if (memcmp(before, after, PIXELS * sizeof *before) != 0)
      fail_msg("%s: allocation %u failed, and the mask is another", what, (unsigned)left);
    free(after);
  }
  assert_true(failures > 0);
  free(before);
  rays_close(&m);
}

static void what_fails_changes_nothing(void **state) {
  (void)state;
  fail_each_allocation(make_mesh, "csm_mesh_create");
  fail_each_allocation(make_alpha_mask, "csm_alpha_mask_create");
  fail_each_allocation(update_mesh, "csm_mesh_update");
  fail_each_allocation(draw_a_list, "csm_render_cascades");
  fail_each_allocation(resolve_larger, "csm_resolve_mask");
  fail_each_allocation(make_soft, "csm_cascades_configure");
  fail_each_allocation(switch_backend, "csm_switch_backend");
}

/* What goes makes room for what comes. */
static void trees_take_no_more_room_than_they_need(void **state) {
  (void)state;
  rays_model m = {0};
  rays_open(&m, 0, NULL);
  const csm_config config = exact_config(CSM_FILTER_EXACT);
  csm_stats stats = {.struct_size = sizeof stats};
  const rays_picture picture = {.cascades = rays_cascades(&m, &config)};
  free(rays_mask(&m, &picture));
  assert_int_equal(csm_get_stats(picture.cascades, &stats), CSM_SUCCESS);
  assert_true(stats.tree_bytes > 0);
  const uint64_t bytes = stats.tree_bytes;
  for (int i = 0; i < 20; ++i) {
    m.shapes[SHAPES] = m.shapes[SHAPE_CLOTH];
    rays_make_mesh(&m, SHAPES);
    free(rays_mask(&m, &picture));
    assert_int_equal(csm_mesh_destroy(m.context, m.shapes[SHAPES].mesh), CSM_SUCCESS);
    free(rays_mask(&m, &picture));
  }
  assert_int_equal(csm_get_stats(picture.cascades, &stats), CSM_SUCCESS);
  assert_true(stats.tree_bytes == bytes);
  m.shapes[SHAPES].mesh = 0;
  rays_close(&m);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(trees_must_have_been_asked_for),
      cmocka_unit_test(misuse_is_named),
      cmocka_unit_test(what_fails_changes_nothing),
      cmocka_unit_test(trees_take_no_more_room_than_they_need),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
