/* defines.c: what fixes shaders/include/csm_sample.inc to a configuration. */
#include "plan/internal.h"

uint32_t plan_maps_alike(const csm_config *config) {
  if (config->map_layout == CSM_LAYOUT_ATLAS)
    return 0;
  for (uint32_t i = 1; i < config->cascade_count; ++i)
    if (plan_resolution(config, i) != plan_resolution(config, 0))
      return 0;
  return plan_has_pages(config) ? 2 : 1;
}

bool plan_bias_in_texels(const csm_config *config) {
  return config->bias_constant_m == 0.0 && config->bias_slope_range == 0.0 && config->bias_limit_range == 0.0;
}

typedef struct define {
  const char *name;
  uint32_t value;
} define;

enum { MOST_DEFINES = 16 };

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
  out[count++] = (define){"CSM_NORMAL_OFFSET_ON", config->bias_normal_texels != 0.0};
  out[count++] = (define){"CSM_NORMAL_OFFSET_MODE", config->normal_offset_mode};
  out[count++] = (define){"CSM_SELECTION", config->selection};
  out[count++] = (define){"CSM_OUT_OF_RANGE", config->out_of_range};
  out[count++] = (define){"CSM_BLENDING", config->blend_mode};
  out[count++] = (define){"CSM_MAPS_ALIKE", plan_maps_alike(config)};
  out[count++] = (define){"CSM_MAPS_REVERSED", config->map_reversed};
  out[count++] = (define){"CSM_CASCADES", config->cascade_count};
  return count;
}

/* A text that counts what does not fit. */
typedef struct text {
  char *to;
  size_t size, length;
} text;

static void put_text(text *out, const char *words) {
  for (; *words; ++words, ++out->length)
    if (out->length + 1 < out->size)
      out->to[out->length] = *words;
}

static void put_number(text *out, uint32_t value) {
  char digits[11] = {0};
  int first = 10;
  do {
    digits[--first] = (char)('0' + value % 10);
    value /= 10;
  } while (value);
  put_text(out, &digits[first]);
}

size_t plan_shader_defines(const csm_config *config, char *to, size_t size) {
  define defines[MOST_DEFINES];
  text out = {.to = to, .size = size};
  const uint32_t count = list_defines(defines, config);
  for (uint32_t i = 0; i < count; ++i) {
    put_text(&out, "#define ");
    put_text(&out, defines[i].name);
    put_text(&out, " ");
    put_number(&out, defines[i].value);
    put_text(&out, "\n");
  }
  if (size)
    to[out.length < size ? out.length : size - 1] = '\0';
  return out.length + 1;
}
