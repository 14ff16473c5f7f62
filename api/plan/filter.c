/* filter.c: the shape of a filter: how far it reaches, and how much its taps weigh. */
#include "plan/internal.h"

#include <math.h>

uint32_t plan_filter_taps(const csm_config *config) {
  switch (config->filter) {
  case CSM_FILTER_PCF_3X3:
  case CSM_FILTER_EXACT: /* the same texels */
    return 3;
  case CSM_FILTER_PCF_5X5:
    return 5;
  case CSM_FILTER_PCF_7X7:
    return 7;
  case CSM_FILTER_PCF_N:
  case CSM_FILTER_VOGEL:
    return config->filter_taps;
  case CSM_FILTER_POISSON:
    return 16;
  case CSM_FILTER_GRID_17:
    return 17;
  default:
    return 1;
  }
}

/*
 * n x n bilinear taps one texel apart read texels whose centres lie less than (n + 1) / 2 away along each axis; a tap
 * of a disc less than the radius and one. Of single texels it is half a texel more than the taps' own distance. A
 * bilinear depth lies on the plane that its texels lie on, so there it is as for one texel.
 */
double plan_filter_reach_texels(const csm_config *config) {
  switch (config->filter) {
  case CSM_FILTER_NEAREST:
  case CSM_FILTER_LINEAR_DEPTH:
    return 0.5;
  case CSM_FILTER_GRID_17:
    return 1.5;
  case CSM_FILTER_VSM:
  case CSM_FILTER_ESM:
  case CSM_FILTER_EVSM2:
  case CSM_FILTER_EVSM4:
  case CSM_FILTER_MSM4:
    return (config->moment_blur_texels + 1.0) * (config->moment_halved ? 2.0 : 1.0);
  case CSM_FILTER_PCSS:
  case CSM_FILTER_VSSM:
  case CSM_FILTER_BACKPROJECTION:
  case CSM_FILTER_EXACT_SOFT:
    return config->soft_radius_max_texels + 1.0;
  case CSM_FILTER_POISSON:
  case CSM_FILTER_VOGEL:
    return config->filter_radius_texels + 1.0;
  default:
    return (plan_filter_taps(config) + 1) / 2;
  }
}

/*
 * What lies away from the light in a filter, of a plane that falls off along an axis of the map, is least where the
 * sample lies on a row of taps: (n - 1) / 2n of n rows. Of few taps it may be nothing.
 */
double plan_filter_least_share(const csm_config *config) {
  const bool few = plan_filter_taps(config) < 3 || (config->filter == CSM_FILTER_VOGEL && config->filter_taps < 16);
  return few ? 0.0 : 1.0 / 3.0;
}

uint32_t plan_filter_radius_texels(const csm_config *config) {
  return (uint32_t)ceil(plan_filter_reach_texels(config));
}

double plan_grid_texels(const csm_config *config) {
  const double page = plan_resolution(config, 0) / (double)PLAN_CELLS;
  return config->snap_mode == CSM_SNAP_OFF ? 0.0 : plan_has_pages(config) ? page : (double)(1u << config->snap_power);
}

/* A snapped map lies up to half of its grid away from where it was wanted, one that is always moved down a whole one.
 */
double plan_padding_texels(const csm_config *config) {
  const double grid = plan_grid_texels(config);
  const double moved = config->snap_mode == CSM_SNAP_FLOOR ? grid : grid / 2.0;
  const double rounding_of_floats = 0.5;
  return plan_filter_radius_texels(config) + ceil(config->bias_normal_texels) + moved + rounding_of_floats +
         plan_jitter_room(config);
}

/*
 * What a lookup in the coarsest level reaches, in texels of the maps: one and a half of that level's, or, with several
 * samples along a footprint, half of those more. All of it lies in the map, and the receiver no nearer to a border.
 */
static double levels_reach(const csm_config *config, uint32_t cascade) {
  plan_moments moments;
  plan_moments_make(&moments, config);
  const double texel = ldexp(config->moment_halved ? 2.0 : 1.0, (int)moments.levels - 1);
  const double samples = config->moment_sampling == CSM_SAMPLING_ANISOTROPIC ? config->moment_anisotropy : 0.0;
  return moments.levels > 1 ? fmin(texel * (1.5 + 0.5 * samples), plan_resolution(config, cascade) / 2.0) : 0.0;
}

/* A blur, unlike levels, is in the padding already, but of VSSM, whose search is. */
double plan_view_room_texels(const csm_config *config, uint32_t cascade) {
  double room = plan_padding_texels(config);
  if (plan_has_moments(config))
    room += levels_reach(config, cascade);
  if (config->filter == CSM_FILTER_VSSM)
    room += config->moment_blur_texels * (config->moment_halved ? 2.0 : 1.0);
  return room;
}

uint32_t plan_resolution(const csm_config *config, uint32_t cascade) {
  return config->resolutions[cascade] ? config->resolutions[cascade] : config->resolution;
}

/*
 * Castano, "Shadow Mapping Summary, Part 1" (2013), read as taps one texel apart: the published bilinear fetches
 * between texels have these weights.
 */
static double castano(uint32_t taps, uint32_t from_middle) {
  static const double of_3[] = {2, 1}, of_5[] = {4, 3, 1}, of_7[] = {16, 12, 5, 1};
  return (taps == 3 ? of_3 : taps == 5 ? of_5 : of_7)[from_middle];
}

static double gaussian(uint32_t taps, uint32_t from_middle) {
  const double deviations = from_middle / (taps / 4.0);
  return exp(-0.5 * deviations * deviations);
}

double plan_filter_weights(double weights[PLAN_MAX_WEIGHTS], const csm_config *config) {
  const uint32_t taps = plan_filter_taps(config);
  double sum = 0.0;
  for (uint32_t i = 0; i < PLAN_MAX_WEIGHTS; ++i) {
    const bool there = i <= taps / 2;
    weights[i] = !there                                           ? 0.0
                 : config->filter_weights == CSM_WEIGHTS_GAUSSIAN ? gaussian(taps, i)
                 : config->filter_weights == CSM_WEIGHTS_CASTANO  ? castano(taps, i)
                                                                  : 1.0;
    weights[i] = (float)weights[i]; /* as the shader sums them */
    sum += i ? 2.0 * weights[i] : weights[i];
  }
  return sum;
}
