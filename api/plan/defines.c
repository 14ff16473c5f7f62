#include "plan/plan.h"

size_t plan_shader_defines(const csm_config *config, char *text, size_t size) {
  (void)config;
  if (size)
    text[0] = '\0';
  return 1;
}
