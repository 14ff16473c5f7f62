/*
 * far_orthographic.c: orthographic cameras kilometres from what they see, as in games seen from above at an angle. Their
 * slices are hundreds of times as long as the picture is wide.
 */
#include "base/host.h"
#include "hard/hard.h"
#include <math.h>

static const double pi = 3.14159265358979323846;

/* Looks at the world's origin from above at an angle, and sees 12 m to each side. Depth goes to twice the way. */
static int look_from(camera *out, double away, double height_deg, double azimuth_deg, bool reversed) {
  const double height = height_deg * (pi / 180.0), azimuth = azimuth_deg * (pi / 180.0), half = 12.0;
  const double back[3] = {cos(height) * sin(azimuth), sin(height), cos(height) * cos(azimuth)};
  const double right[3] = {cos(azimuth), 0.0, -sin(azimuth)};
  const double up[3] = {-sin(height) * sin(azimuth), cos(height), -sin(height) * cos(azimuth)};
  double view[16] = {0}, projection[16] = {0};
  for (int i = 0; i < 3; i++) {
    view[i * 4] = right[i];
    view[i * 4 + 1] = up[i];
    view[i * 4 + 2] = back[i];
  }
  view[14] = -away;
  view[15] = 1.0;
  const double near = 0.1, far = 2.0 * away, sign = reversed ? 1.0 : -1.0;
  projection[0] = 1.0 / half;
  projection[5] = 16.0 / (9.0 * half);
  projection[10] = sign / (far - near);
  projection[14] = (reversed ? far : -near) / (far - near);
  projection[15] = 1.0;
  const char *wrong = camera_from_matrices(out, view, projection, &reversed);
  return wrong ? host_fail(HOST_BAD_INPUT, "the orthographic camera: %s", wrong) : 0;
}

/* A ground of 20 m with a card above it, and boxes on it. */
static void make_plaza(host_setup *out) {
  static const double boxes[][3] = {{-6.0, 0.0, 2.0}, {5.0, 0.0, 5.0}, {3.0, 0.0, -7.0}};
  mesh_builder b = {0};
  hard_setup_begin(out, 320, 180);
  hard_ground(&b, (const double[3]){0.0, 0.0, 0.0}, 10.0, 1);
  hard_add(out, &b, "ground", NULL);
  builder_box(&b, (const double[3]){-2.0, 2.0, -2.0}, (const double[3]){2.0, 2.1, 2.0});
  hard_add(out, &b, "card", NULL);
  for (size_t i = 0; i < sizeof boxes / sizeof boxes[0]; i++) {
    builder_box(&b, (const double[3]){-1.0, -0.5, -0.5}, (const double[3]){1.0, 1.5, 0.5});
    hard_add(out, &b, "box", boxes[i]);
  }
}

static int draw_from(hard_run *run, const host_setup *setup, hard_picture *drawn, hard_truth *truth,
                     uint32_t *with_shadows) {
  const csm_config *config = &setup->config;
  int code = hard_restart(run, config);
  if (code == 0)
    code = hard_draw(run, &setup->camera, &setup->light, 0, drawn);
  if (code == 0)
    code = hard_cast(run, &setup->camera, &setup->light, truth);
  if (code)
    return code;
  /* A pixel is larger than the three texels that a filter reaches, as a map is no wider than the plaza. */
  const hard_margin margin = {.silhouette_px = 2.0, .edge_px = 2.0};
  const hard_count count = hard_judge(run, truth, drawn->mask, margin);
  const double away = setup->camera.far_depth / 2.0;
  const char *selection = config->selection == CSM_SELECT_MAP ? "map" : "interval";
  hard_figure_add(run, (double)count.false_lit, 0.0, "px", "shadows lost, %.0e m away, selection %s", away, selection);
  hard_figure_add(run, (double)count.false_dark, 0.0, "px", "dark though lit, %.0e m away, selection %s", away,
                  selection);
  /* The card's shadow lies on the ground, unless the camera looks along the light. */
  *with_shadows += count.judged > 2000 && count.judged - count.lit > 50;
  return 0;
}

/* From several sides, each with another light and kind of depth. */
static int draw_away(hard_run *run, host_setup *setup, double away, hard_picture *drawn, hard_truth *truth) {
  uint32_t with_shadows = 0;
  const uint32_t count = run->sweep ? 16 : 4;
  static const double heights[] = {35.0, 65.0, 12.0, 50.0};
  int code = 0;
  for (uint32_t i = 0; code == 0 && i < count; i++) {
    setup->light = hard_sun(30.0 + 8.0 * (i % 5), 90.0 * i + 25.0 + 10.0 * (i % 5)); /* grazes no wall */
    setup->config.selection = i & 1 ? CSM_SELECT_INTERVAL : CSM_SELECT_MAP;
    hard_reach(setup, 2.0 * away);
    code = look_from(&setup->camera, away, heights[i % 4], 45.0 + 67.0 * i, i / 2 % 2);
    if (code == 0)
      code = draw_from(run, setup, drawn, truth, &with_shadows);
  }
  if (code == 0)
    hard_figure_add(run, with_shadows * 4 >= count * 3 ? 0.0 : 1.0, 0.0, "1",
                    "distances without shadows, by the truth");
  return code;
}

static int run_case(hard_run *run) {
  static const double distances[] = {3e3, 1e5, 1e2, 3e2, 1e3, 1e4, 3e4};
  const size_t count = run->sweep ? sizeof distances / sizeof distances[0] : 2;
  host_setup setup;
  hard_picture drawn = {0};
  hard_truth truth = {0};
  make_plaza(&setup);
  int code = hard_load(run, &setup);
  for (size_t i = 0; code == 0 && i < count; i++)
    code = draw_away(run, &setup, distances[i], &drawn, &truth);
  hard_truth_free(&truth);
  hard_picture_free(&drawn);
  hard_unload(run);
  setup_free(&setup);
  return code;
}

const hard_case hard_far_orthographic = {
    .name = "far_orthographic", .about = "orthographic cameras up to 100 km from what they see", .run = run_case};
