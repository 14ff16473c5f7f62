/*
 * half_moments.c: moments of 16 bits against those of 32, at every depth and gap. What differs is the least variance,
 * which the format's rounding asks for, or the exponent, which the format bounds, and the rounding itself.
 *
 * With least deviations s and S of 32 and 16 bits, Chebyshev's visibilities under a gap g of one depth are apart by
 * S^2 / (S^2 + g^2) - s^2 / (s^2 + g^2), which is most at g^2 = s S: (S - s) / (S + s). The bound is this with what
 * rounding does to each moment, for all depths and gaps by brute force.
 */
#include "base/host.h"
#include "hard/terrace.h"
#include <math.h>

enum { DEPTHS = 64, GAPS = 256 };

/* How far two answers are apart at most, each of which lies between two bounds. */
static double apart(const double a[2], const double b[2]) {
  return fmax(fabs(a[1] - b[0]), fabs(b[1] - a[0]));
}

/* The most over all depths of a receiver and of one caster above it, or at it. */
static double most_apart(const moment_scene scenes[2]) {
  double most = 0.0;
  for (int i = 0; i < DEPTHS; i++)
    for (int k = 0; k < GAPS; k++) {
      const double z = -1.0 + 2.0 * (i + 0.5) / DEPTHS, gap = k ? 2.0 * exp2(-20.0 * (double)k / GAPS) : 0.0;
      double bounds[2][2];
      if (z - gap < -1.0)
        continue;
      for (int format = 0; format < 2; format++)
        moment_scene_bounds_of_one(&scenes[format], z - gap, z, bounds[format]);
      most = fmax(most, apart(bounds[0], bounds[1]));
    }
  return most;
}

/* In the middle of each step: how far the two masks are apart, and by how much more than rounding allows there. */
static void compare(hard_run *run, const moment_scene scenes[2], const hard_picture drawn[2], const char *name) {
  double most = 0.0, beyond = 0.0;
  for (uint32_t y = TERRACE_CELL_PIXELS / 2; y < TERRACE_PIXELS; y += TERRACE_CELL_PIXELS)
    for (uint32_t x = TERRACE_CELL_PIXELS / 2; x < TERRACE_PIXELS; x += TERRACE_CELL_PIXELS) {
      const size_t at = (size_t)y * TERRACE_PIXELS + x;
      terrace_step step;
      double bounds[2][2];
      (void)terrace_step_at(&step, run->setup, x, y, 0.0);
      for (int format = 0; format < 2; format++)
        moment_scene_bounds(&scenes[format], step.place, bounds[format]);
      const double difference = fabs((double)drawn[0].mask[at] - drawn[1].mask[at]);
      most = fmax(most, difference);
      beyond = fmax(beyond, difference - apart(bounds[0], bounds[1]));
    }
  /* Each of two masks is off by half a step. */
  hard_figure_add(run, most, fmin(most_apart(scenes) + 2.0 * moment_scene_step, 1.0), "1",
                  "float16 against float32, the most, %s", name);
  hard_figure_add(run, beyond, 2.0 * moment_scene_step, "1", "the same, more than rounding allows there, %s", name);
}

static int draw_both(hard_run *run, uint32_t filter, uint32_t blur, const char *name) {
  moment_scene scenes[2] = {0};
  hard_picture drawn[2] = {0};
  int code = 0;
  for (uint32_t format = 0; code == 0 && format < 2; format++) {
    csm_config config = run->setup->config;
    config.resolution = 512;
    config.filter = filter;
    config.moment_format = format;
    config.moment_blur_texels = blur;
    code = hard_configure(run, &config);
    if (code == 0)
      code = hard_draw(run, &run->setup->camera, &run->setup->light, 0, &drawn[format]);
    if (code == 0)
      code = moment_scene_read(&scenes[format], run, &config);
  }
  if (code == 0)
    compare(run, scenes, drawn, name);
  for (int format = 0; format < 2; format++) {
    moment_scene_free(&scenes[format]);
    hard_picture_free(&drawn[format]);
  }
  return code;
}

static int run_case(hard_run *run) {
  static const char *const names[] = {"vsm", "esm", "evsm2", "evsm4", "msm4"};
  host_setup setup;
  terrace_make(&setup, 500.0);
  int code = hard_load(run, &setup);
  if (code == 0)
    code = terrace_hide_lids(run);
  for (uint32_t i = 0; i < 5; i++)
    for (uint32_t blur = 0; code == 0 && blur < (run->sweep ? 5 : 3); blur += 2)
      code = draw_both(run, CSM_FILTER_VSM + i, blur, names[i]);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_half_moments = {
    .name = "half_moments", .about = "moments of 16 bits against those of 32, at every depth", .run = run_case};
