/* config.c: csm_config's fields: one table for names, ranges, defaults and checks. */
#include "plan/internal.h"

static const char *const split_modes[] = {[CSM_SPLIT_PRACTICAL] = "practical", [CSM_SPLIT_MANUAL] = "manual", NULL};
static const char *const filters[] = {[CSM_FILTER_PCF_2X2] = "pcf_2x2", [CSM_FILTER_PCF_3X3] = "pcf_3x3", NULL};

static const char *const bias_modes[] = {
    [CSM_BIAS_SLOPE] = "slope", [CSM_BIAS_RECEIVER_PLANE] = "receiver_plane", NULL};

typedef struct config_entry {
  csm_config_field field;
  const char *not_finite, *out_of_range;
} config_entry;

/* A macro, for it makes texts of the name. */
#define ENTRY(key, ...)                                                                                                \
  {                                                                                                                    \
    .field = {.struct_size = sizeof(csm_config_field),                                                                 \
              .offset = offsetof(csm_config, key),                                                                     \
              .name = #key,                                                                                            \
              __VA_ARGS__},                                                                                            \
    .not_finite = #key " is not finite", .out_of_range = #key " is outside its range"                                  \
  }

/*
 * The defaults of the bias, in texels' widths. A map knows a surface at its texels' centres alone, half a texel away at
 * most along each axis; what lies between is guessed.
 *
 * - mode: every texel is compared with the depth that the receiver's plane has at its centre. A plane then needs no bias
 *   but that for rounding, and what shadows a steep receiver from just above is kept: a caster that covers the receiver
 *   covers more than half of the filter, however the plane runs.
 * - slope: where the surface is no plane, its depth half a texel away differs by half a texel times its slope along each
 *   axis; a slope bias of 1 is that much. In the other mode there is one depth for the whole filter, and 1 is as much as
 *   the plane's depth changes over the filter's reach: a plane never shadows itself, and less would not do.
 * - slope_max: a receiver of slope 10 gets a tenth of the light. Beyond, half a texel in the map is so much depth that a
 *   growing bias would let more light through than it keeps off.
 * - constant: half a texel times the slope of 45 degrees, for what stands beside a receiver that faces the light. It also
 *   covers rounding: the rasteriser places vertices to 1/256 pixel, which moves a plane of slope 10 by at most 0.02
 *   texel; D32 over a range of 64 radii at 2048 texels, and the float arithmetic that leads there, is off by 2^-22 of the
 *   range, 0.016 texel.
 */
static const config_entry entries[] = {
    ENTRY(cascade_count, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = CSM_MAX_CASCADES,
          .default_value = 4, .unit = "1", .about = "Number of cascades."),
    ENTRY(resolution, .type = CSM_FIELD_UINT, .length = 1, .minimum = 16, .maximum = 16384, .default_value = 2048,
          .unit = "texels", .about = "Side of every map."),
    ENTRY(split_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_SPLIT_MANUAL,
          .default_value = CSM_SPLIT_PRACTICAL, .unit = "", .values = split_modes,
          .about = "Where cascades end: by split_lambda, or by split_distances."),
    ENTRY(filter, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_FILTER_PCF_3X3,
          .default_value = CSM_FILTER_PCF_3X3, .unit = "", .values = filters,
          .about = "How a map is filtered: one bilinear comparison, or the mean of 3 x 3 of them."),
    ENTRY(bias_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_BIAS_RECEIVER_PLANE,
          .default_value = CSM_BIAS_RECEIVER_PLANE, .unit = "", .values = bias_modes,
          .about = "What a texel is compared with: one depth for the whole filter, made safe by the slope bias, or the "
                   "depth that the receiver's plane has there."),
    ENTRY(shadow_distance, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 1e-3, .maximum = 1e9,
          .default_value = 150.0, .unit = "m", .about = "View depth at which shadows end."),
    ENTRY(split_lambda, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0, .default_value = 0.75,
          .unit = "1", .about = "Practical splits: 0 is uniform, 1 logarithmic."),
    ENTRY(split_distances, .type = CSM_FIELD_DOUBLES, .length = CSM_MAX_CASCADES, .minimum = 0.0, .maximum = 1e9,
          .default_value = 0.0, .unit = "m", .about = "Manual splits: view depth at which each cascade ends, rising."),
    ENTRY(caster_distance, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1e9,
          .default_value = 1000.0, .unit = "m",
          .about = "How far before a slice, towards the light, depth is kept; nearer casters are clamped there."),
    ENTRY(bias_constant_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1e3,
          .default_value = 0.5, .unit = "texels", .about = "Depth bias towards the light, whatever the slope."),
    ENTRY(bias_slope_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1e3,
          .default_value = 1.0, .unit = "texels",
          .about =
              "Depth bias for each unit of the receiver's slope to the light: times the filter's reach with bias_mode "
              "slope, times half a texel with receiver_plane."),
    ENTRY(bias_slope_max, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1e4, .default_value = 10.0,
          .unit = "1", .about = "Slope at which the slope bias stops growing."),
    ENTRY(bias_normal_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 4.0,
          .default_value = 0.0, .unit = "texels", .about = "Offset of the receiver along its normal."),
};

enum { entry_count = sizeof entries / sizeof *entries };

const csm_config_field *plan_config_field(uint32_t index) {
  return index < entry_count ? &entries[index].field : NULL;
}

void plan_config_default(csm_config *config) {
  *config = (csm_config){.struct_size = sizeof *config};
  for (uint32_t i = 0; i < entry_count; ++i) {
    const csm_config_field *field = &entries[i].field;
    void *const value = (char *)config + field->offset;
    const bool is_double = field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES;
    for (uint32_t k = 0; k < field->length; ++k)
      if (is_double)
        ((double *)value)[k] = field->default_value;
      else
        ((uint32_t *)value)[k] = (uint32_t)field->default_value;
  }
}

static csm_result check_entry(const config_entry *entry, const csm_config *config, const char **error) {
  const csm_config_field *field = &entry->field;
  const void *const value = (const char *)config + field->offset;
  const bool is_double = field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES;
  if (is_double && !plan_finite(value, field->length))
    return plan_fail(error, CSM_ERROR_NOT_FINITE, entry->not_finite);
  for (uint32_t k = 0; k < field->length; ++k) {
    const double number = is_double ? ((const double *)value)[k] : ((const uint32_t *)value)[k];
    if (number < field->minimum || number > field->maximum)
      return plan_fail(error, CSM_ERROR_INVALID_VALUE, entry->out_of_range);
  }
  return CSM_SUCCESS;
}

csm_result plan_config_check(const csm_config *config, const char **error) {
  for (uint32_t i = 0; i < entry_count; ++i) {
    const csm_result result = check_entry(&entries[i], config, error);
    if (result)
      return result;
  }
  if (config->split_mode == CSM_SPLIT_MANUAL) {
    double last = 0.0;
    for (uint32_t i = 0; i < config->cascade_count; ++i) {
      if (!(config->split_distances[i] > last))
        return plan_fail(error, CSM_ERROR_INVALID_VALUE, "split_distances do not rise from above 0");
      last = config->split_distances[i];
    }
  }
  return CSM_SUCCESS;
}

/* Hardware compares 2 x 2 texels, the centre of the farthest less than 1 away; the 3 x 3 taps lie 1 apart. */
uint32_t plan_filter_radius_texels(const csm_config *config) {
  return config->filter == CSM_FILTER_PCF_3X3 ? 2 : 1;
}
