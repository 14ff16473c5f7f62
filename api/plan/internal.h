/* internal.h: what the plan's files share among themselves. */
#ifndef PLAN_INTERNAL_H
#define PLAN_INTERNAL_H

#include "plan/plan.h"

#include <math.h>

/* Largest Frobenius norm of transpose(view) * view - 1 at which a view still counts as rigid. */
#define PLAN_RIGID_TOLERANCE 1e-3

/* ---- vectors ---- */
static inline double plan_dot(const double a[3], const double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void plan_cross(double out[3], const double a[3], const double b[3]);
/* Of any length but 0: also one whose square would overflow or vanish. False: zero, or not finite. */
bool plan_normalize(double v[3]);

/* Whether all values are finite and no larger than `most`, which is above 0. */
bool plan_within(const double *values, uint32_t count, double most);

/* ---- configurations ---- */
/* A field of csm_config, and what is said of it where it is wrong. */
typedef struct plan_config_entry {
  csm_config_field field;
  const char *not_finite, *out_of_range;
} plan_config_entry;

/* NULL past the last one. */
const plan_config_entry *plan_config_entry_at(uint32_t index);
/* Whether a field's numbers are doubles, and not whole ones. */
bool plan_is_double(const csm_config_field *field);

/* ---- floats ---- */
/* The nearest float; what a float cannot hold becomes the largest one. */
static inline float plan_float(double value) {
  const double limit = 3.4028234663852886e38;
  const double above = value > -limit ? value : -limit;
  return (float)(above < limit ? above : limit);
}

/* ---- errors ---- */
static inline csm_result plan_fail(const char **error, csm_result result, const char *text) {
  if (error)
    *error = text;
  return result;
}

/* ---- instances ---- */
/* A mesh's bounds placed in the world: a box with three half-axes. */
typedef struct plan_placed {
  double center[3], axes[3][3];
} plan_placed;

static inline void plan_place_box(plan_placed *out, const plan_instance *instance, const double center[3],
                                  const double extent[3]) {
  for (int i = 0; i < 3; ++i) {
    const double *row = &instance->transform[i * 4];
    out->center[i] = plan_dot(row, center) + row[3];
    for (int k = 0; k < 3; ++k)
      out->axes[k][i] = row[k] * extent[k];
  }
}

static inline void plan_place(plan_placed *out, const plan_instance *instance, const plan_bounds *bounds) {
  plan_place_box(out, instance, bounds->center, bounds->extent);
}

/* The parts of an instance's mesh. */
static inline plan_parts plan_parts_of(const plan_scene *scene, const plan_instance *instance) {
  return scene->parts ? scene->parts[instance->mesh] : (plan_parts){0};
}

/* Whether positions are stored farther from 0, along an axis, than three times half of what they fill there. */
bool plan_bounds_far(const plan_bounds *bounds);

/* How far the box reaches from its centre along a direction. */
static inline double plan_reach(const plan_placed *box, const double direction[3]) {
  return fabs(plan_dot(box->axes[0], direction)) + fabs(plan_dot(box->axes[1], direction)) +
         fabs(plan_dot(box->axes[2], direction));
}

/* ---- camera ---- */
/* The view z that lies before the camera: 1 or -1. */
double plan_view_side(const plan_camera *camera);
/* Inverse of the view's rotation, column-major 3 x 3. */
void plan_view_rotation_inverse(double out[9], const double view[16]);

/* ---- moments ---- */
/* What a configuration's moments are made with, and how far their format and arithmetic put them off. */
typedef struct plan_moment_errors {
  double exponent, negative; /* as configured, or what the format holds */
  double mean;               /* by how much a mean of z may be off, which is from -1 to 1 */
  double variance;           /* a variance of z; with exponentials, as a share of the mean square */
  double bias;               /* msm4: the share of another distribution that leaves one of any that is so far off */
} plan_moment_errors;

void plan_moment_errors_make(plan_moment_errors *out, const csm_config *config);
/* The variance of where a filter's texels lie along an axis, in texels of the map squared, without levels. */
double plan_moment_spread(const csm_config *config);

/* ---- light ---- */
/*
 * The way that the light travels, and the basis that a frame is drawn with: the light's, or the last frame's as long as
 * the light has not moved a step, turned as light_roll says. Errors: those of plan_light_basis.
 */
csm_result plan_light_make(double basis[9], double light[3], const plan_frame_info *info, const char **error);

/* ---- what all cascades of a frame are fitted to ---- */
/* In light space, metres from the world's origin. */
typedef struct plan_span {
  double low[3], high[3];
} plan_span;

typedef struct plan_fit_frame {
  const csm_config *config;
  const plan_camera *camera;
  const double *basis;
  double image[2];                   /* that stable fits are sized for: plan_steady_image */
  const plan_depth_samples *samples; /* of each view */
  uint32_t sample_count;             /* 0: nothing is fitted to them */
  const plan_span *casters;          /* of all that casts into the view; NULL: not known, or of no use */
  const plan_history *before;        /* may be NULL */
  plan_history *after;
  double jitter[2]; /* of all maps, in texels */
} plan_fit_frame;

/* ---- splits ---- */
/* Where the cascades begin and end, as view depth. */
typedef struct plan_depths {
  double at[CSM_MAX_CASCADES + 1]; /* count + 1 values, strictly rising, the last one the end of the shadows exactly */
  double shadow_end;               /* where shadows end, whatever the samples say */
  bool none;                       /* the near plane is at or beyond that end, and `at` is not filled */
} plan_depths;
/* INVALID_CAMERA: there is no room for so many cascades. */
csm_result plan_splits(plan_depths *out, const plan_fit_frame *frame, const char **error);

/* ---- depth samples ---- */
/* Whether what all views saw then says enough of what a camera sees now. */
bool plan_depth_samples_usable(const plan_frame_info *info, const plan_camera *camera);
/* Narrows the range of depths that splits divide. */
void plan_depth_samples_range(double *near, double *end, const plan_fit_frame *frame);
#define PLAN_STEPS_PER_OCTAVE 4.0
/*
 * Steps of a range's logarithm: what is needed, or what there was if that holds it and has not been much wider for
 * long. `direction` is that in which steps hold more.
 */
plan_steps plan_steps_keep(double needed, const plan_steps *before, double direction);
/* Narrows what a map covers of light space, along right and up. */
void plan_depth_samples_bound(double middle[2], double width[2], const plan_fit_frame *frame, uint32_t cascade,
                              const double depths[2]);

/* ---- slices ---- */
/*
 * Jitter moves the image by less than a pixel, and must not change a texel's size. So the image's offset from the view
 * axis is rounded to whole steps, and the slice is made larger by half a step to each side (of clip space, whose sides
 * are at -1 and 1), which covers the image wherever in its step it is. Half a pixel of jitter is less than this from
 * 128 pixels on.
 */
#define PLAN_OFFSET_STEP (1.0 / 64.0)
/* Half the width and the height of what a camera sees: tangents of a perspective one, else metres. */
void plan_image(double half[2], const plan_camera *camera);
/*
 * The corners in view space of what lies between two view depths: four of its near face, then of its far one, of an
 * image so wide and high. False: numbers above PLAN_LARGEST.
 */
bool plan_slice_corners(double corners[8][3], const plan_camera *camera, const double image[2], const double depths[2]);
/* The least sphere, in view space, around a slice; see sphere.c. Depends on the projection alone. */
void plan_slice_sphere(double center[3], double *radius, const double corners[8][3]);
/* The sphere around the mean of its corners, likewise. */
void plan_slice_centroid_sphere(double center[3], double *radius, const double corners[8][3]);
/* A point of a camera's view space in light space; `inverse` is plan_view_rotation_inverse's. */
void plan_view_to_light(double out[3], const plan_camera *camera, const double basis[9], const double inverse[9],
                        const double view[3]);

/* ---- fit ---- */
/* Where a map lies in light space, before its casters are known. */
typedef struct plan_fit {
  double texel[2];  /* metres along right and up */
  double anchor[3]; /* the point in light space from which texels and depth steps are counted, metres */
  double place[2];  /* the number of texels that this point counts as */
  double origin[2]; /* the map's beginning, in texels from the anchor, but for its jitter */
  double jitter[2];
  double depth[2];   /* of the slice along the light, metres */
  double casters[2]; /* where all casters begin and end along the light, if the map is narrowed to them */
  double step;       /* of depths that are rounded, metres */
  uint32_t resolution;
} plan_fit;

/*
 * By how much the surfaces that a map and a camera's depth hold may lie off the surface that was drawn, and what of that
 * the configured bias covers. See rounding.c.
 */
typedef struct plan_rounding {
  double middle[3], begin; /* of the slice: its middle in light space, and where it begins along the light */
  double covered[2];       /* metres along the light at slope 0, and for each unit of slope */
  double slope_max;        /* at which the second stops growing */
  double least;            /* distance in metres from which on a vertex is off by more than is covered */
  double most;             /* metres; a map that is off by more than its slice is long tells nothing any more */
  double beyond;           /* found by culling: the most metres that casters are off by more than is covered */
} plan_rounding;

/* What one map covers of light space, in metres from the world's origin. */
typedef struct plan_area {
  double min[2], max[2]; /* along right and up */
  double depth[2];       /* along the light; nothing beyond the second is drawn; with depth_mode casters the first is
                            where the slice begins */
  double first_caster;   /* found by culling: where the first caster begins along the light; INFINITY: none */
  plan_rounding rounding;
} plan_area;

/* The corners, in light space, of the box in the world that holds all instances; corner_count is 0 if there are none.
 */
typedef struct plan_scene_box {
  double corners[8][3];
  uint32_t corner_count;
  double steady[2]; /* along the light, for pages */
} plan_scene_box;

/* INVALID_CAMERA: numbers too large to plan with. */
csm_result plan_fit_slice(plan_fit *out, const plan_fit_frame *frame, uint32_t cascade, const double depths[2],
                          const char **error);
plan_area plan_fit_area(const plan_fit *fit, const csm_config *config, const plan_scene_box *box);
/* Makes a cascade that holds no point, and into which nothing casts. */
void plan_fit_nothing(plan_cascade *cascade, uint32_t index, const double basis[9], const csm_config *config);
/* Writes the cascade's matrices, now that its casters are known. */
void plan_fit_place(plan_cascade *cascade, const plan_fit *fit, const plan_area *area, const double basis[9],
                    const csm_config *config);

/* ---- rounding ---- */
/* The longest range of depths for which a depth is off by a share of a texel only. */
double plan_longest_range(const plan_fit *fit, const csm_config *config);
/* Of a map, before its casters are known. */
plan_rounding plan_rounding_begin(const plan_fit *fit, const csm_config *config);
/* Notes the frame's origin, which shaders' positions are relative to: what they are off by grows with the way to it. */
void plan_rounding_origin(plan_rounding *rounding, const double basis[9], const double origin[3]);
/* Notes a caster, whose box in light space reaches as far as `end` along the light. */
void plan_rounding_note(plan_rounding *rounding, const double basis[9], const plan_instance *instance,
                        const plan_bounds *bounds, double end);
/* How far receivers are moved towards the light in a map of that depth range. */
double plan_rounding_shift(const plan_rounding *rounding, double range);

/* ---- what carries on from frame to frame ---- */
/* The image that stable fits are sized for; it holds the camera's. */
void plan_steady_image(double image[2], const plan_fit_frame *frame);
/* Fills in anchor and place of a fit whose texels are known; `middle` is the map's in light space. */
void plan_steady_anchor(plan_fit *fit, const plan_fit_frame *frame, uint32_t cascade, const double middle[3]);

/* ---- filter ---- */
enum { PLAN_MAX_TAPS = 31, PLAN_MAX_WEIGHTS = 16, PLAN_LEAST_RESOLUTION = 16 };
/* Taps a side, or points. */
uint32_t plan_filter_taps(const csm_config *config);
/* Of taps from the middle outwards, along one axis; returns the sum of all taps'. */
double plan_filter_weights(double weights[PLAN_MAX_WEIGHTS], const csm_config *config);
/* From a sample to the farthest texel's centre that it is compared with, along one axis. */
double plan_filter_reach_texels(const csm_config *config);
/* Of a filter's weights, at least how much lies on one side of a line through its sample. */
double plan_filter_least_share(const csm_config *config);
/* How far a map's jitter moves it to either side. */
static inline double plan_jitter_room(const csm_config *config) {
  return config->history == CSM_HISTORY_ON && config->history_jitter ? 0.5 : 0.0;
}
/* The grid that maps begin on, in texels; 0: none. */
double plan_grid_texels(const csm_config *config);
/* Room that a map leaves at its borders. */
double plan_padding_texels(const csm_config *config);
/* What is wrong with the sides of a configuration's maps; NULL: nothing. */
const char *plan_refuse_sides(const csm_config *config);
/* Room around what a camera sees, within which what lies in a cascade's map is read for it. */
double plan_view_room_texels(const csm_config *config, uint32_t cascade);

/* ---- culling ---- */
/*
 * The hull of eight points is made of two chains, from the first point to the last and back. A chain has at most all
 * eight, and rounding may put a point that lies next to a chain on both. Each chain's last point is the other's first.
 */
enum { PLAN_HULL_MOST = 2 * (8 - 1) };

/* What a camera sees until the shadows end, across the light: the half-planes around it. */
typedef struct plan_hull {
  double normals[PLAN_HULL_MOST][2], offsets[PLAN_HULL_MOST]; /* inside: dot(normal, xy) <= offset */
  uint32_t count;                                             /* 0: nothing is left out */
} plan_hull;
/* The hull between two view depths, with a square of so many metres around each of its points. */
void plan_view_hull(plan_hull *out, const plan_camera *camera, const double basis[9], const double depths[2],
                    double room);
/* Whether a box across the light lies outside. */
bool plan_outside_hull(const plan_hull *hull, const double low[2], const double high[2]);

/* ---- order ---- */
enum { PLAN_BLOCK = 64 };

/* Boxes in the world around all that casts or receives in each of 64 blocks, or of 64 groups of so many blocks. */
typedef struct plan_bounds_block {
  double low[3][PLAN_BLOCK], high[3][PLAN_BLOCK];
} plan_bounds_block;

/* The places of instances, in blocks of 64, of which 64 are a group, and 64 groups a top; what has neighbouring places lies
 * together in the world. Zero is none: each slot is its own place, and nothing is known of blocks. */
typedef struct plan_order {
  plan_bounds_block *tops, *groups; /* of groups; of blocks */
  double *widths;                   /* by block: the sum of its sides as it was put in order */
  uint64_t *changed;                /* by group, a bit for each block: its bounds are to be found anew */
  uint32_t *slots, *places;         /* by place, and by slot */
  uint64_t *marks, *marked;         /* for sorting: bits of slots, and of marks that are not 0; 0 in between */
  uint32_t *indices;                /* likewise, by slot */
  uint32_t block_count, group_count, top_count;
} plan_order;

size_t plan_order_size(uint32_t slot_count);
/* Where all of it lies in memory of that size, aligned to 8. */
void plan_order_find(plan_order *out, void *memory, uint32_t slot_count);
/* Puts a scene's instances in order. `scratch`: 16 bytes for each slot. */
void plan_order_make(const plan_order *order, const plan_scene *scene, void *scratch);
/* A slot's instance has changed. */
void plan_order_note(const plan_order *order, uint32_t slot);
/* Fits bounds to what has changed. Returns how many more blocks are twice as wide as when they were put in order. */
int64_t plan_order_fit(const plan_order *order, const plan_scene *scene);
/* Around all that casts or receives; low above high: nothing does. */
plan_box plan_order_bounds(const plan_order *order);

static inline uint32_t plan_slot_at(const plan_order *order, uint32_t place) {
  return order->slots ? order->slots[place] : place;
}

static inline uint32_t plan_place_of(const plan_order *order, uint32_t slot) {
  return order->places ? order->places[slot] : slot;
}

/* An instance that lists hold. */
typedef struct plan_found {
  uint64_t mask;   /* bit i is set if list i holds it */
  uint64_t partly; /* of those: bit i is set if list i draws it in parts */
  uint32_t slot, place;
  uint32_t drawn; /* bit i is set if cascade i draws it */
} plan_found;

/* Puts what was found in the order of slots. Precondition: each is there once. */
void plan_order_sort(const plan_order *order, plan_found *out, const plan_found *found, uint32_t count);

/* Of 64 boxes, a bit for each: those in which something may lie that is looked for. */
typedef uint64_t plan_meets(const void *with, const plan_bounds_block *bounds);

/* Leads through the blocks in which something may lie that is looked for; through all of them where there is no order. */
typedef struct plan_walk {
  const plan_order *order;
  plan_meets *meets;
  const void *with;
  uint32_t block_count, next, group;
  uint64_t groups, blocks;
} plan_walk;

plan_walk plan_walk_begin(const plan_order *order, uint32_t slot_count, plan_meets *meets, const void *with);
bool plan_walk_next(plan_walk *walk, uint32_t *block);

/* ---- casters ---- */
void plan_scene_bounds(plan_scene_box *out, const double basis[9], const plan_scene *scene, const plan_order *order);

/* Of casters, a block of places after the other; one that is not a caster's meets no area. */
typedef struct plan_light_block {
  double low[3][PLAN_BLOCK], high[3][PLAN_BLOCK];
  double largest; /* no caster's size is above it: the diagonal of its box, squared */
} plan_light_block;
/* A box across the light. */
typedef struct plan_span_across {
  double low[2], high[2];
} plan_span_across;

/* What a change spoils: pages that it touches, and what is kept of them without what keeps moving. */
enum { PLAN_SPOILS_PAGES = 1, PLAN_SPOILS_STILL = 2 };

/* What a cache keeps for a light. */
typedef struct plan_kept {
  plan_order order;
  plan_light_block *blocks;  /* of casters, in order; NULL: nothing is kept */
  uint64_t *filled;          /* by group, a bit for each block: it is there, with its transforms */
  double (*transforms)[12];  /* of casters, by slot: stored positions to light space, three rows of four */
  plan_span_across *changed; /* as many as the cache says */
  uint8_t *spoils;           /* PLAN_SPOILS_*, of each of them */
  uint32_t *changed_at;      /* by slot: the plan in which it changed last; 0: in none */
  uint32_t *movers;          /* slots of what keeps moving, as many as the cache says */
  bool *moves;               /* by slot: whether it does */
} plan_kept;

/* What the cache has, as it is. Precondition: it keeps something. */
plan_kept plan_cache_kept(const plan_cache *cache);
/* Where a slot's caster lies; false: it casts nothing, or met no map under this light. */
bool plan_kept_box(plan_span_across *out, const plan_kept *kept, uint32_t slot);
/* Forgets what changed before. */
void plan_cache_forget_changes(plan_cache *cache);
/* Takes from those that keep moving what has not moved for long. */
void plan_cache_rest(plan_cache *cache);
/* What the cache has for this light, after bringing it up to date. */
plan_kept plan_cache_fill(plan_cache *cache, const double basis[9], const plan_scene *scene);
/* The order of a scene's instances, if a cache, which may be NULL, knows all of them as they are. */
plan_order plan_cache_order(const plan_cache *cache, const plan_scene *scene);
/* A block: what is kept of it, from now on, or what is made of it in `made`. */
const plan_light_block *plan_light_block_at(plan_light_block *made, const plan_kept *kept, const double basis[9],
                                            const plan_scene *scene, uint32_t block);

/* The lists of a plan while they are made. */
typedef struct plan_lists {
  plan_list *lists[PLAN_WINDOWS_MOST];
  uint32_t count;
  bool sides;     /* mirrored instances are drawn apart */
  uint32_t among; /* instances that might be drawn */
  plan_memory *memory;
  plan_found *found;    /* by place, and after plan_lists_sort by slot */
  uint32_t found_count; /* above what there is room for: the last ones are not there */
  bool room;            /* plan_lists_room was called: parts may be drawn */
  uint32_t *counts;     /* [plan_list_key * count + list]: instances of that key in the list */
  /* by list: draws of parts, by slot and by index; `first` counts the slots that are drawn so */
  plan_draw *part_draws[PLAN_WINDOWS_MOST];
  uint32_t part_counts[PLAN_WINDOWS_MOST];
} plan_lists;

/* A list has no more draws of parts; what does not fit is drawn whole. */
enum { PLAN_MOST_PART_DRAWS = 2048 };

/* What instances share that are drawn together: the mesh and, where it matters, the side. */
static inline uint32_t plan_list_key(const plan_lists *lists, const plan_instance *instance) {
  return instance->mesh * 2 + (lists->sides ? instance->mirrored : 0);
}

/* Begins with nothing found. `memory` may be NULL where nothing can be. */
void plan_lists_begin(plan_lists *lists, plan_memory *memory);
/* How many there is room for. */
static inline uint32_t plan_lists_most(const plan_lists *lists) {
  return lists->memory ? lists->memory->most : 0;
}

/* Notes an instance. Precondition: none with that slot is there. */
static inline void plan_lists_add(plan_lists *lists, const plan_found *found) {
  if (lists->found_count < plan_lists_most(lists))
    lists->found[lists->found_count] = *found;
  ++lists->found_count;
}

/* Whether there is room for all that were found. Tells the memory how many these were. */
bool plan_lists_fit(const plan_lists *lists);
/* Puts what was found in the order of slots. */
void plan_lists_sort(plan_lists *lists, const plan_order *order);
/* Makes room for as many lists as there are, all empty. */
void plan_lists_room(plan_lists *lists, const plan_scene *scene);
/* Makes every list, there, from what was found and sorted. */
void plan_lists_end(plan_lists *lists, const plan_scene *scene);
/* Tells a frame what its cascades draw. */
void plan_lists_drawn(const plan_lists *lists, plan_frame *frame);

/* Which cells of a map are read. */
typedef struct plan_cells {
  double begin[2], size[2];  /* where the first begins along right and up in light space, and of each: metres */
  uint64_t read[PLAN_CELLS]; /* a row's cells, a bit each */
} plan_cells;
/* Lays the cells of a map out, none of which is read. */
void plan_cells_lay(plan_cells *out, const plan_area *area);
/* Notes that the cells that a box across the light lies over are read. */
void plan_cells_add(plan_cells *cells, const double low[2], const double high[2]);
/* Whether a box across the light lies over a cell that is read. */
bool plan_cells_meet(const plan_cells *cells, const double low[2], const double high[2]);
/* Whether it lies over some that are read and some that are not; false also where it lies over one or two of them. */
bool plan_cells_meet_some(const plan_cells *cells, const double low[2], const double high[2]);

/* What casters are tested against. */
typedef struct plan_light_cull {
  const double *basis;
  const plan_hull *hull;
  uint32_t layers;  /* 0: all */
  plan_area *areas; /* whose first_caster is INFINITY yet */
  const plan_kept *kept;
} plan_light_cull;
/* The span of all casters that may shade what lies in the hull; false: there are none. */
bool plan_casters_span(plan_span *out, const plan_light_cull *cull, const plan_scene *scene);
/* Notes in list i what casts into area i, and how far towards the light those casters reach. */
void plan_cull_light(plan_lists *lists, const plan_light_cull *cull, const plan_scene *scene);
/* Takes from each list what lies over no cell of its map that is read. */
void plan_cull_unread(plan_lists *lists, const plan_cells *cells, const plan_light_cull *cull, const plan_scene *scene);
/* Likewise the parts of large meshes. Preconditions: plan_lists_room, plan_lists_sort. */
void plan_cull_unread_parts(plan_lists *lists, const plan_cells *cells, const plan_light_cull *cull,
                            const plan_scene *scene);

/* The parts of one instance's mesh, whose box across the light is given, from the lists that hold it. */
void plan_cull_parts(plan_lists *lists, plan_found *found, const plan_cells *cells, const double basis[9],
                     const plan_scene *scene, const plan_span_across *box);

/* ---- receivers ---- */
/* Where receivers lie: in light space, and along the view. */
typedef struct plan_receiver_box {
  double low[3], high[3], depths[2];
} plan_receiver_box;

/* Who gets boxes, one after the other. */
typedef struct plan_box_sink {
  void (*take)(void *user, const plan_receiver_box *box);
  void *user;
} plan_box_sink;

/* Tells boxes that hold all surfaces of a picture that lie before a view depth: seen_depth.c. */
void plan_seen_walk(const plan_seen_depth *seen, const plan_frame *frame, double end, const plan_box_sink *sink);
/* Whether a camera sees any receiver, up to a view depth. */
bool plan_sees_receivers(const plan_camera *camera, const plan_scene *scene, const plan_order *order, double end);
/* Which cells of each cascade's map are read for the receivers that the frame's camera sees: by its depth, if that is
 * there, or by all receivers that it may see. The maps are placed. */
void plan_read_cells(plan_cells *cells, const plan_frame *frame, const plan_area *areas, const plan_order *order,
                     const plan_frame_info *info);
/* Likewise, of maps that may be read wherever the camera sees, or, with caster_set map, everywhere. */
void plan_seen_cells(plan_cells *cells, const plan_frame *frame, const plan_area *areas, const csm_config *config);

/* ---- pages ---- */
/* The row, from the top, of the slots of cells y up from a map's begin. */
uint32_t plan_slot_row(const plan_pages *pages, uint32_t y);
/* A map's windows, a bit each. */
typedef struct plan_windows {
  uint64_t of[PLAN_WINDOW_KINDS];
} plan_windows;
/*
 * Adds a map's windows, over the cells that are due for each kind, and the cells of each window, which lie where those of
 * window 0 do from `cells` on. False: there is no room for so many, and nothing is added.
 */
bool plan_windows_make(plan_windows *out, plan_frame *frame, plan_cells *cells, uint32_t cascade, const plan_fit *fit,
                       const plan_cells due[PLAN_WINDOW_KINDS]);
/* Before a plan: forgets changes that the pages of the frame before know of. */
void plan_pages_begin(const plan_frame_info *info);
/* The depths of maps that are made of pages: those of the scene, which stay. */
void plan_pages_depth(plan_scene_box *box, plan_frame *frame, const plan_fit *fits, const plan_frame_info *info);
/*
 * Which pages of the maps are drawn, and in which windows: those whose cells are read and that are not valid. Turns the
 * lists of cascades into those of windows. `Cells` become those of the windows.
 */
void plan_pages_make(plan_frame *frame, const plan_fit *fits, plan_lists *lists, plan_cells *cells,
                     const plan_frame_info *info);

/* ---- packing ---- */
/* The transform of positions as they are stored. */
void plan_stored_transform(double out[12], const plan_instance *instance, const plan_bounds *bounds);
/* The same, to light space. */
void plan_light_transform(double out[12], const double basis[9], const plan_instance *instance,
                          const plan_bounds *bounds);
/* Stored positions to a window's clip space, from their transform to light space: three rows of four. */
void plan_light_to_clip(float out[12], const double to_clip[12], const double to_light[12]);

/* ---- pixels.c ---- */

/* Positions relative to the frame's origin, to places in a camera's picture: x to the right and y down in pixels, and the
   depth in its buffer. And back. */
void plan_relative_to_pixels(double out[16], const plan_frame *frame, const plan_camera *camera, uint32_t width,
                             uint32_t height);
void plan_pixels_to_relative(double out[16], const plan_frame *frame, const plan_camera *camera, uint32_t width,
                             uint32_t height);

#endif
