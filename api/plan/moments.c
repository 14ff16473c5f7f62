/* moments.c: what filters vsm to msm4 and vssm read: where moments lie, and the numbers that keep them sound. */
#include "plan/internal.h"

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

static uint32_t levels_of(uint32_t side) {
  uint32_t levels = 1;
  while (side >> levels)
    ++levels;
  return levels;
}

void plan_moments_make(plan_moments *out, const csm_config *config) {
  *out = (plan_moments){.channels = channels_of(config), .depth_layers = config->moment_layers};
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    out->sides[i] = plan_resolution(config, i) >> config->moment_halved;
    out->side = out->sides[i] > out->side ? out->sides[i] : out->side;
  }
  const uint32_t most = levels_of(out->side);
  out->levels = config->moment_levels < most ? config->moment_levels : most;
}

/*
 * The largest exponents that a format holds, z being from -1 to 1: of a first moment alone exp(c), of a second one
 * exp(2 c). The largest float16 is 65504, the largest float32 3.4e38.
 */
double plan_moment_exponent_most(const csm_config *config, bool squared) {
  const double first = config->moment_format == CSM_MOMENTS_FLOAT16 ? 11.08 : 88.0;
  return squared ? first / 2.0 : first;
}
