/*
 * cameras.c: cameras and lights of every kind: depth that runs either way, planes behind the eye, a near plane past the
 * shadows, a far origin, and vertices far from their mesh's own.
 */
#include "outcome.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = OUTCOME_WIDTH, HEIGHT = OUTCOME_HEIGHT, PIXELS = WIDTH * HEIGHT };

typedef struct fixture {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  csm_mesh box;
} fixture;

static void setup(fixture *f, const csm_config *config) {
  memset(f, 0, sizeof *f);
  f->context = support_open(&f->record);
  f->view = support_view(f->context);
  f->box = support_box(f->context, 2);
  assert_int_equal(csm_cascades_create(f->context, config, &f->cascades), CSM_SUCCESS);
}

static void teardown(fixture *f) {
  support_close(f->context, &f->record);
}

/* How many pixels are darker than half. */
static uint32_t dark(const outcome *outcome) {
  uint32_t count = 0;
  for (int i = 0; i < PIXELS; ++i)
    count += outcome->mask[i] < 0.5f;
  return count;
}

/* ---- orthographic cameras ---- */

/* An orthographic camera 20 m above a tower of 4 m on a ground, looking straight down on 32 by 18 m. */
static shot look_down(const csm_instance *instances, double near, double far, bool reversed) {
  static const double view[16] = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, -20, 1};
  double a = 1 / (far - near), b = -near / (far - near);
  if (reversed) {
    a = -a;
    b = 1 - b;
  }
  shot shot = shot_make(instances, 2);
  memcpy(shot.camera.view, view, sizeof view);
  const double projection[16] = {2.0 / 32, 0, 0, 0, 0, 2.0 / 18, 0, 0, 0, 0, -a, 0, 0, 0, b, 1};
  memcpy(shot.camera.projection, projection, sizeof projection);
  memcpy(shot.light.direction, (const double[]){0.5, -1, 0.2}, sizeof shot.light.direction);
  return shot;
}

/*
 * The tower's shadow, seen past its roof: swept along the light it is the hull of its foot and of its roof, which the
 * light moves by (2, 0.8) m. Its area is that of the foot and of what two of its sides sweep: 4 + 2 * 2 + 2 * 0.8 m²,
 * of which the camera does not see the 4 m² under the roof. The roof itself is lit.
 */
static uint32_t shadow_pixels(void) {
  return (uint32_t)lrint((2 * 2.0 + 2 * 0.8) / (32.0 * 18.0) * PIXELS);
}

static void planes_may_lie_behind_the_eye(void **state) {
  (void)state;
  static const double planes[][2] = {{0.1, 60}, {-50, 51}, {-50, 50}, {-50, 40}, {-500, 400}};
  fixture f;
  csm_config config = support_config();
  config.resolution = 1024;
  setup(&f, &config);
  const csm_instance instances[2] = {support_instance(f.box, 0, -1, 0, 40, 1, 40),
                                     support_instance(f.box, 0, 2, 0, 1, 2, 1)};
  const bool draws = strcmp(support_backend(), "null");
  for (size_t i = 0; i < sizeof planes / sizeof planes[0]; ++i)
    for (int reversed = 0; reversed < 2; ++reversed) {
      shot shot = look_down(instances, planes[i][0], planes[i][1], reversed);
      shot.camera.reversed = reversed ? CSM_REVERSED_YES : CSM_REVERSED_NO;
      outcome drawn = outcome_draw(f.context, f.cascades, f.view, &shot);
      const uint32_t count = dark(&drawn), right = shadow_pixels();
      if (draws && (count + 12 < right || count > right + 12))
        fail_msg("near %g, far %g, reversed %d: %u pixels are dark, not %u", planes[i][0], planes[i][1], reversed,
                 count, right);
      outcome_free(&drawn);
    }
  teardown(&f);
}

/* A matrix whose near plane lies behind the eye does not say which end is near: whoever says nothing is told. */
static void what_a_matrix_leaves_open_must_be_said(void **state) {
  (void)state;
  static const struct {
    double near, far;
    bool open;
  } cases[] = {{0.1, 60, false}, {0, 60, false}, {-50, 50, true}, {-50, 40, true}, {-500, 400, true}};
  fixture f;
  const csm_config config = support_config();
  setup(&f, &config);
  const csm_instance instances[2] = {support_instance(f.box, 0, -1, 0, 40, 1, 40),
                                     support_instance(f.box, 0, 2, 0, 1, 2, 1)};
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i)
    for (int reversed = 0; reversed < 2; ++reversed) {
      shot shot = look_down(instances, cases[i].near, cases[i].far, reversed);
      f.record.quiet = cases[i].open;
      const csm_result result = csm_render_cascades(f.cascades, shot_frame(&shot));
      assert_int_equal(result, cases[i].open ? CSM_ERROR_INVALID_CAMERA : CSM_SUCCESS);
      if (cases[i].open)
        assert_non_null(strstr(csm_last_error(f.context), "reversed"));
      shot.camera.reversed = reversed ? CSM_REVERSED_YES : CSM_REVERSED_NO;
      assert_int_equal(csm_render_cascades(f.cascades, shot_frame(&shot)), CSM_SUCCESS);
    }
  teardown(&f);
}

/* A perspective says by its matrix which way depth runs: to say the same changes nothing, to say otherwise is told. */
static void a_perspective_knows_which_way_depth_runs(void **state) {
  (void)state;
  fixture f;
  support_scene scene;
  const csm_config config = support_config();
  setup(&f, &config);
  support_scene_make(&scene, f.context);
  for (int reversed = 0; reversed < 2; ++reversed) {
    shot shot = scene.shot;
    if (!reversed) {
      shot.camera.projection[10] = -1;
      shot.camera.projection[14] = -0.25;
    }
    shot.camera.reversed = CSM_REVERSED_BY_MATRIX;
    outcome silent = outcome_draw(f.context, f.cascades, f.view, &shot);
    shot.camera.reversed = reversed ? CSM_REVERSED_YES : CSM_REVERSED_NO;
    outcome said = outcome_draw(f.context, f.cascades, f.view, &shot);
    assert_true(silent.plan_hash == said.plan_hash);
    shot.camera.reversed = reversed ? CSM_REVERSED_NO : CSM_REVERSED_YES;
    f.record.quiet = true;
    assert_int_equal(csm_render_cascades(f.cascades, shot_frame(&shot)), CSM_ERROR_INVALID_CAMERA);
    assert_non_null(strstr(csm_last_error(f.context), "reversed"));
    outcome_expect_same(&silent, &said, "said");
    outcome_free(&silent);
  }
  teardown(&f);
}

/* ---- depth of csm's own ---- */

/* A perspective with its planes at n and f, which may be INFINITY. */
static void set_planes(double projection[16], double n, double f, bool reversed) {
  const double toward = isinf(f) ? 0 : n / (f - n); /* reversed z over w: -toward + (1 + toward) n / depth */
  projection[10] = reversed ? toward : -1 - toward;
  projection[14] = reversed ? n + n * toward : -n - n * toward;
}

/*
 * A near plane at 1 mm: by the frame's projection, not reversed, floats tell 10 m from 10.006 m, but not from 10.005 m,
 * and every plane is black. What csm draws itself knows better, and gives the same mask as with any other projection.
 */
static void its_own_depth_is_good_for_every_projection(void **state) {
  (void)state;
  static const double fars[] = {INFINITY, 1e4, 100};
  fixture f;
  support_scene scene;
  const csm_config config = support_config();
  setup(&f, &config);
  support_scene_make(&scene, f.context);
  set_planes(scene.shot.camera.projection, 1e-3, INFINITY, true);
  outcome right = outcome_draw(f.context, f.cascades, f.view, &scene.shot);
  float *meters = support_image(f.context, f.view, CSM_READ_VIEW_DEPTH, WIDTH, HEIGHT);
  for (int i = 0; i < 3 * 2; ++i) {
    const double far = fars[i / 2], n = 1e-3;
    const bool reversed = i % 2;
    shot shot = scene.shot;
    set_planes(shot.camera.projection, n, far, reversed);
    outcome drawn = outcome_draw(f.context, f.cascades, f.view, &shot);
    float *depth = support_image(f.context, f.view, CSM_READ_VIEW_DEPTH, WIDTH, HEIGHT);
    uint32_t differ = 0;
    for (int p = 0; p < PIXELS; ++p) {
      /* The pre-pass rounds the far plane's share of each depth otherwise; silhouettes stay where they are */
      differ += drawn.mask[p] != right.mask[p];
      assert_true(isinf(depth[p]) == isinf(meters[p]));
      if (isinf(depth[p])) {
        assert_true(drawn.depth[p] == (reversed ? 0.0f : 1.0f));
        continue;
      }
      assert_true(fabs(depth[p] - meters[p]) <= 1e-5 * meters[p]);
      const double from_far = isinf(far) ? n / depth[p] : n * (far - depth[p]) / (depth[p] * (far - n));
      assert_true(fabs(drawn.depth[p] - (reversed ? from_far : 1 - from_far)) <= 0x1p-24 + 2e-6 * from_far);
    }
    if (differ > PIXELS / 1000)
      fail_msg("far %g, reversed %d: %u pixels differ", far, reversed, differ);
    free(depth);
    outcome_free(&drawn);
  }
  free(meters);
  outcome_free(&right);
  teardown(&f);
}

/* An orthographic camera's planes may lie 2000 km apart, of which a float's 2^-24 is 12 cm: the mask is the same as that
   of planes that lie close. */
static void its_own_depth_is_good_between_far_planes(void **state) {
  (void)state;
  fixture f;
  csm_config config = support_config();
  config.shadow_distance = 60;
  setup(&f, &config);
  const csm_instance instances[2] = {support_instance(f.box, 0, -1, 0, 40, 1, 40),
                                     support_instance(f.box, 0, 2, 0, 1, 2, 1)};
  shot near = look_down(instances, -50, 51, true), far = look_down(instances, -1e6, 1e6, false);
  near.camera.reversed = CSM_REVERSED_YES;
  far.camera.reversed = CSM_REVERSED_NO;
  assert_int_equal(csm_render_cascades(f.cascades, shot_frame(&near)), CSM_SUCCESS);
  assert_int_equal(shot_resolve(&near, f.view, f.cascades, WIDTH, HEIGHT), CSM_SUCCESS);
  float *masks[2], *depths[2];
  masks[0] = support_image(f.context, f.view, CSM_READ_MASK, WIDTH, HEIGHT);
  depths[0] = support_image(f.context, f.view, CSM_READ_VIEW_DEPTH, WIDTH, HEIGHT);
  assert_int_equal(shot_resolve(&far, f.view, f.cascades, WIDTH, HEIGHT), CSM_SUCCESS);
  masks[1] = support_image(f.context, f.view, CSM_READ_MASK, WIDTH, HEIGHT);
  depths[1] = support_image(f.context, f.view, CSM_READ_VIEW_DEPTH, WIDTH, HEIGHT);
  for (int p = 0; p < PIXELS; ++p) {
    assert_true(masks[0][p] == masks[1][p]);
    assert_true(fabs(depths[0][p] - (fabs(depths[0][p] - 16) < 1 ? 16 : 20)) < 1e-4);
    assert_true(fabs(depths[0][p] - depths[1][p]) < 1e-4);
  }
  for (int i = 0; i < 2; ++i) {
    free(masks[i]);
    free(depths[i]);
  }
  teardown(&f);
}

/* ---- a near plane past the shadows ---- */

static void past_the_shadows_all_is_lit(void **state) {
  (void)state;
  fixture f;
  support_scene scene;
  csm_config config = support_config();
  config.shadow_distance = 20;
  setup(&f, &config);
  support_scene_make(&scene, f.context);
  const bool draws = strcmp(support_backend(), "null");
  outcome before = outcome_draw(f.context, f.cascades, f.view, &scene.shot);
  assert_true(!draws || dark(&before) > 100);
  static const double nears[] = {20, 20.5, 1000};
  for (size_t i = 0; i < sizeof nears / sizeof nears[0]; ++i) {
    shot shot = scene.shot;
    support_perspective(shot.camera.projection, 55, 1.5, nears[i], 0);
    outcome far = outcome_draw(f.context, f.cascades, f.view, &shot);
    csm_stats stats = {.struct_size = sizeof stats};
    assert_int_equal(csm_get_stats(f.cascades, &stats), CSM_SUCCESS);
    for (uint32_t k = 0; k < stats.cascade_count; ++k)
      assert_int_equal(stats.cascades[k].casters_drawn, 0);
    for (int p = 0; draws && p < PIXELS; ++p)
      assert_true(far.mask[p] == 1);
    outcome_free(&far);
  }
  outcome after = outcome_draw(f.context, f.cascades, f.view, &scene.shot);
  outcome_expect_same(&before, &after, "near again");
  outcome_free(&before);
  teardown(&f);
}

/* ---- where constants are relative to ---- */

/* The origin is the camera's, or where the engine says; the picture is the same within a few pixels. */
static void expect_any_origin(const csm_config *config) {
  static const double origins[][3] = {{-4, 6, 12}, {0, 0, 0}, {100, -20, 50}};
  fixture f;
  support_scene scene;
  setup(&f, config);
  support_scene_make(&scene, f.context);
  csm_binding binding = {.struct_size = sizeof binding};
  outcome by_camera = outcome_draw(f.context, f.cascades, f.view, &scene.shot);
  assert_int_equal(csm_bind(f.cascades, &binding), CSM_SUCCESS);
  for (int axis = 0; axis < 3; ++axis)
    assert_true(fabs(binding.origin[axis] - origins[0][axis]) < 1e-9);
  for (size_t i = 0; i < sizeof origins / sizeof origins[0]; ++i) {
    shot shot = scene.shot;
    double origin[3];
    memcpy(origin, origins[i], sizeof origin);
    shot.frame.origin = origin;
    outcome drawn = outcome_draw(f.context, f.cascades, f.view, &shot);
    assert_int_equal(csm_bind(f.cascades, &binding), CSM_SUCCESS);
    assert_memory_equal(binding.origin, origins[i], sizeof binding.origin);
    assert_true(outcome_same_maps(&by_camera, &drawn));
    uint32_t differ = 0;
    for (int p = 0; p < PIXELS; ++p)
      differ += fabsf(drawn.mask[p] - by_camera.mask[p]) > 1.0f / 255 + 1e-6f;
    assert_true(differ < PIXELS / 500);
    outcome_free(&drawn);
  }
  outcome_free(&by_camera);
  teardown(&f);
}

/* View depths do not depend on it: neither where cascades begin, nor where shadows fade. */
static void an_origin_may_be_given(void **state) {
  (void)state;
  csm_config config = support_config();
  expect_any_origin(&config);
  config.selection = CSM_SELECT_INTERVAL;
  config.out_of_range = CSM_OUT_OF_RANGE_FADED;
  config.fade_share = 0.5;
  config.shadow_distance = 16.0;
  expect_any_origin(&config);
}

/* A scene that lies a million metres away, with its camera: the same picture. */
static void far_from_the_worlds_origin_all_is_the_same(void **state) {
  (void)state;
  static const double away[3] = {1048576, 4096, -2097152}; /* whole texels of every map's grid: powers of two */
  fixture f;
  support_scene scene;
  csm_config config = support_config();
  config.snap_mode = CSM_SNAP_OFF;
  setup(&f, &config);
  support_scene_make(&scene, f.context);
  outcome near = outcome_draw(f.context, f.cascades, f.view, &scene.shot);
  for (int i = 0; i < SUPPORT_INSTANCES; ++i)
    for (int axis = 0; axis < 3; ++axis)
      scene.instances[i].transform[12 + axis] += away[axis];
  double *view = scene.shot.camera.view;
  for (int row = 0; row < 3; ++row)
    for (int axis = 0; axis < 3; ++axis)
      view[12 + row] -= view[axis * 4 + row] * away[axis];
  outcome far = outcome_draw(f.context, f.cascades, f.view, &scene.shot);
  uint32_t differ = 0;
  for (int p = 0; p < PIXELS; ++p)
    differ += fabsf(near.mask[p] - far.mask[p]) > 0.1f;
  assert_true(differ < PIXELS / 200);
  outcome_free(&near);
  outcome_free(&far);
  teardown(&f);
}

/* ---- vertices far from their mesh's own origin ---- */

static csm_mesh make_quad(csm_context *context, float half, float y, float x) {
  const float positions[4][3] = {{x - half, y, -half}, {x + half, y, -half}, {x + half, y, half}, {x - half, y, half}};
  static const uint16_t indices[6] = {0, 2, 1, 0, 3, 2};
  const csm_mesh_info info = {.struct_size = sizeof info,
                              .positions = positions,
                              .vertex_count = 4,
                              .indices = indices,
                              .index_count = 6,
                              .index_size = 2};
  csm_mesh mesh;
  assert_int_equal(csm_mesh_create(context, &info, &mesh), CSM_SUCCESS);
  return mesh;
}

/* Every number is exact in a float, and the instance's translation brings the mesh back: the frame is the same. */
static void vertices_may_lie_far_from_their_origin(void **state) {
  (void)state;
  static const float away[] = {0, 1e3f, 1e4f, 1e5f, 1.5e5f, 2e5f, 2.5e5f, 3e5f, 4e5f, 5e5f, 6e5f, 8e5f};
  fixture f;
  csm_config config = support_config();
  config.shadow_distance = 40;
  setup(&f, &config);
  outcome right = {0};
  for (size_t i = 0; i < sizeof away / sizeof away[0]; ++i) {
    const csm_instance instances[2] = {
        support_instance(make_quad(f.context, 10, 0, away[i]), -(double)away[i], 0, 0, 1, 1, 1),
        support_instance(make_quad(f.context, 2, 2, away[i]), -(double)away[i], 0, 0, 1, 1, 1)};
    shot shot = shot_make(instances, 2);
    support_look_at(shot.camera.view, (const double[]){0, 6, 10}, (const double[]){0, 1, 0});
    support_perspective(shot.camera.projection, 50, 1.5, 0.1, 0);
    memcpy(shot.light.direction, (const double[]){0.3, -1, -0.4}, sizeof shot.light.direction);
    outcome drawn = outcome_draw(f.context, f.cascades, f.view, &shot);
    if (i == 0) {
      right = drawn;
      assert_true(!strcmp(support_backend(), "null") || dark(&right) > 100);
    } else {
      outcome_expect_same(&right, &drawn, "vertices far away");
    }
  }
  outcome_free(&right);
  teardown(&f);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(planes_may_lie_behind_the_eye),
      cmocka_unit_test(what_a_matrix_leaves_open_must_be_said),
      cmocka_unit_test(a_perspective_knows_which_way_depth_runs),
      cmocka_unit_test(its_own_depth_is_good_for_every_projection),
      cmocka_unit_test(its_own_depth_is_good_between_far_planes),
      cmocka_unit_test(past_the_shadows_all_is_lit),
      cmocka_unit_test(an_origin_may_be_given),
      cmocka_unit_test(far_from_the_worlds_origin_all_is_the_same),
      cmocka_unit_test(vertices_may_lie_far_from_their_origin),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
