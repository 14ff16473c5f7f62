/*
 * knife_edge.c: the penumbra that the straight edge of a thin caster throws on level ground, from 0.1 to 100 m above
 * it, of suns of 0.53 and 5 degrees. The truth is a closed form: a disc that a straight line cuts.
 *
 * Of a sun whose angular radius is a, a point sees the share V(s) = 1/2 + (s sqrt(1 - s^2) + asin s) / pi, where s a is
 * the angle from the sun's middle to the plane through the point and the edge (s < -1: all dark, s > 1: all lit). A
 * cap of the sphere is no flat disc, but V differs by less than 1e-3 at 5 degrees.
 */
#include "base/host.h"
#include "base/linear.h"
#include "hard/overhead.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

enum { PIXELS = 160, RESOLUTION = 256, BINS = 2 * PIXELS };

/* A penumbra is so many texels wide, or texels are as small as any map's are. */
static const double texels_across = 24.0, least_texel = 0.01;

typedef struct knife {
  const char *name;
  uint32_t filter;
  bool stated;    /* its kernel is no disc, and its width is only stated */
  uint32_t rays;  /* that decide, from each pixel; 0: maps do */
  uint32_t share; /* 1: pixels share them */
} knife;

static const knife knives[] = {{"pcss", CSM_FILTER_PCSS, false, 0, 0},
                               {"backprojection", CSM_FILTER_BACKPROJECTION, false, 0, 0},
                               {"vssm", CSM_FILTER_VSSM, true, 0, 0},
                               {"exact_soft", CSM_FILTER_EXACT_SOFT, false, 16, 0},
                               {"exact_soft, 64 rays", CSM_FILTER_EXACT_SOFT, false, 64, 0},
                               {"exact_soft, 4 rays shared", CSM_FILTER_EXACT_SOFT, false, 4, 1}};
enum { KNIVES = sizeof knives / sizeof knives[0] };

typedef struct place {
  double height;      /* of the edge over the ground */
  double disc_deg;    /* the sun's diameter */
  double sun_deg;     /* its height over the horizon */
  double azimuth_deg; /* of the sun, from the way that is across the edge */
} place;

/* ---- the truth ---- */

static double disc_share(double s) {
  const double inside = fmin(fmax(s, -1.0), 1.0);
  return 0.5 + (inside * sqrt(1.0 - inside * inside) + asin(inside)) / pi;
}

/* Where a rising function of the place reaches a share. */
static double reach_share(const place *at, double share, double (*visibility)(const place *, double), double most) {
  double low = -most, high = most;
  for (int i = 0; i < 100; i++) {
    const double middle = 0.5 * (low + high);
    *(visibility(at, middle) < share ? &low : &high) = middle;
  }
  return 0.5 * (low + high);
}

/* The way to the sun: x across the edge towards the lit side, z along it. */
static void sun_of(const place *at, double sun[3]) {
  const double height = at->sun_deg * (pi / 180.0), azimuth = at->azimuth_deg * (pi / 180.0);
  sun[0] = cos(height) * cos(azimuth);
  sun[1] = sin(height);
  sun[2] = cos(height) * sin(azimuth);
}

/*
 * At `x` across the edge's shadow. The edge lies above the place from which the sun's middle is seen at it: at x = 0
 * half of the sun is hidden. The caster is on the side of smaller x.
 */
static double visibility_at(const place *at, double x) {
  double sun[3], normal[3];
  sun_of(at, sun);
  const double to_edge[3] = {sun[0] / sun[1] * at->height - x, at->height, 0.0};
  vec_cross(normal, to_edge, (const double[3]){0.0, 0.0, 1.0}); /* (h, -x', 0): towards the lit side */
  vec_normalize(normal);
  return disc_share(asin(vec_dot(normal, sun)) / (at->disc_deg * (pi / 360.0)));
}

/* ---- the scene ---- */

/* How wide the penumbra is on the ground, from dark to lit. */
static double full_width(const place *at) {
  const double most = 100.0 * at->height;
  return reach_share(at, 1.0 - 1e-9, visibility_at, most) - reach_share(at, 1e-9, visibility_at, most);
}

/* The edge is turned by `turn` in the picture, so that it runs along neither pixels nor texels. */
static const double turn = 0.35;

static void make_scene(host_setup *out, const place *at) {
  const double texel = fmax(least_texel, full_width(at) / texels_across), side = texel * RESOLUTION / 2.0;
  const double eye = fmin(0.5 * at->height, side), far = 8.0 * side;
  mesh_builder b = {0};
  double sun[3];
  overhead_begin(out, &(overhead){.side = side, .eye = eye, .floor = -eye, .pixels = PIXELS});
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, far, 1);
  hard_add(out, &b, "ground", NULL);
  sun_of(at, sun);
  const double edge = sun[0] / sun[1] * at->height, along = sun[2] / sun[1] * at->height;
  const double c = cos(turn), s = sin(turn);
  const double corners[4][2] = {
      {edge - far, along - far}, {edge - far, along + far}, {edge, along + far}, {edge, along - far}};
  double card[4][3];
  for (int i = 0; i < 4; i++) {
    card[i][0] = c * corners[i][0] - s * corners[i][1];
    card[i][1] = at->height;
    card[i][2] = s * corners[i][0] + c * corners[i][1];
  }
  builder_quad(&b, (const double(*)[3])card);
  hard_add(out, &b, "card", NULL);
  out->light = (scene_light){.direction = {-c * sun[0] + s * sun[2], -sun[1], -s * sun[0] - c * sun[2]},
                             .disc_deg = at->disc_deg};
  out->config.fit_mode = CSM_FIT_MINIMUM_SPHERE;
  out->config.resolution = RESOLUTION;
}

/* ---- what was drawn ---- */

typedef struct profile {
  double from, step; /* of bin i the place is from + (i + 0.5) * step */
  double sums[BINS];
  uint32_t counts[BINS];
} profile;

/* The mean over all pixels at one distance from the edge's shadow. */
static void read_profile(profile *out, const host_setup *setup, const hard_picture *drawn) {
  const double pixel = 2.0 / setup->camera.projection[0] / setup->width, c = cos(turn), s = sin(turn);
  *out = (profile){.from = -0.5 * BINS * pixel, .step = pixel};
  for (uint32_t row = 0; row < drawn->height; row++)
    for (uint32_t column = 0; column < drawn->width; column++) {
      double at[2];
      overhead_place(setup, column, row, at);
      const int bin = (int)floor((c * at[0] + s * at[1] - out->from) / out->step);
      if (bin < 0 || bin >= BINS)
        continue;
      out->sums[bin] += drawn->mask[(size_t)row * drawn->width + column];
      out->counts[bin]++;
    }
}

/* Where the profile first reaches a share, going towards the light; NAN if it never does. */
static double profile_reaches(const profile *p, double share) {
  double last_place = NAN, last = NAN;
  for (int i = 0; i < BINS; i++) {
    if (p->counts[i] < PIXELS / 4)
      continue;
    const double place = p->from + (i + 0.5) * p->step, mean = p->sums[i] / p->counts[i];
    if (mean >= share)
      return isnan(last) ? NAN : last_place + (place - last_place) * (share - last) / (mean - last);
    last_place = place;
    last = mean;
  }
  return NAN;
}

static int add_figures(hard_run *run, const knife *with, const place *at, const hard_picture *drawn) {
  csm_binding binding;
  profile profile;
  const int code = hard_bind(run, &binding);
  if (code)
    return code;
  read_profile(&profile, run->setup, drawn);
  const double most = 100.0 * at->height;
  const double ends[3] = {reach_share(at, 0.1, visibility_at, most), reach_share(at, 0.5, visibility_at, most),
                          reach_share(at, 0.9, visibility_at, most)};
  const double seen[3] = {profile_reaches(&profile, 0.1), profile_reaches(&profile, 0.5),
                          profile_reaches(&profile, 0.9)};
  const double width = ends[2] - ends[0];
  /* A texel is longer along the ground, the way that the sun is low. */
  const double stretch = cos(at->azimuth_deg * (pi / 180.0)) / sin(at->sun_deg * (pi / 180.0));
  const double texel = binding.cascades[0].texel_size * fmax(1.0, fabs(stretch));
  /* The bound: 5 %, a pixel or a texel. */
  const double bound = fmax(0.05 * width, fmax(profile.step, texel));
  const double wrong = fabs(seen[2] - seen[0] - width), moved = fabs(seen[1] - ends[1]);
  hard_figure_add(run, wrong / bound, with->stated ? INFINITY : 1.0, "1",
                  "%s: width of a penumbra, of what it may be off, %g deg, %g m", with->name, at->disc_deg, at->height);
  hard_figure_add(run, moved / bound, with->stated ? INFINITY : 1.0, "1", "%s: place of the shadow's edge, likewise",
                  with->name);
  return 0;
}

/* All of the disc is seen, or none of it, so far to either side of a place. */
static bool is_end(const place *at, double across, double reach) {
  const double least = visibility_at(at, across - reach), most = visibility_at(at, across + reach);
  return fmax(least, most) < 1e-6 || fmin(least, most) > 1.0 - 1e-6;
}

/*
 * Rays to the disc are all hidden where the disc is, and none is where all of it is seen, to the last bit. Between them so
 * many rays do no worse than as many at random, whose share has a deviation of half a root. Pixels that share rays see a
 * pixel farther, along a diagonal.
 */
static void add_shares(hard_run *run, const knife *with, const place *at, const hard_picture *drawn) {
  const double c = cos(turn), s = sin(turn);
  uint64_t ends = 0, partly = 0;
  double squares = 0.0, corners[2][2];
  overhead_place(run->setup, 0, 0, corners[0]);
  overhead_place(run->setup, 1, 1, corners[1]);
  const double reach = with->share * hypot(corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]);
  for (uint32_t i = 0; i < drawn->width * drawn->height; i++) {
    double where[2];
    overhead_place(run->setup, i % drawn->width, i / drawn->width, where);
    const double across = c * where[0] + s * where[1], error = drawn->mask[i] - visibility_at(at, across);
    const bool end = is_end(at, across, 0.0);
    ends += is_end(at, across, reach) && fabs(error) > 1e-5;
    partly += !end;
    squares += end ? 0.0 : error * error;
  }
  hard_figure_add(run, (double)ends, 0.0, "px", "%s: neither dark in the umbra nor lit outside", with->name);
  hard_figure_add(run, sqrt(squares / (double)partly) * sqrt(with->rays), 0.5, "1",
                  "%s: rmse in the penumbra, times the root of the rays", with->name);
}

/* ---- the case ---- */

static int draw_place(hard_run *run, const place *at) {
  host_setup setup;
  hard_picture drawn = {0};
  make_scene(&setup, at);
  int code = hard_load(run, &setup);
  for (int i = 0; code == 0 && i < KNIVES; i++) {
    csm_config config = setup.config;
    config.filter = knives[i].filter;
    config.soft_radius_least_texels = 1.5; /* as the presets have it */
    config.moment_levels = knives[i].filter == CSM_FILTER_VSSM ? 8 : 1;
    config.ray_taps = knives[i].rays ? knives[i].rays : config.ray_taps;
    config.ray_share = knives[i].share;
    code = hard_restart(run, &config);
    if (code == 0)
      code = hard_draw(run, &setup.camera, &setup.light, 0, &drawn);
    if (code == 0)
      code = add_figures(run, &knives[i], at, &drawn);
    if (code == 0 && knives[i].rays)
      add_shares(run, &knives[i], at, &drawn);
  }
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

static int run_case(hard_run *run) {
  static const double heights[] = {0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0}, discs[] = {0.53, 5.0};
  static const double suns[][2] = {{90.0, 0.0}, {45.0, 0.0}, {30.0, 60.0}};
  int code = 0;
  /* The short form has each height under one of the discs. */
  for (int d = 0; d < 2; d++)
    for (int h = 0; h < 7; h++)
      for (int s = 0; code == 0 && s < (run->sweep ? 3 : ((d + h) % 2 ? 0 : 1 + h % 2)); s++)
        code = draw_place(run, &(place){heights[h], discs[d], suns[s][0], suns[s][1]});
  return code;
}

const hard_case hard_knife_edge = {
    .name = "knife_edge",
    .about = "the penumbra of a straight edge 0.1 to 100 m above the ground, suns of 0.53 and 5 degrees",
    .run = run_case};
