/* draws.c: an engine's own draws in the cascades' passes: what it is told is true, and what it draws is there. */
#include "stage.h"

#include <math.h>
#include <string.h>

enum { HILLS = 2, FIRST_HILL = SUPPORT_INSTANCES - HILLS };

static const picture_size size = {192, 128};

/* The scene, whose last instances are hills: they matter to every map. */
static void open_hills(stage *stage, rig *rig, const hill *hill, uint32_t flags) {
  stage_open_with(stage, rig, flags);
  const csm_mesh mesh = hill_mesh(stage->context, hill, 2);
  stage->scene.instances[FIRST_HILL] = support_instance(mesh, -4, 3, -3, 2, 1, 3);
  stage->scene.instances[FIRST_HILL + 1] = support_instance(mesh, 5, 9, -12, 4, 2, 2);
}

/* ---- the callback ---- */

typedef struct caster {
  stage *stage;
  rig_caster *hills;
  csm_draw_target target;
  csm_draw_info calls[CSM_MAX_CASCADES];
  uint32_t count, inside; /* calls; instances within the visible bounds */
} caster;

/* Object to clip, in doubles, as csm makes it of an instance. */
static void write_rows(const csm_draw_info *info, const csm_instance *instance, float out[RIG_ROWS]) {
  const double *m = info->world_to_clip, *t = instance->transform;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) {
      const double constant = column == 3 ? m[12 + row] : 0;
      out[row * 4 + column] =
          (float)(m[row] * t[column * 4] + m[4 + row] * t[column * 4 + 1] + m[8 + row] * t[column * 4 + 2] + constant);
    }
}

/* The hills, in a pipeline that is built before any frame: csm told what it will draw into. */
static caster open_caster(stage *stage, const hill *hill) {
  rig_caster_info info = {.positions = (const float(*)[3])hill->positions,
                          .indices = hill->indices,
                          .vertex_count = HILL_VERTICES,
                          .index_count = HILL_INDICES,
                          .target = {.struct_size = sizeof info.target}};
  assert_int_equal(csm_get_draw_target(stage->cascades, &info.target), CSM_SUCCESS);
  rig_check_target(stage->rig, &info.target, stage->config.map_format);
  assert_int_equal(info.target.reversed, stage->config.map_reversed);
  return (caster){.stage = stage, .hills = rig_caster_make(stage->rig, &info), .target = info.target};
}

static double plane_distance(const double plane[4], const double p[3]) {
  return plane[0] * p[0] + plane[1] * p[1] + plane[2] * p[2] + plane[3];
}

/* Whether an instance's centre lies within the planes of what may cast. */
static bool is_inside(const csm_draw_info *info, const csm_instance *instance) {
  for (int i = 0; i < 5; ++i)
    if (plane_distance(info->planes[i], &instance->transform[12]) < 0)
      return false;
  return true;
}

static void CSM_CALL draw_hills(void *user, const csm_draw_info *info) {
  caster *caster = user;
  const csm_instance *hills = &caster->stage->scene.instances[FIRST_HILL];
  float rows[HILLS][RIG_ROWS];
  assert_true(caster->count < CSM_MAX_CASCADES);
  caster->calls[caster->count++] = *info;
  for (int i = 0; i < HILLS; ++i) {
    write_rows(info, &hills[i], rows[i]);
    caster->inside += is_inside(info, &hills[i]);
  }
  rig_caster_draw(caster->hills, info, (const float(*)[RIG_ROWS])rows, HILLS);
}

/* Draws the first `count` instances by csm, and what the callback draws, if any; all are seen by the camera. */
static picture draw(stage *stage, uint32_t count, caster *caster) {
  rig_begin(stage->rig);
  shot shot = stage_shot(stage, 0);
  shot.frame.instance_count = count;
  shot.frame.draw = caster ? draw_hills : NULL;
  shot.frame.draw_user = caster;
  stage_render(stage, &shot);
  shot.frame.instance_count = SUPPORT_INSTANCES;
  stage_resolve(stage, &shot, size);
  picture_copy copy = stage_record(stage, size);
  stage_finish(stage);
  return picture_take(stage->rig, &copy);
}

/* ---- what the engine is told ---- */

/* The planes and the matrix speak of one volume, and the matrix is the one that csm_bind tells of. */
static void check_volume(const csm_draw_info *info, const csm_cascade_info *bound) {
  uint32_t inside = 0;
  for (int i = 0; i < 4000; ++i) {
    const double p[3] = {fmod(i * 17.03, 160) - 80, fmod(i * 5.77, 60) - 20, fmod(i * 29.9, 160) - 90};
    double clip[3], shadow[3];
    assert_true(fabs(support_apply(info->world_to_clip, p, clip) - 1) < 1e-9);
    support_apply(bound->world_to_shadow, p, shadow);
    assert_true(fabs(shadow[0] - (clip[0] + 1) / 2) < 1e-6);
    assert_true(fabs(shadow[1] - (1 - clip[1]) / 2) < 1e-6);
    assert_true(fabs(shadow[2] - clip[2]) < 1e-6);
    const double before_end = info->reversed ? clip[2] : 1 - clip[2];
    const double beyond[5] = {clip[0] + 1, 1 - clip[0], clip[1] + 1, 1 - clip[1], before_end};
    bool within = true, near_edge = false;
    for (int plane = 0; plane < 5; ++plane) {
      near_edge |= fabs(beyond[plane]) < 1e-6;
      within &= beyond[plane] >= 0;
    }
    if (near_edge)
      continue;
    for (int plane = 0; plane < 5; ++plane)
      assert_int_equal(plane_distance(info->planes[plane], p) >= 0, beyond[plane] >= 0);
    inside += within;
  }
  assert_true(inside > 4);
}

static void check_calls(const caster *caster, const void *commands) {
  const stage *stage = caster->stage;
  csm_binding binding = {.struct_size = sizeof binding};
  assert_int_equal(csm_bind(stage->cascades, &binding), CSM_SUCCESS);
  assert_int_equal(caster->count, stage->config.cascade_count);
  for (uint32_t i = 0; i < caster->count; ++i) {
    const csm_draw_info *info = &caster->calls[i];
    assert_int_equal(info->struct_size, sizeof *info);
    assert_int_equal(info->cascade, i);
    assert_int_equal(info->resolution, stage->config.resolution);
    assert_ptr_equal(info->command_buffer, commands);
    assert_int_equal(info->depth_format, caster->target.depth_format);
    assert_true(info->render_pass == caster->target.render_pass);
    assert_int_equal(info->dynamic_rendering, caster->target.dynamic_rendering);
    assert_int_equal(info->reversed, caster->target.reversed);
    rig_check_draw(stage->rig, info);
    check_volume(info, &binding.cascades[i]);
  }
  assert_in_range(caster->inside, 1, HILLS * stage->config.cascade_count);
}

/* ---- the tests ---- */

static uint32_t texels_apart(const picture *a, const picture *b) {
  uint32_t count = 0;
  for (uint32_t i = 0; i + 1 < a->count; ++i)
    for (uint32_t t = 0; t < a->layers[i].width * a->layers[i].height; ++t)
      count += a->layers[i].texels[t] != b->layers[i].texels[t];
  return count;
}

/* What kind of engine, and of maps. */
typedef struct kind {
  rig_kind rig;
  uint32_t map_format, map_reversed;
} kind;

static void configure(stage *stage, const kind *kind) {
  stage->config.map_format = kind->map_format;
  stage->config.map_reversed = kind->map_reversed;
  stage_configure(stage);
}

/* The hills are drawn by csm, by nobody, and by the engine, which draws the same maps bit for bit. */
static void draw_of_kind(const kind *kind) {
  stage own, stage;
  hill hill;
  hill_make(&hill);
  open_hills(&own, NULL, &hill, 0);
  configure(&own, kind);
  picture by_csm = stage_draw_at(&own, 0, size);
  stage_close(&own);
  rig *rig = rig_open(kind->rig);
  open_hills(&stage, rig, &hill, 0);
  configure(&stage, kind);
  caster caster = open_caster(&stage, &hill);
  picture by_nobody = draw(&stage, FIRST_HILL, NULL);
  assert_true(texels_apart(&by_csm, &by_nobody) > 200);
  picture by_engine = draw(&stage, FIRST_HILL, &caster);
  check_calls(&caster, rig_commands(rig));
  picture_expect_equal(&by_csm, &by_engine);
  picture_free(&by_nobody);
  picture_free(&by_csm);
  rig_caster_free(caster.hills);
  stage_close(&stage);
  rig_close(rig);
}

static void own_casters_are_drawn(void **state) {
  (void)state;
  static const kind kinds[] = {{RIG_TYPICAL, CSM_MAP_D32, 0},
                               {RIG_MODERN, CSM_MAP_D32, 0},
                               {RIG_TYPICAL, CSM_MAP_D16, 1},
                               {RIG_MODERN, CSM_MAP_D32, 1}};
  for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i)
    draw_of_kind(&kinds[i]);
}

/* No casters but the engine's: its passes are there without csm's. */
static void all_casters_may_be_the_engines(void **state) {
  (void)state;
  stage stage;
  hill hill;
  hill_make(&hill);
  rig *rig = rig_open(RIG_TYPICAL);
  open_hills(&stage, rig, &hill, 0);
  caster caster = open_caster(&stage, &hill);
  picture drawn = draw(&stage, 0, &caster);
  check_calls(&caster, rig_commands(rig));
  uint32_t texels = 0;
  for (uint32_t i = 0; i < stage.config.resolution * stage.config.resolution; ++i)
    texels += drawn.layers[2].texels[i] < 1;
  assert_true(texels > 50);
  picture_free(&drawn);
  rig_caster_free(caster.hills);
  stage_close(&stage);
  rig_close(rig);
}

/* No ray meets what a callback draws, beside so many instances: where the map calls it dark there is no light. */
static void leave_to_maps(uint32_t instance_count) {
  stage stage;
  hill hill;
  hill_make(&hill);
  rig *rig = rig_open(RIG_TYPICAL);
  open_hills(&stage, rig, &hill, CSM_CREATE_RAYS);
  caster caster = open_caster(&stage, &hill);
  stage.config.filter = CSM_FILTER_PCF_3X3;
  stage_configure(&stage);
  picture by_map = draw(&stage, instance_count, &caster);
  caster.count = 0;
  stage.config.filter = CSM_FILTER_EXACT;
  stage_configure(&stage);
  picture by_rays = draw(&stage, instance_count, &caster);
  const picture_layer *map = &by_map.layers[by_map.count - 1], *rays = &by_rays.layers[by_rays.count - 1];
  uint32_t dark = 0, between = 0;
  for (uint32_t i = 0; i < map->width * map->height; ++i) {
    dark += map->texels[i] < 0.25f;
    between += rays->texels[i] > 0.0f && rays->texels[i] < 1.0f;
    assert_false(map->texels[i] < 0.25f && rays->texels[i] > 0.75f);
  }
  assert_true(dark > 100 && between > 20);
  picture_free(&by_map);
  picture_free(&by_rays);
  rig_caster_free(caster.hills);
  stage_close(&stage);
  rig_close(rig);
}

static void no_ray_meets_the_engines_casters(void **state) {
  (void)state;
  leave_to_maps(FIRST_HILL);
  leave_to_maps(0);
}

/* Nobody knows what of it changed. */
static void pages_hold_nothing_that_a_callback_draws(void **state) {
  (void)state;
  stage stage;
  hill hill;
  hill_make(&hill);
  rig *rig = rig_open(RIG_TYPICAL);
  open_hills(&stage, rig, &hill, 0);
  caster caster = open_caster(&stage, &hill);
  stage.config.map_layout = CSM_LAYOUT_PAGES;
  stage.config.resolution = 256;
  assert_int_equal(csm_cascades_configure(stage.cascades, &stage.config), CSM_SUCCESS);
  rig_begin(rig);
  shot shot = stage_shot(&stage, 0);
  shot.frame.draw = draw_hills;
  shot.frame.draw_user = &caster;
  stage.record.quiet = true;
  const csm_result result = csm_render_cascades(stage.cascades, shot_frame(&shot));
  if (result != CSM_ERROR_UNSUPPORTED)
    fail_msg("%s: %s", csm_result_name(result), csm_last_error(stage.context));
  assert_non_null(strstr(csm_last_error(stage.context), "map_layout pages"));
  assert_int_equal(caster.count, 0);
  shot.frame.draw = NULL;
  stage_render(&stage, &shot);
  stage_finish(&stage);
  rig_caster_free(caster.hills);
  stage_close(&stage);
  rig_close(rig);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(own_casters_are_drawn),
      cmocka_unit_test(all_casters_may_be_the_engines),
      cmocka_unit_test(no_ray_meets_the_engines_casters),
      cmocka_unit_test(pages_hold_nothing_that_a_callback_draws),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
