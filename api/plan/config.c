/* config.c: csm_config's fields: one table for names, ranges, defaults and checks. */
#include "plan/internal.h"

static const char *const split_modes[] = {
    [CSM_SPLIT_PRACTICAL] = "practical",     [CSM_SPLIT_MANUAL] = "manual",       [CSM_SPLIT_UNIFORM] = "uniform",
    [CSM_SPLIT_LOGARITHMIC] = "logarithmic", [CSM_SPLIT_FRACTIONS] = "fractions", NULL};
static const char *const filters[] = {[CSM_FILTER_PCF_2X2] = "pcf_2x2",
                                      [CSM_FILTER_PCF_3X3] = "pcf_3x3",
                                      [CSM_FILTER_NEAREST] = "nearest",
                                      [CSM_FILTER_LINEAR_DEPTH] = "linear_depth",
                                      [CSM_FILTER_PCF_5X5] = "pcf_5x5",
                                      [CSM_FILTER_PCF_7X7] = "pcf_7x7",
                                      [CSM_FILTER_PCF_N] = "pcf_n",
                                      [CSM_FILTER_POISSON] = "poisson",
                                      [CSM_FILTER_VOGEL] = "vogel",
                                      [CSM_FILTER_GRID_17] = "grid_17",
                                      NULL};
static const char *const weights[] = {
    [CSM_WEIGHTS_UNIFORM] = "uniform", [CSM_WEIGHTS_GAUSSIAN] = "gaussian", [CSM_WEIGHTS_CASTANO] = "castano", NULL};
static const char *const bias_modes[] = {
    [CSM_BIAS_SLOPE] = "slope", [CSM_BIAS_RECEIVER_PLANE] = "receiver_plane", NULL};
static const char *const normal_offsets[] = {[CSM_NORMAL_OFFSET_CONSTANT] = "constant",
                                             [CSM_NORMAL_OFFSET_SINE] = "sine",
                                             [CSM_NORMAL_OFFSET_ONE_MINUS_COSINE] = "one_minus_cosine",
                                             NULL};
static const char *const fits[] = {[CSM_FIT_MINIMUM_SPHERE] = "minimum_sphere",
                                   [CSM_FIT_CENTROID_SPHERE] = "centroid_sphere",
                                   [CSM_FIT_CASCADE] = "cascade",
                                   [CSM_FIT_CASCADE_SQUARE] = "cascade_square",
                                   [CSM_FIT_SCENE] = "scene",
                                   [CSM_FIT_SCENE_SQUARE] = "scene_square",
                                   NULL};
static const char *const depths[] = {[CSM_DEPTH_CASTERS] = "casters",
                                     [CSM_DEPTH_SLICE] = "slice",
                                     [CSM_DEPTH_SCENE] = "scene",
                                     [CSM_DEPTH_SCENE_CLIPPED] = "scene_clipped",
                                     NULL};
static const char *const pancakings[] = {[CSM_PANCAKING_CLAMP] = "clamp", [CSM_PANCAKING_CLIP] = "clip", NULL};
static const char *const snaps[] = {
    [CSM_SNAP_ROUND] = "round", [CSM_SNAP_FLOOR] = "floor", [CSM_SNAP_OFF] = "off", NULL};
static const char *const light_rolls[] = {[CSM_LIGHT_ROLL_FIXED] = "fixed", [CSM_LIGHT_ROLL_CARRIED] = "carried", NULL};
static const char *const samples[] = {[CSM_DEPTH_SAMPLES_OFF] = "off",
                                      [CSM_DEPTH_SAMPLES_SPLITS] = "splits",
                                      [CSM_DEPTH_SAMPLES_BOUNDS] = "bounds",
                                      NULL};
static const char *const selections[] = {
    [CSM_SELECT_INTERVAL] = "interval", [CSM_SELECT_MAP] = "map", [CSM_SELECT_BEST] = "best", NULL};
static const char *const out_of_ranges[] = {
    [CSM_OUT_OF_RANGE_LIT] = "lit", [CSM_OUT_OF_RANGE_DARK] = "dark", [CSM_OUT_OF_RANGE_FADED] = "faded", NULL};
static const char *const blends[] = {
    [CSM_BLEND_OFF] = "off", [CSM_BLEND_LINEAR] = "linear", [CSM_BLEND_DITHERED] = "dithered", NULL};
static const char *const face_cullings[] = {
    [CSM_FACE_CULLING_NONE] = "none", [CSM_FACE_CULLING_FRONT] = "front", [CSM_FACE_CULLING_BACK] = "back", NULL};
static const char *const caster_sets[] = {[CSM_CASTER_SET_MAP] = "map", [CSM_CASTER_SET_VIEW] = "view", NULL};
static const char *const layouts[] = {[CSM_LAYOUT_ARRAY] = "array", [CSM_LAYOUT_ATLAS] = "atlas", NULL};
static const char *const formats[] = {[CSM_MAP_D32] = "d32", [CSM_MAP_D16] = "d16", NULL};
static const char *const switches[] = {"off", "on", NULL};

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
 * - mode: every texel is compared with the depth that the receiver's plane has at its centre. A plane then needs no
 * bias but that for rounding, and what shadows a steep receiver from just above is kept: a caster that covers the
 * receiver covers more than half of the filter, however the plane runs.
 * - slope: where the surface is no plane, its depth half a texel away differs by half a texel times its slope along
 * each axis; a slope bias of 1 is that much. In the other mode there is one depth for the whole filter, and 1 is as
 * much as the plane's depth changes over the filter's reach: a plane never shadows itself, and less would not do.
 * - slope_max: a receiver of slope 10 gets a tenth of the light. Beyond, half a texel in the map is so much depth that
 * a growing bias would let more light through than it keeps off.
 * - plane_max: texels that a steeper receiver's plane may itself have darkened have no say. 10000 is a sun at 0.006
 * degrees.
 * - constant: half a texel times the slope of 45 degrees, for what stands beside a receiver that faces the light. It
 * also covers rounding: the rasteriser places vertices to 1/256 pixel, which moves a plane of slope 10 by at most 0.02
 *   texel; D32 over a range of 64 radii at 2048 texels, and the float arithmetic that leads there, is off by 2^-22 of
 * the range, 0.016 texel.
 */
static const config_entry entries[] = {
    /* splits */
    ENTRY(cascade_count, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = CSM_MAX_CASCADES,
          .default_value = 4, .unit = "1", .about = "Number of cascades."),
    ENTRY(split_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_SPLIT_FRACTIONS,
          .default_value = CSM_SPLIT_PRACTICAL, .unit = "", .values = split_modes,
          .about = "Where cascades end: by split_lambda, uniformly, logarithmically, or by split_distances."),
    ENTRY(shadow_distance, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.001, .maximum = 1000000000.0,
          .default_value = 150.0, .unit = "m", .about = "View depth at which shadows end."),
    ENTRY(split_lambda, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0, .default_value = 0.75,
          .unit = "1", .about = "Practical splits: 0 is uniform, 1 logarithmic."),
    ENTRY(split_near, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1000000000.0,
          .default_value = 0.0, .unit = "m",
          .about = "View depth from which splits that are not given are spread; 0 is the near plane."),
    ENTRY(split_distances, .type = CSM_FIELD_DOUBLES, .length = CSM_MAX_CASCADES, .minimum = 0.0, .maximum = 1e9,
          .default_value = 0.0, .unit = "m",
          .about = "Where each cascade ends, rising: as view depth with split_mode manual, as a share of the way from "
                   "the near plane to the end of shadows with fractions."),
    ENTRY(depth_samples, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_DEPTH_SAMPLES_BOUNDS,
          .default_value = CSM_DEPTH_SAMPLES_OFF, .unit = "", .values = samples,
          .about = "What is fitted to the depths that the camera saw in the last mask whose frame is done: nothing, "
                   "splits, or splits and what each map covers."),
    ENTRY(depth_samples_margin, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0,
          .default_value = 0.1, .unit = "1",
          .about = "Room around what depth_samples fits to, as a share of its size."),
    /* fit */
    ENTRY(fit_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_FIT_SCENE_SQUARE,
          .default_value = CSM_FIT_MINIMUM_SPHERE, .unit = "", .values = fits,
          .about = "What a map covers: a sphere around its slice, or the slice's box in light space, as it is or as a "
                   "square that never changes size; with scene every slice begins at the camera."),
    /* depth */
    ENTRY(depth_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_DEPTH_SCENE_CLIPPED,
          .default_value = CSM_DEPTH_CASTERS, .unit = "", .values = depths,
          .about = "From where to where a map reaches along the light: as far as casters do, by the slice, by the "
                   "scene's bounding box, or by what of that lies over the map."),
    ENTRY(caster_distance, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1000000000.0,
          .default_value = 1000.0, .unit = "m",
          .about = "How far before a slice, towards the light, depth is kept; nearer casters are treated as "
                   "pancaking says."),
    ENTRY(pancaking, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_PANCAKING_CLIP,
          .default_value = CSM_PANCAKING_CLAMP, .unit = "", .values = pancakings,
          .about = "Casters before a map's near plane are clamped to it and still cast, or are clipped away."),
    /* stability */
    ENTRY(snap_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_SNAP_OFF,
          .default_value = CSM_SNAP_ROUND, .unit = "", .values = snaps,
          .about = "How the place of a map is brought to the grid of its texels, which is anchored in the world."),
    ENTRY(snap_power, .type = CSM_FIELD_UINT, .length = 1, .minimum = 0, .maximum = 4, .default_value = 0, .unit = "1",
          .about = "The grid is 2^snap_power texels wide."),
    ENTRY(light_roll, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_LIGHT_ROLL_CARRIED,
          .default_value = CSM_LIGHT_ROLL_FIXED, .unit = "", .values = light_rolls,
          .about =
              "How maps are turned about the light: as its direction alone says, or carried on from the frame before."),
    ENTRY(light_step_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 16.0,
          .default_value = 0.0, .unit = "texels",
          .about = "The light moves in steps, each of which shifts what lies a map's width away by so many texels; 0 "
                   "lets it move freely, as a slow light does where steps are short."),
    /* selection */
    ENTRY(selection, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_SELECT_BEST,
          .default_value = CSM_SELECT_MAP, .unit = "", .values = selections,
          .about = "Which cascade a point takes: that of its view depth, or, with map and best alike, of those whose "
                   "maps hold it with its filter the one with the finest texels."),
    ENTRY(blend_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_BLEND_DITHERED,
          .default_value = CSM_BLEND_OFF, .unit = "", .values = blends,
          .about = "How a cascade goes over into the next one along blend_share: at once, by a linear mix, or by a "
                   "pattern that is fixed in the world."),
    ENTRY(blend_share, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0, .default_value = 0.1,
          .unit = "1",
          .about = "Length of the band in which a cascade blends into the next one, as a share of the cascade."),
    ENTRY(out_of_range, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_OUT_OF_RANGE_FADED,
          .default_value = CSM_OUT_OF_RANGE_LIT, .unit = "", .values = out_of_ranges,
          .about =
              "What lies past the last cascade: light, darkness, or light into which shadows fade over fade_share."),
    ENTRY(fade_share, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0, .default_value = 0.2,
          .unit = "1", .about = "Length over which shadows fade out at their end, as a share of the distance to it."),
    /* filter */
    ENTRY(filter, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_FILTER_GRID_17,
          .default_value = CSM_FILTER_PCF_3X3, .unit = "", .values = filters,
          .about = "How a map is filtered: one texel, one bilinear depth, n x n bilinear comparisons a texel apart, or "
                   "a disc of them."),
    ENTRY(filter_taps, .type = CSM_FIELD_UINT, .length = 1, .minimum = 0, .maximum = 64, .default_value = 9,
          .unit = "1", .about = "Filter pcf_n: taps a side, odd, 3 to 31. Filter vogel: points, 1 to 64."),
    ENTRY(filter_weights, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_WEIGHTS_CASTANO,
          .default_value = CSM_WEIGHTS_UNIFORM, .unit = "", .values = weights,
          .about = "Weights of the taps of pcf_3x3 to pcf_n: equal; a Gaussian whose deviation is a quarter of the "
                   "taps a side; Castano's, for 3x3, 5x5 and 7x7."),
    ENTRY(
        filter_early_out, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = 1, .default_value = 0,
        .unit = "", .values = switches,
        .about =
            "Filters pcf_5x5 to pcf_n: look at the corners and the middle first, and read no more where these agree."),
    ENTRY(filter_radius_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 16.0,
          .default_value = 2.0, .unit = "texels", .about = "Radius of the disc of filters poisson and vogel."),
    /* bias */
    ENTRY(bias_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_BIAS_RECEIVER_PLANE,
          .default_value = CSM_BIAS_RECEIVER_PLANE, .unit = "", .values = bias_modes,
          .about = "What a texel is compared with: one depth for the whole filter, made safe by the slope bias, or the "
                   "depth that the receiver's plane has there."),
    ENTRY(normal_offset_mode, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0,
          .maximum = CSM_NORMAL_OFFSET_ONE_MINUS_COSINE, .default_value = CSM_NORMAL_OFFSET_CONSTANT, .unit = "",
          .values = normal_offsets,
          .about = "What bias_normal_texels is multiplied with: 1, the sine of the angle between normal and light, or "
                   "one minus its cosine."),
    ENTRY(bias_constant_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1000.0,
          .default_value = 0.5, .unit = "texels", .about = "Depth bias towards the light, whatever the slope."),
    ENTRY(bias_slope_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1000.0,
          .default_value = 1.0, .unit = "texels",
          .about = "Depth bias for each unit of the receiver's slope to the light: times the filter's reach with "
                   "bias_mode slope, times half a texel with receiver_plane."),
    ENTRY(bias_slope_max, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 10000.0,
          .default_value = 10.0, .unit = "1", .about = "Slope at which the slope bias stops growing."),
    ENTRY(bias_plane_max, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 10000.0,
          .default_value = 10000.0, .unit = "1",
          .about =
              "Slope up to which the plane of a receiver steeper than bias_slope_max is told from what shadows it, "
              "with bias_mode receiver_plane; no more than that is as that."),
    ENTRY(bias_normal_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 4.0,
          .default_value = 0.0, .unit = "texels", .about = "Offset of the receiver along its normal."),
    ENTRY(bias_constant_range, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = -1.0, .maximum = 1.0,
          .default_value = 0.0, .unit = "range", .about = "Depth bias as a share of the map's depth range."),
    ENTRY(bias_constant_m, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1000.0,
          .default_value = 0.0, .unit = "m", .about = "Depth bias in metres."),
    ENTRY(bias_slope_range, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0, .default_value = 0.0,
          .unit = "range",
          .about = "Depth bias for each unit of the receiver's slope, as a share of the map's depth range."),
    ENTRY(bias_limit_range, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0, .default_value = 0.0,
          .unit = "range",
          .about = "The most that the slope biases may add up to, as a share of the depth range; 0 is no limit."),
    ENTRY(polygon_offset_constant, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = -16777216.0, .maximum = 16777216.0,
          .default_value = 0.0, .unit = "units",
          .about =
              "The rasteriser's constant depth bias: whole units of the format, which with d32 grow with the depth."),
    ENTRY(polygon_offset_slope, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = -1000.0, .maximum = 1000.0,
          .default_value = 0.0, .unit = "texels", .about = "The rasteriser's slope-scaled depth bias."),
    ENTRY(polygon_offset_clamp, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0,
          .default_value = 0.0, .unit = "range", .about = "The most that the rasteriser's bias may be; 0 is no limit."),
    /* maps */
    ENTRY(resolution, .type = CSM_FIELD_UINT, .length = 1, .minimum = 16, .maximum = 16384, .default_value = 2048,
          .unit = "texels", .about = "Side of every map that resolutions does not give another."),
    ENTRY(resolutions, .type = CSM_FIELD_UINTS, .length = CSM_MAX_CASCADES, .minimum = 0, .maximum = 16384,
          .default_value = 0, .unit = "texels",
          .about = "Sides of single cascades' maps, 16 or more; 0 takes resolution."),
    ENTRY(map_layout, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_LAYOUT_ATLAS,
          .default_value = CSM_LAYOUT_ARRAY, .unit = "", .values = layouts,
          .about = "A layer of an array for each cascade, or one image that holds all."),
    ENTRY(map_format, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_MAP_D16,
          .default_value = CSM_MAP_D32, .unit = "", .values = formats, .about = "Format of the maps."),
    ENTRY(map_reversed, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = 1, .default_value = 0, .unit = "",
          .values = switches, .about = "Whether depth 1 is nearest to the light."),
    /* casters */
    ENTRY(caster_set, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_CASTER_SET_VIEW,
          .default_value = CSM_CASTER_SET_MAP, .unit = "", .values = caster_sets,
          .about =
              "What is drawn into a map: all that casts into it, or what can shade something that the camera sees; "
              "view is for those who ask for visibility nowhere else."),
    ENTRY(face_culling, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_FACE_CULLING_BACK,
          .default_value = CSM_FACE_CULLING_NONE, .unit = "", .values = face_cullings,
          .about = "Faces of casters that are left out; front suits watertight meshes only."),
};

enum { entry_count = sizeof entries / sizeof *entries };

const csm_config_field *plan_config_field(uint32_t index) {
  return index < entry_count ? &entries[index].field : NULL;
}

bool plan_is_double(const csm_config_field *field) {
  return field->type == CSM_FIELD_DOUBLE || field->type == CSM_FIELD_DOUBLES;
}

void plan_config_default(csm_config *config) {
  *config = (csm_config){.struct_size = sizeof *config};
  for (uint32_t i = 0; i < entry_count; ++i) {
    const csm_config_field *field = &entries[i].field;
    void *const value = (char *)config + field->offset;
    for (uint32_t k = 0; k < field->length; ++k)
      if (plan_is_double(field))
        ((double *)value)[k] = field->default_value;
      else
        ((uint32_t *)value)[k] = (uint32_t)field->default_value;
  }
}

/* ---- checks ---- */

static csm_result check_entry(const config_entry *entry, const csm_config *config, const char **error) {
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

static csm_result check_maps(const csm_config *config, const char **error) {
  if (config->snap_power && config->snap_mode == CSM_SNAP_OFF)
    return plan_fail(error, CSM_ERROR_INVALID_VALUE, "snap_power has no grid with snap_mode off");
  for (uint32_t i = 0; i < config->cascade_count; ++i) {
    const uint32_t resolution = plan_resolution(config, i);
    if (resolution < PLAN_LEAST_RESOLUTION)
      return plan_fail(error, CSM_ERROR_INVALID_VALUE, "resolutions has an entry below 16");
    if (!(resolution > 2.0 * plan_padding_texels(config) + 1.0))
      return plan_fail(
          error, CSM_ERROR_INVALID_VALUE,
          "resolution is too small for the room that filter and bias_normal_texels take at a map's border");
  }
  return CSM_SUCCESS;
}

csm_result plan_config_check(const csm_config *config, const char **error) {
  csm_result result = CSM_SUCCESS;
  for (uint32_t i = 0; i < entry_count && !result; ++i)
    result = check_entry(&entries[i], config, error);
  if (!result && config->reserved)
    result = plan_fail(error, CSM_ERROR_INVALID_VALUE, "reserved is not 0");
  if (!result)
    result = check_splits(config, error);
  if (!result)
    result = check_filter(config, error);
  if (!result)
    result = check_maps(config, error);
  if (!result && config->blend_mode != CSM_BLEND_OFF && config->blend_share == 0.0)
    result = plan_fail(error, CSM_ERROR_INVALID_VALUE, "blend_share is 0, and blend_mode is not off");
  if (!result && config->out_of_range == CSM_OUT_OF_RANGE_FADED && config->fade_share == 0.0)
    result = plan_fail(error, CSM_ERROR_INVALID_VALUE, "fade_share is 0, and out_of_range is faded");
  return result;
}
