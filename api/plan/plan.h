/*
 * plan.h: what a frame of cascades needs, computed in doubles from what the engine says. Pure: no GPU, no I/O, no
 * globals, no allocation. The same plan, byte for byte, serves every backend.
 *
 * A plan is made in two steps. plan_frame_make computes the cascades and which instances each one draws, into memory
 * of the caller's. plan_write_* then write the floats that shaders read, wherever the caller wants them.
 *
 * No function raises a floating-point exception other than inexact and underflow.
 */
#ifndef PLAN_H
#define PLAN_H

#include "csm/csm.h"
#include <stdbool.h>

/* ---- matrices: column-major doubles, element [column * 4 + row] ---- */
void plan_multiply(double out[16], const double a[16], const double b[16]); /* out may not alias */
bool plan_invert(double out[16], const double m[16]);                       /* false: singular; any scale is fine */
bool plan_finite(const double *values, uint32_t count); /* raises no floating-point exception, whatever comes in */
bool plan_finite_floats(const float *values, uint32_t count);
/* CSM_SUCCESS, NOT_FINITE, or INVALID_MATRIX: the last row is not 0 0 0 1, or the columns are dependent. */
csm_result plan_check_affine(const double m[16]);

/* ---- camera ---- */
typedef struct plan_camera {
  double view[16], projection[16];
  double position[3]; /* world: the view's origin, whatever the projection */
  double forward[3];  /* world: unit, the way it looks */
  double near_depth;  /* view depth (distance along forward) of the near plane; the least of an oblique one */
  double far_depth;   /* INFINITY for an infinite far plane */
  bool reversed;      /* clip z is 1 at the near plane */
  bool orthographic;
  bool oblique; /* a perspective whose near and far planes are not across the view: they cut other planes out of it */
} plan_camera;
/*
 * `reversed` is CSM_REVERSED_*. A perspective matrix tells it, and so does an orthographic one whose near and far plane
 * lie on one side of the camera. Any other orthographic matrix needs to be told.
 * CSM_SUCCESS; NOT_FINITE; INVALID_MATRIX (view not affine or not rigid up to a mirroring, projection singular);
 * INVALID_CAMERA (near >= far, no usable near plane, a projection that is neither perspective nor orthographic along
 * view z, one that does not tell whether it is reversed or says otherwise than `reversed`, numbers too large);
 * INVALID_VALUE (`reversed`). `error` gets a sentence.
 */
csm_result plan_camera_make(plan_camera *out, const double view[16], const double projection[16], uint32_t reversed,
                            const char **error);

/* ---- light ---- */
/* Rows right, up, along: orthonormal to 1e-15, for every direction; `along` is the normalised direction of travel. */
csm_result plan_light_basis(double basis[9], const double direction[3], const char **error);

/* ---- configuration ---- */
/* CSM_SUCCESS, NOT_FINITE or INVALID_VALUE; `error` names the field. Only ranges: not what a device can do. */
csm_result plan_config_check(const csm_config *config, const char **error);
/* Describes field `index` of csm_config; NULL past the last one. */
const csm_config_field *plan_config_field(uint32_t index);
void plan_config_default(csm_config *config);
/* Whether the configured filter reads moments of the maps' depths, or looks at the size of the light. */
bool plan_has_moments(const csm_config *config);
bool plan_is_soft(const csm_config *config);
/* Whether rays decide where maps do not. */
bool plan_has_rays(const csm_config *config);
/* Whether masks search for blockers by the nearest depths around a place. */
bool plan_has_ranges(const csm_config *config);
/* Whether pixels of a mask share what their rays found. */
bool plan_shares_rays(const csm_config *config);
/* Whether maps are made of pages that stay. */
bool plan_has_pages(const csm_config *config);
/* Texels around a sample that the configured filter may read. */
uint32_t plan_filter_radius_texels(const csm_config *config);
/* The side of a cascade's map, in texels. */
uint32_t plan_resolution(const csm_config *config, uint32_t cascade);

/* Where a cascade's map lies: a square of an image's layer. */
typedef struct plan_rect {
  uint32_t x, y, side, layer;
} plan_rect;

typedef struct plan_layout {
  uint32_t width, height, layers;
  plan_rect rects[CSM_MAX_CASCADES];
} plan_layout;

/* Lays out the maps of a checked configuration. */
void plan_layout_make(plan_layout *out, const csm_config *config);

/* The image of a configuration's moments: an array, whose layer cascade * depth_layers + k holds slice k of a cascade's
   depth range in its top left corner. */
typedef struct plan_moments {
  uint32_t channels, depth_layers, levels;
  uint32_t side;                    /* of the image */
  uint32_t sides[CSM_MAX_CASCADES]; /* of each cascade's corner */
} plan_moments;

/* Precondition: plan_has_moments. */
void plan_moments_make(plan_moments *out, const csm_config *config);
/* The weights of a separable blur, 2 * moment_blur_texels + 1 of them, whose sum is 1. */
void plan_blur_weights(double *weights, const csm_config *config);

/* ---- a scene ---- */
/* Numbers of a transform, and places in the world, may be so large, in metres. */
#define PLAN_LARGEST 1e30

typedef struct plan_bounds { /* of a mesh, in object space */
  double center[3], extent[3];
  /*
   * Positions are stored less this, which instance matrices add again. Each is 0, or a float so near to all positions
   * along its axis that the difference is exact in floats.
   */
  double offset[3];
} plan_bounds;

/* Triangles of a mesh that lie together, and may be drawn without its others. */
typedef struct plan_part {
  double center[3], extent[3]; /* in object space: a box around all of them */
  uint32_t first_index;
  uint32_t index_count; /* 0: none of them covers anything, though an engine may find pixels in them */
} plan_part;

enum { PLAN_MOST_PARTS = 64 };

/* All of a mesh's, one after the other in its indices. */
typedef struct plan_parts {
  const plan_part *parts;
  uint32_t count; /* 0: the mesh is whole */
} plan_parts;

/* Fills in center, extent and offset. Preconditions: finite, low <= high. */
void plan_bounds_make(plan_bounds *out, const float low[3], const float high[3]);
/* Bounds of positions that are stored as they are: an engine's own buffers. */
void plan_bounds_in_place(plan_bounds *out, const float low[3], const float high[3]);

/* Of an instance; 0 casts and receives. */
enum {
  PLAN_CASTS_ONLY = 1u << 0,    /* no camera sees it */
  PLAN_RECEIVES_ONLY = 1u << 1, /* it casts no shadow */
  PLAN_HIDDEN = 1u << 2,        /* neither */
  PLAN_FLAGS = 7u,              /* all of the above, which a caller may set */
  PLAN_FREE = 1u << 3,          /* the slot holds no instance */
  PLAN_DEGENERATE = 1u << 4     /* the transform leaves no area: nothing is drawn */
};

typedef struct plan_instance {
  double transform[12]; /* object to world: three rows of four */
  uint32_t mesh;        /* index into the meshes' bounds */
  uint32_t mirrored;    /* 1: the transform turns its faces around */
  uint32_t flags;       /* PLAN_CASTS_ONLY to PLAN_DEGENERATE */
  uint32_t layers;      /* bits that a light's must meet; 0: all */
} plan_instance;

static inline bool plan_casts(const plan_instance *instance) {
  return !(instance->flags & (PLAN_RECEIVES_ONLY | PLAN_HIDDEN | PLAN_FREE | PLAN_DEGENERATE));
}

static inline bool plan_receives(const plan_instance *instance) {
  return !(instance->flags & (PLAN_CASTS_ONLY | PLAN_HIDDEN | PLAN_FREE | PLAN_DEGENERATE));
}

/* A box in the world, axis by axis. */
typedef struct plan_box {
  double low[3], high[3];
} plan_box;

/*
 * Instances by slot. A revision is the number of changes so far, and a change is one slot's: changes number r and
 * r + n are followed by revision r + n + 1. Change number r lies at journal[r % journal_size].
 */
typedef struct plan_scene {
  const plan_instance *instances; /* by slot */
  const plan_box *boxes;          /* by slot, around what its mesh fills; unused where PLAN_FREE */
  const uint64_t *revisions;      /* by slot: after the slot's last change */
  uint32_t slot_count;
  uint32_t caster_count, receiver_count; /* of plan_casts, of plan_receives */
  const plan_bounds *meshes;
  const plan_parts *parts; /* by mesh; NULL: all are whole */
  uint32_t mesh_count;
  uint64_t identity; /* of what the instances belong to; 0: revisions say nothing, and nothing is kept */
  uint64_t revision;
  uint64_t journal_from; /* the first change that the journal still holds */
  const uint32_t *journal;
  uint32_t journal_size; /* a power of two, or 0 */
} plan_scene;

/* Sets mirrored, and PLAN_DEGENERATE in flags. Errors: those of plan_check_affine, but for dependent columns;
 * INVALID_MATRIX: numbers above PLAN_LARGEST. */
csm_result plan_instance_check(plan_instance *instance);
/* The box of an instance that is not free. */
void plan_instance_box(plan_box *out, const plan_instance *instance, const plan_bounds *bounds);

/* ---- a frame ---- */
/* One draw call: instances of one mesh, whose matrices lie one after the other; or a piece of one instance's mesh. */
typedef struct plan_draw {
  uint32_t mesh;
  uint32_t first; /* index into the list's matrices */
  uint32_t count;
  uint32_t mirrored; /* all of them; 0 in a camera's list */
  uint32_t first_index;
  uint32_t index_count; /* 0: all of the mesh */
} plan_draw;

/* What one window, or the camera, draws. */
typedef struct plan_list {
  uint32_t
      *instances;   /* slots, ordered by mesh, then by side, then by slot; after them those drawn in parts, by slot */
  plan_draw *draws; /* in the order of their instances, then of their indices */
  uint32_t instance_count, draw_count;
  uint32_t culled; /* casters, or receivers, that are not drawn */
} plan_list;

/* What a view saw: the least and the greatest depth in each square tile of its depth buffer, rows from the top. */
typedef struct plan_depth_samples {
  plan_camera camera;      /* that the depths are of */
  plan_camera maps_camera; /* of the maps that the view was resolved with */
  uint32_t width, height, tile_px;
  uint32_t columns, rows;   /* 0: nothing is known */
  const float (*depths)[2]; /* as in the buffer; the first is above the second where there was no surface */
} plan_depth_samples;

/* Whether a view looked where its maps did, so that they are fitted to what it saw. A reflection does not. */
bool plan_depth_samples_count(const plan_depth_samples *samples, double margin);

/* How far a number that an image holds may be from what it stands for. */
typedef struct plan_grain {
  double share; /* of itself */
  double step;  /* and so much more */
} plan_grain;

enum { PLAN_SEEN_PX = 16, PLAN_SEEN_SLOTS = 32 };

/*
 * What a square of so many pixels holds. Nearness is a depth of a reversed buffer, or 1 less that of another. Slot i has
 * a surface if bit i is set of `slots`, which are two whole numbers of 16 bits. The bits of floats from the least
 * nearness on are divided into slots, each of a power of two of them, the least by which there are no more than 32.
 */
typedef struct plan_seen_tile {
  float nearness[2]; /* the least and the greatest; the first above the second: no surface */
  float slots[2];
} plan_seen_tile;

/* What this frame's camera sees, by its depth: tiles in rows from the top. */
typedef struct plan_seen_depth {
  plan_camera camera; /* that the depth is of */
  uint32_t width, height, columns, rows;
  plan_grain rounding; /* of the depth */
  const plan_seen_tile *tiles;
} plan_seen_depth;

enum { PLAN_CELLS = 64 }; /* of a map, across and up; the pages of one that is made of pages */

/*
 * Pages of a cascade's layer. The world is laid out in pages from the map's anchor on; page (x, y), y up, lies in slot
 * x mod 64 of row -1 - y mod 64 from the top. The layer holds the 64 x 64 pages from `first` on.
 *
 * What a page holds follows from where it lies, from texel, anchor, range of depths and the light's basis, and from the
 * casters over it; from nothing else. So it is kept while those stay, whatever the camera does.
 *
 * What keeps moving spoils a page in each frame, and what stands still in it would be drawn again and again. So a second
 * layer keeps such pages without what moves; they are copied from there, and what moves is drawn over them.
 */
typedef struct plan_pages {
  bool any;                   /* false: nothing is valid, and nothing else is filled in */
  uint64_t valid[PLAN_CELLS]; /* rows of slots, a bit each: it holds its page as it would be drawn now */
  uint64_t still[PLAN_CELLS]; /* likewise, in a second layer: its page without what keeps moving */
  uint64_t mixed[PLAN_CELLS]; /* those that are valid, and hold something that keeps moving */
  int64_t first[2];
  double texel[2], anchor[3], depth[2]; /* what it was drawn with; of depth: scale and offset */
} plan_pages;

/* A size, as steps of a logarithm. */
typedef struct plan_steps {
  double value;
  uint32_t wide_frames; /* for so many frames in a row it has been wider than it need be */
} plan_steps;

/* The point that the grid of a map's texels is counted from. */
typedef struct plan_anchor {
  double at[3];    /* world */
  double place[2]; /* the whole number of texels that it counts as, so that the count goes on where it is moved */
  double texel[2]; /* of the grid, metres; 0: there was no map yet, and the world's origin is the anchor */
} plan_anchor;

/* What a frame hands to the next one. Zero is the first frame. */
typedef struct plan_history {
  bool has_light, has_samples, has_bounds[CSM_MAX_CASCADES], has_casters_width;
  double light[3]; /* the way it travels */
  double basis[9]; /* that was drawn with; it may rest while the light moves on */
  plan_anchor anchors[CSM_MAX_CASCADES];
  double image[2];                             /* half of what stable fits are sized for along clip x and y: tangents
                                                  of a perspective camera, metres of an orthographic one; 0: none */
  plan_steps sample_range[2];                  /* what splits were fitted to */
  plan_steps casters_width;                    /* that maps were narrowed to */
  plan_steps bound_steps[CSM_MAX_CASCADES][2]; /* by which each map was narrowed */
  plan_pages pages[CSM_MAX_CASCADES];
  uint64_t pages_identity; /* of the scene that pages were drawn of; 0: of none that stays */
  uint64_t pages_revision;
  uint32_t pages_plan;   /* of the cache: the plan that drew them */
  uint32_t pages_layers; /* of the light */
  double pages_basis[9];
  double pages_depth[2]; /* the range of depths, in metres from the world's origin; equal: none yet */
} plan_history;

/* Forgets what belongs to a configuration, and keeps how the maps are turned about the light, and their grids' anchors.
 */
void plan_history_reconfigure(plan_history *history);

typedef struct plan_cascade {
  csm_cascade_info info;
  double texel[2];         /* metres along right and up */
  double origin_texels[2]; /* where the map begins, from the world's origin, less its jitter */
  double jitter_texels[2]; /* by which it begins elsewhere in this frame */
  double place_texels[2];  /* where it begins, as its grid is counted: whole numbers */
  uint32_t resolution;
  double to_clip[12]; /* light space (right, up, along, relative to the world's origin) to clip: three rows of four */
  double shift;       /* metres towards the light by which receivers are moved before they are compared */
  uint32_t casters;   /* that are drawn into it in this frame */
  /* Of pages: where the map begins in its layer, across and down, which it goes on at the other side of; rows of slots,
     a bit each: those that are made anew, and those that then are valid */
  uint32_t begin_texels[2];
  uint64_t due[PLAN_CELLS], valid[PLAN_CELLS];
  /* Of those that are due: copied from the second layer, which is first given those that it lacks: copied to it as they
     were, or drawn there */
  uint64_t copied[PLAN_CELLS], saved[PLAN_CELLS], still_due[PLAN_CELLS];
} plan_cascade;

/* What of its pages' casters a window draws, and where to: all of them into the maps; those that stand still into the second
   layer; those that keep moving into the maps, once the pages are copied there. */
typedef enum plan_window_kind {
  PLAN_WINDOW_ALL,
  PLAN_WINDOW_STILL,
  PLAN_WINDOW_MOVING,
  PLAN_WINDOW_KINDS
} plan_window_kind;

/*
 * What is drawn at one go. Of whole maps, window i is cascade i's map. The world of pages is laid out in squares, each as
 * wide as a map. A window is some pages of one of them, and its clip space is all of that square: so a page comes out
 * alike, whatever is drawn beside it.
 */
typedef struct plan_window {
  uint32_t cascade;
  plan_window_kind kind;
  double to_clip[12]; /* as plan_cascade's */
  uint32_t slots[4];  /* of pages: the first column and row, and how many of each, that hold all that is due */
  plan_list list;
} plan_window;

enum { PLAN_WINDOWS_MOST = 8 * CSM_MAX_CASCADES };

/* Which cascades draw an instance, a bit each; of pages those of which it lies over one that is read. */
typedef struct plan_drawn_slot {
  uint32_t slot, cascades;
} plan_drawn_slot;

typedef struct plan_frame {
  plan_camera camera;
  /*
   * The world position that constants are relative to. A float holds a position relative to it to 2^-24 of their
   * distance, so it lies near to what is shaded.
   */
  double origin[3];
  double basis[9];
  double light_diameter; /* radians */
  uint32_t cascade_count;
  double shadow_end; /* view depth in metres where shadows end; depth samples may end the last cascade before */
  bool pages;        /* maps are made of them */
  bool unshadowed;   /* the near plane is at or beyond the end of shadows: nothing is drawn, and no point is in a map */
  plan_cascade cascades[CSM_MAX_CASCADES];
  uint32_t window_count;
  plan_window windows[PLAN_WINDOWS_MOST];
  const plan_drawn_slot *drawn; /* by slot, of what some cascade draws */
  uint32_t drawn_count;
  uint32_t slot_count;
  uint32_t cells_by;            /* CSM_CELLS_* */
  uint32_t cells_read;          /* of all maps */
  const double (*to_light)[12]; /* by slot: what the cache keeps, until it is used again; NULL: nothing */
  plan_history history;         /* for the next frame */
} plan_frame;

/*
 * Keeps casters' boxes and transforms in light space from plan to plan. Only those of changed instances are computed.
 * The plan is the same with it and without. Zero is an empty one. The owner sets memory and slots, and gives it a new
 * memory only together with keeps = false.
 */
typedef struct plan_cache {
  void *memory;   /* plan_cache_size(slots) bytes, aligned to 16 */
  uint32_t slots; /* that there is room for; a scene with more of them is planned without the cache */
  bool keeps;     /* what follows says what the memory holds */
  uint64_t identity, revision;
  double basis[9];
  uint32_t changed; /* boxes of what changed since plan_pages_begin, as they were and as they are */
  bool unknown;     /* not all of them are there */
  int64_t loose;    /* blocks that have grown twice as wide as they were when instances were put in order */
  uint64_t strayed; /* changes since then */
  uint32_t plans;   /* of pages, so far */
  uint32_t movers;  /* casters that keep moving */
} plan_cache;

size_t plan_cache_size(uint32_t slot_count);

typedef struct plan_frame_info {
  const csm_config *config;
  const double *view, *projection, *light; /* 16, 16 and 3 */
  double light_diameter;                   /* radians */
  uint32_t reversed;                       /* CSM_REVERSED_* */
  uint32_t light_layers;                   /* instances of other layers cast nothing; 0: all */
  bool others_cast;                        /* the engine draws casters into the maps that no instance tells of */
  const double *origin;                    /* 3; NULL: the camera's position */
  const plan_scene *scene;
  bool maps_kept;                    /* the maps hold what the frame `before` left there */
  const plan_seen_depth *seen;       /* what the frame's camera sees, and nothing else is asked for; NULL: not known */
  bool all_receivers;                /* no surfaces but the scene's receivers are asked for visibility */
  plan_cache *cache;                 /* may be NULL */
  const plan_history *before;        /* the last frame's; may be NULL */
  const plan_depth_samples *samples; /* of earlier frames, one for each view */
  uint32_t sample_count;
  uint32_t jitter; /* the frame's number, which says where maps begin with history_jitter */
} plan_frame_info;

/* The most windows that a plan of a configuration has. */
uint32_t plan_windows_most(const csm_config *config);
/*
 * Where a plan's lists lie. A plan says how many instances it found that might be drawn, and fails if there is no room for so
 * many. Room for all slots is always enough.
 */
typedef struct plan_memory {
  void *at;       /* plan_memory_size bytes */
  uint32_t most;  /* instances that there is room for */
  uint32_t found; /* by the last plan */
} plan_memory;

/* Bytes of memory, aligned to 16, that a plan of so many found instances, meshes and windows (0 for a camera's) needs. */
size_t plan_memory_size(uint32_t most, uint32_t mesh_count, uint32_t window_count);
/* Whether the last plan found more than there was room for. Asks for room for them, and some more, which the owner then gives. */
bool plan_memory_short(plan_memory *memory);

/*
 * Plans the cascades. Preconditions: the configuration is checked, every instance has passed plan_instance_check, its
 * mesh is below mesh_count. `memory` holds the lists as long as `out` is used; it may be NULL where there are no slots.
 * Errors: OUT_OF_MEMORY (plan_memory_short: to be called again with room for more), those of plan_camera_make and plan_light_basis, and INVALID_CAMERA (numbers too large to plan with),
 * NOT_FINITE and INVALID_VALUE (origin).
 */
csm_result plan_frame_make(plan_frame *out, const plan_frame_info *info, plan_memory *memory, const char **error);

/* Makes a plan of pages that of the same frame once more, in which nothing has changed: no page is drawn. */
void plan_frame_rest(plan_frame *frame);

/* The cascades that draw a slot's instance, a bit each. */
uint32_t plan_drawn_by(const plan_frame *frame, uint32_t slot);

/*
 * What a camera sees of the receivers, for a depth pre-pass. A cache that knows the scene as it is spares looking at all of them;
 * it may be NULL. False: plan_memory_short.
 */
bool plan_view_make(plan_list *out, const plan_camera *camera, const plan_scene *scene, const plan_cache *cache,
                    plan_memory *memory);

/* ---- a camera's depth ---- */
/*
 * The camera that csm draws a camera's depth with. It sees the same, but for what lies outside of its range along the
 * view; its depth is always reversed, for floats are finest near 0. So depths are to 2^-24 of their distance, whatever the
 * planes of a perspective camera are, and those of an orthographic one to 2^-24 of what its list takes up.
 */
void plan_depth_camera_make(plan_camera *out, const plan_camera *camera, const plan_list *seen,
                            const plan_scene *scene);
/* The depth in a camera's buffer where there is no surface. */
static inline double plan_clear_depth(const plan_camera *camera) {
  return camera->reversed ? 0.0 : 1.0;
}
/* The view depth that a depth in a camera's buffer means; INFINITY beyond PLAN_LARGEST. Not of an oblique one. */
double plan_view_depth(const plan_camera *camera, double depth);
/* A place in a camera's picture: clip x and y, and its depth in the buffer. */
typedef struct plan_pixel {
  double x, y, depth;
} plan_pixel;
/*
 * The depth in a camera's buffer of what another one's has at a place; `to` may be NULL, for its view depth: INFINITY if
 * there is no surface. The two see the same but for their planes, of which either none or both are oblique.
 */
double plan_convert_depth(const plan_camera *from, const plan_camera *to, const plan_pixel *pixel);

/* Object to clip of every instance in a window's list: three float4 rows each (12 floats); w is 1. Precondition: the cache
   that the frame was planned with has not been used since. */
void plan_write_window_matrices(float *out, const plan_frame *frame, uint32_t window, const plan_scene *scene);
/* Object to clip: four float4 rows each (16 floats). */
void plan_write_view_matrices(float *out, const plan_list *list, const plan_camera *camera, const plan_scene *scene);

/* The block that shaders/include/csm_constants.h lays out, relative to frame->origin. Returns its bytes. */
uint32_t plan_write_constants(float *out, const plan_frame *frame, const csm_config *config);
/* What a mask is drawn for. */
typedef struct plan_picture {
  const plan_camera *camera; /* that its depth is of */
  uint32_t width, height;    /* in pixels */
  uint32_t show;             /* CSM_SHOW_* */
  bool normals;              /* the engine's are there, and not taken from the depth */
  bool unorm_normals;        /* they are normalised integers */
  plan_grain rounding;       /* of the normals, or of the depth */
  plan_grain depth_rounding; /* of the depth */
} plan_picture;

/* The block of the mask pass: how the picture's pixels map to light space, relative to frame->origin. Returns its
   bytes. */
uint32_t plan_write_mask_constants(float *out, const plan_frame *frame, const plan_picture *picture,
                                   const csm_config *config);

/* ---- a mask's history ---- */

/* What a view's mask was accumulated for. */
typedef struct plan_past {
  plan_camera camera; /* that its depth is of */
  uint32_t width, height;
  double shadow_end;
  uint64_t settings; /* which configuration of which cascades; 0: there is no past */
  uint64_t changes;  /* how often the cascades' shadows had changed; 0: not known */
} plan_past;

/* From an earlier picture to this one; the earlier one counts, or is this one itself. */
typedef struct plan_passage {
  const plan_past *past, *now;
  double phase; /* plan_history_phase of this frame */
} plan_passage;

/* Whether a mask may go on from an earlier one. Where it was cut to another place, no pixel finds itself again. */
bool plan_past_counts(const plan_past *past, const plan_past *now);
/* The place within a texel at which a frame's maps begin, from -1/2 to 1/2 of one. */
void plan_history_jitter(double out[2], uint32_t frame);
/* The block of the history pass (csm_history.h). Returns its bytes. */
uint32_t plan_write_history_constants(float *out, const plan_frame *frame, const plan_picture *picture,
                                      const plan_passage *passage, const csm_config *config);
/* The phase in CSM_S_SOFT_MORE.w of a view's frame: by how much of a pattern its filter goes on, from 0 to 1. Frames lie apart as evenly
   as can be, however many of them there are in a row. */
double plan_history_phase(uint32_t frame);
/* Puts it into the block of plan_write_constants. */
void plan_write_phase(float *out, double phase, const csm_config *config);

/* CSM_MAPS_ALIKE: whether all maps are layers of one image and of one size, and whether they are made of pages. */
uint32_t plan_maps_alike(const csm_config *config);
/* Whether the bias is in texels alone, but for a constant share of the depth range. */
bool plan_bias_in_texels(const csm_config *config);
/* The text of csm_shader_defines: returns its bytes, the final 0 included, and writes no more than `size` of them. */
size_t plan_shader_defines(const csm_config *config, char *text, size_t size);

/* Texels of a tile's side, and how many tiles a side of so many texels has. */
enum { PLAN_TILE = 64 };
uint32_t plan_tiles_across(uint32_t side);
/*
 * Notes for each tile of a cascade, row by row, whether what the frame's camera sees may ask for texels of it, 1 or 0: with
 * caster_set view; else all are 1. `side` is that of the cascade's moments.
 */
void plan_seen_tiles(uint8_t *tiles, const plan_frame *frame, const csm_config *config, uint32_t cascade,
                     uint32_t side);
/*
 * Whether a cascade draws what it drew in an earlier frame, all of it, and where it did, so that its map comes out as it did then.
 * Preconditions: both frames are of one scene and one configuration, and no callback drew into either's maps; `revision`
 * was the scene's then.
 */
bool plan_cascade_same(const plan_frame *before, const plan_frame *now, uint32_t cascade, const plan_scene *scene,
                       uint64_t revision);
/* Likewise, whether all that a frame's shadows follow from is as it was, but for the maps' jitter, and no receiver moved. */
bool plan_frame_rests(const plan_frame *before, const plan_frame *now, const plan_scene *scene, uint64_t revision);

/* Takes a rectangle out of rows of slots, a bit each: its first column and row, and how many of each. False: there is none. */
bool plan_next_slots(uint32_t out[4], uint64_t rows[PLAN_CELLS]);

/* What csm_draw_info says of a cascade: the world's transform to its clip space, and the planes of what may cast. */
void plan_cascade_volume(const plan_frame *frame, uint32_t cascade, double world_to_clip[16], double planes[5][4]);

/* FNV-1a over everything the plan holds that reaches a backend: cascades, lists and matrices. */
uint64_t plan_hash(const plan_frame *frame, const csm_config *config, const plan_scene *scene);

#endif
