/* moments.c: what filters vsm to msm4 and vssm read: where moments lie, and the numbers that keep them sound. */
#include "plan/internal.h"

#include <math.h>

bool plan_has_moments(const csm_config *config) {
  return (config->filter >= CSM_FILTER_VSM && config->filter <= CSM_FILTER_MSM4) || config->filter == CSM_FILTER_VSSM;
}

static uint32_t channels_of(const csm_config *config) {
  switch (config->filter) {
  case CSM_FILTER_ESM:
    return 1;
  case CSM_FILTER_EVSM4:
  case CSM_FILTER_MSM4:
    return 4;
  default:
    return 2;
  }
}

/* A level's texels lie on the map's own, four to one, for as long as its side is even. */
static uint32_t levels_of(uint32_t side) {
  uint32_t levels = 1;
  while (side > 1 && side % 2 == 0) {
    side /= 2;
    ++levels;
  }
  return levels;
}

void plan_moments_make(plan_moments *out, const csm_config *config) {
  *out = (plan_moments){.channels = channels_of(config),
                        .depth_layers = config->filter == CSM_FILTER_VSM ? config->moment_layers : 1,
                        .levels = config->moment_levels};
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    out->sides[i] = plan_resolution(config, i) >> config->moment_halved;
    out->side = out->sides[i] > out->side ? out->sides[i] : out->side;
    const uint32_t most = levels_of(out->sides[i]);
    out->levels = out->levels < most ? out->levels : most;
  }
}

/* ---- what moments are off by ---- */

/* How a number of a format is rounded: by a share of it, and by no more than that if it is 1 at most. */
typedef struct rounding {
  double share, most;
} rounding;

#define UNIT 0x1p-24 /* of a float32, to the nearest, which all arithmetic is done in */

/* Direct3D stores a float16 rounded towards zero, and some drivers of Vulkan do: off by a whole last place, not by half. */
static rounding rounding_of(const csm_config *config) {
  const double share = config->moment_format == CSM_MOMENTS_FLOAT16 ? 0x1p-10 : UNIT;
  return (rounding){.share = share, .most = share / 2.0};
}

/*
 * How often a moment is stored. A blur has two passes, each of which is taken for one rounding: it adds what texels differ from
 * the middle one, so one of a large radius rounds more often only where they differ, and where they do, so much that the
 * variance is far above that. Of what a level averages, float32's errors to either side are half of what its four texels'
 * are, in the root of the mean square, so levels add no more than two of one rounding in all; float16's go all to one side,
 * and add up.
 */
static double stores(const csm_config *config) {
  const double blurs = config->moment_blur_texels > 0 ? 2.0 : 0.0, levels = config->moment_levels - 1.0;
  return 1.0 + (config->moment_format == CSM_MOMENTS_FLOAT16 ? blurs + levels : fmax(blurs, fmin(levels, 2.0)));
}

/* How often, at most, a float32 is rounded that sums samples and levels up, is mixed with another, and compared. */
static double sums(const csm_config *config) {
  const double samples = config->moment_sampling == CSM_SAMPLING_ANISOTROPIC ? config->moment_anisotropy : 0.0;
  return samples + (config->moment_levels > 1 ? 3.0 : 0.0) + 4.0;
}

/*
 * The largest exponents that a format holds, z being from -1 to 1: of a first moment alone exp(-c) to exp(c), of a second
 * one exp(-2 c) to exp(2 c). The largest float16 is 65504 = exp(11.09), but the least that has all its digits, and that no
 * device takes for 0, is exp(-9.704). Of float32 they are exp(88.7), of which four must be summed up, and exp(-87.3).
 */
static double exponent_most(const csm_config *config) {
  const bool squared = config->filter != CSM_FILTER_ESM, half = config->moment_format == CSM_MOMENTS_FLOAT16;
  return squared ? (half ? 4.85 : 42.0) : (half ? 9.7 : 87.0);
}

/*
 * Of moments of z itself. The variance is the mean square less the mean's square, so it may be off by what the one is,
 * and by twice what the other is. Of msm4 in float16 the moments are sums of what is stored: see csm_msm_unpack.
 *
 * The matrix of four moments that are each off by e is off by e times the norm of ((0 1 1) (1 1 1) (1 1 1)) at most,
 * which is 1 + sqrt(3). The distribution with moments 0, 0.4, 0, 0.4, at -1, 0 and 1, is the one whose matrix has the
 * greatest least eigenvalue, 1/5: a share of it of five times the error leaves a matrix of some distribution.
 */
static void plain_errors(plan_moment_errors *out, const csm_config *config) {
  const rounding r = rounding_of(config);
  const bool packed = config->filter == CSM_FILTER_MSM4 && config->moment_format == CSM_MOMENTS_FLOAT16;
  const double floats = sums(config) * UNIT / 2.0, stored = stores(config) * r.most;
  /* The first and third moment, and the second and fourth, for one that is stored from -0.5 to 0.5 */
  const double odd = packed ? (1.0 / 3.0 + sqrt(3.0)) / 2.0 : 1.0, even = packed ? 1.125 / 2.0 : 1.0;
  const double norm = packed ? 4.38 / 2.0 : 1.0 + sqrt(3.0);
  out->mean = odd * stored + floats;
  out->variance = (2.0 * odd + even) * stored + 3.0 * floats;
  out->bias = 5.0 * (norm * stored + (1.0 + sqrt(3.0)) * floats);
}

/*
 * Of exponentials all is off by a share, and an error of a share of exp(c z) is one of that share over c of z. Vulkan lets
 * exp(x) be off by 3 + 2 |x| units of its last place; a moment's and a receiver's may be so to either side. The variance's
 * error is a share of the mean square.
 */
static double warped_error(double exponent, double share) {
  return (share + 2.0 * (3.0 + 2.0 * exponent) * 2.0 * UNIT) / exponent;
}

static void warped_errors(plan_moment_errors *out, const csm_config *config) {
  const double share = stores(config) * rounding_of(config).share + sums(config) * UNIT;
  out->mean = warped_error(out->exponent, share);
  if (config->filter == CSM_FILTER_EVSM4)
    out->mean = fmax(out->mean, warped_error(out->negative, share));
  out->variance = 3.0 * share;
}

void plan_moment_errors_make(plan_moment_errors *out, const csm_config *config) {
  const double most = exponent_most(config);
  *out = (plan_moment_errors){.exponent = fmin(config->moment_exponent, most),
                              .negative = fmin(config->moment_exponent_negative, most)};
  if (!plan_has_moments(config))
    return;
  if (config->filter >= CSM_FILTER_ESM && config->filter <= CSM_FILTER_EVSM4)
    warped_errors(out, config);
  else
    plain_errors(out, config);
}

double plan_moment_spread(const csm_config *config) {
  const double radius = config->moment_blur_texels, texel = config->moment_halved ? 2.0 : 1.0;
  const double box = radius * (radius + 1.0) / 3.0, bilinear = 0.25, halved = config->moment_halved ? 0.25 : 0.0;
  return (box + bilinear) * texel * texel + halved;
}

void plan_blur_weights(double *weights, const csm_config *config) {
  const uint32_t radius = config->moment_blur_texels, count = 2 * radius + 1;
  const double deviation = radius / 2.0;
  double sum = 0.0;
  for (uint32_t i = 0; i < count; ++i) {
    const double away = radius ? ((double)i - radius) / deviation : 0.0;
    weights[i] = config->moment_blur == CSM_BLUR_GAUSSIAN ? exp(-0.5 * away * away) : 1.0;
    sum += weights[i];
  }
  for (uint32_t i = 0; i < count; ++i)
    weights[i] /= sum;
}
