/*
 * hard/hard.h: the hard cases: scenes, cameras, lights and settings at which shadows break, with figures that must
 * hold.
 *
 * A case is one file with one `const hard_case`, named in cases.h, cases.c and meson.build; bare_plane.c is one. Its
 * run function builds a little scene, draws it, and reports figures, each with a bound that a comment there derives.
 * What hard_draw draws is drawn with every backend that was asked for, and compared: cases look at one picture, and it
 * stands for all.
 *
 *   static int run(hard_run *run) {
 *     host_setup setup;
 *     hard_setup_begin(&setup, 256, 144);
 *     ... builders, hard_add, hard_look, hard_reach ...
 *     hard_picture drawn = {0};
 *     hard_truth truth = {0};
 *     int code = hard_load(run, &setup);
 *     if (code == 0)
 *       code = hard_draw(run, &setup.camera, &setup.light, 0, &drawn);
 *     if (code == 0)
 *       code = hard_cast(run, &setup.camera, &setup.light, &truth);
 *     if (code == 0) {
 *       const hard_count count = hard_judge(run, &truth, drawn.mask, (hard_margin){.silhouette_px = 2.0});
 *       hard_figure_add(run, (double)count.false_dark, 0.0, "px", "acne");
 *     }
 *     hard_truth_free(&truth);
 *     hard_picture_free(&drawn);
 *     hard_unload(run);
 *     setup_free(&setup);
 *     return code;
 *   }
 */
#ifndef HOST_HARD_H
#define HOST_HARD_H

#include "base/image.h"
#include "metrics/flicker.h"
#include "scene/mesh_builder.h"
#include "stage/stage.h"

typedef struct hard_run hard_run;
struct hard_engine;

typedef struct hard_case {
  const char *name;          /* as --case takes it */
  const char *about;         /* one line: what is hard about it */
  int (*run)(hard_run *run); /* 0, or a code after a message where it could not be run */
} hard_case;

/* It holds where `value` is at most `bound`. */
typedef struct hard_figure {
  char what[112];
  double value, bound; /* bound INFINITY: it is stated, and may be anything */
  const char *unit;    /* "px", "texels", "m", "1" ... */
} hard_figure;

/* What is around the worst pixel of a case: what it should be, and what was drawn, side by side. */
typedef struct hard_worst {
  double severity; /* negative: there is no picture yet */
  char what[112];
  uint32_t width, height;  /* of each of the two */
  float *expected, *drawn; /* NAN: it is not judged */
} hard_worst;

struct hard_run {
  const host_options *options;
  const hard_case *hard_case;
  bool sweep; /* the long form: every value, not some */
  /* Open devices with what hard_load has put there, those that were asked for. For calls of csm that have no helper. */
  stage stages[HOST_BACKENDS];
  uint32_t stage_count;
  const host_setup *setup;        /* that is loaded, or NULL */
  truth *truth;                   /* of its scene; made when it is first asked */
  struct hard_engine *engines[2]; /* likewise: meshes copied, and in the engine's buffers */
  hard_figure *figures;
  size_t figure_count, figure_capacity;
  hard_worst worst;
  double seconds; /* that it took */
};

/* ---- figures ---- */

/*
 * Reports a figure. Of those with the same text the worst value stays: cases add the same figure for each camera, light
 * or setting.
 */
__attribute__((format(printf, 5, 6))) void hard_figure_add(hard_run *run, double value, double bound, const char *unit,
                                                           const char *format, ...);
bool hard_figure_holds(const hard_figure *figure);

/* ---- scenes ---- */

/*
 * An empty scene with the default configuration, a light from above at an angle, and a picture of that size. Everything
 * may be changed before hard_load. setup_free frees it.
 */
void hard_setup_begin(host_setup *out, uint32_t width, uint32_t height);
/* Adds what was built as a mesh with one instance whose own origin lies at `position`; NULL: at the world's. */
void hard_add(host_setup *setup, mesh_builder *b, const char *name, const double position[3]);
/* A level square that looks up, `half` metres to each side of a point, in cells * cells * 2 triangles. */
void hard_ground(mesh_builder *b, const double center[3], double half, uint32_t cells);
/*
 * A yard of 60 m with boxes, posts, a wall and, if they are wanted, balls; a camera at eye level and shadows to 60 m.
 * All places are multiples of 1/8 m, and so are all vertices but those of balls.
 */
void hard_yard(host_setup *setup, bool balls);
/* Places the camera: reversed, near 0.1 m, without a far plane. Whoever wants another one sets setup->camera. */
void hard_look(host_setup *setup, const double from[3], const double at[3], double vertical_fov_deg);
/* View depth to which there are shadows, of the configuration and of the truth. */
void hard_reach(host_setup *setup, double meters);
/* The way the light travels, for a sun at a height over the horizon, and an azimuth from +x towards +z. */
scene_light hard_sun(double height_deg, double azimuth_deg);
/*
 * Moves and turns everything, instances, camera and light, by a rigid transform. A translation by numbers whose sums
 * with the places are exact is exact.
 */
void hard_place(host_setup *setup, const double rigid[16]);

/* ---- settings ---- */

/* Filters on moments, soft ones and those that send rays, with as many different settings: for cases that look at every
 * kind. */
typedef struct hard_filter {
  const char *name;
  uint32_t filter;
  uint32_t format, blur_texels, levels, sampling; /* of moments */
} hard_filter;

/* Those on moments that have no search come first, and those that send rays last. */
enum { HARD_MOMENT_FILTERS = 4, HARD_FILTERS = 7, HARD_EXACT = HARD_FILTERS, HARD_ALL_FILTERS = 9 };
extern const hard_filter hard_filters[HARD_ALL_FILTERS];

void hard_filter_set(csm_config *config, const hard_filter *filter);

/* ---- drawing ---- */

/*
 * Uploads the scene to every backend, in place of what was there, with new cascades that have no history. `setup` must
 * stay until hard_unload or the next hard_load. 0, or a code after a message; so all that return an int.
 */
int hard_load(hard_run *run, const host_setup *setup);
void hard_unload(hard_run *run);
/* Other settings, for the same cascades; or new cascades with them, that have no history. */
int hard_configure(hard_run *run, const csm_config *config);
int hard_restart(hard_run *run, const csm_config *config);

enum {
  HARD_DEPTH = 1u << 0,   /* view depth, too */
  HARD_CASCADES = 1u << 1 /* and which cascade each pixel takes, as CSM_SHOW_CASCADE has it */
};

/* What was drawn, top row first. */
typedef struct hard_picture {
  uint32_t width, height;
  float *mask, *view_depth, *cascades; /* view_depth: in metres; INFINITY where nothing is */
} hard_picture;

/* Whether hard_draw's maps are drawn for what this frame's depth shows. */
void hard_by_depth(hard_run *run, bool by_depth);

/*
 * Draws the maps and the mask, a frame after the last one, on every backend; `wanted` is HARD_*. *out, which may hold
 * an earlier picture or zeros, gets the first backend's; where another's differs, a figure says so.
 */
int hard_draw(hard_run *run, const camera *from, const scene_light *light, uint32_t wanted, hard_picture *out);
/* The mask that another camera sees, from the maps that are there. */
int hard_resolve(hard_run *run, const camera *from, uint32_t wanted, hard_picture *out);
void hard_picture_free(hard_picture *picture);
/* What a call of csm's came to: 0, or a code after a message that names it. */
int hard_called(csm_result result, const char *what);
/* CSM_INSTANCE_* of the scene's instances from one to before another, on every backend. */
int hard_flag(hard_run *run, size_t begin, size_t end, uint32_t flags);
/* Cascades and constants of the last frame. */
int hard_bind(hard_run *run, csm_binding *binding);
/* What a depth in a cascade's map means: metres along the light from the world's origin. */
double hard_along(const csm_cascade_info *cascade, const scene_light *light, double depth);
/* A map of the last frame, to be freed. Side is its texels. */
int hard_map(hard_run *run, uint32_t cascade, float **out, uint32_t *side);

/* What an engine hands over in place of what csm makes itself. */
typedef struct hard_inputs {
  const float *camera_depth; /* as the camera's projection has it; NULL: csm draws its own */
  const float (*normals)[4]; /* unit, in the world; NULL: they come from the depth */
  bool engine_buffers;       /* the meshes lie in the engine's own buffers */
} hard_inputs;

/*
 * Whether there is an engine's device: of Vulkan alone. Cases leave those figures out where there is none. It is opened
 * by the first hard_draw_engine after hard_load, with the setup's configuration.
 */
bool hard_has_engine(const hard_run *run);
/* As hard_draw, on an engine's device, with history of its own. */
int hard_draw_engine(hard_run *run, const hard_inputs *inputs, const camera *from, const scene_light *light,
                     hard_picture *out);
/* As hard_map, with the cascade, of the last hard_draw_engine with such inputs. Precondition: D32, an array of maps. */
int hard_map_engine(hard_run *run, const hard_inputs *inputs, uint32_t index, csm_cascade_info *cascade, float **out);

/* ---- truth ---- */

typedef struct hard_truth {
  camera camera;
  scene_light light;
  double shadow_distance;
  truth_view view;
  float *visibility;           /* 1 lit, 0 shadowed */
  int64_t *silhouette_squares; /* square of the distance to the next silhouette, in pixels */
  int64_t *edge_squares;       /* and to the next edge of a shadow */
} hard_truth;

/* Casts what a camera sees of the loaded scene. *out may hold an earlier truth or zeros. */
int hard_cast(hard_run *run, const camera *from, const scene_light *light, hard_truth *out);
void hard_truth_free(hard_truth *truth);
/* What a truth's camera would have in its depth buffer, and the geometric normals, to be freed: for hard_inputs. */
float *hard_true_depth(const hard_truth *truth);
float (*hard_true_normals(const hard_truth *truth))[4];
/* As hard_draw_engine, what a truth's camera sees under its light, with its normals. */
int hard_draw_normals(hard_run *run, const hard_truth *truth, hard_picture *out);

/* Pixels nearer to a silhouette (neighbours on surfaces that do not join there), or to a true shadow's edge, than this
 * are not judged, nor are those that the light grazes: the cosine to it is no more than that. */
typedef struct hard_margin {
  double silhouette_px, edge_px, cosine;
} hard_margin;

/* Of the pixels whose surface is turned to the light, lies within the shadow distance and outside the margins. */
typedef struct hard_count {
  uint64_t judged, lit;           /* lit: by the truth */
  uint64_t false_dark, false_lit; /* more than half wrong */
  double rms;
} hard_count;

/* Counts wrong pixels. What is around the worst one becomes the case's picture, if nothing worse was seen before. */
hard_count hard_judge(hard_run *run, const hard_truth *truth, const float *mask, hard_margin margin);
/* The figures of docs/accuracy.md: set S, rmse, acne, leak. The picture has HARD_DEPTH. */
int hard_measure(metrics *out, const hard_truth *truth, const hard_picture *drawn);

/* ---- comparing masks ---- */

typedef struct hard_difference {
  uint64_t pixels; /* that differ by more than `tolerance` */
  double largest;
} hard_difference;

/* Two pictures of one size. The worst pixel becomes the case's picture, likewise. */
hard_difference hard_compare(hard_run *run, const hard_picture *expected, const hard_picture *drawn, double tolerance);

/* ---- moving ---- */

/*
 * Draws the maps and mask of each frame, `count` of them, cameras and lights, on every backend, and hands each pair of
 * neighbours' flicker to `each`, with the index of its second frame.
 */
typedef struct hard_path {
  uint32_t count;
  bool alone; /* by the first backend only */
  const camera *cameras;
  const scene_light *lights;
  void (*each)(void *user, uint32_t index, const flicker *pair);
  void *user;
} hard_path;

int hard_walk(hard_run *run, const hard_path *path);

/* ---- the command ---- */

/* Runs the cases that the options name. An exit code: HOST_DIFFER if a figure does not hold. */
int hard_command(const host_options *options);

/* The two pictures side by side, each pixel as a square. What is wrongly dark is blue, what is wrongly lit red; on the
 * left, what is not judged is bluish grey. */
void hard_worst_picture(image *out, const hard_worst *worst);
/* Runs one case and hands its figures over. hard_run_close is allowed in both cases. */
int hard_run_case(hard_run *out, const hard_case *which, const host_options *options);
void hard_run_close(hard_run *run);
/* Whether all figures hold; and all of them as JSON, a new object. */
bool hard_run_holds(const hard_run *run);
json_t *hard_run_to_json(const hard_run *run);

#endif
