/*
 * low_sun.c: suns down to a tenth of a degree, over a plane, balls, a wall a metre thick and one of 2 cm. What is lit is
 * lit, and what stands on the ground casts from close by.
 */
#include "hard/hard.h"
#include <math.h>

/* The short form has half of the pixels across the bare plane, and of the texels. */
static void make_yard(host_setup *out, bool bare, bool few) {
  mesh_builder b = {0};
  hard_setup_begin(out, few ? 160 : 320, few ? 90 : 180);
  out->config.resolution = few ? 1024 : 2048;
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 400.0, 2);
  hard_add(out, &b, "ground", NULL);
  if (!bare) {
    builder_box(&b, (const double[3]){-6.0, 0.0, -0.5}, (const double[3]){-1.0, 1.0, 0.5});
    hard_add(out, &b, "thick wall", NULL);
    builder_box(&b, (const double[3]){1.0, 0.0, -0.01}, (const double[3]){6.0, 1.0, 0.01});
    hard_add(out, &b, "thin wall", NULL);
    builder_ball(&b, (const double[3]){0.0, 1.0, 4.0}, (const double[3]){0.75, 0.75, 0.75}, 5, 0.0, 1);
    hard_add(out, &b, "ball", NULL);
  }
  hard_look(out, (const double[3]){0.0, 4.0, 12.0}, (const double[3]){0.0, 1.0, 0.0}, 50.0);
  hard_reach(out, 100.0);
}

/* ---- acne ---- */

/*
 * Nothing that is lit is dark: a receiver's own texels have no say, whatever its slope. Where depths change, normals are
 * taken from what lies beside: two pixels of it are left out. An edge of a shadow is off by the filter's half width, 2
 * texels, of less than a pixel here, along the ground by as many times more as the sun is low: the yard's shadows end
 * farther away than that, so that only their sides are edges, 3 px of which are left out.
 */
static void count_dark(hard_run *run, const hard_truth *truth, const hard_picture *drawn, double height,
                       double silhouette_px, double bound, const char *how) {
  const hard_margin margin = {.silhouette_px = silhouette_px, .edge_px = 3.0};
  const hard_count count = hard_judge(run, truth, drawn->mask, margin);
  hard_figure_add(run, (double)count.false_dark, bound, "px", "dark though lit, sun at %g degrees, %s", height, how);
}

/* The same sun and truth, with every kind of filter: on the plane alone, for most are wide. */
static int draw_filters(hard_run *run, const host_setup *setup, const scene_light *sun, const hard_truth *truth,
                        hard_picture *drawn, double height) {
  int code = 0;
  for (int i = 0; code == 0 && i < HARD_ALL_FILTERS; i++) {
    csm_config config = setup->config;
    hard_filter_set(&config, &hard_filters[i]);
    code = hard_restart(run, &config);
    if (code == 0)
      code = hard_draw(run, &setup->camera, sun, 0, drawn);
    if (code == 0)
      count_dark(run, truth, drawn, height, 2.0, 0.0, hard_filters[i].name);
  }
  return code ? code : hard_restart(run, &setup->config);
}

static int look_for_acne(hard_run *run, bool bare) {
  static const double heights[] = {5.0, 1.0, 0.1, 2.0, 0.5}, azimuths[] = {100.0, 40.0, 250.0};
  host_setup setup;
  hard_picture drawn = {0};
  hard_truth truth = {0};
  make_yard(&setup, bare, bare && !run->sweep);
  int code = hard_load(run, &setup);
  for (int i = 0; code == 0 && i < (run->sweep ? 15 : 3); i++) {
    const double height = heights[i % 5];
    const scene_light sun = hard_sun(height, azimuths[i / 5]);
    code = hard_draw(run, &setup.camera, &sun, 0, &drawn);
    if (code == 0)
      code = hard_cast(run, &setup.camera, &sun, &truth);
    if (code == 0)
      count_dark(run, &truth, &drawn, height, 2.0, 0.0, bare ? "a plane" : "a yard");
    if (code == 0 && bare && (run->sweep || height == 1.0)) /* so many filters take long */
      code = draw_filters(run, &setup, &sun, &truth, &drawn, height);
    if (code == 0 && hard_has_engine(run)) {
      code = hard_draw_normals(run, &truth, &drawn);
      if (code == 0)
        count_dark(run, &truth, &drawn, height, 0.0, 0.0,
                   bare ? "a plane, the engine's normals" : "a yard, the engine's normals");
    }
  }
  hard_truth_free(&truth);
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

/* ---- contact ---- */

enum { ACROSS = 64, DOWN = 512 };

static const double eye_height = 10.0, eye_z = -0.5, field_deg = 8.0;

/* A wall along x, `thickness` behind which its shadow begins at z = 0, from above; one map, whose texels are 1.2 cm. */
static void make_wall(host_setup *out, double thickness) {
  mesh_builder b = {0};
  hard_setup_begin(out, ACROSS, DOWN);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 40.0, 2);
  hard_add(out, &b, "ground", NULL);
  builder_box(&b, (const double[3]){-10.0, 0.0, 0.0}, (const double[3]){10.0, 1.0, thickness});
  hard_add(out, &b, "wall", NULL);
  hard_look(out, (const double[3]){0.0, eye_height, eye_z}, (const double[3]){0.0, 0.0, eye_z - 1e-3}, field_deg);
  hard_reach(out, 12.0);
  out->config.cascade_count = 1;
  out->config.resolution = 1024;
}

/* What is lit in the wall's shadow, in the picture's column where that is most, down to 0.6 m behind it: in metres. */
static double lit_behind(const hard_truth *truth, const hard_picture *drawn) {
  const double pixel = 2.0 * eye_height * tan(0.5 * field_deg * (3.14159265358979323846 / 180.0)) / DOWN;
  uint32_t most = 0;
  for (uint32_t x = 0; x < ACROSS; x++) {
    uint32_t lit = 0;
    for (uint32_t y = 0; y < DOWN; y++) {
      const size_t at = (size_t)y * ACROSS + x;
      const double z = eye_z - (0.5 * DOWN - y - 0.5) * pixel;
      lit += z > -0.6 && z < 0.0 && truth->visibility[at] < 0.5f && drawn->mask[at] >= 0.5f;
    }
    most = lit > most ? lit : most;
  }
  return most * pixel;
}

/*
 * A wall that is thinner than a texel, and a texel's share of its top, may miss the texels that its foot's shadow asks:
 * the bias is (0.5 + cot / 2) texels along the light, cot bounded by 10, of which cos lie along the ground, and what the
 * filter's half on the side of the light sees is the ground itself. Issue 10 has the figures that this must stay within.
 * Behind a thick wall its front is asked, which lies farther away than all of that.
 */
static int look_at_contact(hard_run *run, double thickness) {
  static const double heights[] = {45.0, 20.0, 10.0, 5.0}, gaps[] = {0.7, 2.7, 5.5, 9.0};
  host_setup setup;
  hard_picture drawn = {0};
  hard_truth truth = {0};
  csm_binding binding;
  make_wall(&setup, thickness);
  int code = hard_load(run, &setup);
  for (int i = 0; code == 0 && i < 4; i++) {
    const scene_light sun = hard_sun(heights[i], 90.0);
    code = hard_draw(run, &setup.camera, &sun, 0, &drawn);
    if (code == 0)
      code = hard_cast(run, &setup.camera, &sun, &truth);
    if (code == 0)
      code = hard_bind(run, &binding);
    if (code == 0)
      hard_figure_add(run, lit_behind(&truth, &drawn) / binding.cascades[0].texel_size, thickness < 0.1 ? gaps[i] : 0.0,
                      "texels", "gap behind a %s wall, sun at %g degrees", thickness < 0.1 ? "thin" : "thick",
                      heights[i]);
  }
  hard_truth_free(&truth);
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  int code = look_for_acne(run, true);
  if (code == 0)
    code = look_for_acne(run, false);
  if (code == 0)
    code = look_at_contact(run, 0.02);
  return code ? code : look_at_contact(run, 1.0);
}

const hard_case hard_low_sun = {
    .name = "low_sun", .about = "suns down to 0.1 degrees over a plane, balls and walls", .run = run_case};
