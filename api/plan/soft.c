/* soft.c: filters that look at the size of the light. */
#include "plan/internal.h"

bool plan_is_soft(const csm_config *config) {
  return config->filter == CSM_FILTER_PCSS || config->filter == CSM_FILTER_VSSM ||
         config->filter == CSM_FILTER_BACKPROJECTION;
}
