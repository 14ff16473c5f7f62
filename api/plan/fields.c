/* fields.c: csm_config's fields: one table for names, ranges, defaults and what is said where they are wrong. */
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
                                      [CSM_FILTER_VSM] = "vsm",
                                      [CSM_FILTER_ESM] = "esm",
                                      [CSM_FILTER_EVSM2] = "evsm2",
                                      [CSM_FILTER_EVSM4] = "evsm4",
                                      [CSM_FILTER_MSM4] = "msm4",
                                      [CSM_FILTER_PCSS] = "pcss",
                                      [CSM_FILTER_VSSM] = "vssm",
                                      [CSM_FILTER_BACKPROJECTION] = "backprojection",
                                      [CSM_FILTER_EXACT] = "exact",
                                      [CSM_FILTER_EXACT_SOFT] = "exact_soft",
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
static const char *const layouts[] = {
    [CSM_LAYOUT_ARRAY] = "array", [CSM_LAYOUT_ATLAS] = "atlas", [CSM_LAYOUT_PAGES] = "pages", NULL};
static const char *const formats[] = {[CSM_MAP_D32] = "d32", [CSM_MAP_D16] = "d16", NULL};
static const char *const moment_formats[] = {
    [CSM_MOMENTS_FLOAT32] = "float32", [CSM_MOMENTS_FLOAT16] = "float16", NULL};
static const char *const blurs[] = {[CSM_BLUR_BOX] = "box", [CSM_BLUR_GAUSSIAN] = "gaussian", NULL};
static const char *const samplings[] = {[CSM_SAMPLING_BILINEAR] = "bilinear",
                                        [CSM_SAMPLING_TRILINEAR] = "trilinear",
                                        [CSM_SAMPLING_ANISOTROPIC] = "anisotropic",
                                        NULL};
static const char *const bleedings[] = {
    [CSM_BLEEDING_LINEAR] = "linear", [CSM_BLEEDING_SMOOTHSTEP] = "smoothstep", NULL};
static const char *const penumbrae[] = {[CSM_PENUMBRA_LIGHT] = "light", [CSM_PENUMBRA_RATIO] = "ratio", NULL};
static const char *const histories[] = {[CSM_HISTORY_OFF] = "off", [CSM_HISTORY_ON] = "on", NULL};
static const char *const switches[] = {"off", "on", NULL};

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
static const plan_config_entry entries[] = {
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
    ENTRY(filter, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_FILTER_EXACT_SOFT,
          .default_value = CSM_FILTER_PCF_3X3, .unit = "", .values = filters,
          .about = "How a map is filtered: one texel, one bilinear depth, n x n bilinear comparisons a texel apart, a "
                   "disc of them, moments of depth, by the size of the light, or by rays where maps do not decide."),
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
    ENTRY(map_layout, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_LAYOUT_PAGES,
          .default_value = CSM_LAYOUT_ARRAY, .unit = "", .values = layouts,
          .about =
              "A layer of an array for each cascade, one image that holds all, or layers of pages that are kept while "
              "what they show stays."),
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
    /* moments */
    ENTRY(moment_format, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_MOMENTS_FLOAT16,
          .default_value = CSM_MOMENTS_FLOAT32, .unit = "", .values = moment_formats,
          .about = "Format of the moments that filters vsm to msm4 and vssm read."),
    ENTRY(moment_layers, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = 4, .default_value = 1,
          .unit = "1", .about = "Filter vsm: slices of the depth range, each with moments of its own."),
    ENTRY(moment_blur, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_BLUR_GAUSSIAN,
          .default_value = CSM_BLUR_BOX, .unit = "", .values = blurs, .about = "Weights of the moments' blur."),
    ENTRY(moment_blur_texels, .type = CSM_FIELD_UINT, .length = 1, .minimum = 0, .maximum = 32, .default_value = 2,
          .unit = "texels", .about = "Radius of the moments' blur, in their own texels; 0 is none."),
    ENTRY(moment_levels, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = 12, .default_value = 1,
          .unit = "1", .about = "Mip levels of the moments, and at most as many as a map has."),
    ENTRY(moment_sampling, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_SAMPLING_ANISOTROPIC,
          .default_value = CSM_SAMPLING_BILINEAR, .unit = "", .values = samplings,
          .about = "How moments are sampled: their first level, the levels as fine as a pixel is large in the map, or "
                   "several samples along its longer side."),
    ENTRY(moment_anisotropy, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = 16, .default_value = 8,
          .unit = "1", .about = "With moment_sampling anisotropic: at most so many samples."),
    ENTRY(moment_halved, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = 1, .default_value = 0,
          .unit = "", .values = switches, .about = "Whether moments have half as many texels a side as the maps."),
    ENTRY(moment_exponent, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.1, .maximum = 100.0,
          .default_value = 80.0, .unit = "1",
          .about = "Filters esm, evsm2 and evsm4: c of exp(c z), z from -1 to 1 over the depth range; at most what "
                   "moment_format holds."),
    ENTRY(moment_exponent_negative, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.1, .maximum = 100.0,
          .default_value = 5.0, .unit = "1", .about = "Filter evsm4: c of -exp(-c z), likewise."),
    ENTRY(moment_bias, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 0.1, .default_value = 0.0,
          .unit = "1", .about = "Share by which moments become those of depths that are spread over the whole range."),
    ENTRY(moment_deviation_range, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0,
          .default_value = 0.0, .unit = "range",
          .about = "Least standard deviation of depths, as a share of the depth range, above what the format needs."),
    ENTRY(moment_deviation_m, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1000.0,
          .default_value = 0.0, .unit = "m", .about = "The same in metres."),
    ENTRY(moment_deviation_slope, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 16.0,
          .default_value = 0.5, .unit = "texels", .about = "The same for each unit of the receiver's slope."),
    ENTRY(bleeding_curve, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_BLEEDING_SMOOTHSTEP,
          .default_value = CSM_BLEEDING_LINEAR, .unit = "", .values = bleedings,
          .about = "How visibility above bleeding_reduction is stretched; smoothstep brightens what is above 0.6."),
    ENTRY(bleeding_reduction, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 0.99,
          .default_value = 0.2, .unit = "1",
          .about = "Filters of moments: visibility up to this is taken for shadow, and the rest stretched."),
    ENTRY(bleeding_power, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 1.0, .maximum = 16.0, .default_value = 1.0,
          .unit = "1", .about = "What visibility is raised to after that."),
    /* soft */
    ENTRY(soft_penumbra, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_PENUMBRA_RATIO,
          .default_value = CSM_PENUMBRA_LIGHT, .unit = "", .values = penumbrae,
          .about = "Where a penumbra's width comes from: the light's angular diameter and metres, or a textbook's "
                   "ratio of depths times soft_light_range."),
    ENTRY(soft_search_taps, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = 256, .default_value = 16,
          .unit = "1", .about = "Filters pcss and vssm: texels that are searched for blockers."),
    ENTRY(soft_taps, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = 256, .default_value = 32,
          .unit = "1", .about = "Soft filters: comparisons, or points of the light's disc."),
    ENTRY(soft_radius_max_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 1.0, .maximum = 512.0,
          .default_value = 32.0, .unit = "texels", .about = "Soft filters reach no farther than this."),
    ENTRY(soft_radius_least_texels, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 16.0,
          .default_value = 1.0, .unit = "texels", .about = "Soft filters are no smaller than this."),
    ENTRY(soft_light_range, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0,
          .default_value = 0.01, .unit = "range",
          .about = "With soft_penumbra ratio: the light's size as a share of the map's width."),
    /* history */
    ENTRY(history, .type = CSM_FIELD_ENUM, .length = 1, .minimum = 0, .maximum = CSM_HISTORY_ON,
          .default_value = CSM_HISTORY_OFF, .unit = "", .values = histories,
          .about = "Whether a view's masks are accumulated from frame to frame."),
    ENTRY(history_frames, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = 64, .default_value = 8,
          .unit = "1", .about = "With history: a pixel is the mean of so many frames at most."),
    ENTRY(history_depth, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0, .default_value = 0.02,
          .unit = "1",
          .about = "With history: how far from where it was a pixel's surface may lie, as a share of its view depth."),
    ENTRY(history_normal_deg, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 180.0,
          .default_value = 20.0, .unit = "degrees", .about = "With history: how far it may have turned."),
    ENTRY(history_jitter, .type = CSM_FIELD_UINT, .length = 1, .minimum = 0, .maximum = 1, .default_value = 0,
          .unit = "1", .about = "With history: whether each frame's maps begin elsewhere within a texel."),
    /* rays */
    ENTRY(ray_taps, .type = CSM_FIELD_UINT, .length = 1, .minimum = 1, .maximum = 64, .default_value = 16, .unit = "1",
          .about = "Filter exact_soft: rays from a pixel to the light's disc."),
    ENTRY(ray_share, .type = CSM_FIELD_UINT, .length = 1, .minimum = 0, .maximum = 1, .default_value = 0, .unit = "1",
          .about = "Filter exact_soft without history: whether pixels on one plane share what their rays found, where "
                   "chance explains how it differs."),
    ENTRY(ray_unsure_cosine, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0,
          .default_value = 0.1, .unit = "1",
          .about = "Filter exact without normals: a ray decides where depth leaves a pixel's plane unsure and its "
                   "cosine to the light is below this."),
    ENTRY(ray_grazing_cosine, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0,
          .default_value = 0.02, .unit = "1", .about = "And below this one whatever is known of the plane."),
    /* budget */
    ENTRY(budget, .type = CSM_FIELD_UINT, .length = 1, .minimum = 0, .maximum = 7, .default_value = 0, .unit = "1",
          .about =
              "Which targets maps get coarser for: the sum of 1 (budget_ms), 2 (budget_wrong) and 4 (budget_mib)."),
    ENTRY(budget_ms, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1000000.0, .default_value = 0.0,
          .unit = "ms", .about = "The GPU's time for maps and for one view's mask."),
    ENTRY(budget_wrong, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1.0, .default_value = 0.0,
          .unit = "1", .about = "The share of wrong pixels, of those that face the light."),
    ENTRY(budget_mib, .type = CSM_FIELD_DOUBLE, .length = 1, .minimum = 0.0, .maximum = 1000000.0, .default_value = 0.0,
          .unit = "MiB", .about = "Device memory of maps and moments."),
};

enum { entry_count = sizeof entries / sizeof *entries };

const plan_config_entry *plan_config_entry_at(uint32_t index) {
  return index < entry_count ? &entries[index] : NULL;
}

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
