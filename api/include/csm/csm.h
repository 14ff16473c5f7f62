/*
 * csm.h: cascaded shadow maps for an engine, on whichever backend is loaded.
 *
 *   csm_create -> csm_mesh_create -> csm_cascades_create -> each frame: csm_render_cascades, csm_resolve_mask or
 * csm_bind
 *
 * Conventions: column vectors, column-major matrices (element [column * 4 + row]), world positions in doubles, metres.
 * Clip z in [0,1], clip y up; texture coordinate v = 0 and texel row 0 are clip y = +1. A light's direction is the way
 * its light travels. View matrices take world to view; projections may be perspective or orthographic, off-centre,
 * jittered, reversed-Z, with an infinite far plane, of either handedness.
 *
 * Structs begin with struct_size = sizeof(the struct). A smaller size means that the missing tail is zero, which is
 * neutral; a larger one is accepted when its unknown tail is zero. Outputs are never written past the caller's size.
 *
 * Every function but csm_destroy and those that return text returns a csm_result. An error leaves everything as it was
 * and has a text: csm_last_error, and the log callback. After CSM_ERROR_DEVICE_LOST every call on that context but
 * csm_destroy, csm_cascades_destroy, csm_retire, csm_switch_backend and csm_last_error answers CSM_ERROR_DEVICE_LOST.
 *
 * Threads: [any-thread] may be called at any time; [render-thread] one call at a time for one context, from any thread.
 * Contexts are independent of each other.
 */
#ifndef CSM_H
#define CSM_H

#include "csm_base.h"

#ifdef __cplusplus
extern "C" {
#endif

#define CSM_MAX_CASCADES 8

typedef struct csm_context csm_context;   /* a device, with geometry and programs on it */
typedef struct csm_cascades csm_cascades; /* one light seen from one camera: settings, maps, history */
typedef uint64_t csm_mesh;                /* a mesh of one context; 0 is none */
typedef uint64_t csm_alpha_mask;          /* an alpha mask of one context; 0 is none */

struct csm_vulkan_device; /* csm_vulkan.h */
struct csm_vulkan_mesh;
struct csm_d3d12_device; /* csm_d3d12.h */
struct csm_d3d12_mesh;

/* ---- library ---- */

/* CSM_VERSION of the library that runs. [any-thread] */
CSM_API uint32_t CSM_CALL csm_version(void);

/* The name of a result ("CSM_ERROR_NULL_POINTER"), or "CSM_RESULT_UNKNOWN". Static text. [any-thread] */
CSM_API const char *CSM_CALL csm_result_name(csm_result result);

/*
 * The text of the context's last error, "" if there was none or context is NULL. It stays until the next failing call
 * on the context. [render-thread]
 */
CSM_API const char *CSM_CALL csm_last_error(const csm_context *context);

enum {
  CSM_DEVICE_OTHER = 0,
  CSM_DEVICE_INTEGRATED = 1,
  CSM_DEVICE_DISCRETE = 2,
  CSM_DEVICE_VIRTUAL = 3,
  CSM_DEVICE_CPU = 4
};

/* What a backend is, and what it asks of a device. Lists of names end with NULL, and are never NULL. Texts are static,
   or in the struct. */
typedef struct csm_backend_info {
  uint32_t struct_size;
  int32_t result;          /* CSM_SUCCESS: it loads and finds a device; else what is in the way */
  uint32_t device_type;    /* CSM_DEVICE_* of the device it would open */
  uint32_t max_resolution; /* largest map side, in texels */
  char name[32];           /* "vulkan", "d3d12" */
  char path[256];          /* the library's file; "" if none was found */
  char device[256];        /* the device it would open */
  char driver[256];        /* driver and version, as it calls itself */
  char required[512];      /* what an engine must enable on its own device, in words */
  char optional[512];      /* what is used where it is on, in words */
  char error[256];         /* the text of `result` */
  /* The same for programs: names as the API spells them ("VK_KHR_maintenance1", "depthClamp"). */
  const char *const *required_instance_extensions;
  const char *const *required_device_extensions;
  const char *const *required_features;
  const char *const *optional_instance_extensions;
  const char *const *optional_device_extensions;
  const char *const *optional_features;
  uint32_t required_api_version;   /* Vulkan: as VK_API_VERSION_1_1; else 0 */
  uint32_t required_feature_level; /* D3D12: D3D_FEATURE_LEVEL_*; else 0 */
} csm_backend_info;

/*
 * Tells what is installed. *count holds the room in `infos`, and gets the number of backends; infos may be NULL to ask
 * for that number alone. infos[0].struct_size gives the stride; every element is filled. The lists stay as long as
 * libcsm is loaded.
 * Errors: NULL_POINTER (count), STRUCT_SIZE, OUT_OF_MEMORY. [any-thread]
 */
CSM_API csm_result CSM_CALL csm_query_backends(uint32_t *count, csm_backend_info *infos);

/* ---- context ---- */

enum {
  CSM_CREATE_VALIDATE = 1u << 0,     /* own device: turn the driver stack's validation on, messages go to the log */
  CSM_CREATE_KEEP_GEOMETRY = 1u << 1 /* keep a copy of every mesh in host memory, for csm_switch_backend */
};

typedef struct csm_mesh_info csm_mesh_info;

/*
 * Gives a mesh's data again, for csm_switch_backend: fills `info`, whose struct_size is set, as for csm_mesh_create;
 * the shape (counts, index_size) is what it was, and the data stays readable until the next call. Must not call back
 * into csm.
 */
typedef csm_result(CSM_CALL *csm_supply_function)(void *user, csm_mesh mesh, csm_mesh_info *info);

/* Bytes of device memory that the context may still take, as the engine sees it. Must not call back into csm. */
typedef uint64_t(CSM_CALL *csm_budget_function)(void *user);

typedef struct csm_create_info {
  uint32_t struct_size;
  uint32_t flags;        /* CSM_CREATE_* */
  uint32_t version;      /* CSM_VERSION that the caller was compiled with */
  uint32_t frame_slots;  /* frames in flight, 1 to 8; 0 means 3 */
  const char *backend;   /* "vulkan" or "d3d12", or a library's path, with a slash in it */
  const char *device;    /* own device: part of its name; NULL takes the first discrete, integrated, virtual, CPU one */
  uint64_t memory_limit; /* device memory that the context may hold, in bytes; 0 means what the device allows */
  const struct csm_vulkan_device *vulkan; /* the engine's device; NULL opens an own one */
  const struct csm_d3d12_device *d3d12;   /* likewise; at most one of the two */
  csm_allocate_function allocate;         /* both or neither; NULL uses malloc */
  csm_release_function release;
  csm_log_function log;       /* NULL is silent */
  void *user;                 /* handed to the callbacks */
  char *error;                /* receives the text of a creation that failed; may be NULL */
  uint64_t error_size;        /* bytes at `error` */
  csm_supply_function supply; /* may be NULL */
  csm_budget_function budget; /* asked before device memory is taken; NULL asks the driver (VK_EXT_memory_budget) */
} csm_create_info;

/*
 * Loads a backend and makes a context on it. A name is looked up beside libcsm, then in the folder it was installed to;
 * never in the current folder.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (flags, frame_slots, backend; what an engine's device says of
 * itself), BACKEND_NOT_FOUND, BACKEND_BROKEN, BACKEND_TOO_OLD, BACKEND_TOO_NEW, NO_DEVICE, UNSUPPORTED (an engine's
 * device that lacks what csm_query_backends says is required, or that belongs to the other API), OUT_OF_MEMORY,
 * OUT_OF_DEVICE_MEMORY, DEVICE. *context is NULL after an error. [any-thread]
 */
CSM_API csm_result CSM_CALL csm_create(const csm_create_info *info, csm_context **context);

/*
 * Waits for the own device, then destroys the context with all its meshes and cascades; NULL is allowed.
 * [render-thread]
 */
CSM_API void CSM_CALL csm_destroy(csm_context *context);

/*
 * Moves the context to another backend, or device, between two frames. The new device is opened completely, with all
 * meshes (from the context's copy, see CSM_CREATE_KEEP_GEOMETRY, or from `supply`) and the maps of all cascades, or
 * everything stays as it was. Meshes, cascades, settings and snapping carry on; maps and masks are drawn anew by the
 * next csm_render_cascades and csm_resolve_mask. What lies on an own device is freed at once, after waiting for it;
 * what lies on an engine's goes when csm_retire reaches its last frame. Works on a context whose device was lost.
 * `info` is read as by csm_create, but for allocate, release, log, user, supply, budget and CSM_CREATE_KEEP_GEOMETRY:
 * those stay.
 * Errors: as csm_create, and INVALID_STATE (a mesh that has no copy and is not supplied). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_switch_backend(csm_context *context, const csm_create_info *info);

/*
 * Engine's device: the GPU is done with every frame up to `frame`, whether csm recorded anything for it or not. Frees
 * what waited for that. At most frame_slots frames may be recorded and not retired, and a frame that is retired is not
 * recorded again. Errors: NULL_POINTER, UNSUPPORTED (an own device, which knows by itself). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_retire(csm_context *context, uint64_t frame);

/* ---- geometry ---- */

enum { CSM_WRAP_REPEAT = 0, CSM_WRAP_CLAMP = 1, CSM_WRAP_MIRROR = 2 };

/* Where an alpha-tested mesh is: sampled bilinearly, at full resolution, whatever the distance. */
typedef struct csm_alpha_mask_info {
  uint32_t struct_size;
  uint32_t flags;          /* 0 */
  uint32_t width, height;  /* in texels: 1 to 16384, and what the device can do */
  uint32_t wrap_u, wrap_v; /* CSM_WRAP_* */
  const uint8_t *texels;   /* width * height bytes, 0 clear to 255 opaque; the row of v = 0 first; copied, and kept in
                              host   memory for csm_switch_backend */
  uint32_t row_stride;     /* bytes from one row to the next; 0 means width */
  uint32_t reserved;       /* 0 */
  const char *name;        /* for debuggers; may be NULL */
} csm_alpha_mask_info;

/*
 * Copies an alpha mask into the context. It is uploaded by the next frame that is recorded.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (size, wrap, row_stride, flags), LIMIT_EXCEEDED, OUT_OF_MEMORY,
 * OUT_OF_DEVICE_MEMORY, DEVICE_LOST. *alpha mask is 0 after an error. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_alpha_mask_create(csm_context *context, const csm_alpha_mask_info *info,
                                                  csm_alpha_mask *alpha_mask);

/*
 * Frees an alpha mask once no frame in flight uses it. Errors: NULL_POINTER, INVALID_HANDLE, INVALID_STATE (a mesh
 * uses it still), DEVICE_LOST. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_alpha_mask_destroy(csm_context *context, csm_alpha_mask alpha_mask);

enum {
  CSM_MESH_TWO_SIDED = 1u << 0, /* casts from both sides, whatever csm_config.face_culling says: leaves, cloth */
  /* It has an inside: every edge joins two faces, counter-clockwise seen from outside. The faces turned away from the
     light are then behind others, and are not drawn with face_culling none: the maps are the same, and cost less. */
  CSM_MESH_WATERTIGHT = 1u << 1
};
enum { CSM_CASTER_SET_MAP = 0, CSM_CASTER_SET_VIEW = 1 };

struct csm_mesh_info {
  uint32_t struct_size;
  uint32_t flags;           /* CSM_MESH_* */
  const void *positions;    /* vertex_count times three floats: object space, metres; copied */
  uint32_t position_stride; /* bytes from one to the next, a multiple of 4; 0 means 12 */
  uint32_t vertex_count;    /* 1 to 2^31 - 1 */
  const void *indices;      /* index_count indices, three a triangle; copied */
  uint32_t index_count;     /* a positive multiple of 3 */
  uint32_t index_size;      /* 2 or 4 bytes */
  const char *name;         /* for debuggers; may be NULL */
  /* A mesh in an engine's own buffers, which are not copied: positions and indices are NULL then, the bounds are given,
     and indices are not checked. At most one of the two, and the device's. */
  const struct csm_vulkan_mesh *vulkan;
  const struct csm_d3d12_mesh *d3d12;
  float bounds_min[3], bounds_max[3]; /* object space, metres; read only for an engine's buffers */
  /* An alpha-tested mesh: it is there where its alpha mask is at least the cutoff. 0: opaque everywhere. Faces are
     counter-clockwise seen from outside. */
  csm_alpha_mask alpha_mask;
  const void *uvs;    /* vertex_count times two floats, v = 0 at the texture's first row; NULL in an engine's buffers,
                         which say where theirs are */
  uint32_t uv_stride; /* bytes from one to the next, a multiple of 4; 0 means 8 */
  float alpha_cutoff; /* above 0, up to 1 */
};

/*
 * Copies a triangle mesh into the context, or takes in an engine's own buffers, which must stay as they are until the
 * mesh is destroyed and its last frame retired. A copied one is uploaded by the next frame that is recorded.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (counts, stride, index_size, flags), INVALID_INDEX (an index not
 * below vertex_count), INVALID_HANDLE (alpha mask), NOT_FINITE (a position, the bounds), UNSUPPORTED (buffers of the
 * other API), LIMIT_EXCEEDED (memory; more than 32 pairs of strides of vertices and uvs), OUT_OF_MEMORY,
 * OUT_OF_DEVICE_MEMORY, DEVICE_LOST. *mesh is 0 after an error. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_mesh_create(csm_context *context, const csm_mesh_info *info, csm_mesh *mesh);

/*
 * Frees a mesh once no frame in flight that csm recorded uses it. Errors: NULL_POINTER, INVALID_HANDLE, DEVICE_LOST.
 * [render-thread]
 */
CSM_API csm_result CSM_CALL csm_mesh_destroy(csm_context *context, csm_mesh mesh);

/* ---- configuration ---- */

enum {
  CSM_SPLIT_PRACTICAL = 0, /* by split_lambda */
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
  CSM_FILTER_GRID_17 = 9  /* 17 single texels, half a texel and a texel around the sample */
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
enum { CSM_FACE_CULLING_NONE = 0, CSM_FACE_CULLING_FRONT = 1, CSM_FACE_CULLING_BACK = 2 };
enum { CSM_LAYOUT_ARRAY = 0, CSM_LAYOUT_ATLAS = 1 };
enum { CSM_MAP_D32 = 0, CSM_MAP_D16 = 1 };

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
  double caster_distance; /* how far before a slice, towards the light, a caster's depth is kept, in metres */
  uint32_t pancaking;     /* CSM_PANCAKING_*: what becomes of casters before a map's near plane */

  /* Stability: what keeps a map from swimming. */
  uint32_t snap_mode;       /* CSM_SNAP_*: how a map's place is brought to the grid of its texels */
  uint32_t snap_power;      /* the grid is 2^snap_power texels wide; 0 to 4 */
  uint32_t light_roll;      /* CSM_LIGHT_ROLL_*: how maps are turned about the light */
  double light_step_texels; /* the light moves in steps, each of which shifts what lies a map's width away by so
                               many texels; 0: it moves freely */

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
  uint32_t map_layout;                    /* CSM_LAYOUT_*: a layer for each cascade, or one image for all */
  uint32_t map_format;                    /* CSM_MAP_* */
  uint32_t map_reversed;                  /* 1: depth 1 is nearest to the light */

  /* Casters. */
  uint32_t caster_set;   /* CSM_CASTER_SET_*: what is drawn into a map */
  uint32_t face_culling; /* CSM_FACE_CULLING_*: faces of casters that are left out; two-sided meshes keep
                            theirs */
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

/*
 * Fills a configuration with a preset: the defaults, and over them what the preset says. A struct of an older header
 * gets the fields that it has.
 * Preconditions: config->struct_size is set.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (no preset has this name; the configuration is as it was).
 * [any-thread]
 */
CSM_API csm_result CSM_CALL csm_config_preset(const char *name, csm_config *config);

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

/* ---- cascades ---- */

/*
 * Makes the cascades of one light seen from one camera, with their maps.
 * Errors: NULL_POINTER, STRUCT_SIZE, NOT_FINITE, INVALID_VALUE (a field out of range, named in the text; manual splits
 * that do not rise), LIMIT_EXCEEDED (resolution or memory), OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, DEVICE_LOST, DEVICE.
 * *cascades is NULL after an error. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_cascades_create(csm_context *context, const csm_config *config,
                                                csm_cascades **cascades);

/* Changes the settings; maps are made anew only if their shape changes. Errors as csm_cascades_create. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_cascades_configure(csm_cascades *cascades, const csm_config *config);

/* Frees the cascades once no frame in flight uses them; NULL is allowed. Always CSM_SUCCESS. [render-thread] */
CSM_API csm_result CSM_CALL csm_cascades_destroy(csm_cascades *cascades);

/* ---- frames ---- */

typedef struct csm_instance {
  uint32_t struct_size;
  uint32_t flags; /* 0 */
  csm_mesh mesh;
  double transform[16]; /* object to world: affine, not singular */
} csm_instance;

/* What a draw callback gets for each cascade. */
typedef struct csm_draw_info {
  uint32_t struct_size;
  uint32_t cascade;
  uint32_t resolution;      /* of the cascade's map, whose viewport and scissor are set */
  uint32_t depth_format;    /* VkFormat or DXGI_FORMAT of the target; there is no colour, one sample */
  double world_to_clip[16]; /* affine; depth outside [0,1] must be clamped, not clipped; it is smaller nearer the sun,
                               unless `reversed` */
  double planes[5][4];      /* world space: what may cast into the map has dot(p, xyz) + w >= 0 for some point, for each
                               plane: left, right, bottom, top, far; towards the light it is open */
  void *command_buffer;     /* VkCommandBuffer or ID3D12GraphicsCommandList*, inside the cascade's pass */
  uint64_t render_pass;     /* VkRenderPass that the pass is compatible with, subpass 0; 0 on D3D12 */
  uint64_t depth_view;      /* D3D12: CPU descriptor of the depth view that is set; 0 on Vulkan */
  uint32_t x, y;            /* texel of the target at which the map begins: not 0 in an atlas */
  uint32_t reversed;        /* 1: depth is larger nearer the sun, and compared with greater */
  uint32_t reserved;        /* 0 */
} csm_draw_info;

/*
 * Draws casters of the engine's own into a cascade's map, after the frame's instances. It may change pipeline,
 * bindings, buffers and dynamic state, and must leave the pass open. Must not call back into csm.
 */
typedef void(CSM_CALL *csm_draw_function)(void *user, const csm_draw_info *info);

enum {
  CSM_FRAME_TIMESTAMPS = 1u << 0 /* measure the passes on the GPU; each pass then waits for the one before it */
};

typedef struct csm_frame {
  uint32_t struct_size;
  uint32_t flags;                /* CSM_FRAME_* */
  uint64_t frame;                /* engine's device: the frame's number from 1 on, never falling; several calls may
                                    share it; see csm_retire. Else 0 */
  double view[16];               /* world to view: a rotation and a translation, mirrored or not */
  double projection[16];         /* view to clip */
  double light_direction[3];     /* of travel; any length but 0 */
  const csm_instance *instances; /* casters and receivers; all of one struct_size; NULL if instance_count is 0 */
  uint32_t instance_count;
  uint32_t reserved;      /* 0 */
  csm_draw_function draw; /* engine's device: called for each cascade; may be NULL */
  void *draw_user;
  void *command_buffer; /* engine's device: its VkCommandBuffer or ID3D12GraphicsCommandList*; else NULL */
} csm_frame;

/*
 * Plans the frame and draws every cascade's map. On an own device the work is submitted, and runs on after the return;
 * on an engine's it is recorded into command_buffer, uploads of new meshes included.
 * Errors: NULL_POINTER, STRUCT_SIZE, NOT_FINITE, INVALID_VALUE (flags, command_buffer, frame), INVALID_MATRIX (view or
 * an instance's transform singular or not affine, projection singular), INVALID_CAMERA, INVALID_LIGHT, INVALID_HANDLE
 * (an instance's mesh), INVALID_STATE (frame_slots frames are not retired yet), UNSUPPORTED (draw on an own device),
 * OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, LIMIT_EXCEEDED, DEVICE_LOST, DEVICE.
 * [render-thread]
 */
CSM_API csm_result CSM_CALL csm_render_cascades(csm_cascades *cascades, const csm_frame *frame);

/*
 * What a mask holds. Views are for people who look into shadows that are not as they should be; both are 0 where
 * nothing is and beyond the last cascade, and take surfaces' normals from the depth.
 */
enum {
  CSM_VIEW_SHADOW = 0,  /* visibility */
  CSM_VIEW_CASCADE = 1, /* (cascade + 1) / 255, of the cascade that the point takes by `selection`: where two blend, of
                           the nearer one, and where blending is dithered, of the one that the point got */
  CSM_VIEW_DENSITY = 2  /* texels of that cascade's map for a pixel: (128 + 16 * log2(n)) / 255, the sum rounded and
                           clamped to 1..255. n is the larger of the two distances in the map, in texels, that the point
                           moves by from this pixel to the next one along a row and along a column of the mask, on its
                           own surface: 1 is one texel for each pixel, less is coarse, more is wasted */
};

typedef struct csm_mask_info {
  uint32_t struct_size;
  uint32_t flags;           /* CSM_FRAME_* */
  const csm_frame *frame;   /* the camera that sees the mask, its command buffer, and, without camera_depth, the
                               instances that it sees; its light is not read */
  uint32_t width, height;   /* of the mask, in pixels: 1 to 16384, and what the device can do */
  const void *camera_depth; /* engine's device: its depth image (csm_vulkan_image, csm_d3d12_image), of this size and
                               drawn with this camera; NULL draws the frame's instances */
  const void *normals;      /* engine's device: world-space unit normals, likewise; floats as they are, or normalised
                               integers from 0 for -1 to the largest for 1; NULL takes them from the depth */
  uint32_t view;            /* CSM_VIEW_* */
  uint32_t reserved;        /* 0 */
} csm_mask_info;

/*
 * Resolves a screen-space mask (1 lit, 0 shadowed; 1 where nothing is) from the maps that csm_render_cascades drew
 * last, with the selection, filter and bias of the configuration; or a view in the mask's place. A device's first view
 * makes its program, which takes a while.
 * Errors: as csm_render_cascades, and INVALID_STATE (no maps have been drawn with this configuration yet).
 * [render-thread]
 */
CSM_API csm_result CSM_CALL csm_resolve_mask(csm_cascades *cascades, const csm_mask_info *info);

typedef struct csm_cascade_info {
  double near_depth;          /* view depth where the slice begins, in metres */
  double far_depth;           /* and ends */
  double texel_size;          /* in metres */
  double depth_range;         /* metres along the light from depth 0 to depth 1 */
  double world_to_shadow[16]; /* world to texture coordinates and depth */
} csm_cascade_info;

typedef struct csm_binding {
  uint32_t struct_size;
  uint32_t cascade_count;
  uint32_t resolution;     /* texels a side */
  uint32_t constants_size; /* bytes used in constants */
  double origin[3];        /* world position that the constants are relative to */
  csm_cascade_info cascades[CSM_MAX_CASCADES];
  float constants[256];      /* the block of shaders/include/csm_constants.h */
  uint64_t native_maps;      /* VkImage, or ID3D12Resource*: the array of maps, readable by shaders */
  uint64_t native_mask;      /* likewise, the mask; 0 before the first csm_resolve_mask */
  uint64_t native_maps_view; /* Vulkan: VkImageView, 2D array, depth; D3D12: 0 */
  uint64_t native_mask_view; /* Vulkan: VkImageView, 2D; D3D12: 0 */
  uint64_t native_sampler;   /* Vulkan: VkSampler that compares: linear, clamped, less or equal, or with map_reversed
                                greater or equal; D3D12: 0 */
  uint64_t maps_descriptor;  /* in, D3D12: D3D12_CPU_DESCRIPTOR_HANDLE.ptr that gets a view of the maps; or 0 */
  uint64_t mask_descriptor;  /* in, D3D12: likewise of the mask, if there is one */
  uint32_t resolutions[CSM_MAX_CASCADES]; /* of each cascade's map, texels a side */
} csm_binding;

/*
 * Fills in what an engine's shaders need for the maps that were drawn last; records nothing.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_STATE (no maps yet), DEVICE_LOST. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_bind(csm_cascades *cascades, csm_binding *binding);

enum { CSM_READ_MAP = 0, CSM_READ_MASK = 1, CSM_READ_CAMERA_DEPTH = 2 };

typedef struct csm_read_info {
  uint32_t struct_size;
  uint32_t source;   /* CSM_READ_* */
  uint32_t cascade;  /* CSM_READ_MAP: which */
  uint32_t reserved; /* 0 */
  float *data;       /* receives one float a texel, top row first, without gaps */
  uint64_t size;     /* bytes at data; exactly width * height * 4 */
} csm_read_info;

/*
 * Reads a map (raw depth), the mask (visibility) or the camera depth that was drawn for it into memory. Waits for the
 * own device; for tests and tools.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (source, size), INVALID_INDEX (cascade), INVALID_STATE (nothing to
 * read yet), OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, DEVICE_LOST, UNSUPPORTED (an engine's device). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_read(csm_cascades *cascades, const csm_read_info *info);

typedef struct csm_cascade_stats {
  uint32_t casters_drawn;
  uint32_t casters_culled;
  uint64_t triangles_drawn;
  double gpu_ms; /* of the last frame with CSM_FRAME_TIMESTAMPS; negative if there was none */
} csm_cascade_stats;

typedef struct csm_stats {
  uint32_t struct_size;
  uint32_t cascade_count;
  uint64_t plan_hash; /* of everything the last frame's plan holds: equal on every backend */
  double plan_ms;     /* planning and culling of the last csm_render_cascades, on the CPU */
  double record_ms;   /* recording it, submission included on an own device */
  double clear_gpu_ms, camera_depth_gpu_ms, mask_gpu_ms; /* as csm_cascade_stats.gpu_ms */
  csm_cascade_stats cascades[CSM_MAX_CASCADES];
  uint64_t map_bytes;      /* device memory of these cascades' maps */
  uint64_t mask_bytes;     /* of their mask and camera depth */
  uint64_t geometry_bytes; /* of the context's meshes */
  uint64_t frame_bytes;    /* of the context's memory that changes per frame */
} csm_stats;

/*
 * Counts and times of the last csm_render_cascades and csm_resolve_mask. Waits for an own device; on an engine's the
 * GPU's times are those of the last retired frame that measured them. Errors: NULL_POINTER, STRUCT_SIZE, DEVICE_LOST.
 * [render-thread]
 */
CSM_API csm_result CSM_CALL csm_get_stats(csm_cascades *cascades, csm_stats *stats);

/*
 * Tells which instances of the last csm_render_cascades cast into which maps, and which were culled: drawn[i] gets bit
 * K for cascade K that drew instance i of the frame. What an engine's callback draws is not counted. Records nothing.
 * Preconditions: instance_count is that frame's.
 *   `drawn` has room for so many bytes; it may be NULL if there are none.
 * Errors: NULL_POINTER, INVALID_STATE (no maps have been drawn with this configuration yet), INVALID_VALUE (another
 * count), DEVICE_LOST. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_get_casters(csm_cascades *cascades, uint32_t instance_count, uint8_t *drawn);

#ifdef __cplusplus
}
#endif
#endif
