/* defines.c: what fixes shaders/include/csm_sample.inc to a configuration. */
#include "plan/internal.h"

#include <stdio.h>

bool plan_maps_alike(const csm_config *config) {
  if (config->map_layout != CSM_LAYOUT_ARRAY)
    return false;
  for (uint32_t i = 1; i < config->cascade_count; ++i)
    if (plan_resolution(config, i) != plan_resolution(config, 0))
      return false;
  return true;
}

bool plan_bias_in_texels(const csm_config *config) {
  return config->bias_constant_m == 0.0 && config->bias_slope_range == 0.0 && config->bias_limit_range == 0.0;
}

typedef struct define {
  const char *name;
  uint32_t value;
} define;

enum { MOST_DEFINES = 16, MOST_LINE = 64 };

static uint32_t list_defines(define out[MOST_DEFINES], const csm_config *config) {
  uint32_t count = 0;
  out[count++] = (define){"CSM_FILTER", config->filter};
  out[count++] = (define){"CSM_FILTER_TAPS", plan_filter_taps(config)};
  out[count++] = (define){"CSM_FILTER_WEIGHTS", config->filter_weights};
  out[count++] = (define){"CSM_EARLY_OUT", config->filter_early_out};
  /* vkd3d draws some filters wrong that leave early and have their bias fixed */
  if (!config->filter_early_out)
    out[count++] = (define){"CSM_BIAS_MODE", config->bias_mode};
  out[count++] = (define){"CSM_BIAS_UNITS", !plan_bias_in_texels(config)};
  out[count++] = (define){"CSM_NORMAL_OFFSET", config->bias_normal_texels != 0.0};
  out[count++] = (define){"CSM_SELECTION", config->selection};
  out[count++] = (define){"CSM_OUT_OF_RANGE", config->out_of_range};
  out[count++] = (define){"CSM_BLENDING", config->blend_mode};
  out[count++] = (define){"CSM_MAPS_ALIKE", plan_maps_alike(config)};
  out[count++] = (define){"CSM_MAPS_REVERSED", config->map_reversed};
  out[count++] = (define){"CSM_CASCADES", config->cascade_count};
  return count;
}

size_t plan_shader_defines(const csm_config *config, char *text, size_t size) {
  define defines[MOST_DEFINES];
  char line[MOST_LINE];
  const uint32_t count = list_defines(defines, config);
  size_t length = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const size_t more = (size_t)snprintf(line, sizeof line, "#define %s %u\n", defines[i].name, defines[i].value);
    for (size_t k = 0; k < more; ++k, ++length)
      if (length + 1 < size)
        text[length] = line[k];
  }
  if (size)
    text[length < size ? length : size - 1] = '\0';
  return length + 1;
}
