/* Where maps lie in their image. */
#include "support.h"

static void check_rects(const plan_layout *layout, const csm_config *config) {
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    const plan_rect *a = &layout->rects[i];
    assert_int_equal(a->side, config->resolutions[i] ? config->resolutions[i] : config->resolution);
    assert_int_equal(a->side, plan_resolution(config, i));
    assert_true(a->x + a->side <= layout->width && a->y + a->side <= layout->height && a->layer < layout->layers);
    for (uint32_t k = 0; k < i; ++k) {
      const plan_rect *b = &layout->rects[k];
      const bool apart = a->layer != b->layer || a->x + a->side <= b->x || b->x + b->side <= a->x ||
                         a->y + a->side <= b->y || b->y + b->side <= a->y;
      if (!apart)
        fail_msg("maps %u and %u overlap", i, k);
    }
  }
}

static csm_config sized_config(random_state *random, uint32_t layout) {
  csm_config config = default_config();
  config.cascade_count = 1 + random_below(random, CSM_MAX_CASCADES);
  config.map_layout = layout;
  config.resolution = 16 + random_below(random, 16384 - 15);
  for (uint32_t i = 0; i < CSM_MAX_CASCADES; ++i)
    config.resolutions[i] = random_below(random, 3) ? (random_below(random, 2) ? 64u << random_below(random, 8)
                                                                               : 16 + random_below(random, 16384 - 15))
                                                    : 0;
  return config;
}

static void maps_lie_apart_inside_their_image(void **state) {
  (void)state;
  random_state random = {1};
  for (int i = 0; i < 20000; ++i) {
    const csm_config config = sized_config(&random, (uint32_t)i % 2);
    plan_layout layout;
    plan_layout_make(&layout, &config);
    check_rects(&layout, &config);
  }
}

static void an_array_has_a_layer_for_each(void **state) {
  (void)state;
  random_state random = {2};
  for (int i = 0; i < 5000; ++i) {
    const csm_config config = sized_config(&random, CSM_LAYOUT_ARRAY);
    plan_layout layout;
    uint32_t largest = 0;
    plan_layout_make(&layout, &config);
    assert_int_equal(layout.layers, config.cascade_count);
    for (uint32_t k = 0; k < config.cascade_count; ++k) {
      assert_int_equal(layout.rects[k].layer, k);
      assert_int_equal(layout.rects[k].x + layout.rects[k].y, 0);
      largest = plan_resolution(&config, k) > largest ? plan_resolution(&config, k) : largest;
    }
    assert_int_equal(layout.width, largest);
    assert_int_equal(layout.height, largest);
  }
}

static void equal_maps_fill_an_atlas(void **state) {
  (void)state;
  static const uint32_t across[] = {0, 1, 2, 3, 2, 5, 3, 7, 4}, down[] = {0, 1, 1, 1, 2, 1, 2, 1, 2};
  for (uint32_t count = 1; count <= CSM_MAX_CASCADES; ++count) {
    csm_config config = default_config();
    config.cascade_count = count;
    config.map_layout = CSM_LAYOUT_ATLAS;
    plan_layout layout;
    plan_layout_make(&layout, &config);
    assert_int_equal(layout.layers, 1);
    const uint64_t area = (uint64_t)layout.width * layout.height;
    assert_int_equal(area, (uint64_t)count * 2048 * 2048);
    const uint32_t longer = layout.width > layout.height ? layout.width : layout.height;
    const uint32_t expected = across[count] > down[count] ? across[count] : down[count];
    assert_int_equal(longer, expected * 2048);
  }
}

/* No more than all in one row would. */
static void an_atlas_wastes_no_more_than_a_row(void **state) {
  (void)state;
  random_state random = {3};
  for (int i = 0; i < 5000; ++i) {
    const csm_config config = sized_config(&random, CSM_LAYOUT_ATLAS);
    plan_layout layout;
    uint64_t largest = 0;
    plan_layout_make(&layout, &config);
    for (uint32_t k = 0; k < config.cascade_count; ++k)
      largest = plan_resolution(&config, k) > largest ? plan_resolution(&config, k) : largest;
    assert_true((uint64_t)layout.width * layout.height <= largest * largest * config.cascade_count);
    assert_int_equal(layout.width % largest, 0);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(maps_lie_apart_inside_their_image),
      cmocka_unit_test(an_array_has_a_layer_for_each),
      cmocka_unit_test(equal_maps_fill_an_atlas),
      cmocka_unit_test(an_atlas_wastes_no_more_than_a_row),
  };
  return cmocka_run_group_tests_name("plan-layout", tests, NULL, NULL);
}
