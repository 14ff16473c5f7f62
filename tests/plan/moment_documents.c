/*
 * What documents and samples get wrong about moments: each formula stands here as they have it, fails a property that
 * csm's own keeps.
 */
#include "moment_maps.h"
#include "maps.h"

#include "plan/internal.h"

#include <math.h>

static moment_map *map;
static test_maps *maps;

static int make_maps(void **state) {
  (void)state;
  static moment_map made;
  static test_maps cascades;
  map = &made;
  maps = &cascades;
  return 0;
}

static csm_config plain(uint32_t filter, uint32_t format) {
  return moment_config(&(moment_case){.filter = filter, .format = format, .levels = 1, .layers = 1});
}

/* ---- variance ---- */

/* With a least variance, of depths from 0 to 1: the survey's, and Microsoft's, which is added. */
static double survey_vsm(double mean, double square, double depth) {
  const double variance = fmax(square - mean * mean, 0.0001), d = depth - mean;
  return depth <= mean ? 1.0 : variance / (variance + d * d);
}

static double microsoft_vsm(double mean, double square, double depth) {
  double lit = 0.0;
  if (depth <= mean)
    lit = 1.0;
  const double variance = fmin(1.0, fmax(0.0, square - mean * mean + 0.00001)), d = depth - mean;
  lit = variance / (variance + d * d);
  return lit;
}

static void the_least_variances_leak(void **state) {
  (void)state;
  const csm_config config = plain(CSM_FILTER_VSM, CSM_MOMENTS_FLOAT32);
  moment_map_plan(map, &config);
  for (int i = 1; i < 99; ++i) {
    const double caster = i / 100.0, receiver = caster + 0.01;
    assert_near(survey_vsm(caster, caster * caster, receiver), 0.5, 1e-6);
    assert_near(microsoft_vsm(caster, caster * caster, receiver), 0.0909, 1e-4);
    moment_map_flat(map, (float)caster);
    assert_true(moment_map_visibility(map, receiver) <= 0.001f);
    /* A millimetre and a half under 500 m */
    assert_true(moment_map_visibility(map, caster + 3e-6) <= 0.001f);
  }
}

/* The estimate overrides what is before the mean. */
static void microsofts_estimate_darkens_what_is_lit(void **state) {
  (void)state;
  const csm_config config = plain(CSM_FILTER_VSM, CSM_MOMENTS_FLOAT32);
  moment_map_plan(map, &config);
  for (int i = 0; i < 50; ++i) {
    const double receiver = i / 100.0, behind = receiver + 0.1;
    assert_true(microsoft_vsm(behind, behind * behind, receiver) < 0.002);
    moment_map_flat(map, (float)behind);
    assert_true(moment_map_visibility(map, receiver) == 1.0f);
  }
}

/* Of depths from 0 to 1 in 16 bits, the variance of what is flat is off by more than the least one. */
static void sixteen_bits_leak_with_the_surveys_variance(void **state) {
  (void)state;
  const csm_config config = plain(CSM_FILTER_VSM, CSM_MOMENTS_FLOAT16);
  moment_map_plan(map, &config);
  double worst_variance = 0.0, documents = 0.0, own = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const double caster = 0.8 + i * 0.1 / 2000.0, receiver = caster + 0.05;
    const double mean = (double)moment_rounded(CSM_MOMENTS_FLOAT16, (float)caster);
    const double square = (double)moment_rounded(CSM_MOMENTS_FLOAT16, (float)(caster * caster));
    worst_variance = fmax(worst_variance, square - mean * mean);
    documents = fmax(documents, survey_vsm(mean, square, receiver));
    moment_map_flat(map, (float)caster);
    own = fmax(own, (double)moment_map_visibility(map, receiver));
  }
  assert_true(worst_variance > 2.3e-4);
  assert_true(documents > 0.1);
  assert_true(own <= 0.001);
}

/* ---- exponentials ---- */

/* The survey's: one exponent for both, of depths from 0 to 1, and nothing that bounds it. */
static void survey_evsm_store(float out[4], float depth, float c) {
  out[0] = expf(c * depth);
  out[1] = out[0] * out[0];
  out[2] = -expf(-c * depth);
  out[3] = out[2] * out[2];
}

static float survey_evsm_side(const float moments[2], float at) {
  const float variance = fmaxf(moments[1] - moments[0] * moments[0], 0.0001f), d = at - moments[0];
  return at <= moments[0] ? 1.0f : variance / (variance + d * d);
}

static void the_surveys_exponentials_overflow(void **state) {
  (void)state;
  float moments[4];
  survey_evsm_store(moments, 0.9f, 80.0f);
  assert_true(isinf(moments[1]) && moments[3] == 0.0f);
  /* A variance of infinity less infinity is none, and fmaxf takes the other: dark at once, or light that is no number */
  assert_true(isnan(moments[1] - moments[0] * moments[0]) || isinf(moments[0] * moments[0]));
  /* In 16 bits even 40 is too much for an exponential alone, and 5.6 for its square */
  assert_true(isinf(moment_rounded(CSM_MOMENTS_FLOAT16, expf(40.0f * 0.9f))));
  assert_true(isinf(moment_rounded(CSM_MOMENTS_FLOAT16, expf(2.0f * 5.6f))));
  /* The negative side leaves a caster's light on what it hides, for its variance is less than the least one */
  survey_evsm_store(moments, 0.5f, 40.0f);
  assert_true(survey_evsm_side(&moments[2], -expf(-40.0f * 0.6f)) > 0.99f);
  static const uint32_t filters[] = {CSM_FILTER_ESM, CSM_FILTER_EVSM2, CSM_FILTER_EVSM4};
  for (int i = 0; i < 6; ++i) {
    csm_config config = plain(filters[i % 3], (uint32_t)(i / 3));
    config.moment_exponent = config.moment_exponent_negative = 80.0;
    moment_map_plan(map, &config);
    for (int d = 0; d <= 100; ++d) {
      moment_map_flat(map, (float)d / 100.0f);
      for (int k = 0; k < 4; ++k)
        assert_true(isfinite(map->texels[k]));
      assert_true(moment_map_visibility(map, d / 100.0) >= 0.999f);
      /* ln(1000) / 9.7 of -1 to 1, in 16 bits */
      if (d <= 60)
        assert_true(moment_map_visibility(map, d / 100.0 + 0.4) <= 0.001f);
    }
  }
}

/* ---- bleeding ---- */

static double survey_bleeding(double lit) {
  const double t = fmin(fmax((lit - 0.2) / (1.0 - 0.2), 0.0), 1.0);
  return t * t * (3.0 - 2.0 * t);
}

static void the_surveys_smooth_step_brightens(void **state) {
  (void)state;
  for (uint32_t curve = CSM_BLEEDING_LINEAR; curve <= CSM_BLEEDING_SMOOTHSTEP; ++curve) {
    csm_config config = plain(CSM_FILTER_VSM, CSM_MOMENTS_FLOAT32);
    config.bleeding_reduction = 0.2;
    config.bleeding_curve = curve;
    moment_map_plan(map, &config);
    double last = 0.0;
    for (int i = 0; i <= 100; ++i) {
      const double lit = i / 100.0, less = (double)sampler_less_bleeding((float)lit);
      if (i > 60 && i < 100)
        assert_true(survey_bleeding(lit) > (lit - 0.2) / 0.8);
      if (i >= 74 && i < 100)
        assert_true(survey_bleeding(lit) > lit);
      if (curve == CSM_BLEEDING_SMOOTHSTEP)
        assert_near(less, survey_bleeding(lit), 1e-6); /* a textbook's, for comparison */
      else
        assert_true(less <= lit + 1e-6 && less >= last);
      last = less;
    }
    assert_near(last, 1.0, 1e-6);
  }
}

/* ---- four moments ---- */

/* Peters & Klein's algorithm 3 as it is published and copied, for moments from -1 to 1: a shadow's intensity. */
static float published_hamburger(const float moments[4], float depth, float bias) {
  float b[4], z[3] = {depth};
  for (int i = 0; i < 4; ++i)
    b[i] = fmaf(bias, (i % 2 ? 0.4f : 0.0f) - moments[i], moments[i]);
  const float l32d22 = fmaf(-b[0], b[1], b[2]), d22 = fmaf(-b[0], b[0], b[1]);
  const float d33d22 = fmaf(fmaf(-b[1], b[1], b[3]), d22, -l32d22 * l32d22), l32 = l32d22 / d22;
  float c[3] = {1.0f, z[0] - b[0], z[0] * z[0] - b[1]};
  c[2] -= l32 * c[1];
  c[1] /= d22;
  c[2] *= d22 / d33d22;
  c[1] -= l32 * c[2];
  c[0] -= c[1] * b[0] + c[2] * b[1];
  const float p = c[1] / c[2], q = c[0] / c[2], r = sqrtf(p * p * 0.25f - q);
  z[1] = -p * 0.5f - r;
  z[2] = -p * 0.5f + r;
  const float s[4] = {z[2] < z[0] ? z[1] : z[0], z[2] < z[0] ? z[0] : z[1], z[2] < z[0] ? 1.0f : 0.0f,
                      z[1] < z[0] ? 1.0f : 0.0f};
  const float quotient = (s[0] * z[2] - b[0] * (s[0] + z[2]) + b[1]) / ((z[2] - s[1]) * (z[0] - z[1]));
  return fminf(fmaxf(s[2] + s[3] * quotient, 0.0f), 1.0f);
}

static void the_published_quadratic_loses_a_root(void **state) {
  (void)state;
  const csm_config config = plain(CSM_FILTER_MSM4, CSM_MOMENTS_FLOAT32);
  moment_map_plan(map, &config);
  float documents = 0.0f, own = 0.0f;
  for (int i = 0; i < 2000; ++i) {
    const float z = -1.0f + (float)i * 1e-3f, moments[4] = {z, z * z, z * z * z, z * z * z * z};
    moment_map_flat(map, z * 0.5f + 0.5f);
    for (int k = 0; z + 0.2f + (float)k * 0.0009f <= 1.0f; ++k) {
      const float at = z + 0.2f + (float)k * 0.0009f;
      documents = fmaxf(documents, 1.0f - published_hamburger(moments, at, 3e-6f));
      if (k % 8 == 0)
        own = fmaxf(own, moment_map_visibility(map, 0.5 * (double)at + 0.5));
    }
  }
  assert_true(documents > 0.01f);
  assert_true(own <= 0.001f);
}

/* ---- gradients ---- */

/* The area that a pixel has in a map is the same in the world whichever cascade it looks up. */
static void microsofts_gradients_are_the_other_cascades(void **state) {
  (void)state;
  csm_config config = default_config();
  config.filter = CSM_FILTER_VSM;
  maps_make(maps, &config, (double[]){0.3, -1.0, 0.2});
  const float across[3] = {0.5f, 0.25f, 0.0f}, down[3] = {-0.1f, 0.7f, 0.0f};
  float first[2];
  sampler_in_texels(first, 0, across);
  for (int c = 0; c < 4; ++c) {
    const double texel = maps->frame.cascades[c].info.texel_size;
    float own[2][2];
    sampler_in_texels(own[0], c, across);
    sampler_in_texels(own[1], c, down);
    assert_near(hypot((double)own[0][0], (double)own[0][1]) * texel, hypot(0.5, 0.25), 1e-4);
    assert_near(hypot((double)own[1][0], (double)own[1][1]) * texel, hypot(0.1, 0.7), 1e-4);
    /* Reused, they are of another level of detail, by as much as the texels differ */
    if (c > 0)
      assert_true(log2(hypot((double)first[0], (double)first[1]) * texel / hypot(0.5, 0.25)) > 0.5);
  }
}

int main(void) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(the_least_variances_leak),
      cmocka_unit_test(microsofts_estimate_darkens_what_is_lit),
      cmocka_unit_test(sixteen_bits_leak_with_the_surveys_variance),
      cmocka_unit_test(the_surveys_exponentials_overflow),
      cmocka_unit_test(the_surveys_smooth_step_brightens),
      cmocka_unit_test(the_published_quadratic_loses_a_root),
      cmocka_unit_test(microsofts_gradients_are_the_other_cascades),
  };
  return cmocka_run_group_tests_name("plan-moment-documents", tests, make_maps, NULL);
}
