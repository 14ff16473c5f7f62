/* soft.c: filters that look at the size of the light, and those that send rays. */
#include "plan/internal.h"

bool plan_is_soft(const csm_config *config) {
  return config->filter == CSM_FILTER_PCSS || config->filter == CSM_FILTER_VSSM ||
         config->filter == CSM_FILTER_BACKPROJECTION || config->filter == CSM_FILTER_EXACT_SOFT;
}

bool plan_has_rays(const csm_config *config) {
  return config->filter == CSM_FILTER_EXACT || config->filter == CSM_FILTER_EXACT_SOFT;
}

bool plan_shares_rays(const csm_config *config) {
  return config->filter == CSM_FILTER_EXACT_SOFT && config->ray_share && config->history == CSM_HISTORY_OFF;
}

bool plan_has_ranges(const csm_config *config) {
  return config->filter == CSM_FILTER_EXACT_SOFT && config->soft_penumbra == CSM_PENUMBRA_LIGHT &&
         !plan_has_pages(config);
}
