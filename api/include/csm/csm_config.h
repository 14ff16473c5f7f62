/*
 * csm_config.h: how cascades are split, fitted, drawn, filtered and biased: csm_config, its presets and its
 * description.
 *
 * Included by csm.h.
 */
#ifndef CSM_CONFIG_H
#define CSM_CONFIG_H

#include "csm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define CSM_MAX_CASCADES 8

enum {
  CSM_SPLIT_PRACTICAL = 0, /* by split_lambda; of an orthographic camera uniform, as all but the given ones are */
  CSM_SPLIT_MANUAL = 1,    /* by split_distances */
  CSM_SPLIT_UNIFORM = 2,
  CSM_SPLIT_LOGARITHMIC = 3,
  CSM_SPLIT_FRACTIONS = 4 /* by split_distances, as shares of the way from the near plane to the end of shadows */
};
enum {
  CSM_FILTER_PCF_2X2 = 0,      /* one bilinear comparison */
  CSM_FILTER_PCF_3X3 = 1,      /* n x n of them, one texel apart: (n + 1) x (n + 1) texels */
  CSM_FILTER_NEAREST = 2,      /* the one texel that holds the sample */
  CSM_FILTER_LINEAR_DEPTH = 3, /* one comparison with the bilinear depth */
  CSM_FILTER_PCF_5X5 = 4,
  CSM_FILTER_PCF_7X7 = 5,
  CSM_FILTER_PCF_N = 6,   /* filter_taps a side */
  CSM_FILTER_POISSON = 7, /* 16 bilinear comparisons on a disc of filter_radius_texels, turned per place in the world */
  CSM_FILTER_VOGEL = 8,   /* filter_taps of them, on a spiral */
  CSM_FILTER_GRID_17 = 9, /* 17 single texels, half a texel and a texel around the sample */
  /* Of moments of the depth, which are blurred before they are read. */
  CSM_FILTER_VSM = 10,   /* two: variance shadow maps */
  CSM_FILTER_ESM = 11,   /* one, of an exponential */
  CSM_FILTER_EVSM2 = 12, /* two, of an exponential */
  CSM_FILTER_EVSM4 = 13, /* four: two each of a rising and a falling exponential */
  CSM_FILTER_MSM4 = 14,  /* four: moment shadow maps */
  /* Of a light that has a size: the penumbra grows with the distance to what shadows. */
  CSM_FILTER_PCSS = 15, /* percentage-closer soft shadows: a search for blockers, then soft_taps comparisons */
  CSM_FILTER_VSSM = 16, /* variance soft shadow mapping: the same of two moments */
  CSM_FILTER_BACKPROJECTION = 17, /* what the texels around the sample hide of the light's disc */
  /* Maps decide where all texels around the sample agree; elsewhere rays through the casters' triangles do. They need a
     context with CSM_CREATE_RAYS. */
  CSM_FILTER_EXACT = 18,     /* one ray to the middle of the light */
  CSM_FILTER_EXACT_SOFT = 19 /* ray_taps rays to its disc */
};
enum { CSM_WEIGHTS_UNIFORM = 0, CSM_WEIGHTS_GAUSSIAN = 1, CSM_WEIGHTS_CASTANO = 2 };
enum { CSM_BIAS_SLOPE = 0, CSM_BIAS_RECEIVER_PLANE = 1 };
enum { CSM_NORMAL_OFFSET_CONSTANT = 0, CSM_NORMAL_OFFSET_SINE = 1, CSM_NORMAL_OFFSET_ONE_MINUS_COSINE = 2 };
enum {
  CSM_FIT_MINIMUM_SPHERE = 0,
  CSM_FIT_CENTROID_SPHERE = 1,
  CSM_FIT_CASCADE = 2,        /* box of the slice in light space */
  CSM_FIT_CASCADE_SQUARE = 3, /* a square around its middle, as wide as the slice's longest diagonal */
  CSM_FIT_SCENE = 4,          /* as CASCADE, but every slice begins at the camera's near plane */
  CSM_FIT_SCENE_SQUARE = 5
};
enum {
  CSM_DEPTH_CASTERS = 0,      /* the slice, and towards the light as far as casters reach, up to caster_distance */
  CSM_DEPTH_SLICE = 1,        /* the slice, and caster_distance towards the light */
  CSM_DEPTH_SCENE = 2,        /* the bounding box of all instances */
  CSM_DEPTH_SCENE_CLIPPED = 3 /* what of that box lies over the map */
};
enum { CSM_PANCAKING_CLAMP = 0, CSM_PANCAKING_CLIP = 1 };
enum { CSM_SNAP_ROUND = 0, CSM_SNAP_FLOOR = 1, CSM_SNAP_OFF = 2 };
enum { CSM_LIGHT_ROLL_FIXED = 0, CSM_LIGHT_ROLL_CARRIED = 1 };
enum { CSM_DEPTH_SAMPLES_OFF = 0, CSM_DEPTH_SAMPLES_SPLITS = 1, CSM_DEPTH_SAMPLES_BOUNDS = 2 };
enum { CSM_SELECT_INTERVAL = 0, CSM_SELECT_MAP = 1, CSM_SELECT_BEST = 2 };
enum { CSM_OUT_OF_RANGE_LIT = 0, CSM_OUT_OF_RANGE_DARK = 1, CSM_OUT_OF_RANGE_FADED = 2 };
enum { CSM_BLEND_OFF = 0, CSM_BLEND_LINEAR = 1, CSM_BLEND_DITHERED = 2 };
enum { CSM_CASTER_SET_MAP = 0, CSM_CASTER_SET_VIEW = 1 };
enum { CSM_FACE_CULLING_NONE = 0, CSM_FACE_CULLING_FRONT = 1, CSM_FACE_CULLING_BACK = 2 };
enum {
  CSM_LAYOUT_ARRAY = 0, /* a layer for each cascade */
  CSM_LAYOUT_ATLAS = 1, /* one image for all */
  CSM_LAYOUT_PAGES = 2  /* a layer for each cascade, divided into 64 x 64 pages. A place in the world keeps its texels while
                           the camera moves: pages that are read are drawn when they are first seen, or something in them
                           changed, and kept */
};
enum { CSM_MAP_D32 = 0, CSM_MAP_D16 = 1 };
enum { CSM_MOMENTS_FLOAT32 = 0, CSM_MOMENTS_FLOAT16 = 1 };
enum { CSM_BLUR_BOX = 0, CSM_BLUR_GAUSSIAN = 1 };
enum { CSM_SAMPLING_BILINEAR = 0, CSM_SAMPLING_TRILINEAR = 1, CSM_SAMPLING_ANISOTROPIC = 2 };
enum { CSM_BLEEDING_LINEAR = 0, CSM_BLEEDING_SMOOTHSTEP = 1 };
enum { CSM_PENUMBRA_LIGHT = 0, CSM_PENUMBRA_RATIO = 1 };
enum { CSM_HISTORY_OFF = 0, CSM_HISTORY_ON = 1 };
enum { /* which targets of a budget hold */
  CSM_BUDGET_TIME = 1u << 0,
  CSM_BUDGET_ERROR = 1u << 1,
  CSM_BUDGET_MEMORY = 1u << 2
};

/*
 * A configuration of cascades, field by field in themes. csm_config_describe gives the unit, range and default of every
 * field. A zero is a literal zero: start from csm_config_default or csm_config_preset.
 */
typedef struct csm_config {
  uint32_t struct_size;

  /* Splits: where the cascades end. */
  uint32_t cascade_count; /* 1 to CSM_MAX_CASCADES */
  uint32_t split_mode;    /* CSM_SPLIT_* */
  uint32_t depth_samples; /* CSM_DEPTH_SAMPLES_*: what is fitted to the depths that a view saw (SDSM) */
  double shadow_distance; /* view depth at which shadows end, in metres */
  double split_lambda;    /* practical splits: 0 uniform, 1 logarithmic */
  double split_near;      /* view depth in metres from which splits are spread; 0: the near plane */
  double split_distances[CSM_MAX_CASCADES]; /* where each cascade ends, rising; unused entries are 0. Manual splits:
                                               view depth in metres. Fractions: of the way from the near plane to
                                               shadow_distance. */
  double depth_samples_margin;              /* room around what a view saw, as a share of it */

  /* Fit: what of light space a map covers. */
  uint32_t fit_mode; /* CSM_FIT_* */

  /* Depth: from where to where a map reaches along the light. */
  uint32_t depth_mode;    /* CSM_DEPTH_* */
  double caster_distance; /* how far before a slice, towards the light, a caster's depth is kept, in metres; with
                             pancaking clamp at most as far as map_format resolves */
  uint32_t pancaking;     /* CSM_PANCAKING_*: what becomes of casters before a map's near plane */

  /* Stability: what keeps a map from swimming. */
  uint32_t snap_mode;       /* CSM_SNAP_*: how a map's place is brought to the grid of its texels */
  uint32_t snap_power;      /* the grid is 2^snap_power texels wide; 0 to 4 */
  uint32_t light_roll;      /* CSM_LIGHT_ROLL_*: how maps are turned about the light */
  double light_step_texels; /* the light moves in steps, each of which shifts what lies a map's width away by so
                               many texels; 0: it moves freely, as a slow light does where steps are short */

  /* Selection: which cascade a point takes, and what lies at its end. */
  uint32_t selection;    /* CSM_SELECT_* */
  uint32_t blend_mode;   /* CSM_BLEND_* */
  double blend_share;    /* length of the band that blends, as a share of a cascade */
  double fade_share;     /* CSM_OUT_OF_RANGE_FADED: length of the fade, as a share of the shadow distance */
  uint32_t out_of_range; /* CSM_OUT_OF_RANGE_*: what lies past the last cascade */

  /* Filter: how a map is read. */
  uint32_t filter;             /* CSM_FILTER_* */
  uint32_t filter_taps;        /* PCF_N: taps a side, odd, 3 to 31; VOGEL: points, 1 to 64 */
  uint32_t filter_weights;     /* CSM_WEIGHTS_*: of the taps of PCF_3X3 to PCF_N */
  uint32_t filter_early_out;   /* PCF_5X5 to PCF_N: 1 reads corners and middle first, and stops where they agree */
  uint32_t reserved;           /* 0 */
  double filter_radius_texels; /* POISSON, VOGEL: of their disc */

  /* Bias: what keeps a surface from shadowing itself. */
  uint32_t bias_mode;             /* CSM_BIAS_*: one depth for the whole filter, or the receiver's plane under it */
  uint32_t normal_offset_mode;    /* CSM_NORMAL_OFFSET_*: what bias_normal_texels is multiplied with */
  double bias_constant_texels;    /* depth bias towards the light, in texels' widths */
  double bias_slope_texels;       /* depth bias for each unit of the receiver's slope to the light */
  double bias_slope_max;          /* slope (tangent) at which that stops growing */
  double bias_normal_texels;      /* offset of the receiver along its normal, in texels' widths */
  double bias_constant_range;     /* depth bias as a share of the map's depth range */
  double bias_constant_m;         /* depth bias in metres */
  double bias_slope_range;        /* for each unit of slope, as a share of the depth range */
  double bias_limit_range;        /* the most that all slope bias may be, as a share of the depth range; 0: no limit */
  double polygon_offset_constant; /* the rasteriser's constant depth bias, in its own units for the format */
  double polygon_offset_slope;    /* its slope-scaled bias */
  double polygon_offset_clamp;    /* the most that these may be, in depth; 0: no limit */

  /* Maps. */
  uint32_t resolution;                    /* texels a side; 16 to 16384, and what the device can do */
  uint32_t resolutions[CSM_MAX_CASCADES]; /* of single cascades; 0: `resolution` */
  uint32_t map_layout;                    /* CSM_LAYOUT_* */
  uint32_t map_format;                    /* CSM_MAP_* */
  uint32_t map_reversed;                  /* 1: depth 1 is nearest to the light */

  /* Casters. */
  uint32_t caster_set;   /* CSM_CASTER_SET_*: what is drawn into a map; with VIEW, masks and samples are right for what
                            the cascades' own frame sees alone: its camera, its instances */
  uint32_t face_culling; /* CSM_FACE_CULLING_*: faces of casters that are left out; two-sided meshes keep
                            theirs */

  /* Bias of receiver_plane, under a low sun. */
  double bias_plane_max; /* slope (tangent) up to which a receiver's plane is told from what shadows it; as
                            bias_slope_max where that is more */

  /* Moments: what filters vsm to msm4 and vssm read instead of depths. */
  uint32_t moment_format;      /* CSM_MOMENTS_* */
  uint32_t moment_layers;      /* VSM: slices of the depth range, each with moments of its own; 1 to 4 */
  uint32_t moment_blur;        /* CSM_BLUR_* */
  uint32_t moment_blur_texels; /* radius of the blur, in the moments' own texels: 0 (none) to 32 */
  uint32_t moment_levels;      /* mip levels, 1 to 12, and as many as a map has */
  uint32_t moment_sampling;    /* CSM_SAMPLING_* */
  uint32_t moment_anisotropy;  /* CSM_SAMPLING_ANISOTROPIC: at most so many samples, 1 to 16 */
  uint32_t moment_halved;      /* 1: moments have half as many texels a side as the map */
  double moment_exponent;      /* ESM, EVSM2, EVSM4: c of exp(c z), z from -1 to 1 over the depth range; at most what
                                      moment_format holds */
  double moment_exponent_negative; /* EVSM4: c of -exp(-c z), likewise */
  double moment_bias;              /* share by which moments become those of depths that are spread out */
  double moment_deviation_range;   /* least standard deviation of depths, as a share of the depth range */
  double moment_deviation_m;       /* and in metres */
  double moment_deviation_slope;   /* and in texels' widths, for each unit of the receiver's slope */
  uint32_t bleeding_curve;         /* CSM_BLEEDING_*: how visibility is stretched above bleeding_reduction */
  uint32_t reserved_moments;       /* 0 */
  double bleeding_reduction;       /* visibility up to this is taken for shadow; 0 to 0.99 */
  double bleeding_power;           /* and what is above is raised to this; 1 to 16 */

  /* Soft shadows: filters pcss, vssm and backprojection. The size of the light is csm_light.angular_diameter. */
  uint32_t soft_penumbra;          /* CSM_PENUMBRA_*: its width from the light's size and metres, or, for a textbook's,
                                      from soft_light_range and the ratio of two depths */
  uint32_t soft_search_taps;       /* soft filters: texels that are searched for blockers, 1 to 256 */
  uint32_t soft_taps;              /* comparisons, or points of the light's disc, 1 to 256 */
  uint32_t reserved_soft;          /* 0 */
  double soft_radius_max_texels;   /* search and filter reach no farther than this */
  double soft_radius_least_texels; /* and the filter no less */
  double soft_light_range;         /* CSM_PENUMBRA_RATIO: the light's size as a share of the map's width */

  /* History: what a view keeps of its earlier masks. */
  uint32_t history;          /* CSM_HISTORY_* */
  uint32_t history_frames;   /* a pixel is the mean of so many frames at most, 1 to 64 */
  double history_depth;      /* a pixel's history counts where its surface lies as deep, to this share of its depth */
  double history_normal_deg; /* and is turned by no more than this, in degrees */
  uint32_t history_jitter;   /* 1: each frame's maps begin elsewhere within a texel, so that their edges are noise */
  uint32_t reserved_history; /* 0 */

  /* Rays: filters exact and exact_soft. */
  uint32_t ray_taps;        /* EXACT_SOFT: rays from a pixel to the light's disc, 1 to 64 */
  uint32_t ray_share;       /* 1, EXACT_SOFT, csm's own masks without a history: a pixel that rays decide shows the mean
                                 of the 3 x 3 pixels around it on its plane, where chance explains how they differ */
  double ray_unsure_cosine; /* masks without an engine's normals: where the depth leaves a pixel's plane unsure, a ray
                                 decides if the cosine of the plane's normal to the light is below this, 0 to 1 */
  double ray_grazing_cosine; /* and below this one wherever the plane is known, too */

  /* Budget: `resolution` and `resolutions` are the most; all maps get coarser alike, down to an eighth of the texels a
     side, as these targets ask for. csm_stats.budget_text says what was given up, and why. */
  uint32_t budget;          /* CSM_BUDGET_*: which of the targets hold; 0: none. TIME and ERROR choose anew from frame to
                               frame, within an image that stays; not with moments or map_layout pages. TIME turns
                               timestamps on. ERROR is for filters pcf_2x2 and pcf_3x3 */
  uint32_t reserved_budget; /* 0 */
  double budget_ms;         /* the GPU's time for maps and for one view's mask, in milliseconds */
  double budget_wrong;      /* share of the pixels facing the light that are more than half wrong */
  double budget_mib;        /* device memory of maps and moments, in MiB of 2^20 bytes; with map_layout pages, of second
                               layers, too */
} csm_config;

enum { CSM_FIELD_UINT = 0, CSM_FIELD_DOUBLE = 1, CSM_FIELD_ENUM = 2, CSM_FIELD_DOUBLES = 3, CSM_FIELD_UINTS = 4 };

/* One field of csm_config. Texts are static. */
typedef struct csm_config_field {
  uint32_t struct_size;
  uint32_t type;             /* CSM_FIELD_*; DOUBLES and UINTS are arrays of `length` */
  uint32_t offset;           /* in csm_config, in bytes */
  uint32_t length;           /* 1, or an array's length */
  double minimum;            /* inclusive */
  double maximum;            /* inclusive */
  double default_value;      /* for each element */
  const char *name;          /* as in csm_config, and as the key in a JSON file */
  const char *unit;          /* "m", "texels", "1" and so on; "" for an enumeration */
  const char *about;         /* one sentence */
  const char *const *values; /* ENUM: the name of each value from 0 on, then NULL; else NULL */
} csm_config_field;

/* Describes field `index`, from 0. Errors: NULL_POINTER, STRUCT_SIZE, INVALID_INDEX (past the last one). [any-thread]
 */
CSM_API csm_result CSM_CALL csm_config_describe(uint32_t index, csm_config_field *field);

/* Fills a configuration with the defaults. config->struct_size must be set. Errors: NULL_POINTER, STRUCT_SIZE.
 * [any-thread] */
CSM_API csm_result CSM_CALL csm_config_default(csm_config *config);

enum {
  CSM_PRESET_SHADOW_DISTANCE = 1u << 0 /* it says where shadows end; without this, the scene had better say it */
};

/* A preset. Texts are static. */
typedef struct csm_preset_info {
  uint32_t struct_size;
  uint32_t flags; /* CSM_PRESET_* */
  const char *name;
  const char *about;        /* one sentence */
  const char *read_in;      /* where its values were read; "csm" if they are csm's own */
  const char *const *notes; /* sentences, then NULL: what is not stated there, and what was taken for it */
} csm_preset_info;

/*
 * Describes preset `index`, from 0; csm's own come first.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_INDEX (past the last one). [any-thread]
 */
CSM_API csm_result CSM_CALL csm_config_preset_describe(uint32_t index, csm_preset_info *info);

/*
 * Fills a configuration with a preset: the defaults, and over them what the preset says. A struct of an older header
 * gets the fields that it has.
 * Preconditions: config->struct_size is set.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (no preset has this name; the configuration is as it was).
 * [any-thread]
 */
CSM_API csm_result CSM_CALL csm_config_preset(const char *name, csm_config *config);

/*
 * Gives the text that fixes csm's shader includes to a configuration: lines of #define, for GLSL and HLSL alike.
 * Without it the includes read the same settings from the constants at run time. *size holds the room at `text` in
 * bytes, and gets the bytes of the whole text, its final 0 included; `text` may be NULL to ask for that number alone.
 * Errors: NULL_POINTER (config, size), STRUCT_SIZE, NOT_FINITE, INVALID_VALUE (the configuration; a text that does not
 * fit, of which nothing is written). [any-thread]
 */
CSM_API csm_result CSM_CALL csm_shader_defines(const csm_config *config, char *text, uint64_t *size);

#ifdef __cplusplus
}
#endif
#endif
