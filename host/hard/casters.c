/*
 * casters.c: casters that a plan might lose: behind the camera, far up the light, past the shadow distance, larger than
 * everything, across all maps; and those that a map might lose: thin, without thickness, open, inside of each other.
 */
#include "base/host.h"
#include "base/linear.h"
#include "hard/hard.h"
#include <math.h>
#include <stdlib.h>

/* Vertices out here make a mesh's box so wide that nothing is culled. Floats put it off by less than the bias still. */
#define WIDE 1500.0

typedef struct caster_scene {
  host_setup setup;
  mesh_builder builder;
  bool wide; /* each mesh has two vertices far out */
} caster_scene;

typedef struct caster_drawing {
  hard_picture drawn, other;
  hard_truth truth;
  size_t hidden; /* wires whose shadow they hide */
} caster_drawing;

/* ---- building ---- */

static void add(caster_scene *s, const char *name, const double position[3]) {
  for (int side = -1; s->wide && side <= 1; side += 2) {
    const uint32_t vertex = builder_vertex(&s->builder, side * WIDE, side * WIDE, side * WIDE);
    builder_triangle(&s->builder, vertex, vertex, vertex);
  }
  hard_add(&s->setup, &s->builder, name, position);
}

/* A box of its own size, on a point that is the middle of its lower face. */
static void add_box(caster_scene *s, const double at[3], const double size[3]) {
  builder_box(&s->builder, (const double[3]){-size[0] / 2.0, 0.0, -size[2] / 2.0},
              (const double[3]){size[0] / 2.0, size[1], size[2] / 2.0});
  add(s, "box", at);
}

/* A wall without thickness, on a foot from end to end. Its upper edge leans over along x. */
typedef struct caster_sheet {
  double ends[2][2]; /* x, z */
  double height, lean;
} caster_sheet;

static void add_sheet(caster_scene *s, const caster_sheet *sheet) {
  const double x = sheet->ends[1][0] - sheet->ends[0][0], z = sheet->ends[1][1] - sheet->ends[0][1];
  const double h = sheet->height, lean = sheet->lean;
  const double corners[4][3] = {{0, 0, 0}, {x, 0, z}, {x + lean, h, z}, {lean, h, 0}};
  builder_quad(&s->builder, corners);
  add(s, "sheet", (const double[3]){sheet->ends[0][0], 0, sheet->ends[0][1]});
}

/* The distance of a point on the ground to a sheet's foot. */
static double foot_distance(const caster_sheet *sheet, const double point[2]) {
  const double *a = sheet->ends[0], way[2] = {sheet->ends[1][0] - a[0], sheet->ends[1][1] - a[1]};
  const double to[2] = {point[0] - a[0], point[1] - a[1]};
  const double along = (to[0] * way[0] + to[1] * way[1]) / (way[0] * way[0] + way[1] * way[1]);
  const double share = fmin(fmax(along, 0.0), 1.0);
  return hypot(to[0] - share * way[0], to[1] - share * way[1]);
}

static void begin(caster_scene *s, const double from[3], const double at[3], double reach) {
  hard_setup_begin(&s->setup, 320, 180);
  s->setup.config.resolution = 1024;
  hard_look(&s->setup, from, at, 60.0);
  hard_reach(&s->setup, reach);
  hard_ground(&s->builder, (const double[3]){0.0, 0.0, 0.0}, 150.0, 8);
  add(s, "ground", (const double[3]){0.0, 0.0, -40.0});
}

/* ---- the scenes ---- */

/* A wall 12 m behind the camera, whose shadow falls past it. */
static void make_behind(caster_scene *s) {
  begin(s, (const double[3]){0, 2, 0}, (const double[3]){0, 0.5, -6}, 100.0);
  s->setup.light = hard_sun(25.0, 90.0);
  add_box(s, (const double[3]){0, 0, 12}, (const double[3]){6, 8, 0.5});
}

/* A slab a thousand kilometres up the light. */
static void make_up_the_light(caster_scene *s) {
  begin(s, (const double[3]){0, 3, 0}, (const double[3]){0, 0, -12}, 100.0);
  s->setup.light = hard_sun(40.0, 30.0);
  double at[3] = {0.0, 0.0, -14.0};
  for (int i = 0; i < 3; i++)
    at[i] -= 1e6 * s->setup.light.direction[i];
  add_box(s, at, (const double[3]){6, 0.2, 6});
}

/* A wall 20 m past the end of the shadows, which falls towards the camera. */
static void make_ahead(caster_scene *s) {
  begin(s, (const double[3]){0, 3, 0}, (const double[3]){0, 0, -20}, 60.0);
  s->setup.light = hard_sun(25.0, 270.0);
  add_box(s, (const double[3]){0, 0, -80}, (const double[3]){14, 40, 1});
}

/* A roof of one triangle, 10^5 m long, whose edge crosses the picture. */
static void make_triangle(caster_scene *s) {
  begin(s, (const double[3]){0, 3, 0}, (const double[3]){0, 0, -15}, 100.0);
  s->setup.light = hard_sun(50.0, 200.0);
  const double corners[3][3] = {{-22.0, 0.0, -1e5}, {-22.0, 0.0, 1e5}, {-1e5, 0.0, 0.0}};
  for (int i = 0; i < 3; i++)
    builder_vertex(&s->builder, corners[i][0], corners[i][1], corners[i][2]);
  const uint32_t first = (uint32_t)s->builder.vertex_count - 3;
  builder_triangle(&s->builder, first, first + 1, first + 2);
  hard_add(&s->setup, &s->builder, "roof", (const double[3]){0, 30, 0}); /* which is never culled */
}

/* A wall along the view, into every map. */
static void make_across(caster_scene *s) {
  begin(s, (const double[3]){0, 3, 0}, (const double[3]){1, 1, -20}, 100.0);
  s->setup.light = hard_sun(35.0, 20.0);
  add_box(s, (const double[3]){4, 0, -48}, (const double[3]){0.5, 3, 94});
}

/* Upright, leaning, and crossing each other; and an open box. */
static const caster_sheet yard[] = {
    {{{-6, -9.3}, {-2, -8.7}}, 3.0, 0.0}, {{{3, -11}, {5, -9}}, 3.0, 1.0},   {{{-2, -19}, {2, -17}}, 4.0, 0.0},
    {{{1, -20}, {-1, -16}}, 4.0, 0.0},    {{{7, -16}, {10, -16}}, 2.0, 0.0}, {{{10, -16}, {10, -13}}, 2.0, 0.0},
    {{{10, -13}, {7, -13}}, 2.0, 0.0},    {{{7, -13}, {7, -16}}, 2.0, 0.0},
};
enum { yard_count = sizeof yard / sizeof yard[0] };

static void make_sheets(caster_scene *s) {
  begin(s, (const double[3]){0, 4, 2}, (const double[3]){0, 0.5, -12}, 60.0);
  s->setup.light = hard_sun(40.0, 220.0);
  for (size_t i = 0; i < yard_count; i++)
    add_sheet(s, &yard[i]);
}

/* Closed boxes, some inside of others, and a ball half in the ground. */
static void make_solids(caster_scene *s) {
  begin(s, (const double[3]){0, 5, 3}, (const double[3]){0, 0.5, -12}, 60.0);
  s->setup.light = hard_sun(45.0, 130.0);
  add_box(s, (const double[3]){-5, 0, -9}, (const double[3]){2, 3, 2});
  add_box(s, (const double[3]){-4.3, 0, -9.6}, (const double[3]){2, 2, 2});
  add_box(s, (const double[3]){-4.6, 1.5, -9.2}, (const double[3]){1, 2.5, 4});
  builder_ball(&s->builder, (const double[3]){0, 0, 0}, (const double[3]){2, 2, 2}, 4, 0.0, 1);
  add(s, "ball", (const double[3]){0, 0.5, -20});
}

/* Inside a room of thick walls and a lid: all is dark, to the corners. */
static void make_room(caster_scene *s) {
  begin(s, (const double[3]){-2.5, 2, 2.5}, (const double[3]){1, 0.5, -3}, 60.0);
  s->setup.light = hard_sun(45.0, 130.0);
  add_box(s, (const double[3]){0, 3.5, 0}, (const double[3]){9, 0.5, 9});
  for (int side = 0; side < 4; side++) {
    const double sign = side & 1 ? -1.0 : 1.0;
    const bool x = side < 2;
    add_box(s, (const double[3]){x ? sign * 4.25 : 0.0, -0.5, x ? 0.0 : sign * 4.25},
            (const double[3]){x ? 0.5 : 9.0, 4.25, x ? 9.0 : 0.5});
  }
}

typedef struct caster_kind {
  const char *name;
  void (*make)(caster_scene *s);
  bool dark;   /* everything that is seen, to its edges */
  bool sheets; /* they are the yard's */
} caster_kind;

static const caster_kind kinds[] = {
    {.name = "behind the camera", .make = make_behind},
    {.name = "10^6 m up the light", .make = make_up_the_light},
    {.name = "past the end", .make = make_ahead},
    {.name = "a triangle of 10^5 m", .make = make_triangle},
    {.name = "across all maps", .make = make_across},
    {.name = "walls without thickness", .make = make_sheets, .sheets = true},
    {.name = "solids", .make = make_solids},
    {.name = "inside a room", .make = make_room, .dark = true},
};

static caster_scene make_scene(const caster_kind *kind, bool wide) {
  caster_scene s = {.wide = wide};
  kind->make(&s);
  return s;
}

/* ---- nothing is lost ---- */

/*
 * The largest distance, of the pixels that are wrongly lit, from the next foot: they are on the ground, dark by the
 * truth, and clear of silhouettes and edges.
 */
static double lit_from_foot(const host_setup *setup, const caster_drawing *d) {
  const hard_truth *truth = &d->truth;
  double farthest = 0.0;
  camera_rays rays;
  camera_rays_make(&rays, &setup->camera, setup->width, setup->height);
  for (uint32_t i = 0; i < setup->width * setup->height; i++) {
    const truth_surface *surface = &truth->view.surfaces[i];
    if (surface->triangle == TRUTH_NOTHING || surface->normal[1] < 0.99f || truth->silhouette_squares[i] < 4 ||
        truth->edge_squares[i] < 9 || surface->view_depth > setup->shadow_distance ||
        d->drawn.mask[i] <= truth->visibility[i] + 0.5f)
      continue;
    double point[3], nearest = INFINITY;
    camera_point(&rays, &setup->camera, camera_pixel_x(&rays, i % setup->width),
                 camera_pixel_y(&rays, i / setup->width), surface->view_depth, point);
    const double at[2] = {point[0] + setup->camera.position[0], point[2] + setup->camera.position[2]};
    for (size_t k = 0; k < yard_count; k++)
      nearest = fmin(nearest, foot_distance(&yard[k], at));
    farthest = fmax(farthest, nearest);
  }
  return farthest;
}

/*
 * The bias lifts a receiver over a sheet that is nearer than it: by half a texel, and half of the slope along each axis,
 * 1.19 at 40 degrees, so that both are at most 0.84. Of 1.34 texels cos 40 is along the ground. Texels' centres are up
 * to half a texel beside, seen at an angle of 40 degrees.
 */
static int judge_feet(hard_run *run, const host_setup *setup, const caster_drawing *d) {
  csm_binding binding;
  const int code = hard_bind(run, &binding);
  if (code)
    return code;
  /* What lies 20 m away is in the third map at the latest. */
  hard_figure_add(run, lit_from_foot(setup, d) / binding.cascades[2].texel_size, 1.03 + 0.78, "texels",
                  "lit behind the foot of a wall without thickness");
  return 0;
}

static int judge(hard_run *run, const caster_kind *kind, const host_setup *setup, caster_drawing *d) {
  int code = hard_load(run, setup);
  if (code == 0)
    code = hard_draw(run, &setup->camera, &setup->light, 0, &d->drawn);
  if (code == 0)
    code = hard_cast(run, &setup->camera, &setup->light, &d->truth);
  if (code)
    return code;
  /* Three pixels hold the two texels that a filter reaches. */
  const hard_margin margin = {.silhouette_px = 2.0, .edge_px = kind->dark ? 0.0 : 3.0};
  const hard_count count = hard_judge(run, &d->truth, d->drawn.mask, margin);
  if (kind->sheets)
    code = judge_feet(run, setup, d);
  else
    hard_figure_add(run, (double)count.false_lit, 0.0, "px", "lit though dark: %s", kind->name);
  hard_figure_add(run, (double)count.false_dark, 0.0, "px", "dark though lit: %s", kind->name);
  hard_figure_add(run, count.judged > 5000 && count.judged > count.lit + 300 ? 0.0 : 1.0, 0.0, "1",
                  "pictures without shadows, by the truth");
  return code;
}

/* Ranges that do not follow casters, so that a box that is wider changes what is culled, and nothing else. */
static int draw_fixed(hard_run *run, host_setup *setup, hard_picture *drawn) {
  setup->config.depth_mode = CSM_DEPTH_SLICE;
  const int code = hard_load(run, setup);
  return code ? code : hard_draw(run, &setup->camera, &setup->light, 0, drawn);
}

static int compare_culling(hard_run *run, const caster_kind *kind, host_setup *culled, caster_drawing *d) {
  caster_scene wide = make_scene(kind, true);
  int code = draw_fixed(run, culled, &d->drawn);
  if (code == 0)
    code = draw_fixed(run, &wide.setup, &d->other);
  if (code == 0) {
    const hard_difference difference = hard_compare(run, &d->other, &d->drawn, 0.0);
    /* The same triangles are drawn by the same matrices: a caster that was left out wrongly would be missed. */
    hard_figure_add(run, (double)difference.pixels, 0.0, "px", "pixels that culling changes: %s", kind->name);
  }
  hard_unload(run);
  setup_free(&wide.setup);
  return code;
}

static int draw_kind(hard_run *run, const caster_kind *kind, caster_drawing *d) {
  caster_scene s = make_scene(kind, false);
  int code = judge(run, kind, &s.setup, d);
  if (code == 0)
    code = compare_culling(run, kind, &s.setup, d);
  hard_unload(run);
  setup_free(&s.setup);
  return code;
}

/* ---- what a view leaves out ---- */

/* Boxes in the air all around a narrow view, under a large sun: each of its own, and every other row a mesh that is drawn
 * in parts. */
static void make_crowd(caster_scene *s) {
  begin(s, (const double[3]){0, 6, 4}, (const double[3]){0.5, 0, -6}, 40.0);
  hard_look(&s->setup, (const double[3]){0, 6, 4}, (const double[3]){0.5, 0, -6}, 24.0);
  s->setup.light = hard_sun(50.0, 60.0);
  s->setup.light.disc_deg = 8.0;
  for (int i = 0; i < 32 * 32; i++) {
    const double at[3] = {-31.0 + 2.0 * (i % 32), 3.0 + i % 3, 12.0 - 2.0 * (i / 32)};
    builder_box(&s->builder, (const double[3]){at[0] - 0.35, at[1], at[2] - 0.35},
                (const double[3]){at[0] + 0.35, at[1] + 0.3, at[2] + 0.35});
    if (i / 32 % 2 == 0 || i % 32 == 31)
      add(s, "boxes", (const double[3]){0.0, 0.0, 0.0});
  }
}

/* A filter that reads far beside what it is asked for. */
typedef struct reader {
  const char *name;
  uint32_t filter, blur, levels, sampling;
} reader;

static csm_config reader_config(const host_setup *setup, const reader *r, uint32_t cascades, uint32_t caster_set) {
  csm_config config = setup->config;
  config.caster_set = caster_set;
  config.depth_mode = CSM_DEPTH_SLICE; /* ranges that do not follow casters */
  config.cascade_count = cascades;
  config.resolution = 512;
  config.filter = r->filter;
  config.filter_taps = 31;
  config.soft_radius_max_texels = 32.0;
  config.moment_blur_texels = r->blur;
  config.moment_levels = r->levels ? r->levels : 1;
  config.moment_sampling = r->sampling;
  return config;
}

/* Draws with what casts into the maps, or for the view alone; *casters gets how many were drawn. */
static int draw_reader(hard_run *run, const csm_config *config, hard_picture *out, uint64_t *casters) {
  csm_stats stats = {.struct_size = sizeof stats};
  int code = hard_restart(run, config);
  if (code == 0)
    code = hard_draw(run, &run->setup->camera, &run->setup->light, 0, out);
  if (code == 0 && csm_get_stats(run->stages[0].cascades, &stats))
    code = HOST_NO_DEVICE;
  *casters = 0;
  for (uint32_t i = 0; i < stats.cascade_count; i++)
    *casters += stats.cascades[i].casters_drawn;
  return code;
}

/* What is drawn for the view, by its receivers or by this frame's depth, against what casts into the maps. */
static int compare_reader(hard_run *run, const caster_scene *s, const reader *r, uint32_t cascades, caster_drawing *d) {
  const csm_config whole = reader_config(&s->setup, r, cascades, CSM_CASTER_SET_MAP);
  const csm_config view = reader_config(&s->setup, r, cascades, CSM_CASTER_SET_VIEW);
  uint64_t all = 0, seen[2] = {0, 0};
  int code = draw_reader(run, &whole, &d->drawn, &all);
  for (int depth = 0; depth < 2 && code == 0; depth++) {
    hard_by_depth(run, depth);
    code = draw_reader(run, &view, &d->other, &seen[depth]);
    hard_by_depth(run, false);
    if (code)
      break;
    const hard_difference difference = hard_compare(run, &d->drawn, &d->other, 0.0);
    hard_figure_add(run, (double)difference.pixels, 0.0, "px", "pixels that %s changes: %s",
                    depth ? "this frame's depth" : "caster_set view", r->name);
  }
  if (code)
    return code;
  hard_figure_add(run, seen[0] < all ? 0.0 : 1.0, 0.0, "1", "views that leave no caster out");
  hard_figure_add(run, seen[1] < seen[0] ? 0.0 : 1.0, 0.0, "1", "depths that leave no more casters out");
  return 0;
}

/* Each with one map and with three; the short form has these in turn. */
static int draw_readers(hard_run *run, caster_drawing *d) {
  static const reader readers[] = {{"pcf_n of 31 taps", CSM_FILTER_PCF_N, 0, 0, 0},
                                   {"evsm4, a blur of 32", CSM_FILTER_EVSM4, 32, 0, 0},
                                   {"evsm4, 6 levels", CSM_FILTER_EVSM4, 3, 6, CSM_SAMPLING_TRILINEAR},
                                   {"evsm4, anisotropic", CSM_FILTER_EVSM4, 0, 5, CSM_SAMPLING_ANISOTROPIC},
                                   {"pcss, 32 texels", CSM_FILTER_PCSS, 0, 0, 0},
                                   {"backprojection, 32 texels", CSM_FILTER_BACKPROJECTION, 0, 0, 0},
                                   {"vssm, 32 texels", CSM_FILTER_VSSM, 4, 6, CSM_SAMPLING_TRILINEAR},
                                   {"exact", CSM_FILTER_EXACT, 0, 0, 0},
                                   {"exact_soft, 32 texels", CSM_FILTER_EXACT_SOFT, 0, 0, 0}};
  caster_scene s = {0};
  make_crowd(&s);
  int code = hard_load(run, &s.setup);
  for (size_t i = 0; code == 0 && i < 2 * sizeof readers / sizeof readers[0]; i++) {
    const reader *r = &readers[i / 2];
    if (run->sweep || i % 2 == i / 2 % 2)
      code = compare_reader(run, &s, r, i % 2 ? 3 : 1, d);
  }
  hard_unload(run);
  setup_free(&s.setup);
  return code;
}

/* ---- wires ---- */

/* A picture from above of a ground under one coarse map, with a wire 3 m up. */
static void make_wire(caster_scene *s, double width, double turn) {
  const double cosine = cos(turn), sine = sin(turn), sides = 24.0, pi = 3.14159265358979323846;
  const double radius = width / 2.0 / cos(pi / sides); /* no side of the tube is narrower */
  begin(s, (const double[3]){0, 9, 1}, (const double[3]){0, 0, -2}, 30.0);
  s->setup.config.cascade_count = 1;
  s->setup.config.resolution = 256;
  s->setup.light = hard_sun(50.0, 213.0);
  if (width > 0.0) {
    builder_tube(&s->builder, (const double[3]){-9.0 * cosine, 0, -9.0 * sine},
                 (const double[3]){9.0 * cosine, 0, 9.0 * sine}, radius, radius, (uint32_t)sides);
    add(s, "wire", (const double[3]){0, 3, -4});
  }
}

/* The share of the pixels in the wire's shadow at which nothing of it was drawn; negative: the wire hides it. */
static double lost_share(const hard_truth *truth, const float *mask) {
  uint64_t dark = 0, lost = 0;
  for (size_t i = 0; i < (size_t)truth->view.width * truth->view.height; i++) {
    const truth_surface *surface = &truth->view.surfaces[i];
    if (surface->triangle == TRUTH_NOTHING || surface->normal[1] < 0.99f || truth->visibility[i] >= 0.5f ||
        surface->view_depth > truth->shadow_distance || truth->silhouette_squares[i] < 4)
      continue;
    dark++;
    lost += mask[i] > 254.0f / 255.0f;
  }
  return dark ? (double)lost / (double)dark : -1.0;
}

/*
 * By the default, and by rays, which find a whole wire where a map has a part of it.
 *
 * What is as wide as a texel is long across holds a texel's centre in each row or column that it passes.
 */
static int draw_wire(hard_run *run, double texels, double width, double turn, caster_drawing *d) {
  caster_scene s = {0};
  make_wire(&s, width, turn);
  int code = hard_load(run, &s.setup);
  if (code == 0)
    code = hard_cast(run, &s.setup.camera, &s.setup.light, &d->truth);
  for (int rays = 0; code == 0 && rays < 2; rays++) {
    csm_config config = s.setup.config;
    if (rays)
      hard_filter_set(&config, &hard_filters[HARD_EXACT]);
    code = hard_configure(run, &config);
    if (code == 0)
      code = hard_draw(run, &s.setup.camera, &s.setup.light, 0, &d->drawn);
    const double share = code == 0 ? lost_share(&d->truth, d->drawn.mask) : -1.0;
    d->hidden += share < 0.0;
    if (share >= 0.0)
      hard_figure_add(run, share, texels >= 1.4 ? 0.0 : INFINITY, "1",
                      "share of its shadow that a wire of %.3g texels loses%s", texels, rays ? ", exact" : "");
  }
  hard_unload(run);
  setup_free(&s.setup);
  return code;
}

static int find_texel(hard_run *run, double *texel, caster_drawing *d) {
  caster_scene s = {0};
  csm_binding binding;
  make_wire(&s, 0.0, 0.0);
  int code = hard_load(run, &s.setup);
  if (code == 0)
    code = hard_draw(run, &s.setup.camera, &s.setup.light, 0, &d->drawn);
  if (code == 0)
    code = hard_bind(run, &binding);
  if (code == 0)
    *texel = binding.cascades[0].texel_size;
  hard_unload(run);
  setup_free(&s.setup);
  return code;
}

static int draw_wires(hard_run *run, caster_drawing *d) {
  static const double widths[] = {4.0, 1.4, 1.0, 0.5, 0.25, 0.1, 2.0, 0.7};
  const size_t count = run->sweep ? sizeof widths / sizeof widths[0] : 6;
  const int turns = run->sweep ? 24 : 2;
  double texel;
  int code = find_texel(run, &texel, d);
  for (size_t i = 0; code == 0 && i < count; i++)
    for (int turn = 0; code == 0 && turn < turns; turn++)
      code = draw_wire(run, widths[i], widths[i] * texel, 3.1416 * turn / turns + 0.1, d);
  if (code == 0)
    hard_figure_add(run, d->hidden * 10 < 2 * count * (size_t)turns ? 0.0 : 1.0, 0.0, "1",
                    "wires that hide their shadows");
  return code;
}

/* ---- the case ---- */

static int run_case(hard_run *run) {
  caster_drawing d = {0};
  int code = 0;
  for (size_t i = 0; code == 0 && i < sizeof kinds / sizeof kinds[0]; i++)
    code = draw_kind(run, &kinds[i], &d);
  if (code == 0)
    code = draw_readers(run, &d);
  if (code == 0)
    code = draw_wires(run, &d);
  hard_truth_free(&d.truth);
  hard_picture_free(&d.drawn);
  hard_picture_free(&d.other);
  return code;
}

const hard_case hard_casters = {
    .name = "casters", .about = "casters that planning, culling or sampling might lose", .run = run_case};
