/*
 * Moments: what their formats hold, that no arithmetic on them overflows, that what is lit is lit and what is dark is
 * dark, and how far each technique is wrong. Bounds are computed here from the formats, not by the plan.
 */
#include "moment_maps.h"

#include "plan/internal.h"

#include <math.h>

static moment_map *map;

static int make_map(void **state) {
  (void)state;
  static moment_map made;
  map = &made;
  return 0;
}

static bool is_half(const moment_case *c) {
  return c->format == CSM_MOMENTS_FLOAT16;
}

/* ---- formats ---- */

static void exponents_are_what_a_format_holds(void **state) {
  (void)state;
  static const double largest[] = {3.4028235e38, 65504.0};
  for (int i = 0; i < 10; ++i) {
    const moment_case *c = moment_case_at(i);
    csm_config config = moment_config(c);
    plan_moment_errors errors;
    plan_moment_errors_make(&errors, &config);
    const double power = c->filter == CSM_FILTER_ESM ? 1.0 : 2.0;
    /* Four may be summed up in float32 before they are averaged */
    assert_true(exp(power * errors.exponent) <= largest[c->format]);
    assert_true(4.0 * exp(power * errors.exponent) <= largest[0]);
    assert_true(exp(power * errors.negative) <= largest[c->format]);
    /* And the limit is no lower than it need be: a tenth more does not fit, or is not told from 0 with all its digits */
    const double least = is_half(c) ? 6.1e-5 : 1.18e-38;
    assert_true(exp(1.1 * power * errors.exponent) > largest[c->format] || exp(-1.1 * power * errors.exponent) < least);
    config.moment_exponent = config.moment_exponent_negative = 2.0;
    plan_moment_errors_make(&errors, &config);
    assert_true(errors.exponent == 2.0 && errors.negative == 2.0);
  }
}

/* ---- nothing overflows ---- */

static void all_is_finite_at_every_depth(void **state) {
  (void)state;
  for (int i = 0; i < moment_case_count; ++i) {
    const moment_case *c = moment_case_at(i);
    const csm_config config = moment_config(c);
    moment_map_plan(map, &config);
    for (int a = 0; a <= 16; ++a)
      for (int b = a; b <= 16; ++b)
        for (int s = 0; s <= 4; ++s) {
          static const double shares[] = {0.0, 1e-6, 0.25, 0.5, 0.999};
          moment_map_mix(map, (float)a / 16.0f, (float)b / 16.0f, shares[s]);
          for (int k = 0; k < 4; ++k)
            assert_true(isfinite(map->texels[k]));
          for (int t = -1; t <= 17; ++t) {
            const float lit = moment_map_visibility(map, t / 16.0);
            if (!(lit >= 0.0f && lit <= 1.0f))
              fail_msg("%s: %g at %d with %d and %d", moment_case_name(c), (double)lit, t, a, b);
          }
        }
  }
}

/* ---- lit and dark ---- */

/* The most that storing a number from -1 to 1 is off by, so many times, and arithmetic in floats besides. */
static double rounding_of(const moment_case *c) {
  const double once = is_half(c) ? 0x1p-12 : 0x1p-25;
  return (c->blur_texels || c->levels > 1 ? 3.0 : 1.0) * once + (c->levels > 1 ? 15.0 : 4.0) * 0x1p-25;
}

static double warped_error(double exponent, double share) {
  return (share + 8.0 * (3.0 + 2.0 * exponent) * 0x1p-25) / exponent;
}

/* By how much a mean of z is off, for techniques of z itself and of exponentials. */
static double error_of(const moment_case *c, const plan_moment_errors *errors) {
  const double once = rounding_of(c);
  if (c->filter == CSM_FILTER_VSM || c->filter == CSM_FILTER_MSM4)
    return 1.1 * once;
  const double rising = warped_error(errors->exponent, 2.0 * once);
  return c->filter == CSM_FILTER_EVSM4 ? fmax(rising, warped_error(errors->negative, 2.0 * once)) : rising;
}

/*
 * The least gap, as a share of the depth range, from which on a receiver below a flat caster is dark: 31.6 deviations for
 * Cantelli's inequality, ln(1000) / c for an exponential alone, and what depths are off by besides.
 */
static double least_gap(const moment_case *c, const csm_config *config) {
  plan_moment_errors errors;
  plan_moment_errors_make(&errors, config);
  const double error = error_of(c, &errors), deviation = hypot(2.0 * config->moment_deviation_range, error);
  if (c->filter == CSM_FILTER_ESM)
    return (log(1000.0) / errors.exponent + 2.0 * error) / 2.0;
  return (sqrt(999.0) * deviation + 2.0 * error) / 2.0;
}

static void what_is_flat_is_lit_at_every_depth(void **state) {
  (void)state;
  for (int i = 0; i < moment_case_count; ++i) {
    const moment_case *c = moment_case_at(i);
    const csm_config config = moment_config(c);
    moment_map_plan(map, &config);
    for (int d = 0; d <= 4000; ++d) {
      const float depth = (float)(d < 1000 ? d * 1e-6 : d > 3000 ? 1.0 - (4000 - d) * 1e-6 : (d - 1000) / 2000.0);
      moment_map_flat(map, depth);
      const float lit = moment_map_visibility(map, (double)depth);
      if (!(lit >= 0.999f))
        fail_msg("%s: %g at %g", moment_case_name(c), (double)lit, (double)depth);
    }
  }
}

static void what_is_covered_is_dark_from_the_least_gap_on(void **state) {
  (void)state;
  static const double deviations[] = {0.0, 1e-4, 3e-3};
  for (int i = 0; i < 3 * moment_case_count; ++i) {
    const moment_case *c = moment_case_at(i / 3);
    csm_config config = moment_config(c);
    config.moment_deviation_range = deviations[i % 3];
    moment_map_plan(map, &config);
    const double gap = least_gap(c, &config);
    for (int d = 0; d <= 200; ++d) {
      const float depth = (float)d / 200.0f;
      moment_map_flat(map, depth);
      for (double g = gap; (double)depth + g <= 1.0; g *= 1.1) {
        const float lit = moment_map_visibility(map, (double)depth + g);
        if (!(lit <= 0.001f))
          fail_msg("%s: %g at %g, a gap of %g", moment_case_name(c), (double)lit, (double)depth, g);
      }
    }
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(exponents_are_what_a_format_holds),
      cmocka_unit_test(all_is_finite_at_every_depth),
      cmocka_unit_test(what_is_flat_is_lit_at_every_depth),
      cmocka_unit_test(what_is_covered_is_dark_from_the_least_gap_on),
  };
  return cmocka_run_group_tests_name("plan-moments", tests, make_map, NULL);
}
