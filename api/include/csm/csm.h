/*
 * csm.h: cascaded shadow maps for an engine, on whichever backend is loaded.
 *
 *   once        csm_create, csm_mesh_create, csm_scene_create, csm_scene_add, csm_cascades_create, csm_view_create
 *   each frame  csm_scene_move, csm_render_cascades, then csm_resolve_mask or csm_bind
 *
 * Conventions: column vectors, column-major matrices (element [column * 4 + row]), world positions in doubles, metres,
 * radians. Clip z in [0,1], clip y up; texture coordinate v = 0 and texel row 0 are clip y = +1. A light's direction is
 * the way its light travels. View matrices take world to view. Projections may be perspective or orthographic,
 * off-centre, jittered, reversed-Z, with an infinite far plane or an oblique near one, of either handedness.
 *
 * Structs begin with struct_size = sizeof(the struct). A smaller size means that the missing tail is zero, which is
 * neutral; a larger one is accepted when its unknown tail is zero. Outputs are never written past the caller's size.
 *
 * Functions return a csm_result, but for csm_destroy and those that return text. An error leaves everything as it was
 * and has a text: csm_last_error, and the log callback. After CSM_ERROR_DEVICE_LOST only csm_switch_backend,
 * csm_retire, csm_last_error and the functions that destroy something work; all others answer CSM_ERROR_DEVICE_LOST.
 *
 * Threads: [any-thread] may be called at any time; [render-thread] one call at a time for one context, from any thread.
 * Contexts are independent of each other.
 *
 * Floating-point exceptions may trap (feenableexcept): csm's own arithmetic raises none of invalid, division by zero and
 * overflow, and what drivers open, create, record and wait for, and draw callbacks, run with traps off.
 */
#ifndef CSM_H
#define CSM_H

#include "csm_base.h"
#include "csm_config.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct csm_context csm_context;   /* a device, with geometry and programs on it */
typedef struct csm_scene csm_scene;       /* instances that stay from frame to frame */
typedef struct csm_cascades csm_cascades; /* one light seen from one camera: settings, maps, history */
typedef struct csm_view csm_view;         /* one picture: mask, own camera depth, depth samples */
typedef uint64_t csm_mesh;                /* a mesh of one context; 0 is none */
typedef uint64_t csm_alpha_mask;          /* an alpha mask of one context; 0 is none */
typedef uint64_t csm_instance_id;         /* an instance of one scene; 0 is none */

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
  /*
   * own device: turn the driver stack's validation on, messages go to the log. While such a context is called, no other
   * thread makes or destroys a Vulkan device: the Khronos layer looks its devices up without a lock.
   */
  CSM_CREATE_VALIDATE = 1u << 0,
  CSM_CREATE_KEEP_GEOMETRY = 1u << 1, /* keep a copy of every mesh in host memory, for csm_switch_backend */
  CSM_CREATE_RAYS = 1u << 2,          /* make a tree of every mesh, for filters exact and exact_soft */
  /*
   * own Vulkan device: name its objects and mark its passes, for captures and for validation's messages. Threads keep
   * to what CSM_CREATE_VALIDATE asks: loaders look a device up without a lock to name an object of it. Other devices
   * have names and marks without this flag: Direct3D 12's always, an engine's Vulkan device where its instance enables
   * VK_EXT_debug_utils.
   */
  CSM_CREATE_NAMES = 1u << 3
};

typedef struct csm_mesh_info csm_mesh_info;

/*
 * Gives a mesh's data again, for csm_switch_backend: fills `info`, whose struct_size is set, as for csm_mesh_create.
 * Preconditions: the shape (counts, index_size, flags, alpha mask) is what it was; the data stays readable until the
 * next call; csm is not called. Any result but CSM_SUCCESS ends the switch with INVALID_STATE.
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
 * never in the current folder. A path must lead to a regular file.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (flags, frame_slots, backend; what an engine's device says of
 * itself), BACKEND_NOT_FOUND, BACKEND_BROKEN, BACKEND_TOO_OLD, BACKEND_TOO_NEW, NO_DEVICE, UNSUPPORTED (an engine's
 * device that lacks what csm_query_backends says is required, or that belongs to the other API), OUT_OF_MEMORY,
 * OUT_OF_DEVICE_MEMORY, DEVICE. *context is NULL after an error. [any-thread]
 */
CSM_API csm_result CSM_CALL csm_create(const csm_create_info *info, csm_context **context);

/*
 * Waits for the own device, then destroys the context with all its meshes, scenes, cascades and views; NULL is allowed.
 * [render-thread]
 */
CSM_API void CSM_CALL csm_destroy(csm_context *context);

/*
 * Moves the context to another backend, or device, between two frames. The new device is opened completely, with all
 * meshes (from the context's copy, see CSM_CREATE_KEEP_GEOMETRY, or from `supply`), all alpha masks and the maps of all
 * cascades, or everything stays as it was. Meshes, scenes, cascades, views, settings and snapping carry on; maps and
 * masks are drawn anew by the next csm_render_cascades and csm_resolve_mask. What lies on an own device is freed at
 * once, after waiting for it; what lies on an engine's goes when csm_retire reaches its last frame: at once, if it has
 * done so. Works on a context whose device was lost. `info` is read as by csm_create, but for allocate, release, log,
 * user, supply, budget, CSM_CREATE_KEEP_GEOMETRY and CSM_CREATE_RAYS: those stay.
 * Errors: as csm_create, and INVALID_STATE (a mesh that has no copy and is not supplied), LIMIT_EXCEEDED (memory; what
 * the new device cannot do), and, with a mesh that is supplied, those of csm_mesh_create. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_switch_backend(csm_context *context, const csm_create_info *info);

/*
 * Engine's device: the GPU is done with every frame up to `frame`, whether csm recorded anything for it or not. Frees
 * what waited for that. At most frame_slots frames may be recorded and not retired, and a frame that is retired is not
 * recorded again. Errors: NULL_POINTER, UNSUPPORTED (an own device, which knows by itself), DEVICE,
 * DEVICE_LOST (reading times; what waited is freed all the same). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_retire(csm_context *context, uint64_t frame);

/* ---- alpha masks ---- */

enum { CSM_WRAP_REPEAT = 0, CSM_WRAP_CLAMP = 1, CSM_WRAP_MIRROR = 2 };

/* Where an alpha-tested mesh is: sampled bilinearly, at full resolution, whatever the distance. */
typedef struct csm_alpha_mask_info {
  uint32_t struct_size;
  uint32_t flags;          /* 0 */
  uint32_t width, height;  /* in texels: 1 to 16384, and what the device can do */
  uint32_t wrap_u, wrap_v; /* CSM_WRAP_* */
  const uint8_t *texels;   /* width * height bytes, 0 clear to 255 opaque; the row of v = 0 first; copied, and kept in
                              host memory for csm_switch_backend */
  uint32_t row_stride;     /* bytes from one row to the next; 0 means width */
  uint32_t reserved;       /* 0 */
  const char *name;        /* for debuggers; may be NULL */
} csm_alpha_mask_info;

/*
 * Copies an alpha mask into the context. It is uploaded by the next frame that is recorded.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (size, wrap, row_stride, flags), LIMIT_EXCEEDED, OUT_OF_MEMORY,
 * OUT_OF_DEVICE_MEMORY, DEVICE_LOST, DEVICE. *alpha_mask is 0 after an error. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_alpha_mask_create(csm_context *context, const csm_alpha_mask_info *info,
                                                  csm_alpha_mask *alpha_mask);

/*
 * Frees an alpha mask once no frame in flight uses it. Errors: NULL_POINTER, INVALID_HANDLE, INVALID_STATE (a mesh uses
 * it still). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_alpha_mask_destroy(csm_context *context, csm_alpha_mask alpha_mask);

/* ---- meshes ---- */

enum {
  CSM_MESH_TWO_SIDED = 1u << 0, /* casts from both sides, whatever csm_config.face_culling says: leaves, cloth */
  /* It has an inside: every edge joins two faces, counter-clockwise seen from outside. The faces turned away from the
     light are then behind others, and are not drawn with face_culling none: the maps are the same, and cost less. */
  CSM_MESH_WATERTIGHT = 1u << 1
};

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
  const void *uvs;    /* vertex_count times two floats, v = 0 at the mask's first row; NULL in an engine's buffers,
                         which say where theirs are */
  uint32_t uv_stride; /* bytes from one to the next, a multiple of 4; 0 means 8 */
  float alpha_cutoff; /* above 0, up to 1 */
};

/*
 * Copies a triangle mesh into the context, or takes in an engine's own buffers, which must stay until the mesh is
 * destroyed and its last frame retired. A copied one is uploaded by the next frame that is recorded. Copied positions
 * keep their precision however far from their own origin they lie, and triangles of theirs that are lines or points draw
 * nothing until an update; those in an engine's buffers are read as they are.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (counts, stride, index_size, flags, bounds, uv_stride, alpha_cutoff;
 * buffers of two APIs), INVALID_INDEX (an index not below vertex_count), INVALID_HANDLE (alpha_mask), NOT_FINITE (a
 * position, a uv, the bounds), UNSUPPORTED (buffers of the other API), LIMIT_EXCEEDED (memory; more than 32 pairs of
 * strides of vertices and uvs in the life of the device), OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, DEVICE_LOST, DEVICE.
 * *mesh is 0 after an error. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_mesh_create(csm_context *context, const csm_mesh_info *info, csm_mesh *mesh);

/* New places for the vertices of a mesh, whose triangles stay. */
typedef struct csm_mesh_update_info {
  uint32_t struct_size;
  uint32_t flags;           /* 0 */
  const void *positions;    /* vertex_count of the mesh times three floats; copied. NULL: an engine's buffers */
  uint32_t position_stride; /* bytes from one to the next, a multiple of 4; 0 means 12 */
  uint32_t reserved;        /* 0 */
  float bounds_min[3], bounds_max[3]; /* an engine's buffers: the new bounds */
} csm_mesh_update_info;

/*
 * Moves the vertices of a mesh: skinned, morphed or edited geometry of the same topology. The next recording uploads
 * them; frames that were recorded before draw what they had, and nothing waits. All instances of the mesh count as
 * moved. For a mesh in an engine's buffers it says that their content has changed.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_HANDLE, INVALID_VALUE (stride, flags, bounds), NOT_FINITE, LIMIT_EXCEEDED,
 * OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, DEVICE_LOST, DEVICE. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_mesh_update(csm_context *context, csm_mesh mesh, const csm_mesh_update_info *info);

/*
 * Frees a mesh once no frame in flight that csm recorded uses it. With CSM_CREATE_RAYS: what sends rays by cascades that
 * drew the mesh, csm_resolve_mask or an engine's shader, is recorded before this, or after csm_render_cascades has
 * recorded them anew; in between it may miss the mesh's shadow. Errors: NULL_POINTER, INVALID_HANDLE, INVALID_STATE (an
 * instance of a scene uses it still). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_mesh_destroy(csm_context *context, csm_mesh mesh);

/* ---- scenes ---- */

enum {
  CSM_INSTANCE_CAST_ONLY = 1u << 0,    /* it casts, and no camera sees it: it is not drawn into a view's own depth */
  CSM_INSTANCE_RECEIVE_ONLY = 1u << 1, /* cameras see it, and it casts nothing */
  CSM_INSTANCE_HIDDEN = 1u << 2        /* neither, for now */
};

typedef struct csm_instance {
  uint32_t struct_size;
  uint32_t flags; /* CSM_INSTANCE_*; not both CAST_ONLY and RECEIVE_ONLY */
  csm_mesh mesh;
  double transform[16]; /* object to world: affine. One that is scaled to nothing draws nothing. */
  uint32_t layers;      /* bits; it casts for a light that shares one. 0: all layers */
  uint32_t reserved;    /* 0 */
} csm_instance;

/* Makes an empty scene. Errors: NULL_POINTER, OUT_OF_MEMORY, DEVICE_LOST. *scene is NULL after an error.
 * [render-thread] */
CSM_API csm_result CSM_CALL csm_scene_create(csm_context *context, csm_scene **scene);

/* Frees a scene with its instances; NULL is allowed. Its meshes stay. Always CSM_SUCCESS. [render-thread] */
CSM_API csm_result CSM_CALL csm_scene_destroy(csm_scene *scene);

/*
 * Instances of a scene, by the thousand. Transforms are those of `instances`, unless `matrices` or `rows` gives them:
 * at most one of these two.
 */
typedef struct csm_scene_batch {
  uint32_t struct_size;
  uint32_t count;
  csm_instance_id *ids;          /* csm_scene_add: receives them; else: which instances; of one that comes twice
                                    the last stays */
  const csm_instance *instances; /* all of one struct_size; csm_scene_move: NULL */
  const double *matrices;        /* count times 16: object to world, column-major */
  const float *rows;             /* count times 12: object to world relative to `origin`, three rows of four */
  double origin[3];              /* of `rows` */
} csm_scene_batch;

/*
 * These change many instances of a scene at once, or, after an error, none. What was not touched costs nothing in the
 * next frame: csm knows by itself what moved.
 *   csm_scene_add     makes instances
 *   csm_scene_move    gives them other transforms
 *   csm_scene_change  gives them other meshes, flags, layers and transforms
 *   csm_scene_remove  removes them; ids are not given out again
 * Errors: NULL_POINTER, STRUCT_SIZE (of an instance: one that ends before its transform does, too), INVALID_HANDLE (an
 * id or a mesh; an id that is removed twice), INVALID_VALUE (flags, reserved, two kinds of transforms), NOT_FINITE,
 * INVALID_MATRIX (a transform that is not affine, or has numbers above 1e30), LIMIT_EXCEEDED (more than 2^31 - 2
 * instances), OUT_OF_MEMORY, DEVICE_LOST. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_scene_add(csm_scene *scene, const csm_scene_batch *batch);
CSM_API csm_result CSM_CALL csm_scene_move(csm_scene *scene, const csm_scene_batch *batch);
CSM_API csm_result CSM_CALL csm_scene_change(csm_scene *scene, const csm_scene_batch *batch);
CSM_API csm_result CSM_CALL csm_scene_remove(csm_scene *scene, uint32_t count, const csm_instance_id *ids);

/* ---- cascades ---- */

/*
 * Makes the cascades of one light seen from one camera, with their maps.
 * Errors: NULL_POINTER, STRUCT_SIZE, NOT_FINITE, INVALID_VALUE (a field out of range, named in the text; manual splits
 * that do not rise; a budget that no maps keep), UNSUPPORTED (polygon_offset_clamp on a device without depthBiasClamp;
 * moments or rays on one that cannot compute or store them), INVALID_STATE (filter exact or exact_soft without
 * CSM_CREATE_RAYS), LIMIT_EXCEEDED (resolution or memory), OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, DEVICE_LOST, DEVICE.
 * *cascades is NULL after an error.
 * [render-thread]
 */
CSM_API csm_result CSM_CALL csm_cascades_create(csm_context *context, const csm_config *config,
                                                csm_cascades **cascades);

/*
 * Changes the settings. Maps are made anew only if their shape changes; the light's roll carries on.
 * Errors: as csm_cascades_create. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_cascades_configure(csm_cascades *cascades, const csm_config *config);

/* Frees the cascades once no frame in flight uses them; NULL is allowed. Always CSM_SUCCESS. [render-thread] */
CSM_API csm_result CSM_CALL csm_cascades_destroy(csm_cascades *cascades);

/* ---- views ---- */

/*
 * Makes a view: what belongs to one picture. Two pictures that share cascades (two eyes, split screen, a reflection)
 * have a view each. Its images are made by csm_resolve_mask, in the size asked for there.
 * With csm_config.depth_samples, cascades are fitted to what their views saw: those that were resolved with them in the
 * last 8 csm_render_cascades, with a camera like that of the cascades (the same kind of projection, and turned and
 * moved by no more than depth_samples_margin). Other views, a reflection say, are left out, and what they alone see may
 * lie outside the maps. A view that saw another picture than the cascades' camera sees now, as after a cut, leaves the
 * frame unfitted.
 * Errors: NULL_POINTER, OUT_OF_MEMORY, DEVICE_LOST. *view is NULL after an error. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_view_create(csm_context *context, csm_view **view);

/* Frees a view once no frame in flight uses it; NULL is allowed. Always CSM_SUCCESS. [render-thread] */
CSM_API csm_result CSM_CALL csm_view_destroy(csm_view *view);

/* ---- frames ---- */

enum { CSM_REVERSED_BY_MATRIX = 0, CSM_REVERSED_YES = 1, CSM_REVERSED_NO = 2 };

typedef struct csm_camera {
  uint32_t struct_size;
  uint32_t reversed; /* CSM_REVERSED_*: whether clip z is 1 at the near plane. A matrix says so by itself, but for an
                        orthographic one whose near plane lies behind the camera: that one must be told. */
  double view[16];   /* world to view: a rotation and a translation, mirrored or not */
  double projection[16]; /* view to clip */
} csm_camera;

typedef struct csm_light {
  uint32_t struct_size;
  uint32_t layers;         /* bits: which instances cast for it. 0: all */
  double direction[3];     /* of travel; any length but 0 */
  double angular_diameter; /* radians, 0 to 1, as seen from the ground: 0.00925 for the sun. 0: a point at infinity.
                              Filters pcss, vssm and backprojection read it. */
} csm_light;

/* What a draw callback draws into: known before the first frame, so that pipelines can be built. */
typedef struct csm_draw_target {
  uint32_t struct_size;
  uint32_t depth_format;      /* VkFormat or DXGI_FORMAT of the target; there is no colour, one sample */
  uint64_t render_pass;       /* VkRenderPass that the pass is compatible with, subpass 0. 0: D3D12, and dynamic
                                 rendering */
  uint32_t dynamic_rendering; /* Vulkan: 1 if the pass is begun by vkCmdBeginRendering */
  uint32_t reversed;          /* 1: depth is larger nearer the light, and compared with greater */
} csm_draw_target;

/*
 * Tells what a draw callback will draw into with the present configuration. It changes with csm_cascades_configure
 * (map_format, map_reversed) and csm_switch_backend alone.
 * Errors: NULL_POINTER, STRUCT_SIZE, OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, DEVICE_LOST, DEVICE. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_get_draw_target(csm_cascades *cascades, csm_draw_target *target);

/* What a draw callback gets for each cascade. */
typedef struct csm_draw_info {
  uint32_t struct_size;
  uint32_t cascade;
  uint32_t resolution;   /* of the cascade's map, whose viewport and scissor are set; a budget may change it */
  uint32_t depth_format; /* this and the next two as in csm_draw_target */
  uint64_t render_pass;
  uint32_t dynamic_rendering;
  uint32_t reversed;
  double world_to_clip[16]; /* affine; depth outside [0,1] must be clamped, not clipped; it is smaller nearer the light,
                               unless `reversed` */
  double planes[5][4];      /* world space: what may cast into the map has dot(p, xyz) + w >= 0 for some point, for each
                               plane: left, right, bottom, top, far; towards the light it is open */
  void *command_buffer;     /* VkCommandBuffer or ID3D12GraphicsCommandList*, inside the cascade's pass */
  uint64_t depth_view;      /* D3D12: CPU descriptor of the depth view that is set; 0 on Vulkan */
  uint32_t x, y;            /* texel of the target at which the map begins: not 0 in an atlas */
} csm_draw_info;

/*
 * Draws casters of the engine's own into a cascade's map, after the frame's instances. It may change pipeline,
 * bindings, buffers and dynamic state, and must leave the pass open. Must not call back into csm.
 */
typedef void(CSM_CALL *csm_draw_function)(void *user, const csm_draw_info *info);

enum {
  CSM_FRAME_TIMESTAMPS = 1u << 0, /* measure the passes on the GPU; each pass then waits for the one before it */
  /* Visibility is asked for on this frame's receivers alone, as it always is on own devices. With caster_set VIEW what
     shades none of them that the camera sees is left out of the maps. */
  CSM_FRAME_RECEIVERS = 1u << 1
};

typedef struct csm_frame {
  uint32_t struct_size;
  uint32_t flags;       /* CSM_FRAME_* */
  uint64_t frame;       /* engine's device: the frame's number from 1 on, never falling; several calls may share it;
                           see csm_retire. Else 0 */
  void *command_buffer; /* engine's device: its VkCommandBuffer or ID3D12GraphicsCommandList*; else NULL */
  const csm_camera *camera;
  const csm_light *light;
  const double *origin;          /* the world position, three doubles, that csm_binding.constants are relative to; NULL:
                                    the camera's. Shaders lose precision with the distance between the two. */
  csm_scene *scene;              /* casters and receivers that stay; or NULL */
  const csm_instance *instances; /* the simple way, without a scene: all of them, each frame; all of one struct_size */
  uint32_t instance_count;
  uint32_t reserved;      /* 0 */
  csm_draw_function draw; /* engine's device: called for each cascade; may be NULL, and is with map_layout pages */
  void *draw_user;
  /*
   * A view whose csm_reduce_depth looked with this camera, at this scene as it is. With caster_set VIEW, what shades none
   * of the surfaces that it saw is left out of the maps, and masks of these maps are of its camera and size. NULL: what
   * the camera sees is not known. csm_render_cascades alone reads it.
   */
  csm_view *depth_view;
} csm_frame;

/*
 * Plans the frame and draws every cascade's map. On an own device the work is submitted, and runs on after the return;
 * on an engine's it is recorded into command_buffer, uploads included. A camera whose near plane lies beyond the shadow
 * distance has no shadows: no map is drawn, csm_bind gives constants by which every point is out of range, and csm_read
 * gives what the maps held before, or empty ones.
 * Errors: NULL_POINTER (command_buffer too), STRUCT_SIZE, NOT_FINITE, INVALID_VALUE (flags, reserved, command_buffer,
 * frame; a scene and instances; an instance's flags; csm_camera.reversed; angular_diameter; an origin beyond 1e30),
 * INVALID_MATRIX (view or an instance's transform not affine, or with numbers above 1e30, view or projection
 * singular), INVALID_CAMERA, INVALID_LIGHT, INVALID_HANDLE (an instance's mesh; a scene of another context),
 * INVALID_STATE (frame_slots frames are not retired yet; depth_view has reduced no depth on this device, its frame is
 * not retired yet, or the scene has changed since), INVALID_VALUE and INVALID_HANDLE (depth_view saw another camera or
 * scene; a view of another context), UNSUPPORTED (draw on an own device, or with map_layout pages), OUT_OF_MEMORY,
 * OUT_OF_DEVICE_MEMORY, LIMIT_EXCEEDED, DEVICE_LOST, DEVICE.
 * [render-thread]
 */
CSM_API csm_result CSM_CALL csm_render_cascades(csm_cascades *cascades, const csm_frame *frame);

/*
 * What a mask shows. All but visibility are for people who look into shadows that are not as they should be; they are 0
 * where nothing is and past the last cascade, and take surfaces' normals from the depth.
 */
enum {
  CSM_SHOW_VISIBILITY = 0,
  CSM_SHOW_CASCADE = 1,  /* (cascade + 1) / 255, of the cascade that the point takes by `selection`: where two blend, of
                            the nearer one, and where blending is dithered, of the one that the point got */
  CSM_SHOW_DENSITY = 2,  /* texels of that cascade's map for a pixel: (128 + 16 * log2(n)) / 255, the sum rounded and
                            clamped to 1..255. n is the larger of the two distances in the map, in texels, that the point
                            moves by from this pixel to the next one along a row and along a column of the mask, on its
                            own surface: 1 is one texel for each pixel, less is coarse, more is wasted */
  CSM_SHOW_PENUMBRA = 3, /* filters pcss, vssm and backprojection: the radius of the penumbra that the filter found, in
                            texels of the cascade that CSM_SHOW_CASCADE tells, on the scale of CSM_SHOW_DENSITY: it is
                            2^((255 v - 128) / 16) texels for what the mask holds, v, from 1/245 to 245. 0 too where
                            nothing lies before the light. What is more than soft_radius_max_texels is filtered with
                            that, what is less than soft_radius_least_texels with this */
  CSM_SHOW_HISTORY = 4,  /* with csm_config.history: how many frames the pixel of the mask is the mean of, as n / 255.
                            The mask is accumulated as it is for visibility */
  CSM_SHOW_RAYS = 5,     /* filters exact and exact_soft: how many nodes of trees the pixel's rays looked at, as
                            (1 + 16 * log2(n)) / 255, rounded and clamped to 1..255; 0 where the map decided */
  CSM_SHOW_PAGES = 6     /* with map_layout pages: the cascade, as CSM_SHOW_CASCADE has it, and which of its pages the
                            point lies in: (1 + 16 cascade + 4 (column mod 4) + row mod 4) / 255, counted in the cascade's
                            layer from the top left. A place in the world keeps its page while the camera moves */
};

typedef struct csm_mask_info {
  uint32_t struct_size;
  uint32_t flags;         /* CSM_FRAME_* */
  const csm_frame *frame; /* the camera that sees the mask, its command buffer, and, without camera_depth, the scene or
                             instances that it sees; its light, origin and draw are not read */
  uint32_t width, height; /* of the mask, in pixels: 1 to 16384, and what the device can do */
  const void *camera_depth; /* engine's device: its depth image (csm_vulkan_image, csm_d3d12_image), of this size and
                               drawn with this camera: it is as precise as its projection makes it. NULL draws what the
                               frame has, in reversed depth, whatever the projection */
  const void *normals;      /* engine's device: world-space unit normals, likewise; floats as they are, or normalised
                               integers from 0 for -1 to the largest for 1; NULL takes them from the depth */
  uint32_t show;            /* CSM_SHOW_* */
  uint32_t reserved;        /* 0 */
  const void *motion;       /* engine's device: where the surface of each pixel was in the view's picture before, less
                               where it is now, as shares of the picture's width and height, right and down; an image
                               of two floats, of this size. NULL: it has not moved. Read with csm_config.history */
} csm_mask_info;

/*
 * Looks at this frame's depth, before the maps are drawn, for csm_frame.depth_view: `info` is that of the mask to come,
 * of which the camera, the scene, the size and camera_depth are read. Without camera_depth csm draws the depth, and
 * csm_resolve_mask does not draw it again for the same view, camera, size and scene. What was seen is known once the
 * recording is done: csm_render_cascades waits for an own device. An engine submits what was recorded under a frame's
 * number of its own, waits, and calls csm_retire; csm_render_cascades comes under a later number.
 * What a view saw counts until its next csm_reduce_depth, for cascades of any light, as long as the scene stays as it was.
 * Errors: as csm_resolve_mask, and INVALID_VALUE (instances in place of a scene). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_reduce_depth(csm_view *view, const csm_mask_info *info);

/*
 * Resolves a screen-space mask (1 lit, 0 shadowed; 1 where nothing is) from the maps that csm_render_cascades drew
 * last, with the selection, filter and bias of the configuration. A view holds the last mask that was resolved for it.
 * With csm_config.history each is a frame of the view's history, and the mask the mean of what its frames saw of each
 * surface; a plain one where no shadow can have moved since the mask before. It begins anew with another size, with other
 * cascades or another configuration, and with another device.
 * A device's first mask of a kind makes its program, which takes a while.
 * Errors: as csm_render_cascades, and INVALID_VALUE (show: no such one; a history that is not kept; a penumbra of a filter
 * that finds none; another camera or size than that of the depth that the maps were drawn for), INVALID_STATE (no maps have been drawn with this configuration yet),
 * INVALID_HANDLE (a view of another context). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_resolve_mask(csm_view *view, csm_cascades *cascades, const csm_mask_info *info);

/* ---- what came of it ---- */

typedef struct csm_cascade_info {
  double near_depth;          /* view depth where the slice begins, in metres */
  double far_depth;           /* and ends */
  double texel_size;          /* in metres */
  double depth_range;         /* metres along the light from depth 0 to depth 1 */
  double world_to_shadow[16]; /* world to texture coordinates and depth; with map_layout pages those of the map, which
                                 begins within its layer and goes on at the other side: use the includes, or a mask */
} csm_cascade_info;

typedef struct csm_binding {
  uint32_t struct_size;
  uint32_t cascade_count;
  csm_view *view;   /* in: whose mask to tell of; may be NULL */
  double origin[3]; /* world position that the constants are relative to */
  csm_cascade_info cascades[CSM_MAX_CASCADES];
  uint32_t resolutions[CSM_MAX_CASCADES]; /* of each cascade's map, texels a side */
  /* The two blocks of shaders/include/csm_constants.h, as bytes to copy. They stay until the next csm_render_cascades,
     csm_cascades_configure or csm_cascades_destroy. */
  const void *cascade_constants; /* csm_cascades_block */
  const void *setting_constants; /* csm_settings_block, and csm_rays_block after it */
  uint32_t cascade_constants_size;
  uint32_t setting_constants_size; /* it grows with csm, at its end */
  uint64_t native_maps;            /* VkImage, or ID3D12Resource*: the array of maps, readable by shaders */
  uint64_t native_maps_view;       /* Vulkan: VkImageView, 2D array, depth; D3D12: 0 */
  uint64_t native_sampler;         /* Vulkan: VkSampler that compares: linear, clamped (with map_layout pages
                                      repeated), less or equal, or with map_reversed greater or equal; D3D12: 0 */
  uint64_t native_mask;            /* as native_maps, the view's mask; 0 without a view, or before its first mask */
  uint64_t native_mask_view;       /* Vulkan: VkImageView, 2D; D3D12: 0 */
  uint64_t maps_descriptor;        /* in, D3D12: D3D12_CPU_DESCRIPTOR_HANDLE.ptr that gets a view of the maps; or 0 */
  uint64_t mask_descriptor;        /* in, D3D12: likewise of the mask, if there is one */
  uint64_t native_moments;         /* as native_maps, the array of moments; 0 with a filter that reads none */
  uint64_t native_moments_view;    /* Vulkan: VkImageView, 2D array of all levels; D3D12: 0 */
  uint64_t native_moments_sampler; /* Vulkan: VkSampler: linear, also between levels, clamped; D3D12: 0 */
  uint64_t moments_descriptor;     /* in, D3D12: as maps_descriptor, of the moments, if there are any */
  /* What rays look up, with filters exact and exact_soft; with another filter 0. Two buffers of rows of four 32-bit whole
     numbers, each read as the engine likes: as a texel buffer (GLSL: usamplerBuffer or utextureBuffer, on a VkBufferView of
     VK_FORMAT_R32G32B32A32_UINT; HLSL: Buffer<uint4>, on a shader resource view of DXGI_FORMAT_R32G32B32A32_UINT), which
     a rasteriser on a CPU reads twice as fast; or as a structured one (GLSL: a std430 uvec4[], if the size is at most
     maxStorageBufferRange; HLSL: StructuredBuffer<uint4>, format UNKNOWN, StructureByteStride 16). NumElements is
     size / 16. Bind all of each. They are readable by vertex, pixel
     and compute shaders once csm has recorded. D3D12: in state COMMON, out of which reading promotes them; a command list
     that csm records into again has brought them back to it. csm_mesh_create, csm_mesh_update and csm_render_cascades
     change them with what is recorded next: render, and bind anew in each frame. */
  uint64_t native_ray_meshes;    /* VkBuffer, or ID3D12Resource*: the meshes' trees; where no mesh has one, the other
                                    buffer, of which no row is read for it */
  uint64_t native_ray_instances; /* likewise: the instances' tree */
  uint64_t ray_meshes_size;      /* in bytes */
  uint64_t ray_instances_size;
} csm_binding;

/*
 * Fills in what an engine's shaders need for the maps that were drawn last; records nothing.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_STATE (no maps yet), INVALID_HANDLE (a view of another context),
 * DEVICE_LOST. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_bind(csm_cascades *cascades, csm_binding *binding);

enum {
  CSM_READ_MAP = 0,  /* raw depth */
  CSM_READ_MASK = 1, /* visibility */
  CSM_READ_CAMERA_DEPTH =
      2,                   /* that csm drew for the mask: clip depth by the frame's projection, as its own depth buffer
                                would hold it; 1 where nothing is, or, if depth is reversed, 0 */
  CSM_READ_VIEW_DEPTH = 3, /* the same as view depth in metres, which loses nothing; INFINITY where nothing is */
  CSM_READ_MOMENTS = 4     /* of a cascade: 1 (ESM), 2 or 4 floats a texel; layers of depth one after the other */
};

typedef struct csm_read_info {
  uint32_t struct_size;
  uint32_t source;         /* CSM_READ_* */
  csm_cascades *cascades;  /* CSM_READ_MAP, CSM_READ_MOMENTS: whose */
  csm_view *view;          /* else: whose */
  uint32_t cascade;        /* CSM_READ_MAP, CSM_READ_MOMENTS: which */
  uint32_t reserved;       /* 0 */
  float *data;             /* receives one float a texel, or all of its moments; top row first, without gaps */
  uint64_t size;           /* bytes at data; exactly width * height * 4, times the moments of a texel */
  uint32_t level;          /* CSM_READ_MOMENTS: of moment_levels, each half as wide as the one before; else 0 */
  uint32_t reserved_level; /* 0 */
} csm_read_info;

/*
 * Reads a map, a mask or the camera depth that was drawn for it into memory. Waits for the own device; for tests and
 * tools.
 * Errors: NULL_POINTER, STRUCT_SIZE, INVALID_VALUE (source, size), INVALID_INDEX (cascade, level), INVALID_HANDLE (of another
 * context), INVALID_STATE (nothing to read yet), OUT_OF_MEMORY, OUT_OF_DEVICE_MEMORY, DEVICE_LOST, DEVICE,
 * UNSUPPORTED (an engine's device). [render-thread]
 */
CSM_API csm_result CSM_CALL csm_read(csm_context *context, const csm_read_info *info);

typedef struct csm_cascade_stats {
  uint32_t casters_drawn;
  uint32_t casters_culled;
  uint64_t triangles_drawn;
  double gpu_ms; /* of the last frame with CSM_FRAME_TIMESTAMPS; negative if there was none */
} csm_cascade_stats;

/* By what a frame knows which cells of its maps are read, of 64 x 64 of each: casters over no such cell are left out. */
enum {
  CSM_CELLS_ALL = 0,       /* it does not */
  CSM_CELLS_RECEIVERS = 1, /* by the boxes of all receivers that its camera may see */
  CSM_CELLS_DEPTH = 2      /* by csm_frame.depth_view */
};

typedef struct csm_stats {
  uint32_t struct_size;
  uint32_t cascade_count;
  uint64_t plan_hash;  /* of everything the last frame's plan holds: equal on every backend. 0 if there was none, or its
                          scene, or a mesh of its list, has changed since */
  double plan_ms;      /* planning and culling of the last csm_render_cascades, on the CPU */
  double record_ms;    /* recording it, submission included on an own device */
  double clear_gpu_ms; /* as csm_cascade_stats.gpu_ms; with map_layout pages, making those without what moves, too */
  csm_cascade_stats cascades[CSM_MAX_CASCADES];
  uint64_t map_bytes;         /* device memory of these cascades' maps */
  uint64_t geometry_bytes;    /* of the context's meshes */
  uint64_t frame_bytes;       /* of the context's memory that changes per frame */
  uint32_t instances;         /* that the last frame's scene or list held */
  uint32_t instances_changed; /* that came, moved, changed or went since these cascades' frame before; of a list, or of
                                 another scene than before, all */
  double moments_gpu_ms;      /* as csm_cascade_stats.gpu_ms: making and blurring moments */
  uint64_t moment_bytes;   /* device memory of the moments of these cascades' maps, and of what they are blurred in */
  uint64_t tree_bytes;     /* device memory of what rays look up: trees of the context's meshes, and of instances */
  double mesh_trees_ms;    /* making the trees of the context's meshes, all together, on the CPU */
  double instance_tree_ms; /* bringing the instances' tree up to date in the last csm_render_cascades */
  uint32_t pages_drawn;    /* with map_layout pages: of all maps, those that the last frame drew */
  uint32_t pages_valid;    /* and those that then hold what they would if they were drawn */
  uint32_t pages_copied;   /* of pages_drawn: copied without what keeps moving, which was drawn over them */
  uint32_t reserved;       /* 0 */
  double ranges_gpu_ms;    /* as csm_cascade_stats.gpu_ms: with filter exact_soft, finding how near to the light casters
                              lie around each place; 0 if that was known */
  uint64_t range_bytes;    /* device memory of that */
  uint32_t cells_by;       /* CSM_CELLS_*, of the last frame */
  uint32_t cells_read;     /* of all maps; 0 with CSM_CELLS_ALL, but with map_layout pages */
  double budget_ms_predicted;    /* with a budget of time: of maps and mask as they are; negative: not known yet */
  double budget_wrong_predicted; /* with one of error: the share of wrong pixels; negative: not known yet */
  uint32_t budget_side;          /* of the first cascade's map, in texels, as a budget has it now; 0 without a budget */
  uint32_t budget_missed;        /* CSM_BUDGET_*: targets that the coarsest, or the finest, maps miss */
  char budget_text[160];         /* what a budget gave up, and why, in words; "" without one */
} csm_stats;

/*
 * Counts and times of the last csm_render_cascades. Waits for an own device; on an engine's the GPU's times are those
 * of the last retired frame that measured them. Errors: NULL_POINTER, STRUCT_SIZE, DEVICE_LOST, DEVICE. [render-thread]
 */
CSM_API csm_result CSM_CALL csm_get_stats(csm_cascades *cascades, csm_stats *stats);

typedef struct csm_view_stats {
  uint32_t struct_size;
  uint32_t width, height; /* of the last mask, in pixels; 0 before the first */
  uint32_t reserved;
  double camera_depth_gpu_ms, mask_gpu_ms; /* as csm_cascade_stats.gpu_ms */
  uint64_t bytes;                          /* device memory of mask, own camera depth, depth samples and history */
  double history_gpu_ms;                   /* as csm_cascade_stats.gpu_ms */
  uint64_t history_bytes;                  /* of `bytes`, those of the history */
  double rays_gpu_ms;      /* as csm_cascade_stats.gpu_ms: filters exact and exact_soft, after the mask */
  uint32_t ray_pixels;     /* of the last mask that the GPU is done with: pixels that sent rays, 0 by other filters */
  uint32_t ray_map_pixels; /* and those of them that the map decided: their rays passed casters that cannot be traced */
  uint64_t ray_nodes;      /* of the last CSM_SHOW_RAYS: nodes that all rays looked at, to 16 a pixel */
  uint64_t ray_triangles;  /* and triangles */
  double reduce_gpu_ms;    /* as csm_cascade_stats.gpu_ms: csm_reduce_depth, without drawing the depth */
} csm_view_stats;

/* The same of a view's last csm_resolve_mask. Errors: NULL_POINTER, STRUCT_SIZE, DEVICE_LOST, DEVICE.
 * [render-thread] */
CSM_API csm_result CSM_CALL csm_get_view_stats(csm_view *view, csm_view_stats *stats);

/*
 * Tells which instances of the last csm_render_cascades cast into which maps, and which were culled: drawn[i] gets bit
 * K for cascade K that drew instance i. What an engine's callback draws is not counted. Records nothing.
 * Preconditions: `ids` are of the scene that was drawn, and `count` of them; or NULL, and `count` is that of the list.
 *   `drawn` has room for `count` bytes; it may be NULL if there are none.
 * Errors: NULL_POINTER, INVALID_STATE (no maps have been drawn with this configuration yet; the scene has changed
 * since), INVALID_HANDLE (an id), INVALID_VALUE (another count; ids without a scene, or none with one), DEVICE_LOST.
 * [render-thread]
 */
CSM_API csm_result CSM_CALL csm_get_casters(csm_cascades *cascades, uint32_t count, const csm_instance_id *ids,
                                            uint8_t *drawn);

#ifdef __cplusplus
}
#endif
#endif
