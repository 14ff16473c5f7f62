/*
 * huge_ground.c: a level ground of two triangles, up to a thousand kilometres to each side. Floats put its vertices off
 * their place by as much as a texel and more, so receivers are moved towards the light by what that takes.
 */
#include "base/linear.h"
#include "csm_constants.h"
#include "hard/hard.h"
#include <math.h>

enum { lights = 16 };

typedef struct huge_ground {
  double half, middle[3]; /* of the ground is where the camera is not */
  hard_picture drawn;
  hard_truth truth;
} huge_ground;

/* The ground, a card 2 m up and a box, in front of the camera. */
static void make_ground(host_setup *out, const huge_ground *ground) {
  mesh_builder b = {0};
  hard_setup_begin(out, 320, 180);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, ground->half, 1);
  hard_add(out, &b, "ground", ground->middle);
  builder_box(&b, (const double[3]){-2.0, 0.0, -2.0}, (const double[3]){2.0, 0.1, 2.0});
  hard_add(out, &b, "card", (const double[3]){0.0, 2.0, 0.0});
  builder_box(&b, (const double[3]){-1.0, -1.0, -1.0}, (const double[3]){1.0, 3.0, 1.0});
  hard_add(out, &b, "box", (const double[3]){6.0, 0.0, -8.0});
  hard_look(out, (const double[3]){0.0, 3.0, 12.0}, (const double[3]){0.0, 1.0, 0.0}, 60.0);
  hard_reach(out, 60.0);
}

/* How far a map's receivers are moved towards the light: constants are moved, and world_to_shadow is not. */
static double moved_by(const csm_binding *binding, uint32_t cascade) {
  const csm_cascades_block *block = binding->cascade_constants;
  const csm_cascade_info *info = &binding->cascades[cascade];
  double at[4];
  mat_transform(at, info->world_to_shadow, binding->origin, 1.0);
  return (at[2] - (double)block->offsets[cascade][2]) * info->depth_range;
}

/*
 * Two roundings, of maps and of the camera's depth: each 2^-24 of the way to the farthest corner, along the light and,
 * by the ground's slope, across it. What the constants are rounded to comes on top: 2^-24 of the range.
 */
static int add_moves(hard_run *run, const huge_ground *ground, const scene_light *light) {
  csm_binding binding;
  const int code = hard_bind(run, &binding);
  if (code)
    return code;
  const double across = hypot(ground->middle[0], ground->middle[2]) + 200.0;
  const double slope = hypot(light->direction[0], light->direction[2]) / fabs(light->direction[1]);
  const double bound = 2.0 * 0x1p-24 * (sqrt(2.0) * ground->half + across) * (1.0 + slope);
  for (uint32_t c = 0; c < binding.cascade_count; c++)
    hard_figure_add(run, moved_by(&binding, c) / (bound + 0x1p-23 * binding.cascades[c].depth_range), 1.0, "1",
                    "moved towards the light, of what is derived, %.0e m", ground->half);
  return 0;
}

static int draw_light(hard_run *run, huge_ground *ground, const host_setup *setup, const scene_light *light) {
  int code = hard_draw(run, &setup->camera, light, 0, &ground->drawn);
  if (code == 0)
    code = hard_cast(run, &setup->camera, light, &ground->truth);
  if (code == 0)
    code = add_moves(run, ground, light);
  if (code)
    return code;
  /* Three pixels are more than a filter's reach of two texels of each cascade's. */
  const hard_margin margin = {.silhouette_px = 2.0, .edge_px = 3.0};
  const hard_count count = hard_judge(run, &ground->truth, ground->drawn.mask, margin);
  hard_figure_add(run, (double)count.false_dark, 0.0, "px", "dark though lit, ground of %.0e m", ground->half);
  hard_figure_add(run, (double)count.false_lit, 0.0, "px", "lit though dark, ground of %.0e m", ground->half);
  return 0;
}

/* The camera stands at the ground's middle, and far from it. */
static int draw_ground(hard_run *run, huge_ground *ground, double half, bool aside) {
  static const double heights[] = {20.0, 35.0, 50.0, 75.0};
  host_setup setup;
  ground->half = half;
  ground->middle[0] = aside ? -0.5 * half : 0.0;
  ground->middle[2] = aside ? 0.25 * half : 0.0;
  make_ground(&setup, ground);
  int code = hard_load(run, &setup);
  for (int i = 0; code == 0 && i < lights; i++) {
    const scene_light sun = hard_sun(heights[i % 4], 360.0 * i / lights + 5.0);
    code = draw_light(run, ground, &setup, &sun);
  }
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  static const double halves[] = {1e5, 1e6, 1e4, 3e4, 3e5, 1e3};
  const size_t count = run->sweep ? sizeof halves / sizeof halves[0] : 2;
  huge_ground ground = {0};
  int code = 0;
  for (size_t i = 0; code == 0 && i < count; i++)
    for (int aside = 0; code == 0 && aside < (run->sweep ? 2 : 1); aside++)
      code = draw_ground(run, &ground, halves[i], aside || !run->sweep);
  hard_truth_free(&ground.truth);
  hard_picture_free(&ground.drawn);
  return code;
}

const hard_case hard_huge_ground = {
    .name = "huge_ground", .about = "a ground of two triangles, up to 10^6 m, under 16 lights", .run = run_case};
