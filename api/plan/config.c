/* config.c: which configurations are sound. */
#include "plan/budget.h"
#include "plan/internal.h"

static csm_result check_entry(const plan_config_entry *entry, const csm_config *config, const char **error) {
  const csm_config_field *field = &entry->field;
  const void *const value = (const char *)config + field->offset;
  if (plan_is_double(field) && !plan_finite(value, field->length))
    return plan_fail(error, CSM_ERROR_NOT_FINITE, entry->not_finite);
  for (uint32_t k = 0; k < field->length; ++k) {
    const double number = plan_is_double(field) ? ((const double *)value)[k] : ((const uint32_t *)value)[k];
    if (number < field->minimum || number > field->maximum)
      return plan_fail(error, CSM_ERROR_INVALID_VALUE, entry->out_of_range);
  }
  return CSM_SUCCESS;
}

static csm_result check_splits(const csm_config *config, const char **error) {
  const bool fractions = config->split_mode == CSM_SPLIT_FRACTIONS;
  if (config->split_mode != CSM_SPLIT_MANUAL && !fractions)
    return CSM_SUCCESS;
  if (config->depth_samples == CSM_DEPTH_SAMPLES_SPLITS)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE,
                     "depth_samples splits has no splits to place: split_mode gives them by split_distances");
  double last = 0.0;
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    if (!(config->split_distances[i] > last))
      return plan_fail(error, CSM_ERROR_INVALID_VALUE, "split_distances do not rise from above 0");
    last = config->split_distances[i];
  }
  if (fractions && last > 1.0)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "split_distances are fractions, and go above 1");
  return CSM_SUCCESS;
}

static csm_result check_filter(const csm_config *config, const char **error) {
  const uint32_t filter = config->filter, taps = config->filter_taps, weights = config->filter_weights;
  const bool large = filter == CSM_FILTER_PCF_5X5 || filter == CSM_FILTER_PCF_7X7;
  const bool any = filter == CSM_FILTER_PCF_N;
  if (any && (taps % 2 == 0 || taps < 3 || taps > PLAN_MAX_TAPS))
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "filter_taps of filter pcf_n is not odd and 3 to 31");
  if (filter == CSM_FILTER_VOGEL && taps < 1)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "filter_taps of filter vogel is 0");
  if (weights != CSM_WEIGHTS_UNIFORM && !large && !any && filter != CSM_FILTER_PCF_3X3)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "filter_weights are for filters pcf_3x3 to pcf_n");
  if (weights == CSM_WEIGHTS_CASTANO && any)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE,
                     "filter_weights castano is for filters pcf_3x3, pcf_5x5 and pcf_7x7");
  if (config->filter_early_out && !large && !any)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "filter_early_out is for filters pcf_5x5, pcf_7x7 and pcf_n");
  if (filter == CSM_FILTER_LINEAR_DEPTH && config->bias_mode == CSM_BIAS_RECEIVER_PLANE)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE,
                     "bias_mode receiver_plane has no texels to place with filter linear_depth, which compares once");
  return CSM_SUCCESS;
}

static csm_result check_moments(const csm_config *config, const char **error) {
  const uint32_t filter = config->filter;
  if (filter == CSM_FILTER_VSSM && config->moment_levels < 2)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE,
                     "filter vssm needs moment_levels above 1: it reads means of areas");
  if (plan_has_moments(config) && config->moment_sampling == CSM_SAMPLING_TRILINEAR && config->moment_levels < 2)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "moment_sampling trilinear needs moment_levels above 1");
  if (filter == CSM_FILTER_BACKPROJECTION && config->soft_penumbra == CSM_PENUMBRA_RATIO)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE,
                     "soft_penumbra ratio is for filters pcss and vssm: backprojection knows the light alone");
  return CSM_SUCCESS;
}

static csm_result check_rays(const csm_config *config, const char **error) {
  if (!plan_has_rays(config))
    return CSM_SUCCESS;
  if (config->blend_mode != CSM_BLEND_OFF)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE,
                     "blend_mode is for filters whose cascades differ: with filter exact rays decide");
  if (config->bias_mode != CSM_BIAS_RECEIVER_PLANE)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE,
                     "filter exact needs bias_mode receiver_plane: it asks which texels lie on the receiver's plane");
  return CSM_SUCCESS;
}

/* Pages stay where they are in the world, as large as they are, in layers that go on at their other side. */
static const char *refuse_pages(const csm_config *config) {
  const bool steady = config->fit_mode != CSM_FIT_CASCADE && config->fit_mode != CSM_FIT_SCENE;
  bool alike = true;
  for (uint32_t i = 0; i < config->cascade_count; ++i)
    alike &= plan_resolution(config, i) == plan_resolution(config, 0);
  return !steady ? "map_layout pages needs a fit_mode whose texels stay as large as they are: spheres or squares"
         : config->snap_mode == CSM_SNAP_OFF ? "map_layout pages needs a grid, and snap_mode is off"
         : config->snap_power                ? "map_layout pages has a grid of its own, and snap_power is not 0"
         : !alike                            ? "map_layout pages needs maps of one size, and resolutions has others"
         : plan_resolution(config, 0) % PLAN_CELLS ? "map_layout pages needs a resolution that is a multiple of 64"
         : plan_has_moments(config)                ? "map_layout pages keeps depths alone, and the filter reads moments"
         : config->history == CSM_HISTORY_ON && config->history_jitter
             ? "map_layout pages keeps what it has drawn, and history_jitter moves maps in every frame"
             : NULL;
}

const char *plan_refuse_sides(const csm_config *config) {
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    const uint32_t resolution = plan_resolution(config, i);
    if (resolution < PLAN_LEAST_RESOLUTION)
      return "resolutions has an entry below 16";
    if (!(resolution > 2.0 * plan_padding_texels(config) + 1.0))
      return "resolution is too small for the room that filter and bias_normal_texels take at a map's border";
  }
  return NULL;
}

static csm_result check_maps(const csm_config *config, const char **error) {
  if (config->snap_power && config->snap_mode == CSM_SNAP_OFF)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "snap_power has no grid with snap_mode off");
  const char *refused = plan_has_pages(config) ? refuse_pages(config) : NULL;
  if (refused)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, refused);
  refused = plan_refuse_sides(config);
  return refused ? plan_fail(error, CSM_ERROR_INVALID_VALUE, refused) : CSM_SUCCESS;
}

/* Each target that holds is one, and the configuration is one that it can be kept with. */
static const char *refuse_budget(const csm_config *config) {
  const uint32_t budget = config->budget;
  const bool timed = budget & CSM_BUDGET_TIME, judged = budget & CSM_BUDGET_ERROR, capped = budget & CSM_BUDGET_MEMORY;
  return timed && !(config->budget_ms > 0.0)       ? "budget_ms is not above 0, and budget has its bit"
         : judged && !(config->budget_wrong > 0.0) ? "budget_wrong is not above 0, and budget has its bit"
         : capped && !(config->budget_mib > 0.0)   ? "budget_mib is not above 0, and budget has its bit"
         : (timed || judged) && plan_has_moments(config)
             ? "budget has a target of time or error, and the filter reads moments: memory alone can be kept then"
         : (timed || judged) && plan_has_pages(config) ? "budget has a target of time or error, and map_layout pages "
                                                         "keeps its texels: memory alone can be kept then"
         : judged && !plan_budget_judges(config)
             ? "budget has a target of error, which is for filters pcf_2x2 and pcf_3x3"
         : judged && config->out_of_range == CSM_OUT_OF_RANGE_FADED
             ? "budget has a target of error, and out_of_range faded hides which pixels are edges"
         : capped && plan_budget_fit(config, 0) == PLAN_BUDGET_STEPS
             ? "budget_mib is less than the coarsest maps take: an eighth of the texels a side, and room for the filter"
             : NULL;
}

csm_result plan_config_check(const csm_config *config, const char **error) {
  csm_result result = CSM_SUCCESS;
  const plan_config_entry *entry;
  for (uint32_t i = 0; !result && (entry = plan_config_entry_at(i)); ++i)
    result = check_entry(entry, config, error);
  if (!result && (config->reserved || config->reserved_moments || config->reserved_soft || config->reserved_history ||
                  config->reserved_budget))
    result = plan_fail(error, CSM_ERROR_INVALID_VALUE, "reserved is not 0");
  if (!result)
    result = check_splits(config, error);
  if (!result)
    result = check_filter(config, error);
  if (!result)
    result = check_moments(config, error);
  if (!result)
    result = check_rays(config, error);
  if (!result)
    result = check_maps(config, error);
  if (!result && config->blend_mode != CSM_BLEND_OFF && config->blend_share == 0.0)
    result = plan_fail(error, CSM_ERROR_INVALID_VALUE, "blend_share is 0, and blend_mode is not off");
  if (!result && config->out_of_range == CSM_OUT_OF_RANGE_FADED && config->fade_share == 0.0)
    result = plan_fail(error, CSM_ERROR_INVALID_VALUE, "fade_share is 0, and out_of_range is faded");
  const char *refused = result ? NULL : refuse_budget(config);
  if (refused)
    result = plan_fail(error, CSM_ERROR_INVALID_VALUE, refused);
  return result;
}
