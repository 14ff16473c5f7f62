/* Soft shadows: the penumbra below a straight edge, against the share of a disc that an edge hides. */
#include "support.h"

#include "csm_constants.h"
#include "plan/internal.h"
#include "sampler.h"

#include <math.h>

enum { side = 512, rows = 24 };

/* A receiver that faces the light, and above half of it, up to the map's middle, a caster. */
typedef struct knife_edge {
  csm_constants constants;
  float depths[side * side];
  double texel; /* metres */
} knife_edge;

static csm_config soft_config(uint32_t filter) {
  csm_config config = default_config();
  config.cascade_count = 1;
  config.resolution = side;
  config.shadow_distance = 20.0;
  config.depth_mode = CSM_DEPTH_SLICE;
  config.caster_distance = 200.0;
  config.filter = filter;
  config.soft_search_taps = 64;
  config.soft_taps = 64;
  config.soft_radius_max_texels = 64.0;
  return config;
}

static void edge_make(knife_edge *edge, const csm_config *config, double diameter, double depth, double height) {
  const test_camera camera = plain_camera();
  const char *error = "";
  if (plan_config_check(config, &error))
    fail_msg("%s", error);
  plan_frame frame = plan_empty(config, &camera, (double[]){0.3, -1.0, 0.2});
  frame.light_diameter = diameter;
  (void)plan_write_constants((float *)&edge->constants, &frame, config);
  const double caster = depth - height * fabs(edge->constants.cascades.scales[0][2]);
  assert_true(caster > 0.0);
  for (int k = 0; k < side * side; ++k)
    edge->depths[k] = k % side < side / 2 ? (float)caster : 1.0f;
  edge->texel = 2.0 / (side * (double)edge->constants.cascades.scales[0][0]);
  sampler_bind((const float *)&edge->constants, edge->depths, side, side, 1);
}

/* Visibility so many texels to the lit side of the edge, the mean of many rows: each has a pattern of its own. */
static double lit_at(const knife_edge *edge, double depth, double texels) {
  const csm_cascades_block *c = &edge->constants.cascades;
  double sum = 0.0;
  for (int row = 0; row < rows; ++row) {
    const double at[3] = {2.0 * texels / side, 2.0 * (1.37 * row - 16.0) / side, depth};
    float position[3] = {0.0f, 0.0f, 0.0f}, normal[3];
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 3; ++k)
        position[k] += (float)((at[axis] - c->offsets[0][axis]) / c->scales[0][axis] * c->basis[axis][k]);
    for (int k = 0; k < 3; ++k)
      normal[k] = -c->basis[2][k];
    sum += sampler_visibility(position, normal, 1.0f);
  }
  return sum / rows;
}

/* How many texels beyond the edge so much of the light is seen: there is one such place. */
static double place_of(const knife_edge *edge, double depth, double lit) {
  double low = -90.0, high = 90.0;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    *(lit_at(edge, depth, middle) < lit ? &low : &high) = middle;
  }
  return 0.5 * (low + high);
}

/* From a tenth to nine tenths of the light, in metres. */
static double drawn_width(const knife_edge *edge, double depth) {
  return (place_of(edge, depth, 0.9) - place_of(edge, depth, 0.1)) * edge->texel;
}

/* Where an edge leaves a tenth of a disc of radius 1: asin(x) + x sqrt(1 - x x) is -0.4 pi there. */
static double true_width(double diameter, double height) {
  double low = -1.0, high = 0.0;
  for (int i = 0; i < 60; ++i) {
    const double x = 0.5 * (low + high);
    *(0.5 + (asin(x) + x * sqrt(1.0 - x * x)) / M_PI < 0.1 ? &low : &high) = x;
  }
  return -2.0 * low * height * tan(0.5 * diameter);
}

static const double diameters[] = {0.53 * M_PI / 180.0, 5.0 * M_PI / 180.0};
static const double heights[] = {0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0};

static void a_penumbra_is_as_wide_as_the_light_and_the_distance_say(void **state) {
  (void)state;
  static knife_edge edge;
  const uint32_t filters[] = {CSM_FILTER_PCSS, CSM_FILTER_BACKPROJECTION};
  for (int f = 0; f < 2; ++f)
    for (int d = 0; d < 2; ++d)
      for (int h = 0; h < 7; ++h)
        for (double depth = 0.6; depth < 1.0; depth += 0.3) {
          const csm_config config = soft_config(filters[f]);
          edge_make(&edge, &config, diameters[d], depth, heights[h]);
          const double width = true_width(diameters[d], heights[h]), drawn = drawn_width(&edge, depth);
          if (!(fabs(drawn - width) <= fmax(0.05 * width, edge.texel)))
            fail_msg("filter %u, %g degrees, %g m above, depth %g: %g m wide, not %g; a texel is %g m", filters[f],
                     diameters[d] * 180.0 / M_PI, heights[h], depth, drawn, width, edge.texel);
          assert_near(place_of(&edge, depth, 0.5) * edge.texel, 0.0, fmax(0.05 * width, edge.texel));
        }
}

/* It divides by the blocker's depth: one gap has another penumbra wherever it lies. */
static void a_textbooks_penumbra_depends_on_where_the_map_begins(void **state) {
  (void)state;
  static knife_edge edge;
  csm_config config = soft_config(CSM_FILTER_PCSS);
  config.soft_penumbra = CSM_PENUMBRA_RATIO;
  const double height = 20.0, width = true_width(diameters[1], height);
  double drawn[2];
  for (int i = 0; i < 2; ++i) {
    const double depth = i ? 0.9 : 0.5;
    edge_make(&edge, &config, diameters[1], depth, height);
    const double fallen = height * fabs(edge.constants.cascades.scales[0][2]);
    /* What makes it right at the first of both depths */
    config.soft_light_range =
        i ? config.soft_light_range : height * tan(0.5 * diameters[1]) / edge.texel / side * (depth - fallen) / fallen;
    edge_make(&edge, &config, diameters[1], depth, height);
    drawn[i] = drawn_width(&edge, depth);
  }
  assert_near(drawn[0], width, 0.08 * width);
  assert_true(drawn[1] < 0.6 * width);
}

/* Far from every caster all is lit, and below one all is dark, whatever the pattern. */
static void beyond_the_penumbra_nothing_is_mixed(void **state) {
  (void)state;
  static knife_edge edge;
  const uint32_t filters[] = {CSM_FILTER_PCSS, CSM_FILTER_BACKPROJECTION};
  for (int f = 0; f < 2; ++f)
    for (int d = 0; d < 2; ++d)
      for (int h = 0; h < 7; ++h) {
        csm_config config = soft_config(filters[f]);
        config.soft_search_taps = config.soft_taps = 16;
        edge_make(&edge, &config, diameters[d], 0.9, heights[h]);
        const double beyond = 1.1 * heights[h] * tan(0.5 * diameters[d]) / edge.texel + 4.0;
        assert_near(lit_at(&edge, 0.9, beyond), 1.0, 1e-6);
        assert_near(lit_at(&edge, 0.9, -beyond), 0.0, 1e-6);
      }
}

/* Without a size the light's shadow is the least kernel's. */
static void a_light_without_a_size_has_the_least_kernel(void **state) {
  (void)state;
  static knife_edge edge;
  const csm_config config = soft_config(CSM_FILTER_PCSS);
  edge_make(&edge, &config, 0.0, 0.9, 30.0);
  assert_near(lit_at(&edge, 0.9, 2.5), 1.0, 1e-6);
  assert_near(lit_at(&edge, 0.9, -2.5), 0.0, 1e-6);
}

static void soft_filters_are_told_from_the_others(void **state) {
  (void)state;
  for (uint32_t filter = 0; filter <= CSM_FILTER_BACKPROJECTION; ++filter) {
    csm_config config = default_config();
    config.filter = filter;
    assert_int_equal(plan_is_soft(&config), filter >= CSM_FILTER_PCSS);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(a_penumbra_is_as_wide_as_the_light_and_the_distance_say),
      cmocka_unit_test(a_textbooks_penumbra_depends_on_where_the_map_begins),
      cmocka_unit_test(beyond_the_penumbra_nothing_is_mixed),
      cmocka_unit_test(a_light_without_a_size_has_the_least_kernel),
      cmocka_unit_test(soft_filters_are_told_from_the_others),
  };
  return cmocka_run_group_tests_name("plan-soft", tests, NULL, NULL);
}
