/* show.c: what a mask shows in place of visibility, against what the plan says, and who cast into which map. */
#include "support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { width = 192, height = 128, pixels = width * height };

typedef struct shown {
  record record;
  csm_context *context;
  csm_cascades *cascades;
  csm_view *view;
  csm_binding binding;
} shown;

static void open_view_with(shown *v, uint32_t flags) {
  memset(v, 0, sizeof *v);
  v->context = support_open_with(&v->record, flags);
  v->view = support_view(v->context);
}

static void open_view(shown *v) {
  open_view_with(v, 0);
}

static void draw(shown *v, const csm_config *config, shot *shot) {
  if (v->cascades)
    assert_int_equal(csm_cascades_configure(v->cascades, config), CSM_SUCCESS);
  else
    assert_int_equal(csm_cascades_create(v->context, config, &v->cascades), CSM_SUCCESS);
  assert_int_equal(csm_render_cascades(v->cascades, shot_frame(shot)), CSM_SUCCESS);
  v->binding = (csm_binding){.struct_size = sizeof v->binding};
  assert_int_equal(csm_bind(v->cascades, &v->binding), CSM_SUCCESS);
}

/* What a mask of that size holds, in 255ths; the caller frees it. */
static int *resolve_sized(const shown *v, shot *shot, uint32_t show, uint32_t across, uint32_t down) {
  const csm_mask_info info = {
      .struct_size = sizeof info, .frame = shot_frame(shot), .width = across, .height = down, .show = show};
  assert_int_equal(csm_resolve_mask(v->view, v->cascades, &info), CSM_SUCCESS);
  float *mask = support_image(v->context, v->view, CSM_READ_MASK, across, down);
  int *values = malloc(across * down * sizeof *values);
  assert_non_null(values);
  for (uint32_t i = 0; i < across * down; ++i) {
    values[i] = (int)lroundf(mask[i] * 255);
    assert_float_equal(mask[i] * 255, values[i], 1e-3);
  }
  free(mask);
  return values;
}

static int *resolve(const shown *v, shot *shot, uint32_t show) {
  return resolve_sized(v, shot, show, width, height);
}

static void finish(shown *v) {
  assert_int_equal(csm_cascades_destroy(v->cascades), CSM_SUCCESS);
  support_close(v->context, &v->record);
}

/* ---- cascades ---- */

/* View depth of what the scene's camera sees at a pixel; negative: nothing. */
static double view_depth(const shot *shot, float depth) {
  return depth > 0 ? shot->camera.projection[14] / ((double)depth + shot->camera.projection[10]) : -1;
}

/* The first cascade that does not end before a depth; how far its ends are, as a share of the depth, into *margin. */
static uint32_t interval(const csm_binding *binding, double depth, double *margin) {
  uint32_t cascade = 0;
  *margin = 1;
  for (uint32_t k = 0; k < binding->cascade_count; ++k) {
    cascade += depth > binding->cascades[k].far_depth;
    *margin = fmin(*margin, fabs(depth - binding->cascades[k].far_depth) / depth);
  }
  return cascade;
}

static void a_point_has_the_cascade_of_its_interval(void **state) {
  (void)state;
  shown v;
  support_scene scene;
  csm_config config = support_config();
  config.selection = CSM_SELECT_INTERVAL;
  config.shadow_distance = 26;
  config.split_mode = CSM_SPLIT_MANUAL;
  config.split_distances[0] = 12;
  config.split_distances[1] = 18;
  config.split_distances[2] = 26;
  open_view(&v);
  support_scene_make(&scene, v.context);
  draw(&v, &config, &scene.shot);
  int *values = resolve(&v, &scene.shot, CSM_SHOW_CASCADE);
  float *depths = support_image(v.context, v.view, CSM_READ_CAMERA_DEPTH, width, height);
  uint32_t seen[5] = {0}, near_a_split = 0;
  for (int i = 0; i < pixels; ++i) {
    double margin = 1;
    const double depth = view_depth(&scene.shot, depths[i]);
    const uint32_t cascade = depth < 0 ? 4 : interval(&v.binding, depth, &margin);
    const bool split = margin < 1e-5;
    near_a_split += split;
    if (!split)
      assert_int_equal(values[i], cascade < 3 ? cascade + 1 : 0);
    ++seen[cascade];
  }
  for (int k = 0; k < 5; ++k) /* 3: beyond, 4: nothing */
    assert_true(seen[k] > 100);
  assert_true(near_a_split < 100);
  free(values);
  free(depths);

  /* The mask is visibility again when it is asked for. */
  int *shadow = resolve(&v, &scene.shot, CSM_SHOW_VISIBILITY);
  uint32_t lit = 0;
  for (int i = 0; i < pixels; ++i)
    lit += shadow[i] == 255;
  assert_true(lit > pixels / 4);
  free(shadow);
  finish(&v);
}

/* Over the end of a slice each point has its own cascade or the next one, and elsewhere its own. */
static void dithered_points_have_the_cascade_they_got(void **state) {
  (void)state;
  shown v;
  support_scene scene;
  csm_config config = support_config();
  config.selection = CSM_SELECT_INTERVAL;
  config.blend_mode = CSM_BLEND_DITHERED;
  config.blend_share = 0.5;
  open_view(&v);
  support_scene_make(&scene, v.context);
  draw(&v, &config, &scene.shot);
  int *values = resolve(&v, &scene.shot, CSM_SHOW_CASCADE);
  float *depths = support_image(v.context, v.view, CSM_READ_CAMERA_DEPTH, width, height);
  uint32_t stayed = 0, went = 0;
  for (int i = 0; i < pixels; ++i) {
    double margin = 1;
    const double depth = view_depth(&scene.shot, depths[i]);
    const uint32_t cascade = depth < 0 ? 4 : interval(&v.binding, depth, &margin);
    if (cascade > 1 || margin < 1e-5)
      continue; /* the last one has none after it */
    const csm_cascade_info *info = &v.binding.cascades[cascade];
    const double along = (depth - info->near_depth) / (info->far_depth - info->near_depth);
    if (along < 0.499)
      assert_int_equal(values[i], cascade + 1);
    else if (along > 0.501) {
      assert_true(values[i] == (int)cascade + 1 || values[i] == (int)cascade + 2);
      stayed += values[i] == (int)cascade + 1;
      went += values[i] == (int)cascade + 2;
    }
  }
  assert_true(stayed > 500 && went > 500);
  free(values);
  free(depths);
  finish(&v);
}

/* ---- pages ---- */

/* A wall that faces the sun. Pages count from the world's origin, right and up as the map's texels do, so what lies in one
   keeps it when the camera goes on. */
static void a_place_keeps_its_page(void **state) {
  (void)state;
  const double depth = 10 - 1e-3;
  csm_config config = support_config();
  config.map_layout = CSM_LAYOUT_PAGES;
  config.resolution = 256;
  shown v;
  open_view(&v);
  const csm_instance wall = support_instance(support_box(v.context, 2), 0, 0, -10, 100, 100, 1e-3);
  uint32_t seen = 0, near_edges = 0;
  for (int step = 0; step < 6; ++step) {
    const double eye[3] = {step * 1.3, -0.7 * step, 0}, to[3] = {eye[0], eye[1], -1};
    shot shot = shot_make(&wall, 1);
    memcpy(shot.light.direction, (const double[]){0, 0, -1}, sizeof shot.light.direction);
    support_look_at(shot.camera.view, eye, to);
    support_perspective(shot.camera.projection, 50, 1.5, 0.25, 200);
    draw(&v, &config, &shot);
    int *cascades = resolve(&v, &shot, CSM_SHOW_CASCADE), *values = resolve(&v, &shot, CSM_SHOW_PAGES);
    for (int at = 0; at < pixels; ++at) {
      const double across = (at % width + 0.5) / width * 2 - 1, up = 1 - (at / width + 0.5) / height * 2;
      const double x = eye[0] + across * depth / shot.camera.projection[0];
      const double y = eye[1] + up * depth / shot.camera.projection[5];
      const csm_cascade_info *of = &v.binding.cascades[cascades[at] - 1];
      const double page = of->texel_size * config.resolution / 64, *m = of->world_to_shadow;
      const double right = (m[0] * x + m[4] * y) / hypot(m[0], m[4]) / page; /* the sun looks along z */
      const double high = -(m[1] * x + m[5] * y) / hypot(m[1], m[5]) / page;
      near_edges += fabs(right - round(right)) < 1e-3 || fabs(high - round(high)) < 1e-3;
      if (fabs(right - round(right)) < 1e-3 || fabs(high - round(high)) < 1e-3)
        continue;
      const int column = (int)floor(right) & 3, row = 3 - ((int)floor(high) & 3);
      assert_int_equal(values[at], 1 + 16 * (cascades[at] - 1) + 4 * column + row);
      seen |= 1u << (4 * column + row);
    }
    free(cascades);
    free(values);
  }
  assert_int_equal(seen, 0xffff);
  assert_true(near_edges < pixels / 10);
  finish(&v);
}

/* ---- density ---- */

/* Each pixel of a wall 10 m before a camera that looks straight at it has one density: the picture's own metres a pixel
   over a texel's, whichever way the map is turned, and though the sun comes from the side: along the wall's height a
   texel stays as it is. */
static void a_wall_has_the_density_of_its_texels(void **state) {
  (void)state;
  const struct {
    uint32_t resolution;
    double aside, aspect; /* of the sun; of the picture, which is seen through pixels of `width` to `height` */
  } cases[] = {{256, 0, 1.5}, {1024, 0, 1.5}, {256, 1.2, 1.5}, {512, 0, 4.5}, {16, 0, 1.5}};
  shown v;
  open_view(&v);
  const csm_instance wall = support_instance(support_box(v.context, 2), 0, 0, -10, 100, 100, 1e-3);
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    csm_config config = support_config();
    config.selection = CSM_SELECT_INTERVAL;
    config.resolution = cases[i].resolution;
    shot shot = shot_make(&wall, 1);
    memcpy(shot.light.direction, (const double[]){-sin(cases[i].aside), 0, -cos(cases[i].aside)},
           sizeof shot.light.direction);
    support_look_at(shot.camera.view, (const double[]){0, 0, 0}, (const double[]){0, 0, -1});
    support_perspective(shot.camera.projection, 50, cases[i].aspect, 0.25, 200);
    draw(&v, &config, &shot);
    int *cascades = resolve(&v, &shot, CSM_SHOW_CASCADE), *values = resolve(&v, &shot, CSM_SHOW_DENSITY);
    const double depth = 10 - 1e-3, down = 2 * depth / shot.camera.projection[5] / height;
    const double across = 2 * depth / shot.camera.projection[0] / width * cos(cases[i].aside);
    double margin;
    const uint32_t cascade = interval(&v.binding, depth, &margin);
    const double exact = 128 + 16 * log2(fmax(across, down) / v.binding.cascades[cascade].texel_size);
    assert_true(margin > 1e-3 && exact > 1 && exact < 255);
    for (int at = 0; at < pixels; ++at) {
      assert_int_equal(cascades[at], cascade + 1);
      assert_float_equal(values[at], exact, 0.5 + 0.02);
    }
    free(cascades);
    free(values);
  }
  finish(&v);
}

/* Nothing, and what lies beyond, has no density; a grazed ground has more texels for a pixel farther away. */
static void the_ground_is_coarse_before_the_camera(void **state) {
  (void)state;
  shown v;
  support_scene scene;
  csm_config config = support_config();
  config.cascade_count = 1;
  config.shadow_distance = 30;
  open_view(&v);
  support_scene_make(&scene, v.context);
  scene.shot.frame.instance_count = 1;
  draw(&v, &config, &scene.shot);
  int *cascades = resolve(&v, &scene.shot, CSM_SHOW_CASCADE), *values = resolve(&v, &scene.shot, CSM_SHOW_DENSITY);
  uint32_t steps = 0;
  for (int i = 0; i < pixels; ++i) {
    assert_true((values[i] == 0) == (cascades[i] == 0));
    if (i < width || !values[i] || !values[i - width])
      continue;
    assert_true(values[i] <= values[i - width] + 1);
    steps += values[i] < values[i - width];
  }
  assert_true(steps > width);
  free(cascades);
  free(values);
  finish(&v);
}

/* ---- penumbrae ---- */

/* A plate `height` over the ground, along the light, and a camera between them; the plate's edge may cross the picture. */
typedef struct plate {
  uint32_t filter;
  double height, diameter; /* in metres; of the sun, in radians */
  double slant;            /* of the sun, in radians */
  bool ends;
} plate;

static void draw_plate(shown *v, const plate *p, shot *shot, csm_instance instances[2]) {
  csm_config config = support_config();
  config.filter = p->filter;
  config.moment_levels = 8;
  config.bias_slope_texels = 0;
  config.shadow_distance = 30;
  const csm_mesh box = support_box(v->context, 2);
  const double thin = 1e-3, up = p->height * cos(p->slant);
  instances[0] = support_instance(box, 0, -thin, 0, 300, thin, 300);
  instances[1] = support_instance(box, p->ends ? -100 : 0, up - thin, 0, 100, thin, 300);
  *shot = shot_make(instances, 2);
  memcpy(shot->light.direction, (const double[]){0, -cos(p->slant), -sin(p->slant)}, sizeof shot->light.direction);
  shot->light.angular_diameter = p->diameter;
  support_look_at(shot->camera.view, (const double[]){0, 1.5, 0}, (const double[]){0, 0, -4});
  support_perspective(shot->camera.projection, 50, (double)width / height, 0.1, 200);
  draw(v, &config, shot);
}

/* What lies h before a plane hides a part of the sun where it is no farther to the side than h tan(a / 2). */
static void check_plate(shown *v, const plate *p) {
  const csm_config config = support_config();
  csm_instance instances[2];
  shot shot;
  draw_plate(v, p, &shot, instances);
  int *cascades = resolve(v, &shot, CSM_SHOW_CASCADE), *values = resolve(v, &shot, CSM_SHOW_PENUMBRA);
  uint32_t seen[4] = {0}, none = 0;
  for (int at = 0; at < pixels; ++at) {
    none += cascades[at] && !values[at];
    if (!cascades[at] || !values[at]) {
      assert_true(!values[at]);
      continue;
    }
    const double texel = v->binding.cascades[cascades[at] - 1].texel_size;
    const double radius = (p->height / texel - config.bias_constant_texels) * tan(p->diameter / 2);
    const double exact = 128 + 16 * log2(radius);
    assert_true(exact > 1 && exact < 255);
    if (fabs(values[at] - exact) > 0.5 + 0.05)
      fail_msg("filter %u, %g m: %d at pixel %d, not %g", p->filter, p->height, values[at], at, exact);
    ++seen[cascades[at]];
  }
  assert_true(seen[1] > 500 && seen[2] > 500);
  assert_true(p->ends ? none > pixels / 8 : none == 0);
  free(cascades);
  free(values);
}

static void a_penumbra_is_as_wide_as_its_caster_is_high(void **state) {
  (void)state;
  static const plate plates[] = {
      {.filter = CSM_FILTER_PCSS, .height = 10, .diameter = 0.09, .ends = true},
      {.filter = CSM_FILTER_PCSS, .height = 10, .diameter = 0.00925},
      {.filter = CSM_FILTER_PCSS, .height = 4, .diameter = 0.3, .slant = 0.6, .ends = true},
      {.filter = CSM_FILTER_BACKPROJECTION, .height = 10, .diameter = 0.09, .ends = true},
      {.filter = CSM_FILTER_VSSM, .height = 10, .diameter = 0.09},
      {.filter = CSM_FILTER_VSSM, .height = 4, .diameter = 0.3},
  };
  shown v;
  open_view(&v);
  for (size_t i = 0; i < sizeof plates / sizeof *plates; ++i)
    check_plate(&v, &plates[i]);
  finish(&v);
}

/* ---- rays ---- */

/*
 * A level is 1 more than 16 times the binary logarithm of the nodes, so what it stands for is off by up to 2.2 %; the sum of
 * nodes is off by what each pixel's rounding to 16 leaves.
 */
static void nodes_of_rays_are_counted(void **state) {
  (void)state;
  shown v;
  support_scene scene;
  csm_config config = support_config();
  config.filter = CSM_FILTER_EXACT;
  open_view_with(&v, CSM_CREATE_RAYS);
  support_scene_make(&scene, v.context);
  draw(&v, &config, &scene.shot);
  int *values = resolve(&v, &scene.shot, CSM_SHOW_RAYS);
  csm_view_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_view_stats(v.view, &stats), CSM_SUCCESS);
  uint32_t asked = 0;
  double nodes = 0;
  for (int at = 0; at < pixels; ++at)
    if (values[at]) {
      ++asked;
      nodes += exp2((values[at] - 1) / 16.0);
    }
  assert_in_range(asked, pixels / 100, pixels);
  assert_int_equal(stats.ray_pixels, asked);
  assert_float_equal((double)stats.ray_nodes / nodes, 1.0, 0.03);
  /* Most rays are of pixels at a shadow's edge: they meet the box of a caster at least. */
  assert_in_range(stats.ray_triangles, asked / 2, stats.ray_nodes);
  free(values);
  finish(&v);
}

/* Threads look at pixels by fours, in squares: where all surfaces ask, each is in the list once, whatever the picture's size. */
static void every_pixel_of_any_size_is_listed_once(void **state) {
  (void)state;
  static const uint32_t sizes[][2] = {{1, 1}, {2, 1}, {1, 9}, {17, 16}, {16, 17}, {33, 31}, {34, 34}};
  shown v;
  support_scene scene;
  csm_config config = support_config();
  config.filter = CSM_FILTER_EXACT;
  config.ray_grazing_cosine = 1;
  open_view_with(&v, CSM_CREATE_RAYS);
  support_scene_make(&scene, v.context);
  draw(&v, &config, &scene.shot);
  for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
    const uint32_t across = sizes[i][0], down = sizes[i][1];
    int *cascades = resolve_sized(&v, &scene.shot, CSM_SHOW_CASCADE, across, down);
    int *rays = resolve_sized(&v, &scene.shot, CSM_SHOW_RAYS, across, down);
    csm_view_stats stats = {.struct_size = sizeof stats};
    assert_int_equal(csm_get_view_stats(v.view, &stats), CSM_SUCCESS);
    uint32_t held = 0;
    for (uint32_t at = 0; at < across * down; ++at) {
      assert_int_equal(rays[at] > 0, cascades[at] > 0);
      held += cascades[at] > 0;
    }
    assert_true(held > across * down / 2);
    assert_int_equal(stats.ray_pixels, held);
    free(rays);
    free(cascades);
  }
  finish(&v);
}

/* ---- times ---- */

static csm_view_stats stats_after(shown *v, const csm_config *config, shot *shot, uint32_t show) {
  csm_view_stats stats = {.struct_size = sizeof stats};
  draw(v, config, shot);
  free(resolve(v, shot, show));
  assert_int_equal(csm_get_view_stats(v->view, &stats), CSM_SUCCESS);
  return stats;
}

/* What the last timed mask went without has no time, whatever masks before it took. */
static void times_are_of_the_last_mask_that_was_timed(void **state) {
  (void)state;
  shown v;
  support_scene scene;
  const csm_config plain = support_config();
  csm_config exact = plain;
  exact.filter = CSM_FILTER_EXACT;
  exact.history = CSM_HISTORY_ON;
  open_view_with(&v, CSM_CREATE_RAYS);
  support_scene_make(&scene, v.context);
  shot *shot = &scene.shot;
  shot->frame.flags = CSM_FRAME_TIMESTAMPS;
  csm_view_stats stats = stats_after(&v, &exact, shot, CSM_SHOW_VISIBILITY);
  assert_true(stats.mask_gpu_ms > 0 && stats.rays_gpu_ms > 0 && stats.history_gpu_ms > 0 && stats.ray_pixels > 0);
  shot->frame.flags = 0;
  const csm_view_stats untimed = stats_after(&v, &exact, shot, CSM_SHOW_CASCADE);
  assert_true(untimed.rays_gpu_ms == stats.rays_gpu_ms && untimed.history_gpu_ms == stats.history_gpu_ms);
  shot->frame.flags = CSM_FRAME_TIMESTAMPS;
  stats = stats_after(&v, &exact, shot, CSM_SHOW_CASCADE);
  assert_true(stats.mask_gpu_ms > 0 && stats.rays_gpu_ms < 0 && stats.history_gpu_ms < 0);
  stats = stats_after(&v, &exact, shot, CSM_SHOW_VISIBILITY);
  assert_true(stats.rays_gpu_ms > 0 && stats.history_gpu_ms > 0);
  const uint64_t bytes = stats.bytes - stats.history_bytes;
  stats = stats_after(&v, &plain, shot, CSM_SHOW_VISIBILITY);
  assert_true(stats.mask_gpu_ms > 0 && stats.rays_gpu_ms < 0 && stats.history_gpu_ms < 0);
  assert_int_equal(stats.ray_pixels, 0);
  assert_true(stats.bytes + 3 * (uint64_t)pixels <= bytes); /* the rays' list of 4 bytes a pixel has gone, too */
  finish(&v);
}

/* ---- casters ---- */

static void casters_are_told(void **state) {
  (void)state;
  shown v;
  support_scene scene;
  const csm_config config = support_config();
  open_view(&v);
  support_scene_make(&scene, v.context);
  csm_instance instances[SUPPORT_INSTANCES + 1];
  memcpy(instances, scene.instances, sizeof scene.instances);
  instances[SUPPORT_INSTANCES] = support_instance(instances[1].mesh, 4000, 0, 0, 1, 1, 1);
  scene.shot.frame.instances = instances;
  scene.shot.frame.instance_count = SUPPORT_INSTANCES + 1;
  draw(&v, &config, &scene.shot);
  csm_stats stats = {.struct_size = sizeof stats};
  assert_int_equal(csm_get_stats(v.cascades, &stats), CSM_SUCCESS);
  uint8_t drawn[SUPPORT_INSTANCES + 2];
  memset(drawn, 0xAA, sizeof drawn);
  assert_int_equal(csm_get_casters(v.cascades, SUPPORT_INSTANCES + 1, NULL, drawn), CSM_SUCCESS);
  assert_int_equal(drawn[0], 7);                        /* the ground */
  assert_int_equal(drawn[SUPPORT_INSTANCES], 0);        /* what is far away */
  assert_int_equal(drawn[SUPPORT_INSTANCES + 1], 0xAA); /* no more is written */
  for (uint32_t k = 0; k < 8; ++k) {
    uint32_t count = 0;
    for (uint32_t i = 0; i <= SUPPORT_INSTANCES; ++i)
      count += drawn[i] >> k & 1;
    assert_int_equal(count, k < config.cascade_count ? stats.cascades[k].casters_drawn : 0);
  }
  /* A frame that fails leaves the last one's; one without instances has none to tell. */
  shot shot = scene.shot;
  shot.light.direction[0] = NAN;
  v.record.quiet = true;
  assert_int_equal(csm_render_cascades(v.cascades, shot_frame(&shot)), CSM_ERROR_NOT_FINITE);
  assert_int_equal(csm_get_casters(v.cascades, SUPPORT_INSTANCES + 1, NULL, drawn), CSM_SUCCESS);
  assert_int_equal(drawn[0], 7);
  shot = scene.shot;
  shot.frame.instance_count = 0;
  assert_int_equal(csm_render_cascades(v.cascades, shot_frame(&shot)), CSM_SUCCESS);
  assert_int_equal(csm_get_casters(v.cascades, 0, NULL, NULL), CSM_SUCCESS);
  finish(&v);
}

int main(int argc, char **argv) {
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(nodes_of_rays_are_counted),
      cmocka_unit_test(every_pixel_of_any_size_is_listed_once),
      cmocka_unit_test(times_are_of_the_last_mask_that_was_timed),
      cmocka_unit_test(a_point_has_the_cascade_of_its_interval),
      cmocka_unit_test(dithered_points_have_the_cascade_they_got),
      cmocka_unit_test(a_place_keeps_its_page),
      cmocka_unit_test(a_wall_has_the_density_of_its_texels),
      cmocka_unit_test(the_ground_is_coarse_before_the_camera),
      cmocka_unit_test(a_penumbra_is_as_wide_as_its_caster_is_high),
      cmocka_unit_test(casters_are_told),
  };
  return support_main(argc, argv, tests, sizeof tests / sizeof tests[0]);
}
