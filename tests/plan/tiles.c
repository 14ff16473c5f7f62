/* tiles.c: which tiles of a cascade's moments a camera looks at, and when a cascade is as it was. */
#include "support.h"

#include <math.h>
#include <string.h>

enum { MOST = 64 * 64, CAMERAS = 200, POINTS = 200 };

static csm_config view_config(random_state *random) {
  csm_config config = default_config();
  config.filter = CSM_FILTER_EVSM4;
  config.moment_blur_texels = random_below(random, 9);
  config.caster_set = CSM_CASTER_SET_VIEW;
  config.resolution = 256 + random_below(random, 1024);
  return config;
}

/* A point that the camera sees lies in a tile that is seen, in every cascade whose map holds it. */
static void what_is_seen_is_among_them(void **state) {
  (void)state;
  random_state random = {1};
  static uint8_t tiles[MOST];
  uint32_t left_out = 0;
  for (int i = 0; i < CAMERAS; ++i) {
    const csm_config config = view_config(&random);
    const test_camera camera = random_camera(&random, 100);
    double light[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    for (uint32_t cascade = 0; cascade < frame.cascade_count && !frame.unshadowed; ++cascade) {
      const uint32_t side = config.resolution, across = plan_tiles_across(side);
      plan_seen_tiles(tiles, &frame, &config, cascade, side);
      for (uint32_t k = 0; k < across * across; ++k)
        left_out += !tiles[k];
      for (int k = 0; k < POINTS; ++k) {
        double point[3], at[3];
        slice_point(&random, &camera, &frame.cascades[random_below(&random, frame.cascade_count)].info, point);
        transform_point(frame.cascades[cascade].info.world_to_shadow, point, at);
        if (!(at[0] >= 0 && at[0] < 1 && at[1] >= 0 && at[1] < 1))
          continue;
        const uint32_t x = (uint32_t)(at[0] * side) / PLAN_TILE, y = (uint32_t)(at[1] * side) / PLAN_TILE;
        assert_int_equal(tiles[y * across + x], 1);
      }
    }
  }
  assert_true(left_out > 1000);
}

/* And so does what a lookup in the coarsest level reads around it: one and a half of that level's texels to each side, where
   half of the room to the map's border holds them. */
static void what_levels_read_is_among_them(void **state) {
  (void)state;
  random_state random = {3};
  static uint8_t tiles[MOST];
  uint32_t read = 0, left_out = 0;
  for (int i = 0; i < 20 * CAMERAS; ++i) {
    csm_config config = view_config(&random);
    config.resolution = 1024;
    config.cascade_count = 1 + random_below(&random, 2);
    config.moment_blur_texels = 0;
    config.moment_levels = 2 + random_below(&random, 6);
    config.moment_sampling = CSM_SAMPLING_TRILINEAR;
    test_camera camera = random_camera(&random, 10);
    double light[3], point[3], at[3];
    random_unit(&random, light);
    const plan_frame frame = plan_empty(&config, &camera, light);
    const uint32_t cascade = random_below(&random, frame.cascade_count);
    const double side = config.resolution, reach = 1.5 * ldexp(1.0, (int)config.moment_levels - 1) - 0.5;
    if (frame.unshadowed)
      continue;
    plan_seen_tiles(tiles, &frame, &config, cascade, config.resolution);
    slice_point(&random, &camera, &frame.cascades[cascade].info, point);
    transform_point(frame.cascades[cascade].info.world_to_shadow, point, at);
    if (fmax(fabs(at[0] - 0.5), fabs(at[1] - 0.5)) * side > side / 2.0 - 2.0 * reach)
      continue;
    const uint32_t across = plan_tiles_across(config.resolution);
    for (int corner = 0; corner < 4; ++corner) {
      const double x = at[0] * side + (corner & 1 ? reach : -reach), y = at[1] * side + (corner & 2 ? reach : -reach);
      assert_int_equal(tiles[(uint32_t)y / PLAN_TILE * across + (uint32_t)x / PLAN_TILE], 1);
      ++read;
    }
    for (uint32_t k = 0; k < across * across; ++k)
      left_out += !tiles[k];
  }
  assert_true(read > 1000 && left_out > 1000);
}

/* For views that see all, nothing is left out. */
static void maps_are_whole(void **state) {
  (void)state;
  random_state random = {2};
  static uint8_t tiles[MOST];
  csm_config config = view_config(&random);
  config.caster_set = CSM_CASTER_SET_MAP;
  const test_camera camera = plain_camera();
  const plan_frame frame = plan_empty(&config, &camera, (const double[3]){1, -2, 0.5});
  plan_seen_tiles(tiles, &frame, &config, 0, config.resolution);
  for (uint32_t k = 0; k < plan_tiles_across(config.resolution) * plan_tiles_across(config.resolution); ++k)
    assert_int_equal(tiles[k], 1);
}

static void a_blur_has_the_sum_1(void **state) {
  (void)state;
  csm_config config = default_config();
  for (uint32_t radius = 0; radius <= 32; ++radius)
    for (uint32_t kind = CSM_BLUR_BOX; kind <= CSM_BLUR_GAUSSIAN; ++kind) {
      double weights[65], sum = 0.0;
      config.moment_blur = kind;
      config.moment_blur_texels = radius;
      plan_blur_weights(weights, &config);
      for (uint32_t i = 0; i <= 2 * radius; ++i) {
        sum += weights[i];
        assert_true(weights[i] > 0.0 && weights[i] == weights[2 * radius - i]);
        const double share = radius ? ((double)i - radius) / (radius / 2.0) : 0.0;
        const double expected = kind == CSM_BLUR_GAUSSIAN ? exp(-0.5 * share * share) : 1.0;
        assert_true(fabs(weights[i] / weights[radius] - expected) < 1e-12);
      }
      assert_true(fabs(sum - 1.0) < 1e-12);
    }
}

/* A light that turns, and another camera, make another map. */
static void another_place_is_another_map(void **state) {
  (void)state;
  const csm_config config = default_config();
  const plan_scene scene = {0};
  test_camera camera = plain_camera();
  const plan_frame first = plan_empty(&config, &camera, (const double[3]){1, -2, 0.5});
  const plan_frame again = plan_empty(&config, &camera, (const double[3]){1, -2, 0.5});
  const plan_frame turned = plan_empty(&config, &camera, (const double[3]){1, -2, 0.501});
  camera.eye[0] += 40;
  const plan_frame moved = plan_empty(&config, &camera, (const double[3]){1, -2, 0.5});
  plan_frame without = first;
  without.unshadowed = true;
  for (uint32_t i = 0; i < config.cascade_count; ++i) {
    assert_true(plan_cascade_same(&first, &again, i, &scene, 0));
    assert_false(plan_cascade_same(&first, &turned, i, &scene, 0));
    assert_false(plan_cascade_same(&first, &moved, i, &scene, 0));
    assert_false(plan_cascade_same(&without, &again, i, &scene, 0));
    assert_false(plan_cascade_same(&first, &without, i, &scene, 0));
  }
}

/* Other parts of the same casters: another map, and shadows that rest. */
static void other_parts_are_another_map(void **state) {
  (void)state;
  const csm_config config = default_config();
  const test_camera camera = plain_camera();
  const uint64_t revisions[1] = {0};
  const plan_instance instance = {.transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  const plan_bounds bounds = {.extent = {1.0, 1.0, 1.0}};
  const plan_scene scene = {
      .instances = &instance, .revisions = revisions, .slot_count = 1, .meshes = &bounds, .mesh_count = 1};
  plan_frame before = plan_empty(&config, &camera, (const double[3]){1, -2, 0.5}), now = before;
  uint32_t slots[1] = {0};
  plan_draw one[2] = {{.count = 1, .index_count = 6}, {.count = 1, .first_index = 12, .index_count = 3}};
  plan_draw other[2] = {{.count = 1, .index_count = 6}, {.count = 1, .first_index = 12, .index_count = 3}};
  before.windows[0].list = (plan_list){.instances = slots, .draws = one, .instance_count = 1, .draw_count = 2};
  now.windows[0].list = (plan_list){.instances = slots, .draws = other, .instance_count = 1, .draw_count = 2};
  assert_true(plan_cascade_same(&before, &now, 0, &scene, 0));
  other[1].first_index = 9;
  assert_false(plan_cascade_same(&before, &now, 0, &scene, 0));
  assert_true(plan_cascade_same(&before, &now, 1, &scene, 0));
  assert_true(plan_frame_rests(&before, &now, &scene, 0));
  now.windows[0].list.draw_count = 1;
  assert_false(plan_cascade_same(&before, &now, 0, &scene, 0));
  assert_true(plan_hash(&before, &config, &scene) != plan_hash(&now, &config, &scene));
}

/* A frame of a still camera, whose maps are jittered. */
static plan_frame jittered(const csm_config *config, uint32_t number, double diameter) {
  const plan_scene scene = {0};
  const test_camera camera = plain_camera();
  double view[16], projection[16];
  unsigned char bytes[4096];
  plan_memory memory = {.at = bytes};
  plan_frame frame;
  const char *error = "";
  camera_matrices(&camera, view, projection);
  assert_true(plan_memory_size(0, 0, config->cascade_count) <= sizeof bytes);
  const plan_frame_info info = {.config = config,
                                .view = view,
                                .projection = projection,
                                .reversed = camera_reversed(&camera),
                                .light = (const double[3]){1, -2, 0.5},
                                .light_diameter = diameter,
                                .scene = &scene,
                                .jitter = number};
  assert_int_equal(plan_traced(&frame, &info, &memory, &error), CSM_SUCCESS);
  return frame;
}

/* Maps begin elsewhere within a texel, by what the frame says of it, and all shadows rest. */
static void jitter_moves_maps_and_nothing_else(void **state) {
  (void)state;
  const plan_scene scene = {0};
  csm_config config = default_config();
  const plan_frame plain = jittered(&config, 1, 0.01);
  assert_true(memcmp(&plain.cascades, &(plan_frame){0}.cascades, sizeof plain.cascades) != 0);
  config.history = CSM_HISTORY_ON;
  config.history_jitter = 1;
  const plan_frame first = jittered(&config, 1, 0.01), second = jittered(&config, 2, 0.01);
  const plan_frame wider = jittered(&config, 2, 0.02);
  assert_true(plan_frame_rests(&first, &second, &scene, 0));
  assert_false(plan_frame_rests(&first, &wider, &scene, 0));
  for (uint32_t i = 0; i < config.cascade_count; ++i) {
    const plan_cascade *a = &first.cascades[i], *b = &second.cascades[i];
    assert_false(plan_cascade_same(&first, &second, i, &scene, 0));
    for (int axis = 0; axis < 2; ++axis) {
      /* A point's place in texels from the map's middle, by the matrices that maps are drawn with */
      const double to_texels = 0.5 * a->resolution;
      const double moved = to_texels * (a->to_clip[axis * 4 + 3] - b->to_clip[axis * 4 + 3]);
      assert_near(moved, b->jitter_texels[axis] - a->jitter_texels[axis], 1e-6);
      assert_true(plain.cascades[i].jitter_texels[axis] == 0.0 && moved != 0.0);
    }
  }
  config.history = CSM_HISTORY_OFF; /* without which nothing is jittered */
  const plan_frame off = jittered(&config, 2, 0.01);
  for (uint32_t i = 0; i < config.cascade_count; ++i)
    assert_memory_equal(off.cascades[i].to_clip, plain.cascades[i].to_clip, sizeof plain.cascades[i].to_clip);
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(what_is_seen_is_among_them),
      cmocka_unit_test(what_levels_read_is_among_them),
      cmocka_unit_test(maps_are_whole),
      cmocka_unit_test(a_blur_has_the_sum_1),
      cmocka_unit_test(another_place_is_another_map),
      cmocka_unit_test(other_parts_are_another_map),
      cmocka_unit_test(jitter_moves_maps_and_nothing_else),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
